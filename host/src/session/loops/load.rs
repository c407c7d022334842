//! Load during a run: threads that copy and compute without a pause, and share nothing with it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Instant;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::session::loops::realtime::{allowed_cores, pin_to};
use crate::session::timing::cold::last_level_cache_bytes;

/// Largest number of bytes that a thread copies back and forth.
const BUFFER_BYTES_MAX: usize = 64 << 20;
/// Bytes copied between two checks for the end.
const CHUNK_BYTES: usize = 1 << 20;

/// Figures of a load.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LoadFigures {
    /// Number of threads, all of them busy all the time.
    pub threads: usize,
    /// Rate at which all of them together read and write \[GB/s\].
    pub gb_per_s: f64,
}

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    bytes: AtomicU64,
}

/// Busy threads; dropping this ends them.
#[derive(Debug)]
pub struct Load {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    start: Instant,
}

impl Load {
    /// Starts `threads` threads on all cores except the last, which is the tissue's.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn start(threads: usize) -> Result<Self> {
        let cores = allowed_cores();
        let others = cores.get(..cores.len().saturating_sub(1)).unwrap_or_default();
        let mut load = Self { shared: Arc::default(), threads: Vec::new(), start: Instant::now() };
        for at in 0..threads {
            let core = others.get(at % others.len().max(1)).copied();
            let shared = Arc::clone(&load.shared);
            let thread = std::thread::Builder::new().name(format!("load {at}"));
            let started = thread.spawn(move || {
                // A core that is refused leaves the choice to the system.
                let _ = core.map(pin_to);
                work(&shared);
            });
            load.threads.push(
                started.map_err(|why| Error::check(format!("cannot start the load: {why}")))?,
            );
        }
        Ok(load)
    }

    /// Ends the threads and returns their figures.
    #[must_use]
    pub fn end(mut self) -> LoadFigures {
        let threads = self.threads.len();
        self.join();
        let bytes = self.shared.bytes.load(Ordering::Relaxed);
        let seconds = self.start.elapsed().as_secs_f64().max(1e-9);
        LoadFigures { threads, gb_per_s: bytes as f64 * 1e-9 / seconds }
    }

    fn join(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A thread that failed has ended.
            let _ = thread.join();
        }
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.join();
    }
}

/// Copies as many bytes as the last-level cache holds back and forth and adds them up, until `stop` is set.
fn work(shared: &Shared) {
    let half = last_level_cache_bytes().clamp(CHUNK_BYTES, BUFFER_BYTES_MAX / 2);
    let (mut one, mut other) = (vec![1_u8; half], vec![2_u8; half]);
    let mut sum = 0_u64;
    loop {
        for (to, from) in one.chunks_mut(CHUNK_BYTES).zip(other.chunks(CHUNK_BYTES)) {
            if shared.stop.load(Ordering::Relaxed) {
                return;
            }
            to.copy_from_slice(from);
            sum = to.iter().fold(sum, |sum, byte| sum.wrapping_mul(31) ^ u64::from(*byte));
            std::hint::black_box(sum);
            // Read and written by the copy, read by the sum.
            shared.bytes.fetch_add(3 * to.len() as u64, Ordering::Relaxed);
        }
        std::mem::swap(&mut one, &mut other);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_work_until_they_are_stopped() {
        let load = Load::start(2).unwrap();
        // Many chunks of each.
        while load.shared.bytes.load(Ordering::Relaxed) < 100 * CHUNK_BYTES as u64 {
            assert!(load.start.elapsed().as_secs() < 60, "they do not go on");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert!(!load.threads.iter().any(JoinHandle::is_finished), "a thread ended by itself");
        let figures = load.end();
        assert_eq!(figures.threads, 2);
        assert!(figures.gb_per_s > 0.0, "{figures:?}");
        assert_eq!(Load::start(0).unwrap().end(), LoadFigures::default());
    }
}
