//! Doubts on a simulated clock.

use super::*;
use proptest::prelude::*;

const MS: u64 = MILLISECOND_NS;
const WANTED_N: [f32; 3] = [0.0, 0.6, 0.8];

/// A hand that is engaged and feels all of the force, at the returned time.
fn engaged() -> (Guard, u64) {
    let mut guard = Guard::new(2.0, 3.0, 0);
    for ms in 1..=120 {
        calm(&mut guard, ms * MS);
    }
    assert!(guard.is_engaged() && guard.shown_n() == WANTED_N);
    (guard, 120 * MS)
}

fn calm(guard: &mut Guard, now_ns: u64) -> [f32; 3] {
    guard.state([0.1, 0.0, 0.2], now_ns).unwrap();
    guard.answer(Notes::default());
    guard.force(WANTED_N, now_ns)
}

/// From here on the force falls along the ramp to exactly 0, and comes again after a calm while alone.
fn falls_and_comes_again(guard: &mut Guard, mut now_ns: u64) {
    let mut last_n = size(guard.shown_n());
    for ms in 1..=RAMP_MS {
        now_ns += MS;
        guard.state([0.1, 0.0, 0.2], now_ns).unwrap();
        guard.answer(Notes::default());
        let size_n = size(guard.force(WANTED_N, now_ns));
        assert!(last_n - size_n < 1.0 / RAMP_MS as f32 + 1e-5, "{ms}: no jump");
        assert!(!guard.is_engaged());
        last_n = size_n;
    }
    assert_eq!(guard.shown_n(), [0.0; 3]);
    for calm_states in 1..=CALM_STATES {
        now_ns += MS;
        calm(guard, now_ns);
        assert_eq!(guard.is_engaged(), calm_states == CALM_STATES, "{calm_states}");
    }
    for _ in 0..RAMP_MS {
        now_ns += MS;
        calm(guard, now_ns);
    }
    assert!(guard.shown_n() == WANTED_N && guard.present_doubt().is_none());
}

#[test]
fn there_is_no_force_before_an_answer_and_a_calm_while() {
    let mut guard = Guard::new(2.0, 3.0, 0);
    for ms in 1..=300 {
        guard.state([0.1, 0.0, 0.2], ms * MS).unwrap();
        guard.answer(Notes::NOTHING_YET);
        assert_eq!(guard.force(WANTED_N, ms * MS), [0.0; 3]);
    }
    for ms in 301..=300 + u64::from(CALM_STATES) {
        assert!(!guard.is_engaged(), "{ms}");
        calm(&mut guard, ms * MS);
    }
    assert!(guard.is_engaged());
}

#[test]
fn each_doubt_lets_the_force_fall_and_counts_once() {
    for doubt in [Doubt::Malformed, Doubt::NoDevice, Doubt::NotReady] {
        let (mut guard, now_ns) = engaged();
        guard.doubt(doubt);
        guard.doubt(doubt);
        assert_eq!(guard.counts()[doubt as usize], 1);
        falls_and_comes_again(&mut guard, now_ns);
    }
    for (notes, doubt) in [
        (Notes::SILENT, Doubt::TissueSilent),
        (Notes::NEW_SESSION, Doubt::NewSession),
        (Notes(2 + 4 + 8), Doubt::NewSession),
    ] {
        let (mut guard, now_ns) = engaged();
        guard.answer(notes);
        assert_eq!(guard.present_doubt(), Some(doubt));
        falls_and_comes_again(&mut guard, now_ns);
    }
}

