//! The answer that a caller is shown: a function of the answers received and of the time alone.
//!
//! The force of an answer counts until the next one, at most for the time of the watchdog. Then it falls
//! to 0 along a ramp; with the next answer it rises along one. It is always finite.

use chaincell_kernel::Flags;

use crate::ramp::Shown;
use crate::shaper::ForceShaper;
use crate::tools::{TOOLS_MAX, ToolForces};

chaincell_kernel::flags! {
    /// Notes of the client itself on an answer, a sum.
    ///
    /// ```
    /// use chaincell_client::Notes;
    ///
    /// let notes = Notes(2 + 4); // as C and Python have them
    /// assert!(notes.contains(Notes::SILENT) && notes.contains(Notes::RAMP)); // the force falls
    /// assert!(!notes.contains(Notes::NEW_SESSION));
    /// ```
    Notes {
        /// No answer has come yet.
        NOTHING_YET = 1;
        /// No answer for the time of the watchdog: the force falls, or is 0.
        SILENT = 2;
        /// The force is on a ramp, and not yet the force of the tissue.
        RAMP = 4;
        /// A new session has answered, of another server: its tissue is at rest, or where `serve --restore` or
        /// `serve --stand-by` took it up. Tools get no force until they were released. The note stays until the first
        /// answer in which no tool must be released.
        NEW_SESSION = 8;
    }
}

/// Force and torque on a tool.
///
/// ```
/// use chaincell_client::{Flags, ToolOutput};
///
/// let output = ToolOutput { force_n: [0.0, 3.0, 4.0], flags: 8, ..ToolOutput::default() }; // of an answer
/// let magnitude_n = output.force_n.iter().map(|x| x * x).sum::<f32>().sqrt();
/// assert_eq!(magnitude_n, 5.0); // [N]
/// assert!(Flags(output.flags).contains(Flags::FORCE_CLAMPED)); // the tissue would push harder
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct ToolOutput {
    /// Force of the tissue on it \[N\].
    pub force_n: [f32; 3],
    /// Torque on it about its position \[N m\].
    pub torque_n_m: [f32; 3],
    /// Number of cells it holds, or of triangles it is in contact with.
    pub contacts: u32,
    /// Limits and events of the tool, see [`chaincell_kernel::Flags`].
    pub flags: u32,
}

/// The answer to show at a moment.
///
/// ```
/// use chaincell_client::{Answer, ToolOutput};
///
/// // `Client::step` gives one; before the first all of it is 0.
/// let none = Answer::default();
/// assert_eq!((none.tick, none.tools[0]), (0, ToolOutput::default()));
/// let answer = Answer { tick: 41, force_tick: 40, round_trip_ns: 250_000, ..none };
/// assert!(answer.round_trip_ns < 1_000_000); // [ns], within a tick of 1 kHz
/// assert_eq!(answer.tick - answer.force_tick, 1); // a late tick repeats an earlier force
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Answer {
    /// Number of the tick that was answered last, 0 before the first.
    pub tick: u64,
    /// Session of the server that answered, 0 before the first.
    pub session_id: u64,
    /// Number of the tick whose pose the force belongs to.
    pub force_tick: u64,
    /// Hash of the state after the tick, 0 if none was computed.
    pub state_hash: u64,
    /// Time from sending the pose to its answer \[ns\].
    pub round_trip_ns: u64,
    /// Age of the answer \[ns\].
    pub age_ns: u64,
    /// Number of answers received.
    pub answers: u64,
    /// Certified upper bound of the elastic energy of the published state \[J\].
    pub energy_j: f32,
    /// Limits and events of the tick, see [`chaincell_kernel::Flags`].
    pub flags: u32,
    /// Notes of the client itself.
    pub notes: Notes,
    /// Duration of the tick in the server \[ns\].
    pub step_ns: u32,
    /// Sweeps made in the tick, 0 in a late one.
    pub sweeps: u32,
    /// Force and torque on each tool, by its number.
    pub tools: [ToolOutput; TOOLS_MAX],
    /// Estimated error of each tool's force, before its limit \[N\]; `None` where it is not known, where an output
    /// stage answers another force than the tissue's, and while the client shows another force than the server's.
    pub force_error_n: [Option<f32>; TOOLS_MAX],
    /// Estimated error of each tool's torque likewise, `None` for held cells too \[N m\].
    pub torque_error_n_m: [Option<f32>; TOOLS_MAX],
}

