//! A thread that lowers the force to 0 also while a tick does not end.
//!
//! It checks every [`LOOK_NS`], and every millisecond while the force falls. It publishes only while the loop
//! is in a tick: between ticks the loop itself is the watchdog.
//!
//! Leftovers of killed programs have a thread of their own: it waits for the file system, which a falling
//! force must not.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::park_timeout;
use std::time::Duration;

use super::voice::Voice;
use crate::session::ipc::serving::AnswerPublisher;
use crate::session::timing::clock::{MILLISECOND_NS, PERIOD_NS, now_ns, sleep_until_ns};

/// Time between checks while there is nothing to publish \[ns\].
const LOOK_NS: u64 = 4 * MILLISECOND_NS;
/// Time after which the loop counts as stopped: it makes a round at least every 5 ms.
const STANDS: Duration = Duration::from_millis(100);

/// State shared by the loop and the watcher.
#[derive(Debug)]
pub struct Shared {
    voice: Mutex<Voice>,
    in_tick: AtomicBool,
    has_ended: AtomicBool,
    /// Number of rounds of the loop.
    rounds: AtomicU64,
}

impl Shared {
    /// The state between ticks.
    #[must_use]
    pub fn new(voice: Voice) -> Self {
        Self {
            voice: Mutex::new(voice),
            in_tick: AtomicBool::new(false),
            has_ended: AtomicBool::new(false),
            rounds: AtomicU64::new(0),
        }
    }

    /// Locks the voice, for one of the two at a time.
    pub fn voice(&self) -> MutexGuard<'_, Voice> {
        self.voice.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes the start of a tick.
    pub(super) fn begin_tick(&self) {
        self.in_tick.store(true, Ordering::Release);
    }

    /// Notes its end.
    pub(super) fn end_tick(&self) {
        self.in_tick.store(false, Ordering::Release);
    }

    /// Notes a further round of the loop.
    pub(super) fn begin_round(&self) {
        self.rounds.fetch_add(1, Ordering::Relaxed);
    }

    /// Notes the end of the loop.
    pub(super) fn end(&self) {
        self.has_ended.store(true, Ordering::Release);
    }

    /// Lowers the force while a tick does not end, until the loop has ended.
    pub(super) fn watch(&self, answers: &AnswerPublisher) {
        while !self.has_ended.load(Ordering::Acquire) {
            let mut span_ns = LOOK_NS;
            if self.in_tick.load(Ordering::Acquire) {
                let mut voice = self.voice();
                // Checked again with the voice locked: the tick may have ended meanwhile.
                if self.in_tick.load(Ordering::Acquire)
                    && let Some(answer) = voice.falling_in_tick(now_ns())
                {
                    // A message that shared memory does not accept is followed by the next one.
                    let _ = answers.send(&answer);
                }
                if voice.is_urgent() {
                    span_ns = PERIOD_NS;
                }
            }
            sleep_until_ns(now_ns() + span_ns);
        }
    }

    /// Calls `clear` every 100 ms in which the loop makes no round, until it has ended and wakes this thread: a
    /// program may have been killed while it connected, and the loop then waits for its leftovers to go.
    pub(super) fn clear_when_it_stands(&self, clear: impl Fn()) {
        let mut last_rounds = None;
        while !self.has_ended.load(Ordering::Acquire) {
            let rounds = Some(self.rounds.load(Ordering::Relaxed));
            if rounds == last_rounds {
                clear();
            }
            last_rounds = rounds;
            park_timeout(STANDS);
        }
    }
}
