//! Load beside a run: threads that copy and compute without a pause, and share nothing with it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Instant;

use serde::Serialize;

use chaincell_host::error::{Error, Result};
use chaincell_host::session::loops::realtime::{allowed_cores, pin_to};
use chaincell_host::session::timing::cold::last_level_cache_bytes;

/// Most that a thread copies to and fro \[bytes\].
const BUFFER_BYTES_MAX: usize = 64 << 20;
/// Copied between looks whether to stop \[bytes\].
const CHUNK_BYTES: usize = 1 << 20;

/// What the load did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LoadFigures {
    /// Threads that were busy all the time.
    pub threads: usize,
    /// Read and written by all of them, a second \[GB/s\].
    pub gb_per_s: f64,
}

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    bytes: AtomicU64,
}

/// Busy threads, ended with the value.
#[derive(Debug)]
pub struct Load {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    start: Instant,
}

/// Threads unless the user says otherwise: one for each core but the tissue's, at least one.
#[must_use]
pub fn default_threads() -> usize {
    allowed_cores().len().saturating_sub(1).max(1)
}

impl Load {
    /// Starts so many threads, on all cores but the last, which is the tissue's.
    ///
    /// # Errors
    /// A thread that the system refuses.
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

    /// Ends it.
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

/// Copies as much as the last-level cache holds to and fro and adds it up, until told to stop.
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
    fn threads_work_until_they_are_told_to_stop() {
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
        assert!(default_threads() >= 1);
    }
}