/// The last answer received, and the forces shown: for a transport of its own.
///
/// ```
/// use chaincell_client::clock::MILLISECOND_NS as MS;
/// use chaincell_client::{Hearing, tools::ToolForces};
///
/// let mut hearing = Hearing::new(20, 0, 0); // watchdog 20 ms, no ramp
/// let mut forces = ToolForces { tick: 1, session_id: 7, tools: 1, ..ToolForces::default() };
/// forces.each[0].force_n = [0.0, 0.0, 2.0];
/// assert!(hearing.hear(&forces, MS)); // an answer
/// hearing.wait(20 * MS);
/// assert_eq!(hearing.answer(20 * MS).tools[0].force_n[2], 2.0); // [N], the last force holds
/// hearing.wait(21 * MS);
/// assert_eq!(hearing.answer(21 * MS).tools[0].force_n[2], 0.0);
/// assert!(hearing.is_silent());
/// ```
#[derive(Debug)]
pub struct Hearing {
    shaper: ForceShaper,
    shown: Shown,
    last: Answer,
    heard_ns: u64,
    is_silent: bool,
    is_new_session: bool,
}

impl Hearing {
    /// Starts without an answer and with no force shown; watchdog and ramp as in [`Options`](crate::Options).
    #[must_use]
    pub fn new(watchdog_ms: u32, ramp_ms: u32, now_ns: u64) -> Self {
        let mut shaper = ForceShaper::new(watchdog_ms, ramp_ms, f32::INFINITY, now_ns);
        shaper.begin_at_zero();
        Self {
            shaper,
            shown: Shown::ZERO,
            last: Answer::default(),
            heard_ns: now_ns,
            is_silent: false,
            is_new_session: false,
        }
    }

    /// Takes a message. Returns true if it is an answer, false if it is the server's falling force in a
    /// silence.
    pub fn hear(&mut self, forces: &ToolForces, now_ns: u64) -> bool {
        // Another session: ramp from the force shown to its force.
        if self.last.session_id != 0 && forces.session_id != self.last.session_id {
            self.is_new_session = true;
            self.shaper.begin_ramp();
        }
        self.shaper.hear(now_ns);
        self.is_silent = false;
        self.heard_ns = now_ns;
        // The force and torque of each tool, by its number.
        let mut told = Shown::ZERO;
        let mut tools = [ToolOutput::default(); TOOLS_MAX];
        for (at, of) in forces.each_tool() {
            (told.force_n[at], told.torque_n_m[at]) = (of.force_n, of.torque_n_m);
            (tools[at].contacts, tools[at].flags) = (of.contacts, of.flags);
        }
        // Shape them. The error of a force that is not the server's is not known.
        self.shown = self.shaper.shape(&told, now_ns);
        let (mut force_error_n, mut torque_error_n_m) = ([None; TOOLS_MAX], [None; TOOLS_MAX]);
        for (at, of) in forces.each_tool().filter(|(at, of)| self.shown.force_n[*at] == of.force_n)
        {
            (force_error_n[at], torque_error_n_m[at]) = (of.error_n(), of.torque_error_n_m());
        }
        // Keep the rest of the message.
        let is_stale = Flags(forces.flags).contains(Flags::STALE);
        self.last = Answer {
            tick: forces.tick,
            session_id: forces.session_id,
            force_tick: forces.force_tick,
            state_hash: forces.state_hash,
            round_trip_ns: match is_stale {
                true => self.last.round_trip_ns,
                false => now_ns.saturating_sub(forces.send_ns),
            },
            age_ns: 0,
            answers: self.last.answers + u64::from(!is_stale),
            energy_j: if forces.energy_j.is_finite() { forces.energy_j } else { 0.0 },
            flags: forces.flags,
            notes: Notes::default(),
            step_ns: forces.step_ns,
            sweeps: forces.sweeps,
            tools,
            force_error_n,
            torque_error_n_m,
        };
        !is_stale
    }

    /// Notes that no message has come up to `now_ns`.
    pub fn wait(&mut self, now_ns: u64) {
        if let Some(fall) = self.shaper.wait(now_ns) {
            (self.shown, self.is_silent) = (fall.shown, true);
            self.last.force_error_n = [None; TOOLS_MAX];
            self.last.torque_error_n_m = [None; TOOLS_MAX];
        }
    }

    /// Returns true if the watchdog has expired.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// Returns the answer to show now. It reports a new session once, or until its tools were released.
    pub fn answer(&mut self, now_ns: u64) -> Answer {
        let mut answer = self.last;
        answer.age_ns = now_ns.saturating_sub(self.heard_ns);
        for (at, felt) in answer.tools.iter_mut().enumerate() {
            (felt.force_n, felt.torque_n_m) = (self.shown.force_n[at], self.shown.torque_n_m[at]);
        }
        let notes = [
            (self.last.session_id == 0, Notes::NOTHING_YET),
            (self.is_silent, Notes::SILENT),
            (!self.shaper.is_done(), Notes::RAMP),
            (self.is_new_session, Notes::NEW_SESSION),
        ];
        let set = notes.iter().filter(|(is_set, _)| *is_set);
        answer.notes = Notes(set.map(|(_, note)| note.0).sum());
        let must_release = Flags(answer.flags).contains(Flags::RELEASE_FIRST);
        self.is_new_session &= self.is_silent || must_release;
        answer
    }

