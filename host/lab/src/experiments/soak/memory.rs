//! Memory that a process takes, as the kernel counts its pages, and whether it grew.
//!
//! Taken are the pages of `/proc/PID/smaps` that no file on a disk backs: heap, stacks, written
//! data, and shared memory, whose messages the process maps. Pages of the program's own text are
//! told apart: the first call of a function brings them in, and the system may take them back. The
//! counters of `/proc/PID/status` are cheaper, and on some kernels off by a few hundred kilobytes.

use std::fs;

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
        let (taken_kb, file_kb) = pages(&fs::read_to_string(format!("/proc/{pid}/smaps")).ok()?);
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let (minor_faults, major_faults) = faults(&stat)?;
        Some(Self { taken_kb, file_kb, minor_faults, major_faults })
    }
}

/// Taken and file-backed pages of a process's `smaps` \[kB\].
fn pages(smaps: &str) -> (u64, u64) {
    let (mut taken_kb, mut file_kb) = (0, 0);
    let (mut on_disk, mut resident_kb) = (false, 0);
    for line in smaps.lines() {
        let mut words = line.split_whitespace();
        let Some(first) = words.next() else { continue };
        let size_kb = || line.split_whitespace().nth(1).and_then(|kb| kb.parse::<u64>().ok());
        match first {
            "Rss:" => {
                resident_kb = size_kb().unwrap_or(0);
                if !on_disk {
                    taken_kb += resident_kb;
                }
            }
            "Anonymous:" if on_disk => {
                let written_kb = size_kb().unwrap_or(0);
                taken_kb += written_kb;
                file_kb += resident_kb.saturating_sub(written_kb);
            }
            // 7f00-7f10 r--p 00000000 08:01 4711 /usr/lib/libc.so.6
            _ if !first.ends_with(':') => on_disk = words.nth(4).is_some_and(is_on_disk),
            _ => {}
        }
    }
    (taken_kb, file_kb)
}

fn is_on_disk(path: &str) -> bool {
    let in_memory = ["/dev/shm/", "/dev/zero", "/memfd:", "/SYSV"];
    path.starts_with('/') && !in_memory.iter().any(|start| path.starts_with(start))
}

/// Minor and major page faults of a process's `stat`.
fn faults(stat: &str) -> Option<(u64, u64)> {
    // The name stands in brackets and may hold anything; the state follows.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(7);
    let minor = fields.next()?.parse().ok()?;
    Some((minor, fields.nth(1)?.parse().ok()?))
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

    const SMAPS: &str = "\
55d0-55e0 r-xp 00000000 08:01 42    /usr/bin/chaincell
Size:                 64 kB
Rss:                  40 kB
Anonymous:             8 kB
VmFlags: rd ex mr mw me
7ff0-7ff1 rw-s 00000000 00:1a 7     /dev/shm/iox2_abc.data
Rss:                  20 kB
Anonymous:             0 kB
5600-5700 rw-p 00000000 00:00 0     [heap]
Rss:                 100 kB
Anonymous:           100 kB
7e00-7e10 rw-p 00000000 00:00 0
Rss:                   4 kB
Anonymous:             4 kB
";

    #[test]
    fn what_no_disk_backs_is_taken() {
        assert_eq!(pages(SMAPS), (8 + 20 + 100 + 4, 32));
        assert_eq!(pages(""), (0, 0));
    }

    #[test]
    fn faults_are_found_behind_any_name() {
        let stat = "7 (a) b) S 1 7 7 0 -1 4194304 123 9 45 0 1 2 3";
        assert_eq!(faults(stat), Some((123, 45)));
        assert_eq!(faults("7 (x"), None);
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
