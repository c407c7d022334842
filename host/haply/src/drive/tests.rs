//! Service, tissue and clock are simulated: sessions of many seconds take no time.

use std::cell::{Cell, RefCell};

use super::*;

const MS: u64 = MILLISECOND_NS;
/// Of the tissue [N/m].
const STIFFNESS_N_PER_M: f32 = 100.0;

/// Simulated time; what is sent, with the time of each message.
#[derive(Debug, Default)]
struct World {
    now_ns: Cell<u64>,
    sent: RefCell<Vec<(u64, Value)>>,
    pending: Cell<usize>,
    closed_at: Cell<Option<usize>>,
    /// True once the clock stands still.
    stands: Cell<bool>,
}

impl Clock for World {
    fn now_ns(&self) -> u64 {
        self.now_ns.get()
    }

    fn sleep_until_ns(&self, moment_ns: u64) {
        let to_ns = if self.stands.get() { 0 } else { moment_ns };
        self.now_ns.set(self.now_ns.get().max(to_ns));
    }
}

impl World {
    fn forces_n(&self) -> Vec<f32> {
        let sent = self.sent.borrow();
        let vectors = sent.iter().map(|(_, message)| {
            let vector = &message["inverse3"][0]["commands"]["set_cursor_force"]["vector"];
            ["x", "y", "z"].map(|axis| vector[axis].as_f64().unwrap() as f32)
        });
        vectors.map(|v| v.iter().map(|x| x * x).sum::<f32>().sqrt()).collect()
    }
}

/// Depth of the device in the tissue in a period: 10 mm and back, twice a second [m].
fn depth_m(message: usize) -> f32 {
    0.01 * (1.0 - (message as f32 * std::f32::consts::TAU / 500.0).cos()) / 2.0
}

fn good(message: usize) -> String {
    let z = -depth_m(message);
    format!(
        r#"{{"inverse3":[{{"device_id":"A","state":{{"cursor_position":{{"x":0,"y":0,"z":{z}}}}}}}]}}"#
    )
}

/// A service that answers message n by `answer(n)`, as an error by closing, and takes 0.2 ms.
struct FakeService<'a, F> {
    world: &'a World,
    answer: F,
}

impl<F: Fn(usize) -> Result<Option<String>, String>> Service for FakeService<'_, F> {
    fn send(&mut self, message: &str) -> Result<(), String> {
        assert!(self.world.closed_at.get().is_none());
        let message = serde_json::from_str(message).unwrap();
        self.world.sent.borrow_mut().push((self.world.now_ns(), message));
        self.world.pending.set(self.world.pending.get() + 1);
        Ok(())
    }

    fn receive(&mut self, end_ns: u64) -> Result<Option<String>, String> {
        if self.world.pending.replace(0) == 0 {
            self.world.sleep_until_ns(end_ns);
            return Ok(None);
        }
        let text = (self.answer)(self.world.sent.borrow().len())?;
        self.world.sleep_until_ns(if text.is_none() {
            end_ns
        } else {
            self.world.now_ns() + MS / 5
        });
        Ok(text)
    }

    fn close(&mut self) {
        self.world.closed_at.set(Some(self.world.sent.borrow().len()));
    }
}

/// A spring from z = 0 down, with the client's notes for pose n.
struct FakeTissue<'a, F> {
    world: &'a World,
    notes: F,
    poses: usize,
    is_served: bool,
}

impl<F: Fn(usize) -> Notes> Tissue for FakeTissue<'_, F> {
    fn step(&mut self, pose: &ToolPose, end_ns: u64) -> Result<Felt, String> {
        self.poses += 1;
        let notes = (self.notes)(self.poses);
        let is_answered = notes == Notes::default();
        self.world.sleep_until_ns(if is_answered { self.world.now_ns() + MS / 5 } else { end_ns });
        let depth_m = if pose.engaged == 1 { -pose.position_m[2] } else { 0.0 };
        let force_n = [0.0, 0.0, STIFFNESS_N_PER_M * depth_m.max(0.0)];
        Ok(Felt { force_n, notes, is_answered })
    }

    fn is_served(&self) -> bool {
        self.is_served
    }
}

