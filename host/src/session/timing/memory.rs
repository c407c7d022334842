//! Memory of a process, as the kernel counts its pages, and its growth.
//!
//! The counted pages are those of `/proc/PID/smaps` that no file on a disk backs: heap, stacks, written
//! data, and shared memory, whose messages the process maps. Pages of files are counted separately: the
//! first call of a function brings them in, and the system may take them back. The counters of
//! `/proc/PID/status` are cheaper, and on some kernels wrong by a few hundred kilobytes.

use serde::Serialize;

/// Memory of a process at a moment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Pages in use that no file on a disk backs \[kB\].
    pub taken_kb: u64,
    /// Unchanged pages of files in use \[kB\].
    pub file_kb: u64,
    /// Page faults so far that needed no disk.
    pub minor_faults: u64,
    /// Page faults so far that read from a disk.
    pub major_faults: u64,
}

impl Memory {
    /// Reads the memory of a process of this user; `None` once it has ended. Cost: a walk over its pages,
    /// during which the process continues.
    #[must_use]
    pub fn of(pid: u32) -> Option<Self> {
        let read = |name: &str| std::fs::read_to_string(format!("/proc/{pid}/{name}")).ok();
        let stat = read("stat")?;
        // Fields 10 and 12; the second one, a name in parentheses, may contain spaces.
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        let faults = |field: usize| fields.get(field - 3)?.parse().ok();
        let mut memory =
            Self { minor_faults: faults(10)?, major_faults: faults(12)?, ..Self::default() };
        memory.add_mappings(&read("smaps")?);
        Some(memory)
    }

    /// Adds the mappings of a text like `/proc/PID/smaps`: a line with the path of each, then a line for
    /// each of its sizes.
    fn add_mappings(&mut self, smaps: &str) {
        let mut is_on_disk = false;
        for line in smaps.lines() {
            let mut words = line.split_whitespace();
            let (first, second) = (words.next().unwrap_or_default(), words.next());
            let kb = second.and_then(|word| word.parse::<u64>().ok()).unwrap_or(0);
            match first {
                "Rss:" if is_on_disk => self.file_kb += kb,
                "Rss:" => self.taken_kb += kb,
                // Changed pages of a file on a disk; they are part of its `Rss` above.
                "Anonymous:" if is_on_disk => {
                    self.taken_kb += kb;
                    self.file_kb = self.file_kb.saturating_sub(kb);
                }
                _ if !first.ends_with(':') => is_on_disk = words.nth(3).is_some_and(is_disk_path),
                _ => {}
            }
        }
    }
}

/// Returns true if the path of a mapping names a file on a disk.
fn is_disk_path(path: &str) -> bool {
    let elsewhere = ["/dev/shm/", "/dev/zero", "/memfd:", "/SYSV"];
    path.starts_with('/') && !elsewhere.iter().any(|start| path.starts_with(start))
}

/// Memory of a process from the end of its warm-up on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Growth {
    /// Pages taken at the last look minus those at the first \[kB\].
    pub growth_kb: i64,
    /// Largest number of pages taken at a look \[kB\].
    pub most_kb: u64,
    /// Pages taken at the first look \[kB\].
    pub first_kb: u64,
    /// The same difference of the pages of files \[kB\].
    pub file_growth_kb: i64,
    /// Page faults between those looks that needed no disk.
    pub minor_faults: u64,
    /// Page faults between those looks that read from a disk.
    pub major_faults: u64,
    /// Number of looks.
    pub looks: u64,
}

/// Looks at the memory of a process.
#[derive(Debug, Clone, Copy, Default)]
pub struct Watch {
    first: Option<Memory>,
    growth: Growth,
}

impl Watch {
    /// Adds a look.
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

    /// Returns the result of the looks.
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
        let memory = |path: &str| {
            let mapping = format!("7f00-7f40 rw-s 00000000 fe:00 42   {path}");
            let mut memory = Memory::default();
            memory.add_mappings(&format!("{mapping}\nSize: 256 kB\nRss: 64 kB\nAnonymous: 4 kB\n"));
            [memory.taken_kb, memory.file_kb]
        };
        assert_eq!(memory("/usr/bin/chaincell"), [4, 60]);
        for path in ["", "[heap]", "[stack]", "[vdso]", "/SYSV0000004d (deleted)"] {
            assert_eq!(memory(path), [64, 0], "{path}");
        }
        for path in ["/dev/shm/iox2_abc.data", "/dev/zero (deleted)", "/memfd:a (deleted)"] {
            assert_eq!(memory(path), [64, 0], "{path}");
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
        // Other tests of this process take and give back memory too.
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