#[test]
fn a_position_that_jumps_or_is_no_number_is_a_doubt() {
    let far = [[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [0.0, 0.0, -1.01]];
    for position_m in far {
        let (mut guard, now_ns) = engaged();
        assert_eq!(guard.state(position_m, now_ns + MS), Err(Doubt::OutOfReach));
        falls_and_comes_again(&mut guard, now_ns + MS);
    }
    let (mut guard, now_ns) = engaged();
    assert_eq!(guard.state([0.1, 0.0, 0.2 + 0.0079], now_ns + MS), Ok(()));
    assert_eq!(guard.state([0.1, 0.0, 0.2], now_ns + 2 * MS), Ok(()));
    assert_eq!(guard.state([0.1, 0.0, 0.2 + 0.0081], now_ns + 3 * MS), Err(Doubt::Jump));
    // Back again: as far once more.
    assert_eq!(guard.state([0.1, 0.0, 0.2], now_ns + 4 * MS), Err(Doubt::Jump));
    falls_and_comes_again(&mut guard, now_ns + 4 * MS);
}

#[test]
fn within_20_ms_of_a_silent_service_the_force_is_0() {
    let (mut guard, now_ns) = engaged();
    let mut last_n = 1.0;
    for ms in 1..=30 {
        let size_n = size(guard.force(WANTED_N, now_ns + ms * MS));
        let falling_ms = (ms + 1).saturating_sub(u64::from(WATCHDOG_MS)).min(u64::from(RAMP_MS));
        let wanted_n = 1.0 - falling_ms as f32 / RAMP_MS as f32;
        assert!((size_n - wanted_n).abs() < 1e-5, "{ms}: {size_n} {wanted_n}");
        assert!(last_n - size_n < 1.0 / RAMP_MS as f32 + 1e-5);
        last_n = size_n;
    }
    assert_eq!(guard.counts()[Doubt::ServiceSilent as usize], 1);
    for calm_states in 1..=u64::from(CALM_STATES) {
        assert!(!guard.is_engaged());
        calm(&mut guard, now_ns + (30 + calm_states) * MS);
    }
    assert!(guard.is_engaged());
}

/// While the program lets go at its end it reads no states: that is no doubt in the service.
#[test]
fn the_fall_at_the_end_is_no_doubt() {
    let (mut guard, now_ns) = engaged();
    guard.let_go();
    let zero_ms = (1..=30).find(|ms| guard.force(WANTED_N, now_ns + ms * MS) == [0.0; 3]);
    assert!(zero_ms.is_some_and(|ms| ms <= 2 * u64::from(RAMP_MS)), "{zero_ms:?}");
    assert_eq!(guard.counts(), [0; Doubt::ALL.len()]);
}

#[test]
fn a_force_is_shortened_to_its_limit_and_one_that_is_no_number_is_none() {
    let (mut guard, now_ns) = engaged();
    for (wanted_n, felt_n) in [
        ([0.0, 3.0, 4.0], [0.0, 1.2, 1.6]),
        ([f32::NAN, 0.0, 1.0], [0.0; 3]),
        ([f32::MAX; 3], [0.0; 3]),
    ] {
        guard.state([0.1, 0.0, 0.2], now_ns).unwrap();
        let force_n = guard.force(wanted_n, now_ns);
        assert!(force_n.iter().zip(felt_n).all(|(a, b)| (a - b).abs() < 1e-6), "{force_n:?}");
    }
}

proptest! {
    /// Whatever comes, at whatever times.
    #[test]
    fn no_force_without_a_state_for_20_ms_and_never_above_the_limit(
        events in proptest::collection::vec((0u8..7, 0u64..30_000), 1..60),
    ) {
        let (mut guard, mut now_ns) = engaged();
        let (mut heard_ns, mut last_n) = (now_ns, 1.0);
        for (event, since_us) in events {
            now_ns += 1000 * since_us;
            match event {
                4 => {}
                5 => _ = guard.doubt(Doubt::Malformed),
                6 => guard.answer(Notes::SILENT),
                _ => {
                    heard_ns = now_ns;
                    let _ = guard.state([0.1, 0.0, 0.2], now_ns);
                    guard.answer(Notes::default());
                }
            }
            let force_n = size(guard.force([3.0, 4.0, 12.0], now_ns));
            prop_assert!(force_n <= 2.0 + 1e-6);
            prop_assert!(now_ns - heard_ns < OFF_NS || force_n == 0.0);
            // At once, and as far as time has passed: two answers of the same time are alike.
            let waits = since_us == 0 && force_n == last_n;
            let falls = force_n < last_n || force_n == 0.0 || waits;
            prop_assert!(guard.is_engaged() || falls, "{} {}", last_n, force_n);
            last_n = force_n;
        }
    }
}