fn options(seconds: u64) -> Options {
    Options {
        device_id: "A".to_owned(),
        force_key: ForceKey::Vector,
        frame: Frame::new("x,y,z", 1.0, [0.0; 3]).unwrap(),
        max_force_n: 0.8,
        max_speed_m_per_s: 3.0,
        end_ns: Some(seconds * SECOND_NS),
    }
}

/// A session; however it ends, no force jumps and the last message is one of zero.
fn session(
    seconds: u64,
    answer: impl Fn(usize) -> Result<Option<String>, String>,
    notes: impl Fn(usize) -> Notes,
    is_served: bool,
) -> (World, Report) {
    let world = World::default();
    let mut service = FakeService { world: &world, answer };
    let mut tissue = FakeTissue { world: &world, notes, poses: 0, is_served };
    let report = drive(&mut service, &mut tissue, &world, &options(seconds), || false, |_| ());
    let forces_n = world.forces_n();
    assert_eq!(forces_n.last(), Some(&0.0), "{report:?}");
    assert_eq!(world.closed_at.get(), Some(forces_n.len()));
    assert_eq!(report.counts.forces_sent as usize, forces_n.len());
    for (at, pair) in forces_n.windows(2).enumerate() {
        assert!((pair[1] - pair[0]).abs() < 0.11, "message {at}: a jump, {pair:?}");
    }
    (world, report)
}

fn calm(_: usize) -> Notes {
    Notes::default()
}

#[test]
fn ten_seconds_at_1_khz_every_pose_answered() {
    let (world, report) = session(10, |n| Ok(Some(good(n))), calm, true);
    assert_eq!(report.ended, Ended::TimeUp);
    assert_eq!(
        (report.counts.states, report.counts.poses, report.counts.answered),
        (10_000, 10_000, 10_000)
    );
    assert_eq!((report.doubts, report.ended.exit_code()), ([0; 8], 0));
    assert!((report.largest_force_n - 0.8).abs() < 1e-6, "up to its limit: {report:?}");
    let sent = world.sent.borrow();
    assert_eq!(sent[0].1["session"]["configure"]["profile"]["name"], "chaincell");
    assert!(sent[1..].iter().all(|(_, message)| message.get("session").is_none()));
    // The force is that of the pose one period before.
    let forces_n = world.forces_n();
    for message in [4_300, 6_080, 8_930] {
        let wanted_n = (STIFFNESS_N_PER_M * depth_m(message - 1)).min(0.8);
        assert!((forces_n[message - 1] - wanted_n).abs() < 1e-3, "{message}");
    }
}

#[test]
fn within_20_ms_of_a_silent_service_the_last_message_has_force_zero() {
    let silent = 250;
    let answers = |n| Ok((n < silent || n > 1_000).then(|| good(n)));
    let (world, report) = session(3, answers, calm, true);
    assert_eq!(report.ended, Ended::ServiceGone(Some(Doubt::ServiceSilent)));
    let (sent, forces_n) = (world.sent.borrow(), world.forces_n());
    let (last_state_ns, _) = sent[silent - 2];
    assert!(forces_n[silent - 2] > 0.7);
    let later = sent.iter().zip(&forces_n).skip(silent);
    let off_ns = later.clone().find(|(_, force_n)| **force_n == 0.0).unwrap().0.0;
    assert!(off_ns - last_state_ns <= 20 * MS, "{} ms", (off_ns - last_state_ns) / MS);
    assert!(later.filter(|(sent, _)| sent.0 > off_ns).all(|(_, force_n)| *force_n == 0.0));
    // After that it gets a knock from time to time alone.
    assert!(sent.len() < silent + 60, "{}", sent.len());
}

#[test]
fn a_service_that_comes_again_is_felt_again() {
    let (world, report) =
        session(3, |n| Ok((!(300..320).contains(&n)).then(|| good(n))), calm, true);
    assert_eq!((&report.ended, report.doubts[Doubt::ServiceSilent as usize]), (&Ended::TimeUp, 1));
    assert_eq!(report.doubts.iter().sum::<u64>(), 1);
    let forces_n = world.forces_n();
    assert!(forces_n[320..400].iter().all(|force_n| *force_n == 0.0));
    assert!(forces_n[500..].iter().any(|force_n| *force_n > 0.7));
}

