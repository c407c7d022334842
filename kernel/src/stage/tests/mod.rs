//! From any input bits only forces within the limits come out; and tests of the single parts.

mod control;
mod felt;
mod missing;
mod restored;

use super::*;
use crate::tick::sample::Flags;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::vec::Vec;

#[derive(Debug, Clone)]
enum Event {
    Tick(ToolPose, TickOutput),
    Missed,
}

/// A number of a plausible size, or any bits.
fn number(scale: f32) -> impl Strategy<Value = f32> {
    prop_oneof![8 => (-1.0_f32..1.0).prop_map(move |x| x * scale), 1 => any::<u32>().prop_map(f32::from_bits)]
}

fn vector(scale: f32) -> impl Strategy<Value = Vector3<f32>> {
    [number(scale), number(scale), number(scale)].prop_map(Vector3::from)
}

fn event() -> impl Strategy<Value = Event> {
    let engaged = prop_oneof![1 => Just(0_u32), 8 => Just(1), 1 => any::<u32>()];
    let sample =
        (vector(0.01), engaged).prop_map(|(position_m, engaged)| ToolPose::at(position_m, engaged));
    let answer = (vector(20.0), number(1.0), number(0.01), number(1.0e4), 0..256_u32).prop_map(
        |(force_n, energy_j, work_j, stiffness, flags)| TickOutput {
            force_n,
            energy_j,
            work_j,
            stiffness_n_per_m: stiffness.abs(),
            contacts: 1,
            sweeps: 1,
            flags: Flags(flags),
        },
    );
    prop_oneof![
        6 => (sample, answer).prop_map(|(sample, answer)| Event::Tick(sample, answer)),
        1 => Just(Event::Missed),
    ]
}

fn length(v: Vector3<f32>) -> f64 {
    v.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt()
}

fn step(stage: &mut Stage, event: &Event) -> TickOutput {
    match event {
        Event::Tick(sample, answer) => {
            let tool = stage.sample(sample);
            assert!(!tool.is_good() || tool.position_m.iter().all(|x| x.abs() < 1.0e10));
            stage.output(answer)
        }
        Event::Missed => stage.missed(),
    }
}

proptest! {
    // REQ-STG-01, REQ-STG-05
    #[test]
    fn any_bits_give_a_force_within_the_limits(
        events in prop::collection::vec(event(), 1..200), device in 0..5_usize, ramp in 0..20_u16,
        delay_ticks in 0..2_u8, logs in prop::option::of([0.0_f32..6.0, -3.0..6.0, -5.0..0.0]),
        has_coupling in any::<bool>(),
    ) {
        let device = [Device::Touch, Device::Premium, Device::Falcon, Device::Omega, Device::Sigma][device];
        let mut settings = StageSettings { ramp_ticks: ramp, watchdog_ticks: 3, ..StageSettings::for_device(device) };
        settings.passivity = Some(Passivity { device_damping_n_s_per_m: 0.5, delay_ticks });
        if ramp % 2 == 0 {
            settings.max_speed_m_per_s = f32::INFINITY;
        }
        if let Some([stiffness, damping, tick_s]) = logs.map(|logs| logs.map(|log| 10.0_f32.powf(log))) {
            let (stiffness_n_per_m, damping_n_s_per_m) = (stiffness.clamp(1.0, COUPLING_MAX), damping.min(COUPLING_MAX));
            settings.coupling = Some(Coupling { stiffness_n_per_m, damping_n_s_per_m });
            settings.passivity = Some(Passivity { device_damping_n_s_per_m: damping_n_s_per_m, delay_ticks });
            settings.tick_s = tick_s.clamp(1.0e-5, 1.0);
        }
        if !has_coupling {
            settings.coupling = None;
        }
        let mut stage = Stage::new(settings).unwrap();
        let (mut last, most) = (Vector3::zeros(), f64::from(settings.max_slew_n_per_s * settings.tick_s));
        for event in &events {
            let output = step(&mut stage, event);
            let force = output.force_n;
            prop_assert!(force.iter().all(|f| f.is_finite()), "{force:?}");
            prop_assert!(length(force) <= f64::from(settings.max_force_n), "{force:?}");
            prop_assert!(length(force - last) <= 1.000_01 * most + 1.0e-5, "{last:?} {force:?}");
            prop_assert!(output.energy_j.is_finite() && output.work_j.is_finite());
            prop_assert!(!output.flags.contains(Flags::SAFE_STATE) || length(force) == 0.0);
            last = force;
        }
    }
}

/// A wall below z = 0 with an exact ledger.
struct Wall {
    stiffness: f32,
    stored: f32,
}

