//! Real-time privileges: they are requested, a refusal is reported, and none is required.

use iceoryx2_bb_posix::process::{Process, ProcessId, ProcessSetSchedulerError};
use iceoryx2_bb_posix::scheduler::Scheduler;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, Signal, getrlimit, set_parent_process_death_signal};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use crate::error::{Error, Result};
use crate::session::loops::wait::Wait;
use crate::words::counted;

/// Middle of the range 0 to 255, which maps to Linux's priorities 1 to 99.
const FIFO_PRIORITY: u8 = 127;

/// The process that asks; each of the two gets a different core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The tissue: it gets the last allowed core.
    Serve,
    /// The controller: it gets the allowed core before that.
    Control,
}

/// Asks for locked memory, `SCHED_FIFO` and a separate core for the calling thread. Returns each refusal with
/// its reason.
pub fn ask(role: Role, wait: Wait) -> Vec<String> {
    let mut refused = Vec::new();
    if let Err(why) = lock_memory() {
        refused.push(format!("mlockall refused: {why}"));
    }
    sharpen_timers();
    if wait == Wait::Spin {
        // A FIFO thread that never sleeps loses its core for 50 ms in each second.
        refused.push("SCHED_FIFO not asked for: a loop that spins never sleeps".to_owned());
        return refused;
    }
    match ask_fifo() {
        Ok(()) => refused.extend(pin(role)),
        // A pinned thread of ordinary priority could not move to a free core.
        Err(why) => refused.push(format!("SCHED_FIFO refused: {why}")),
    }
    refused
}

/// Asks for a termination signal when the process that started this one ends.
pub fn end_with_parent() -> Result<()> {
    set_parent_process_death_signal(Some(Signal::TERM))
        .map_err(|why| Error::check(format!("cannot follow the parent process: {why}")))
}

fn lock_memory() -> rustix::io::Result<()> {
    // If locked memory is limited, locking future mappings would make them fail.
    let flags = match getrlimit(Resource::Memlock).current {
        None => MlockAllFlags::CURRENT | MlockAllFlags::FUTURE,
        Some(_) => MlockAllFlags::CURRENT,
    };
    mlockall(flags)
}

/// Sets the least timer slack: by default ordinary threads wake up to 50 us late, to save power.
fn sharpen_timers() {
    // If the kernel refuses, the default remains.
    let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
}

fn ask_fifo() -> std::result::Result<(), String> {
    // Linux schedules threads: with the id of a thread, only that thread changes.
    let thread = rustix::thread::gettid().as_raw_nonzero().get();
    let mut thread = Process::from_pid(ProcessId::new(thread));
    match thread.set_scheduler(Scheduler::Fifo) {
        Ok(_) => {}
        Err(ProcessSetSchedulerError::InsufficientPermissions) => {
            return Err("Operation not permitted".to_owned());
        }
        Err(why) => return Err(format!("{why:?}")),
    }
    let raised = thread.set_priority(FIFO_PRIORITY);
    raised.map_err(|why| format!("{why:?}"))
}

fn pin(role: Role) -> Option<String> {
    let cores = allowed_cores();
    match core_for(role, &cores) {
        None => {
            Some(format!("pinning left out: {} allowed, two needed", counted(cores.len(), "core")))
        }
        Some(core) => pin_to(core).err().map(|_| format!("pinning to core {core} refused")),
    }
}

/// Returns the cores on which this thread may run, ascending; none if the system does not report them.
#[must_use]
pub fn allowed_cores() -> Vec<usize> {
    let allowed = sched_getaffinity(None).unwrap_or_default();
    (0..CpuSet::MAX_CPU).filter(|&core| allowed.is_set(core)).collect()
}

/// Pins the calling thread to a core.
///
/// # Errors
/// A core that does not exist or is not allowed.
pub fn pin_to(core: usize) -> rustix::io::Result<()> {
    let mut only = CpuSet::new();
    only.set(core);
    sched_setaffinity(None, &only)
}

fn core_for(role: Role, cores: &[usize]) -> Option<usize> {
    let place_from_end = match role {
        Role::Serve => 1,
        Role::Control => 2,
    };
    if cores.len() < 2 {
        return None;
    }
    cores.get(cores.len() - place_from_end).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_processes_get_different_cores() {
        let cores = [0, 3, 5];
        assert_eq!(core_for(Role::Serve, &cores), Some(5));
        assert_eq!(core_for(Role::Control, &cores), Some(3));
        assert_eq!(core_for(Role::Serve, &cores[..1]), None);
        assert_eq!(core_for(Role::Control, &[]), None);
    }
}
