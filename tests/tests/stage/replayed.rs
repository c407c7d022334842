//! Sessions of two tools behind stages are played again to the same bits, whatever came: poses that are
//! no poses to one tool, to its stage or to the tissue, ticks of any count of sweeps, commands, silences.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use chaincell_host::bake::ImageBytes;
use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::order::skipped;
use chaincell_host::engine::staged::Staged;
use chaincell_host::engine::tissue::TissueEngine;
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::files::recording::{Played, Recording, Start, TraceFile, play, tissue};
use chaincell_host::session::ipc::tools::TickForce;
use chaincell_host::session::loops::record::{Recorder, Row};
use chaincell_kernel::stage::{Device, StageSettings};
use chaincell_kernel::trace::{Command, CommandRecord, End, Reader};
use chaincell_kernel::{Budget, Model, NOT_TURNED, Network, Settings, ToolPart, ToolPose};
use chaincell_tests::bodies::nodal;
use nalgebra::Vector3;
use proptest::prelude::*;

const RADIUS_M: f32 = 0.008;
/// Height of the top \[m\].
const TOP_M: f32 = 0.02;
const DEVICES: [Device; 4] = [Device::Touch, Device::Premium, Device::Omega, Device::Falcon];

/// One thing that happens in a session.
#[derive(Debug, Clone)]
enum Event {
    /// Poses of both tools, the sweeps that there is time for, the delay that was measured, and whether
    /// there was a silence before.
    Tick { poses: [ToolPose; 2], sweeps: u16, delay: Option<u16>, is_behind_gap: bool },
    /// A command between two ticks.
    Command(Command),
}

fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        20 => -0.03_f32..0.03,
        1 => prop::sample::select(vec![-2.0e3, 999.0, 1.0e30, f32::NAN, f32::INFINITY, f32::MAX]),
    ]
}

/// Mostly a press, now and then anything.
fn pose() -> impl Strategy<Value = ToolPose> {
    let depth = prop_oneof![12 => -0.004_f32..0.008, 1 => coordinate()];
    let engaged = prop_oneof![20 => Just(1), 4 => Just(0), 1 => any::<u32>()];
    let orientation = prop_oneof![
        12 => Just(NOT_TURNED),
        1 => prop::array::uniform4(-2.0_f32..2.0),
        1 => Just([f32::NAN; 4]),
    ];
    ((coordinate(), coordinate()), depth, engaged, orientation).prop_map(
        |((x, y), depth_m, engaged, orientation)| {
            let position_m = Vector3::new(x, y, TOP_M + RADIUS_M - depth_m);
            ToolPose { orientation, ..ToolPose::at(position_m, engaged) }
        },
    )
}

fn event() -> impl Strategy<Value = Event> {
    let delay = prop::option::of(0_u16..20);
    let tick = ([pose(), pose()], 0_u16..5, delay, prop::bool::weighted(0.05));
    let tick = tick.prop_map(|(poses, sweeps, delay, is_behind_gap)| Event::Tick {
        poses,
        sweeps,
        delay,
        is_behind_gap,
    });
    let command = prop::sample::select(vec![
        Command::Reset,
        Command::Pause,
        Command::Resume,
        Command::Sweeps(3),
        Command::MaxForceN(0.5),
        Command::Grip { tool: 1 },
        Command::LetGo { tool: 1, ticks: 3 },
    ]);
    prop_oneof![30 => tick, 1 => command.prop_map(Event::Command)]
}

/// Two spheres, each behind a stage.
fn staged<'m>(image: &'m ImageBytes, settings: &StageSettings) -> (Staged<'m>, Recording) {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let network = Network::new(model, Settings { sweeps: 4, ..Settings::for_model(&model) });
    let tools = vec![vec![ToolPart::sphere(RADIUS_M)]; 2];
    let contact = Contact::Tools { tools, friction: 0.3 };
    let scheme = Scheme::Predict;
    let engine = Engine::with_contact(network.unwrap(), scheme, Arithmetic::F32, contact).unwrap();
    let begun = Recording::begin(&engine, scheme, Arithmetic::F32, Some(settings)).unwrap();
    (Staged::new(engine, Some(*settings)).unwrap(), begun)
}