impl Wall {
    fn new(stiffness: f32) -> Self {
        Self { stiffness, stored: 0.0 }
    }

    fn tick(&mut self, tool: &ToolPose) -> TickOutput {
        let depth = (-tool.position_m.z).max(0.0);
        let before = core::mem::replace(&mut self.stored, 0.5 * self.stiffness * depth * depth);
        TickOutput {
            force_n: Vector3::new(0.0, 0.0, self.stiffness * depth),
            work_j: self.stored - before,
            energy_j: self.stored,
            stiffness_n_per_m: if depth > 0.0 { self.stiffness } else { 0.0 },
            ..TickOutput::NONE
        }
    }
}

/// An engaged tool at height `z`.
fn at_height(z: f32) -> ToolPose {
    ToolPose::at(Vector3::new(0.0, 0.0, z), 1)
}

/// A tick of a spring of 1 kN/m along z.
fn tick(stage: &mut Stage, z: f32) -> TickOutput {
    let tool = stage.sample(&ToolPose::at(Vector3::new(0.0, 0.0, z), 1));
    let force_n = -1000.0 * tool.position_m;
    stage.output(&TickOutput { force_n, contacts: 1, ..TickOutput::NONE })
}

// REQ-STG-04
#[test]
fn an_absent_stage_changes_no_bit() {
    let mut stage = Stage::new(StageSettings::NONE).unwrap();
    let answer = TickOutput {
        force_n: Vector3::new(1.0e-30, -3.0, 700.0),
        energy_j: 0.3,
        work_j: -1.0e-9,
        stiffness_n_per_m: 12.0,
        contacts: 4,
        sweeps: 3,
        flags: Flags(1 + 32),
    };
    let sample = ToolPose::at(Vector3::new(0.1, 0.2, 0.3), 1);
    assert_eq!(stage.sample(&sample), sample);
    assert_eq!(stage.output(&answer), answer);
}

// REQ-STG-06
#[test]
fn ramp_silence_and_return() {
    let settings = StageSettings { ramp_ticks: 4, watchdog_ticks: 2, ..StageSettings::NONE };
    let mut stage = Stage::new(settings).unwrap();
    let z = |output: TickOutput| output.force_n.z;
    let up: Vec<f32> = (0..5).map(|_| z(tick(&mut stage, -0.001))).collect();
    assert_eq!(up, [0.25, 0.5, 0.75, 1.0, 1.0]);
    let silence: Vec<(f32, u32)> = (0..7)
        .map(|_| {
            let output = stage.missed();
            (z(output), output.flags.0)
        })
        .collect();
    let stale = Flags::STALE.0;
    let (safe, held) = (stale + Flags::SAFE_STATE.0, 0);
    assert_eq!(
        silence,
        [
            (1.0, held),
            (1.0, held),
            (0.75, stale),
            (0.5, stale),
            (0.25, stale),
            (0.0, safe),
            (0.0, safe)
        ]
    );
    assert_eq!(z(tick(&mut stage, -0.001)), 0.25);
    // A bad sample counts as none: the last force holds.
    let bad = ToolPose::at(Vector3::new(f32::NAN, 0.0, 0.0), 1);
    assert!(!stage.sample(&bad).is_good());
    let output = stage.output(&TickOutput::NONE);
    assert_eq!((z(output), output.flags), (0.25, Flags::BAD_SAMPLE));
}

// REQ-STG-05
#[test]
fn a_bad_answer_lets_the_force_go_by_the_slew_limit() {
    let settings = StageSettings { max_slew_n_per_s: 400.0, ..StageSettings::NONE };
    let mut stage = Stage::new(settings).unwrap();
    for _ in 0..4 {
        tick(&mut stage, -0.001);
    }
    let sample = ToolPose::at(Vector3::new(0.0, 0.0, -0.001), 1);
    let forces: Vec<f32> = (0..3)
        .map(|_| {
            let _ = stage.sample(&sample);
            let force_n = Vector3::new(0.0, f32::NAN, 0.0);
            let output = stage.output(&TickOutput { force_n, ..TickOutput::NONE });
            assert_eq!(output.flags.contains(Flags::SAFE_STATE), output.force_n.z == 0.0);
            output.force_n.z
        })
        .collect();
    assert!((forces[0] - 0.6).abs() < 1e-5 && (forces[1] - 0.2).abs() < 1e-5 && forces[2] == 0.0);
}

