//! Memory that a process takes, as the kernel counts its pages, and whether it grew.
//!
//! Taken are the pages of `/proc/PID/smaps` that no file on a disk backs: heap, stacks, written
//! data, and shared memory, whose messages the process maps. Pages of the program's own text are
//! told apart: the first call of a function brings them in, and the system may take them back. The
//! counters of `/proc/PID/status` are cheaper, and on some kernels off by a few hundred kilobytes.

use procfs::process::{MMapPath, Process};
use serde::Serialize;

/// Memory of a process at a moment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Pages in use that no file on a disk backs \[kB\].
    pub taken_kb: u64,
    /// Pages in use of files, unchanged \[kB\].
    pub file_kb: u64,
    /// Page faults so far that needed no disk.
    pub minor_faults: u64,
    /// Page faults so far that read from a disk.
    pub major_faults: u64,
}

impl Memory {
    /// Memory of a process of this user; `None` once it has ended. Cost: a walk over its pages,
    /// with the process running on.
    #[must_use]
    pub fn of(pid: u32) -> Option<Self> {
        let process = Process::new(pid.cast_signed()).ok()?;
        let stat = process.stat().ok()?;
        let mut memory =
            Self { minor_faults: stat.minflt, major_faults: stat.majflt, ..Self::default() };
        for map in process.smaps().ok()? {
            let kb = |key: &str| map.extension.map.get(key).map_or(0, |bytes| bytes / 1024);
            let backed_kb = if is_on_disk(&map.pathname) {
                kb("Rss").saturating_sub(kb("Anonymous"))
            } else {
                0
            };
            memory.taken_kb += kb("Rss") - backed_kb;
            memory.file_kb += backed_kb;
        }
        Some(memory)
    }
}

/// Whether a file on a disk stands behind a mapping.
fn is_on_disk(path: &MMapPath) -> bool {
    let MMapPath::Path(path) = path else { return false };
    let path = path.to_string_lossy();
    path.starts_with('/')
        && !["/dev/shm/", "/dev/zero", "/memfd:"].iter().any(|start| path.starts_with(start))
}

/// How a process's memory went after the warm-up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Growth {
    /// Taken at the last look less at the first \[kB\].
    pub growth_kb: i64,
    /// Most taken at any look \[kB\].
    pub most_kb: u64,
    /// Taken at the first look after the warm-up \[kB\].
    pub first_kb: u64,
    /// Pages of files that came in since, or went \[kB\].
    pub file_growth_kb: i64,
    /// Page faults since that needed no disk.
    pub minor_faults: u64,
    /// Page faults since that read from a disk.
    pub major_faults: u64,
    /// Number of looks.
    pub looks: u64,
}

/// Looks at a process from the end of its warm-up on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Watch {
    first: Option<Memory>,
    growth: Growth,
}

impl Watch {
    /// Takes a look.
    pub fn look(&mut self, now: Memory) {
        let first = *self.first.get_or_insert(now);
        let change = |from: u64, to: u64| to.cast_signed() - from.cast_signed();
        self.growth = Growth {
            growth_kb: change(first.taken_kb, now.taken_kb),
            most_kb: self.growth.most_kb.max(now.taken_kb),
            first_kb: first.taken_kb,
            file_growth_kb: change(first.file_kb, now.file_kb),
            minor_faults: now.minor_faults.saturating_sub(first.minor_faults),
            major_faults: now.major_faults.saturating_sub(first.major_faults),
            looks: self.growth.looks + 1,
        };
    }

    /// What the looks said.
    #[must_use]
    pub fn growth(&self) -> Growth {
        self.growth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_on_a_disk_alone_back_pages() {
        let on_disk = |text: &str| is_on_disk(&MMapPath::from(text).unwrap());
        assert!(on_disk("/usr/bin/chaincell"));
        for text in ["", "[heap]", "[stack]", "[vdso]", "/SYSV0000004d (deleted)"] {
            assert!(!on_disk(text), "{text}");
        }
        for text in ["/dev/shm/iox2_abc.data", "/dev/zero (deleted)", "/memfd:a (deleted)"] {
            assert!(!on_disk(text), "{text}");
        }
    }

    #[test]
    fn memory_of_this_process_grows_by_what_it_writes() {
        const BYTES: usize = 512 << 20;
        let pid = std::process::id();
        let mut watch = Watch::default();
        watch.look(Memory::of(pid).unwrap());
        let written = vec![7_u8; BYTES];
        std::hint::black_box(&written);
        watch.look(Memory::of(pid).unwrap());
        let growth = watch.growth();
        // Other tests of this process take and give back some of their own.
        assert!(growth.growth_kb > 256 << 10, "{growth:?}");
        assert!(growth.minor_faults > 0 && growth.looks == 2, "{growth:?}");
    }

    #[test]
    fn growth_is_the_last_look_less_the_first() {
        let mut watch = Watch::default();
        for taken_kb in [100, 160, 96] {
            watch.look(Memory { taken_kb, ..Memory::default() });
        }
        let growth = watch.growth();
        assert_eq!((growth.growth_kb, growth.most_kb, growth.first_kb), (-4, 160, 100));
    }
}
