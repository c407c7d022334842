//! The force on the hand: off on any doubt, along a ramp, and on again after a calm while.
//!
//! A function of states, answers and times alone; ramp and watchdog are the client's.

use chaincell_client::Notes;
use chaincell_client::clock::MILLISECOND_NS;
use chaincell_client::ramp::Shown;
use chaincell_client::shaper::ForceShaper;

use crate::doubt::Doubt;

/// Time without a state after which the force falls, and in which it falls \[ms\].
pub const WATCHDOG_MS: u32 = 8;
/// Length of every ramp of the force \[ms\].
pub const RAMP_MS: u32 = 8;
/// Time without a state after which there is no force, however seldom this program ran \[ns\].
pub const OFF_NS: u64 = 20 * MILLISECOND_NS;
/// Good states in a row before the tool engages.
const CALM_STATES: u32 = 100;
/// Farthest position from the device's zero \[m\].
const REACH_M: f32 = 1.0;
/// A change of position that counts as no jump, however short the time \[m\].
const STEP_M: f32 = 0.005;

/// Stage of a hand on the tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// No force, and the tool is not engaged, until all was calm for a while.
    Waiting,
    /// The tool is engaged, and its force is shown.
    Engaged,
    /// The tool is not engaged, and the force falls.
    Falling,
}

/// The last good state.
#[derive(Debug, Clone, Copy)]
struct LastState {
    position_m: [f32; 3],
    at_ns: u64,
}

/// Decides on the force that the device gets.
#[derive(Debug)]
pub struct Guard {
    shaper: ForceShaper,
    phase: Phase,
    max_force_n: f32,
    max_speed_m_per_s: f32,
    last: Option<LastState>,
    started_ns: u64,
    calm_states: u32,
    /// True if the tissue's last answer is fresh.
    has_answer: bool,
    /// Doubt at present, and how often each began.
    doubt: Option<Doubt>,
    counts: [u64; Doubt::ALL.len()],
    shown_n: [f32; 3],
    largest_n: f32,
}

impl Guard {
    /// Starts without a force.
    #[must_use]
    pub fn new(max_force_n: f32, max_speed_m_per_s: f32, now_ns: u64) -> Self {
        let mut shaper = ForceShaper::new(WATCHDOG_MS, RAMP_MS, f32::INFINITY, now_ns);
        shaper.begin_at_zero();
        Self {
            shaper,
            phase: Phase::Waiting,
            max_force_n,
            max_speed_m_per_s,
            last: None,
            started_ns: now_ns,
            calm_states: 0,
            has_answer: false,
            doubt: None,
            counts: [0; Doubt::ALL.len()],
            shown_n: [0.0; 3],
            largest_n: 0.0,
        }
    }

    /// Takes a position of the device \[m\].
    ///
    /// # Errors
    /// A doubt in it: the force falls from here on.
    pub fn state(&mut self, position_m: [f32; 3], now_ns: u64) -> Result<(), Doubt> {
        if !position_m.iter().all(|x| x.abs() <= REACH_M) {
            return Err(self.doubt(Doubt::OutOfReach));
        }
        // A good position, also after a jump: the next one is compared with it.
        let before = self.last.replace(LastState { position_m, at_ns: now_ns });
        self.shaper.hear(now_ns);
        if before.is_some_and(|before| self.is_jump(&before, position_m, now_ns)) {
            return Err(self.doubt(Doubt::Jump));
        }
        self.calm_states = self.calm_states.saturating_add(1);
        if self.phase == Phase::Waiting && self.has_answer && self.calm_states >= CALM_STATES {
            self.phase = Phase::Engaged;
            self.doubt = None;
            self.shaper.begin_ramp();
        }
        Ok(())
    }

    fn is_jump(&self, before: &LastState, position_m: [f32; 3], now_ns: u64) -> bool {
        let squares =
            position_m.iter().zip(before.position_m).map(|(to, from)| (to - from).powi(2));
        let seconds = now_ns.saturating_sub(before.at_ns).min(OFF_NS) as f32 * 1e-9;
        squares.sum::<f32>().sqrt() > STEP_M + self.max_speed_m_per_s * seconds
    }