/// A coupling at rest shows the tissue's force, however stiff the tissue is against it.
// REQ-STG-04
#[test]
fn a_coupling_shows_the_tissues_force() {
    for stiffness in [10.0_f32, 300.0, 50_000.0] {
        let coupling = Some(Coupling { stiffness_n_per_m: 300.0, damping_n_s_per_m: 0.1 });
        let mut stage = Stage::new(StageSettings { coupling, ..StageSettings::NONE }).unwrap();
        let mut last = (TickOutput::NONE, 0.0_f32);
        for at in 0..2000_u16 {
            let z = -1.0e-5 * f32::from(at.min(500));
            let tool = stage.sample(&ToolPose::at(Vector3::new(0.0, 0.0, z), 1));
            let force_n = -stiffness * tool.position_m;
            let answer = TickOutput { force_n, stiffness_n_per_m: stiffness, ..TickOutput::NONE };
            last = (stage.output(&answer), force_n.z);
            assert!(last.0.force_n.z < 1.6, "{stiffness}: {}", last.0.force_n.z);
        }
        let wanted = 0.005 * 300.0 * stiffness / (300.0 + stiffness);
        assert!(
            (last.0.force_n.z - wanted).abs() < 2e-3 * wanted,
            "{stiffness}: {last:?} {wanted}"
        );
    }
}

// REQ-STG-07
#[test]
fn every_setting_out_of_range_is_named() {
    let whole = StageSettings::for_device(Device::Sigma);
    assert!(Stage::new(whole).is_ok());
    let coupling = |stiffness_n_per_m, damping_n_s_per_m| StageSettings {
        coupling: Some(Coupling { stiffness_n_per_m, damping_n_s_per_m }),
        ..whole
    };
    let passivity = |device_damping_n_s_per_m, delay_ticks| StageSettings {
        passivity: Some(Passivity { device_damping_n_s_per_m, delay_ticks }),
        ..whole
    };
    for (settings, why) in [
        (StageSettings { tick_s: 0.0, ..whole }, StageError::Tick),
        (StageSettings { tick_s: f32::NAN, ..whole }, StageError::Tick),
        (coupling(0.0, 0.0), StageError::Coupling),
        (coupling(0.99, 0.0), StageError::Coupling),
        (coupling(f32::INFINITY, 0.0), StageError::Coupling),
        (coupling(100.0, -1.0), StageError::Coupling),
        (passivity(f32::NAN, 0), StageError::Passivity),
        (passivity(0.5, 17), StageError::Passivity),
        (StageSettings { coupling: None, ..passivity(0.5, 2) }, StageError::Passivity),
        (StageSettings { max_slew_n_per_s: 0.0, ..whole }, StageError::Slew),
        (StageSettings { max_force_n: f32::NAN, ..whole }, StageError::MaxForce),
        (StageSettings { ramp_ticks: 60_001, ..whole }, StageError::Ticks),
        (StageSettings { max_speed_m_per_s: 0.0, ..whole }, StageError::MaxSpeed),
        (StageSettings { watchdog_ticks: u16::MAX, ..whole }, StageError::Ticks),
    ] {
        assert_eq!(Stage::new(settings).map(|_| ()), Err(why), "{settings:?}");
    }
}

/// Under a current the tissue makes a force and reports neither work nor stiffness.
#[test]
fn a_stage_that_goes_by_position_gives_no_force_under_a_current() {
    let sample = ToolPose::at(Vector3::zeros(), 1);
    let driven = TickOutput {
        force_n: Vector3::new(0.0, 0.0, 1.0),
        contacts: 3,
        energy_j: 0.1,
        ..TickOutput::NONE
    };
    let all = StageSettings { ramp_ticks: 0, ..StageSettings::for_device(Device::Falcon) };
    let given = |settings: StageSettings, answer: &TickOutput| {
        let mut stage = Stage::new(settings).unwrap();
        let mut last = TickOutput::NONE;
        for _ in 0..20 {
            stage.sample(&sample);
            last = stage.output(answer);
        }
        last
    };
    let coupled = StageSettings { passivity: None, ..all };
    let passive = StageSettings { coupling: None, ..all };
    for settings in [all, coupled, passive] {
        let answer = given(settings, &driven);
        assert_eq!(answer.force_n, Vector3::zeros());
        assert!(answer.flags.contains(Flags::SAFE_STATE));
    }
    let answer = given(StageSettings { coupling: None, passivity: None, ..all }, &driven);
    assert_eq!((answer.force_n, answer.flags), (driven.force_n, Flags::default()));
    let answer = given(passive, &TickOutput { stiffness_n_per_m: 100.0, ..driven });
    assert!(answer.force_n.z > 0.9 && !answer.flags.contains(Flags::SAFE_STATE));
}