/// What a server does with these events, recorded.
fn session(staged: &mut Staged<'_>, recorder: &mut Recorder, events: &[Event]) {
    let (mut is_paused, mut last) = (false, None);
    for (at, event) in (1..).zip(events) {
        // Now and then ticks are lost.
        let tick = at + 3 * (at / 40);
        match event {
            Event::Command(command) => {
                match command {
                    Command::Pause => is_paused = true,
                    Command::Resume => is_paused = false,
                    other if staged.command(other).is_err() => continue,
                    _ => {}
                }
                let state_hash = Some(staged.state_hash());
                recorder.command(CommandRecord { tick, command: *command, state_hash });
            }
            Event::Tick { poses, sweeps, delay, is_behind_gap } => {
                let (mut made, lost) = (None, last.map_or(0, |last| skipped(last, tick)));
                last = Some(tick);
                if !is_paused {
                    if *is_behind_gap {
                        staged.restart_ramp();
                    }
                    staged.skipped(lost);
                    delay.iter().for_each(|&ticks| staged.delayed(ticks));
                    let mut more = |done| done < *sweeps;
                    let chosen = if *sweeps == 0 { Budget::LATE } else { Budget::While(&mut more) };
                    made = Some(staged.tick_by(poses, chosen).sweeps);
                }
                let state_hash = staged.state_hash();
                let pose = Pose { sweeps: made, ..Pose::of(tick, &poses[0]) };
                let force = TickForce { tick, state_hash, ..TickForce::default() };
                let row = Row {
                    ramp_restarted: *is_behind_gap,
                    delay_ticks: *delay,
                    ..Row::of(pose, force)
                };
                recorder.record_tools(row, poses, &[]);
            }
        }
    }
}

/// Plays events twice, the second time from their trace.
fn plays_again(image: &ImageBytes, device: Device, events: &[Event]) -> Result<(), TestCaseError> {
    let settings = StageSettings { watchdog_ticks: 5, ..StageSettings::for_device(device) };
    let (mut first, begun) = staged(image, &settings);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.trace");
    let records = Recorder::trace_records(events.len(), 2);
    let trace = TraceFile::create("`record`", &path, false, begun, records).unwrap();
    let mut recorder = Recorder::on_disk(events.len(), trace);
    session(&mut first, &mut recorder, events);
    recorder.finish_trace().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let trace = Reader::open(&bytes).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let (mut again, ..) = tissue(&trace, Path::new("a.trace"), model).unwrap();
    let mut played = Played::default();
    let end = play(&trace, &mut again, Start::default(), &mut played, |_, _| true);
    prop_assert_eq!(end, Ok(End::Complete));
    prop_assert_eq!(u64::from(played.ticks), recorder.ticks());
    prop_assert_eq!(played.compared, played.ticks + played.commands);
    // The stages stand where they stood: what the devices are given next is the same too.
    let place = Vector3::new(0.0, 0.0, TOP_M + RADIUS_M - 0.002);
    let next = [ToolPose::at(place, 1); 2];
    let outputs = [&mut first, &mut again].map(|staged| {
        let output = staged.tick_by(&next, Budget::All);
        (output, [staged.felt(0), staged.felt(1)])
    });
    prop_assert_eq!(outputs[0], outputs[1]);
    Ok(())
}

/// One message in the middle of a press, whose second tool is finite and 2 km away: the first one's
/// device is given no new force, and the tissue has its sweeps.
#[test]
fn a_pose_that_is_bad_to_one_stage_alone_is_a_tick_with_sweeps() {
    let image = nodal("box:5x5x3x0.01", 5.0e3);
    let press = |depth_m, x| {
        let position_m = Vector3::new(x, 0.002, TOP_M + RADIUS_M - depth_m);
        ToolPose::at(position_m, 1)
    };
    let events: Vec<Event> = (0..80)
        .map(|at| {
            let depth_m = 1.0e-4 * f32::from(at as u8);
            let far = if at == 60 { 2.0e3 } else { 0.01 };
            let poses = [press(depth_m, -0.01), press(depth_m, far)];
            Event::Tick { poses, sweeps: 3, delay: None, is_behind_gap: false }
        })
        .collect();
    for device in DEVICES {
        plays_again(&image, device, &events).unwrap();
    }
}

// REQ-STG-08, REQ-COS-12
#[test]
fn whatever_came_is_played_again() {
    let image = nodal("box:5x5x3x0.01", 5.0e3);
    let cases = if std::env::var_os("CHAINCELL_SLOW").is_some() { 2_000 } else { 60 };
    let events = prop::collection::vec(event(), 1..120);
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(cases)
    });
    let strategy = (prop::sample::select(DEVICES.to_vec()), events);
    runner.run(&strategy, |(device, events)| plays_again(&image, device, &events)).unwrap();
}