    /// Takes the client's notes on the tissue's last answer, after each pose.
    pub fn answer(&mut self, notes: Notes) {
        let old = Notes(Notes::NOTHING_YET.0 + Notes::NEW_SESSION.0 + Notes::SILENT.0);
        self.has_answer = notes.0 & old.0 == 0;
        if notes.contains(Notes::NOTHING_YET) {
            self.calm_states = 0;
        } else if notes.contains(Notes::NEW_SESSION) {
            self.doubt(Doubt::NewSession);
        } else if notes.contains(Notes::SILENT) {
            self.doubt(Doubt::TissueSilent);
        }
    }

    /// Takes a doubt, and returns it: the force falls, and the calm while begins anew.
    pub fn doubt(&mut self, doubt: Doubt) -> Doubt {
        if self.doubt != Some(doubt) {
            self.doubt = Some(doubt);
            self.counts[doubt as usize] += 1;
        }
        self.let_go();
        doubt
    }

    /// Lets the force fall.
    pub fn let_go(&mut self) {
        if self.phase == Phase::Engaged {
            self.shaper.begin_fall();
            self.phase = Phase::Falling;
        }
        self.calm_states = 0;
    }

    /// Returns the force to send now \[N\]; `wanted_n` is that of the tissue's last answer.
    pub fn force(&mut self, wanted_n: [f32; 3], now_ns: u64) -> [f32; 3] {
        let target = match self.phase {
            Phase::Engaged => Shown::of(limited(wanted_n, self.max_force_n)),
            Phase::Waiting | Phase::Falling => Shown::ZERO,
        };
        // The watchdog goes before: what it returns falls already.
        let shown = match self.shaper.wait(now_ns) {
            Some(fall) => {
                // A service without a good state says why. While the force falls anyway, as at the end of the program,
                // nobody asks for states.
                let is_falling = self.phase == Phase::Falling;
                self.phase = Phase::Falling;
                if !is_falling && !self.doubt.is_some_and(Doubt::is_of_states) {
                    self.doubt(Doubt::ServiceSilent);
                }
                self.calm_states = 0;
                fall.shown
            }
            None => self.shaper.shape(&target, now_ns),
        };
        self.shown_n = shown.force_n[0];
        if now_ns.saturating_sub(self.heard_ns()) >= OFF_NS {
            self.shaper.begin_at_zero();
            self.shown_n = [0.0; 3];
        }
        if self.phase == Phase::Falling && self.shown_n == [0.0; 3] {
            (self.phase, self.calm_states) = (Phase::Waiting, 0);
        }
        self.largest_n = self.largest_n.max(size(self.shown_n));
        self.shown_n
    }

    /// Returns true while the tool is engaged.
    #[must_use]
    pub fn is_engaged(&self) -> bool {
        self.phase == Phase::Engaged
    }

    /// Returns the doubt for which there is no force, if there is one.
    #[must_use]
    pub fn present_doubt(&self) -> Option<Doubt> {
        self.doubt
    }

    /// Returns how often each doubt began, in the order of [`Doubt::ALL`].
    #[must_use]
    pub fn counts(&self) -> [u64; Doubt::ALL.len()] {
        self.counts
    }

    /// Returns the time of the last good position, that of the start before the first \[ns\].
    #[must_use]
    pub fn heard_ns(&self) -> u64 {
        self.last.map_or(self.started_ns, |last| last.at_ns)
    }

    /// Returns the force of the last call of [`Self::force`] \[N\].
    #[must_use]
    pub fn shown_n(&self) -> [f32; 3] {
        self.shown_n
    }

    /// Returns the largest force so far \[N\].
    #[must_use]
    pub fn largest_n(&self) -> f32 {
        self.largest_n
    }
}

/// Returns the size of a force \[N\].
fn size(force_n: [f32; 3]) -> f32 {
    force_n.iter().map(|x| x * x).sum::<f32>().sqrt()
}

/// Shortens a force to a limit; one that is not finite is none.
fn limited(force_n: [f32; 3], max_n: f32) -> [f32; 3] {
    let size_n = size(force_n);
    if !size_n.is_finite() {
        [0.0; 3]
    } else if size_n > max_n {
        force_n.map(|x| x * (max_n / size_n))
    } else {
        force_n
    }
}

#[cfg(test)]
mod tests;