    /// Returns the largest change between two forces of a tool shown one after the other \[N\].
    #[must_use]
    pub fn largest_step_n(&self) -> f32 {
        self.shaper.largest_step_n()
    }

    /// Returns the number of silences longer than the watchdog's time.
    #[must_use]
    pub fn silences(&self) -> u64 {
        self.shaper.silences()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::MILLISECOND_NS;
    use crate::tools::{OneToolForce, UNKNOWN_N};

    const MS: u64 = MILLISECOND_NS;

    /// An answer with forces on tools 0 and 3.
    fn forces(tick: u64, session_id: u64, force_n: f32) -> ToolForces {
        let mut forces = ToolForces { tick, session_id, tools: 2, ..ToolForces::default() };
        forces.each[0] = OneToolForce { force_n: [force_n, 0.0, 0.0], ..Default::default() };
        let torque_n_m = [0.0, force_n / 10.0, 0.0];
        forces.each[1] = OneToolForce { number: 3, contacts: 5, torque_n_m, ..Default::default() };
        forces
    }

    #[test]
    fn an_error_belongs_to_the_force_of_the_server() {
        let mut hearing = Hearing::new(50, 10, 0);
        let told = |tick| {
            let mut forces = forces(tick, 1, 2.0);
            (forces.each[0].force_error_n, forces.each[1].force_error_n) = (0.25, UNKNOWN_N);
            (forces.each[0].torque_error_n_m, forces.each[1].torque_error_n_m) = (0.125, UNKNOWN_N);
            forces
        };
        // On the ramp of a new session, and behind it.
        hearing.hear(&told(1), 5 * MS);
        assert_eq!(hearing.answer(5 * MS).force_error_n, [None; TOOLS_MAX]);
        (6..=20).for_each(|ms| _ = hearing.hear(&told(ms), ms * MS));
        let known = hearing.answer(20 * MS).force_error_n;
        assert_eq!((known[0], known[3]), (Some(0.25), None));
        let known = hearing.answer(20 * MS).torque_error_n_m;
        assert_eq!((known[0], known[3]), (Some(0.125), None));
        // In a silence.
        hearing.wait(75 * MS);
        let answer = hearing.answer(75 * MS);
        assert_eq!((answer.force_error_n[0], answer.torque_error_n_m[0]), (None, None));
    }

    fn size_n(answer: &Answer) -> f32 {
        answer.tools[0].force_n[0]
    }

    /// Takes an answer each millisecond up to `up_to_ms`, and returns the answer shown then.
    fn heard(hearing: &mut Hearing, up_to_ms: u64) -> Answer {
        for ms in 1..=up_to_ms {
            assert!(hearing.hear(&forces(ms, 1, 4.0), ms * MS));
        }
        hearing.answer(up_to_ms * MS)
    }

    #[test]
    fn before_the_first_answer_there_is_no_force() {
        let mut hearing = Hearing::new(20, 10, 0);
        for ms in 0..100 {
            hearing.wait(ms * MS);
            let answer = hearing.answer(ms * MS);
            assert!(answer.notes.contains(Notes::NOTHING_YET), "{ms}");
            assert_eq!(answer.tools, [ToolOutput::default(); TOOLS_MAX]);
        }
    }

    #[test]
    fn the_first_force_rises_and_then_is_shown_as_it_is() {
        let mut hearing = Hearing::new(20, 10, 0);
        let mut last_n = 0.0;
        for ms in 1..=10 {
            hearing.hear(&forces(ms, 1, 4.0), ms * MS);
            let answer = hearing.answer(ms * MS);
            assert!((size_n(&answer) - last_n - 0.4).abs() < 1e-5, "{ms}: {answer:?}");
            assert_eq!(answer.notes.contains(Notes::RAMP), ms < 10);
            last_n = size_n(&answer);
        }
        let answer = heard(&mut hearing, 11);
        assert_eq!((answer.tick, answer.session_id, answer.notes), (11, 1, Notes::default()));
        assert_eq!((size_n(&answer), answer.tools[3].torque_n_m[1]), (4.0, 0.4));
        assert_eq!((answer.tools[3].contacts, answer.tools[1]), (5, ToolOutput::default()));
    }

    #[test]
    fn in_a_silence_the_force_holds_for_the_watchdog_and_then_falls_to_exactly_zero() {
        let mut hearing = Hearing::new(20, 10, 0);
        heard(&mut hearing, 30);
        let mut last_n = 4.0;
        for ms in 31..70 {
            hearing.wait(ms * MS);
            let answer = hearing.answer(ms * MS);
            assert_eq!(answer.age_ns, (ms - 30) * MS);
            assert_eq!(answer.notes.contains(Notes::SILENT), ms >= 50, "{ms}");
            assert_eq!(hearing.is_silent(), ms >= 50);
            let wanted_n = 4.0 - 0.4 * (ms as f32 - 49.0).clamp(0.0, 10.0);
            assert!((size_n(&answer) - wanted_n).abs() < 1e-5, "{ms}: {answer:?}");
            assert!(last_n - size_n(&answer) < 0.4 + 1e-5);
            last_n = size_n(&answer);
        }
        let answer = hearing.answer(70 * MS);
        assert!(answer.tools.iter().all(|of| of.force_n == [0.0; 3] && of.torque_n_m == [0.0; 3]));
        assert_eq!(hearing.silences(), 1);
        // It comes again along a ramp.
        hearing.hear(&forces(71, 1, 4.0), 71 * MS);
        let answer = hearing.answer(71 * MS);
        assert!((size_n(&answer) - 0.4).abs() < 1e-5, "{answer:?}");
        assert_eq!((answer.notes, hearing.is_silent()), (Notes::RAMP, false));
        assert!(hearing.largest_step_n() < 0.4 + 1e-5);
    }

    #[test]
    fn a_caller_that_stood_still_sees_no_jump() {
        let mut hearing = Hearing::new(20, 10, 0);
        heard(&mut hearing, 30);
        hearing.wait(1000 * MS);
        assert!((size_n(&hearing.answer(1000 * MS)) - 3.6).abs() < 1e-5);
        hearing.hear(&forces(31, 1, 0.0), 1000 * MS);
        assert!(size_n(&hearing.answer(1000 * MS)) > 3.0);
    }

    #[test]
    fn another_session_is_told_once_or_until_the_tool_was_released() {
        let mut hearing = Hearing::new(20, 10, 0);
        assert!(!heard(&mut hearing, 30).notes.contains(Notes::NEW_SESSION));
        let is_new = |hearing: &mut Hearing, ms: u64| {
            hearing.answer(ms * MS).notes.contains(Notes::NEW_SESSION)
        };
        let first_release = ToolForces { flags: Flags::RELEASE_FIRST.0, ..forces(31, 2, 0.0) };
        for ms in 31..40 {
            hearing.hear(&ToolForces { tick: ms, ..first_release }, ms * MS);
            let answer = hearing.answer(ms * MS);
            assert!(answer.notes.contains(Notes::NEW_SESSION) && answer.session_id == 2, "{ms}");
            assert!((size_n(&answer) - (4.0 - 0.4 * (ms - 30) as f32)).abs() < 1e-5, "no jump");
        }
        hearing.hear(&forces(40, 2, 0.0), 40 * MS);
        assert!(is_new(&mut hearing, 40) && !is_new(&mut hearing, 40), "once more");
        hearing.hear(&forces(41, 3, 0.0), 41 * MS);
        assert!(is_new(&mut hearing, 41) && !is_new(&mut hearing, 41), "told once");
    }

    #[test]
    fn what_is_no_number_or_no_tool_is_shown_as_nothing() {
        let mut hearing = Hearing::new(20, 0, 0);
        let mut wild = forces(1, 1, f32::NAN);
        wild.energy_j = f32::NAN;
        (wild.tools, wild.each[2].number, wild.each[3].number) = (u32::MAX, 8, u32::MAX);
        hearing.hear(&wild, MS);
        let answer = hearing.answer(MS);
        assert_eq!((size_n(&answer), answer.energy_j), (0.0, 0.0));
        assert!(answer.tools.iter().all(|of| of.torque_n_m == [0.0; 3]));
    }

    #[test]
    fn a_falling_force_of_the_server_is_shown_and_is_no_answer() {
        let mut hearing = Hearing::new(20, 0, 0);
        heard(&mut hearing, 5);
        let falling = ToolForces { flags: Flags::STALE.0, ..forces(5, 1, 2.0) };
        assert!(!hearing.hear(&falling, 6 * MS));
        let answer = hearing.answer(6 * MS);
        assert_eq!((size_n(&answer), answer.answers, answer.flags), (2.0, 5, 4));
    }
}
