//! The tissue of a scene by the client, and the machine's clock.

use chaincell_client::clock::{now_ns, sleep_until_ns};
use chaincell_client::{Client, Outcome, ToolPose};

use crate::drive::{Clock, Felt, Tissue};

impl Tissue for Client {
    fn step(&mut self, pose: &ToolPose, end_ns: u64) -> Result<Felt, String> {
        let wait_ns = end_ns.saturating_sub(now_ns());
        let (outcome, answer) =
            Self::step(self, &[*pose], wait_ns).map_err(|why| why.to_string())?;
        Ok(Felt {
            force_n: answer.tools[0].force_n,
            notes: answer.notes,
            is_answered: outcome == Outcome::Answered,
        })
    }

    fn is_served(&self) -> bool {
        Self::is_served(self)
    }
}

/// The monotonic clock.
#[derive(Debug, Clone, Copy)]
pub struct Monotonic;

impl Clock for Monotonic {
    fn now_ns(&self) -> u64 {
        now_ns()
    }

    fn sleep_until_ns(&self, moment_ns: u64) {
        sleep_until_ns(moment_ns);
    }
}
