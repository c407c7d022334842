//! A thread beside the loop, so that the force falls to 0 also while a tick does not end.
//!
//! It looks every [`LOOK_NS`], and every millisecond while the force falls. It speaks only while the
//! loop is in a tick: between ticks the loop itself is the watchdog.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::voice::Voice;
use crate::session::ipc::serving::AnswerPublisher;
use crate::session::timing::clock::{MILLISECOND_NS, PERIOD_NS, now_ns, sleep_until_ns};

/// Span between looks while nothing is to be said \[ns\].
const LOOK_NS: u64 = 4 * MILLISECOND_NS;
/// After so long the loop stands still: it looks at itself every 5 ms \[ns\].
const STANDS_NS: u64 = 100 * MILLISECOND_NS;

/// What the loop and the watcher share.
#[derive(Debug)]
pub struct Shared {
    voice: Mutex<Voice>,
    in_tick: AtomicBool,
    has_ended: AtomicBool,
    /// Rounds of the loop.
    rounds: AtomicU64,
}

impl Shared {
    /// Between ticks.
    #[must_use]
    pub fn new(voice: Voice) -> Self {
        Self {
            voice: Mutex::new(voice),
            in_tick: AtomicBool::new(false),
            has_ended: AtomicBool::new(false),
            rounds: AtomicU64::new(0),
        }
    }

    /// The voice, for one of the two at a time.
    pub fn voice(&self) -> MutexGuard<'_, Voice> {
        self.voice.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A tick begins.
    pub(super) fn begin_tick(&self) {
        self.in_tick.store(true, Ordering::Release);
    }

    /// It has ended.
    pub(super) fn end_tick(&self) {
        self.in_tick.store(false, Ordering::Release);
    }

    /// The loop begins a further round.
    pub(super) fn begin_round(&self) {
        self.rounds.fetch_add(1, Ordering::Relaxed);
    }

    /// The loop has ended.
    pub(super) fn end(&self) {
        self.has_ended.store(true, Ordering::Release);
    }

    /// Looks until the loop has ended. Where the loop stands still, a program may have been killed that
    /// made a connection to it: `clear` then clears up, every 100 ms.
    pub(super) fn watch(&self, answers: &AnswerPublisher, clear: impl Fn()) {
        let (mut rounds, mut since_ns) = (0, now_ns());
        while !self.has_ended.load(Ordering::Acquire) {
            let mut span_ns = LOOK_NS;
            if self.in_tick.load(Ordering::Acquire) {
                let mut voice = self.voice();
                // Looked at again with the voice in hand: the answer may have left meanwhile.
                if self.in_tick.load(Ordering::Acquire)
                    && let Some(answer) = voice.falling_in_tick(now_ns())
                {
                    // A message that shared memory does not take is followed by the next one.
                    let _ = answers.send(&answer);
                }
                if voice.is_urgent() {
                    span_ns = PERIOD_NS;
                }
            }
            let now_ns = now_ns();
            let reached = self.rounds.load(Ordering::Relaxed);
            if reached != rounds {
                (rounds, since_ns) = (reached, now_ns);
            } else if now_ns > since_ns + STANDS_NS {
                since_ns = now_ns;
                clear();
            }
            sleep_until_ns(now_ns + span_ns);
        }
    }
}
