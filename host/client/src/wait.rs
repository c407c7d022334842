//! Waits of a loop for the next message: sleeping, polling, or sleeping until woken.

use std::time::Duration;

use chaincell_kernel::choices;

use crate::clock::{MILLISECOND_NS, PERIOD_NS, now_ns, sleep_until_ns};
use crate::services::Wake;

/// Polling starts this long before the expected moment \[ns\].
const LEAD_NS: u64 = 100_000;
/// Longest polling for one message \[ns\].
const POLL_NS: u64 = 200_000;
/// Polling period while a message is late \[ns\].
const LATE_STEP_NS: u64 = 50_000;
/// Time without a message after which the peer counts as absent \[ns\].
const ABSENT_NS: u64 = 100 * MILLISECOND_NS;
/// Polling period while the peer is absent, short enough for its first message's deadline \[ns\].
const ABSENT_STEP_NS: u64 = MILLISECOND_NS / 4;
/// Time before a deadline that is polled, since a sleep ends late \[ns\].
const APPROACH_NS: u64 = 60_000;
/// Longest wait for a wake-up: a peer that sends none is noticed after this time \[ns\].
const WAKE_STEP_NS: u64 = MILLISECOND_NS;

choices! {
    /// How to wait for the next message.
    #[derive(Default)]
    Wait {
        /// Sleep until shortly before the message is expected, poll for at most 200 us, then short
        /// sleeps.
        #[default]
        Hybrid = 0, "hybrid";
        /// Poll all the time: the shortest answers, but only with a free core for each side.
        Spin = 1, "spin";
        /// Sleep until the sender wakes this process: no polling, the longest answers.
        Event = 2, "event";
    }
}

/// Waits for messages of one peer and learns the time at which the next one is due.
///
/// ```
/// use chaincell_client::clock::{MILLISECOND_NS, now_ns};
/// use chaincell_client::wait::{Wait, Waiter};
/// use chaincell_kernel::Choice;
///
/// let mode = Wait::from_name("hybrid").ok_or("no such way to wait")?;
/// let waiter = Waiter::new(mode, 200_000); // answers take 0.2 ms or so [ns]
/// let moment_ns = now_ns() + MILLISECOND_NS;
/// waiter.until(moment_ns); // a sleep, then polling for at most 60 us
/// assert!(now_ns() >= moment_ns);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug)]
pub struct Waiter {
    mode: Wait,
    typical_ns: u64,
    expected_ns: Option<u64>,
    last_message_ns: u64,
}

impl Waiter {
    /// Starts with a guess of the delay between the cause of a message and its arrival \[ns\].
    #[must_use]
    pub fn new(mode: Wait, typical_ns: u64) -> Self {
        Self { mode, typical_ns: typical_ns.min(PERIOD_NS), expected_ns: None, last_message_ns: 0 }
    }

    /// Notes that a message arrived at `arrival_ns`, `span_ns` after its cause.
    pub fn arrived(&mut self, arrival_ns: u64, span_ns: u64) {
        let span_ns = span_ns.min(PERIOD_NS);
        self.typical_ns = (7 * self.typical_ns + span_ns) / 8;
        self.last_message_ns = arrival_ns;
        self.expected_ns = None;
    }

    /// Notes that the cause of the next message happened at `cause_ns`.
    pub fn expect_after(&mut self, cause_ns: u64) {
        self.expected_ns = Some(cause_ns + self.typical_ns);
    }

    /// Makes one step of waiting, at most until the deadline; then the caller checks again.
    pub fn pause(&self, deadline_ns: u64, wake: &Wake) {
        let now_ns = now_ns();
        if now_ns >= deadline_ns {
            return;
        }
        let absent = now_ns.saturating_sub(self.last_message_ns) > ABSENT_NS;
        match (self.mode, self.expected_ns) {
            (Wait::Event, Some(_)) => wait_for_wake(now_ns, deadline_ns, wake),
            (_, None) => self.approach(deadline_ns),
            (_, Some(_)) if absent => self.nap(now_ns, ABSENT_STEP_NS, deadline_ns),
            (Wait::Spin, Some(_)) => std::hint::spin_loop(),
            (Wait::Hybrid, Some(expected_ns)) => {
                self.poll_or_sleep(now_ns, expected_ns, deadline_ns)
            }
        }
    }

    /// Waits until `moment_ns`, as precisely as the mode allows.
    pub fn until(&self, moment_ns: u64) {
        while now_ns() < moment_ns {
            self.approach(moment_ns);
        }
    }

    fn poll_or_sleep(&self, now_ns: u64, expected_ns: u64, deadline_ns: u64) {
        let poll_from_ns = expected_ns.saturating_sub(LEAD_NS);
        if now_ns < poll_from_ns {
            self.nap(now_ns, poll_from_ns - now_ns, deadline_ns);
        } else if now_ns < poll_from_ns + POLL_NS {
            std::hint::spin_loop();
        } else {
            self.nap(now_ns, LATE_STEP_NS, deadline_ns);
        }
    }

    fn nap(&self, now_ns: u64, span_ns: u64, deadline_ns: u64) {
        if now_ns + span_ns < deadline_ns {
            sleep_until_ns(now_ns + span_ns);
        } else {
            self.approach(deadline_ns);
        }
    }

    /// Makes one step of waiting for `moment_ns`: a sleep, then polling if the mode polls.
    fn approach(&self, moment_ns: u64) {
        let polled_ns = match self.mode {
            Wait::Event => 0,
            Wait::Hybrid => APPROACH_NS,
            Wait::Spin => ABSENT_NS,
        };
        let sleep_until = moment_ns.saturating_sub(polled_ns);
        if now_ns() < sleep_until {
            sleep_until_ns(sleep_until);
        } else {
            std::hint::spin_loop();
        }
    }
}

fn wait_for_wake(now_ns: u64, deadline_ns: u64, wake: &Wake) {
    let span_ns = (deadline_ns - now_ns).min(WAKE_STEP_NS);
    if !wake.wait(Duration::from_nanos(span_ns)) {
        sleep_until_ns(now_ns + span_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_waiter_learns_the_span_and_never_expects_more_than_a_period() {
        let mut waiter = Waiter::new(Wait::Hybrid, PERIOD_NS);
        for _ in 0..200 {
            waiter.arrived(1, 300_000);
        }
        waiter.expect_after(1_000_000);
        let expected_ns = waiter.expected_ns.unwrap();
        assert!((1_300_000..1_300_010).contains(&expected_ns), "{expected_ns}");
        for _ in 0..200 {
            waiter.arrived(1, u64::MAX);
        }
        assert!(waiter.typical_ns <= PERIOD_NS);
        assert_eq!(waiter.expected_ns, None);
    }

    #[test]
    fn until_never_returns_early() {
        for mode in [Wait::Hybrid, Wait::Spin, Wait::Event] {
            let moment_ns = now_ns() + MILLISECOND_NS;
            Waiter::new(mode, PERIOD_NS).until(moment_ns);
            assert!(now_ns() >= moment_ns);
        }
    }
}