#[test]
fn a_bad_message_lets_the_tool_go_and_a_stream_of_them_ends_the_session() {
    let jump = good(0).replace("\"z\":-0", "\"z\":0.1");
    for (text, doubt) in [
        ("{\"inverse3\":[".to_owned(), Doubt::Malformed),
        (good(0).replace('A', "B"), Doubt::NoDevice),
        (good(0).replace("\"z\":-0", "\"z\":1e30"), Doubt::OutOfReach),
        (jump, Doubt::Jump),
    ] {
        let answers = |n| Ok(Some(if n == 250 { text.clone() } else { good(n) }));
        let (world, report) = session(1, answers, calm, true);
        assert_eq!(report.doubts[doubt as usize], 1, "{doubt:?} {report:?}");
        let forces_n = &world.forces_n()[250..350];
        assert!(forces_n[10..].iter().all(|force_n| *force_n == 0.0), "{doubt:?} {forces_n:?}");
        assert_eq!(report.counts.poses, report.counts.answered);
    }
    let answers = |n| Ok(Some(if n >= 250 { "null".to_owned() } else { good(n) }));
    let (_, report) = session(9, answers, calm, true);
    assert_eq!(report.ended, Ended::ServiceGone(Some(Doubt::Malformed)));
    assert_eq!((report.doubts.iter().sum::<u64>(), report.ended.exit_code()), (1, 1));
}

#[test]
fn a_closed_connection_is_the_end() {
    let answers = |n| if n < 250 { Ok(Some(good(n))) } else { Err("reset".to_owned()) };
    let (_, report) = session(1, answers, calm, true);
    assert_eq!(report.ended, Ended::ServiceClosed("reset".to_owned()));
    assert!(report.ended.to_string().contains("is it still running?"));
}

#[test]
fn an_old_answer_of_the_tissue_is_a_doubt_and_its_end_is_told_from_a_silence() {
    let notes = |pose| if pose > 250 { Notes::SILENT } else { Notes::default() };
    for (is_served, ended, exit_code) in
        [(true, Ended::TissueGone, 1), (false, Ended::SessionEnded, 0)]
    {
        let (world, report) = session(9, |n| Ok(Some(good(n))), notes, is_served);
        assert_eq!((&report.ended, report.ended.exit_code()), (&ended, exit_code));
        assert_eq!(report.counts.answered, 250);
        let forces_n = &world.forces_n()[250..];
        assert!(forces_n[17..].iter().all(|force_n| *force_n == 0.0), "{forces_n:?}");
    }
    let nothing_yet = |_| Notes::NOTHING_YET;
    let (world, report) = session(1, |n| Ok(Some(good(n))), nothing_yet, true);
    assert!(world.forces_n().iter().all(|force_n| *force_n == 0.0) && report.counts.answered == 0);
}

#[test]
fn a_panic_or_a_stop_lets_the_force_fall() {
    let notes = |pose| {
        assert!(pose < 250, "a bug");
        Notes::default()
    };
    let (world, report) = session(1, |n| Ok(Some(good(n))), notes, true);
    assert_eq!((&report.ended, report.ended.exit_code()), (&Ended::Panicked, 1));
    let forces_n = world.forces_n();
    assert!(forces_n[249] > 0.7 && forces_n.len() > 250 + 7, "along a ramp");
    // Stopped in the middle of a press, once with a clock that stands still from there on.
    for stands in [false, true] {
        let world = World::default();
        let mut service = FakeService { world: &world, answer: |n| Ok(Some(good(n))) };
        let mut tissue = FakeTissue { world: &world, notes: calm, poses: 0, is_served: true };
        let stop = || {
            let is_asked = world.sent.borrow().len() >= 250;
            world.stands.set(is_asked && stands);
            is_asked
        };
        let report = drive(&mut service, &mut tissue, &world, &options(9), stop, |_| ());
        assert_eq!((report.ended, world.forces_n().last()), (Ended::Stopped, Some(&0.0)));
        assert!(world.forces_n().len() > 250 + 7);
    }
}
