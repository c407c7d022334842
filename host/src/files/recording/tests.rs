//! Tests of trace files while they are written, and of sessions with an output stage.

use std::fs;
use std::path::PathBuf;

use chaincell_kernel::stage::{Coupling, Passivity, Stage};
use chaincell_kernel::trace::{CommandRecord, RECORD_BYTES, header_bytes};
use chaincell_kernel::{Budget, Flags, ToolPose};
use nalgebra::Vector3;

use super::*;
use crate::engine::fixture::{engine, plane};
use crate::files::output::Folder;

/// Begins the trace of the plane.
pub(crate) fn begun(stage: Option<&StageSettings>) -> Recording {
    Recording::begin(&engine(&plane()), Scheme::Track, Arithmetic::F32, stage).unwrap()
}

fn record(tick: u64) -> Record {
    let position_m = Vector3::new(0.0, 0.001, -0.0002 * tick as f32);
    let sample = ToolPose::at(position_m, u32::from(tick % 50 < 40));
    Record { state_hash: Some(tick << 40 | 1), ..Record::of(tick, sample) }
}

fn place() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.trace");
    (folder, path)
}

fn create(path: &Path, force: bool, records: usize) -> Result<TraceFile> {
    TraceFile::create("`record`", path, force, begun(None), records)
}

#[test]
fn every_record_stands_in_the_file_at_once() {
    let (_folder, path) = place();
    let (mut file, mut memory) = (create(&path, false, 10).unwrap(), begun(None));
    for tick in 0..7 {
        assert!(file.add(&record(tick)));
        memory.add(&record(tick));
        let found = fs::read(&path).unwrap();
        let (front, behind) = found.split_at(memory.bytes().len());
        assert_eq!(front, memory.bytes(), "tick {tick}");
        assert_eq!(behind.len(), (9 - tick as usize) * RECORD_BYTES);
        assert!(behind.iter().all(|&byte| byte == 0));
    }
    file.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), memory.bytes());
}

#[test]
fn a_full_file_takes_nothing_and_keeps_all() {
    let (_folder, path) = place();
    let mut file = create(&path, false, 2).unwrap();
    assert!(file.add(&record(1)) && file.has_room());
    let pause = CommandRecord { tick: 1, command: Command::Pause, state_hash: None };
    assert!(file.add_command(&pause) && !file.has_room());
    let before = fs::read(&path).unwrap();
    assert!(!file.add(&record(2)) && !file.add_command(&pause));
    assert_eq!(fs::read(&path).unwrap(), before);
    file.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap().len(), header_bytes(1) + 2 * RECORD_BYTES);
}

#[test]
fn a_file_that_is_recorded_to_is_left_alone() {
    let (folder, path) = place();
    let mut file = create(&path, false, 4).unwrap();
    file.add(&record(0));
    let before = fs::read(&path).unwrap();
    for force in [false, true] {
        let refused = create(&path, force, 4).unwrap_err().to_string();
        assert!(refused.contains("another run is recording to it"), "{refused}");
    }
    assert!(check_idle("`out`", &path).is_err() && check_place(&path, true).is_err());
    let session = folder.path().join(TRACE);
    fs::rename(&path, &session).unwrap();
    let refused = Folder::open(folder.path(), true).unwrap_err().to_string();
    assert!(refused.contains("another run is recording"), "{refused}");
    assert_eq!(fs::read(&session).unwrap(), before);
    drop(file);
    check_idle("`out`", &session).unwrap();
    Folder::open(folder.path(), true).unwrap();
    check_idle("`out`", &session).unwrap();
}

#[test]
fn a_file_that_is_there_is_replaced_by_force_and_only_where_it_is_a_trace() {
    let (folder, path) = place();
    create(&path, false, 1).unwrap().finish().unwrap();
    let before = fs::read(&path).unwrap();
    let refused = create(&path, false, 1).unwrap_err().to_string();
    assert!(refused.contains("`force`"), "{refused}");
    assert_eq!(fs::read(&path).unwrap(), before);
    create(&path, true, 3).unwrap().finish().unwrap();
    fs::write(&path, "mine").unwrap();
    let refused = create(&path, true, 1).unwrap_err().to_string();
    assert!(refused.contains("is no trace"), "{refused}");
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    let refused = create(folder.path(), true, 1).unwrap_err().to_string();
    assert!(refused.contains("no file"), "{refused}");
}

#[test]
fn a_disk_without_room_is_told_at_once_and_nothing_is_left() {
    let (_folder, path) = place();
    let refused = create(&path, false, 1 << 50).unwrap_err().to_string();
    for wanted in ["`record`", "no room for the trace", "MB", "`record_ticks`"] {
        assert!(refused.contains(wanted), "wanted `{wanted}`, got {refused}");
    }
    assert!(!path.exists());
}

/// Returns the number of page faults of this thread so far that did not read from the disk.
fn page_faults() -> u64 {
    let stat = fs::read_to_string("/proc/thread-self/stat").unwrap();
    let fields = stat.rsplit(") ").next().unwrap();
    fields.split(' ').nth(7).unwrap().parse().unwrap()
}

#[test]
fn adding_a_record_is_no_page_fault() {
    const RECORDS: u64 = 100_000;
    // The system may write the pages to the disk meanwhile: take the best of three runs.
    let least = (0..3).map(|_| {
        let (_folder, path) = place();
        let mut file = create(&path, false, RECORDS as usize).unwrap();
        let (before, start) = (page_faults(), std::time::Instant::now());
        (0..RECORDS).for_each(|tick| assert!(file.add(&record(tick))));
        println!("{} ns a record", start.elapsed().as_nanos() / u128::from(RECORDS));
        page_faults() - before
    });
    let least = least.min().unwrap();
    // The records fill 1,172 pages.
    assert!(least < 10, "{least} page faults");
}

/// An output stage's behaviour in a session is reproduced from the device's samples, with pauses, lost
/// ticks and commands.
// REQ-STG-08
#[test]
fn a_session_behind_a_stage_is_played_to_the_same_bits() {
    // Set up a tissue with a stage, and its trace.
    let stage_settings = StageSettings {
        coupling: Some(Coupling { stiffness_n_per_m: 200.0, damping_n_s_per_m: 0.5 }),
        passivity: Some(Passivity { device_damping_n_s_per_m: 0.1, delay_ticks: 1 }),
        max_slew_n_per_s: 500.0,
        max_force_n: 3.0,
        max_speed_m_per_s: 4.0,
        ramp_ticks: 30,
        watchdog_ticks: 5,
        ..StageSettings::NONE
    };
    let (image, mut recording) = (plane(), begun(Some(&stage_settings)));
    let (mut engine, mut stage) = (engine(&image), Stage::new(stage_settings).unwrap());
    // Record ticks and commands.
    let mut paused = false;
    for at in 0..200 {
        let tick = 10 + at + 3 * (at / 70);
        let device = record(at).sample;
        if !paused {
            let answer = engine.tick(&stage.sample(&device));
            stage.output(&answer);
        }
        let state_hash = Some(engine.state_hash());
        recording.add(&Record { state_hash, ..Record::of(tick, device) });
        let command = match at {
            60 => Command::Pause,
            75 => Command::Resume,
            120 => Command::Reset,
            _ if at % 70 == 69 => {
                // A silence lets the force fall and moves no cell, so the trace does not contain it.
                (0..12).for_each(|_| _ = stage.missed());
                continue;
            }
            _ => continue,
        };
        match command {
            Command::Pause => paused = true,
            Command::Resume => paused = false,
            command => engine.obey(&command).unwrap(),
        }
        if command == Command::Reset {
            stage = Stage::new(stage_settings).unwrap();
        }
        let state_hash = Some(engine.state_hash());
        recording.bytes.extend(recording.writer.command(&CommandRecord {
            tick,
            command,
            state_hash,
        }));
    }
    let trace = Reader::open(recording.bytes()).unwrap();
    let path = Path::new("a.trace");
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let (mut again, ..) = tissue(&trace, path, model).unwrap();
    // Play them.
    let mut played = Played::default();
    assert_eq!(play(&trace, &mut again, Start::default(), &mut played), Ok(End::Complete));
    assert_eq!(played, Played { ticks: 200, commands: 3, compared: 203, has_touched: true });
    assert_eq!(again.state_hash(), engine.state_hash());
}

/// Counted sweeps and restarted ramps are reproduced, with and without a stage.
// REQ-COS-12
#[test]
fn what_the_clock_decided_is_played_again() {
    for ramp_ticks in [None, Some(30)] {
        let settings = ramp_ticks.map(|ramp_ticks| StageSettings {
            coupling: Some(Coupling { stiffness_n_per_m: 200.0, damping_n_s_per_m: 0.5 }),
            ramp_ticks,
            ..StageSettings::NONE
        });
        let (image, mut recording) = (plane(), begun(settings.as_ref()));
        let mut first = Staged::new(engine(&image), settings).unwrap();
        // Record ticks with restarted ramps and counted sweeps.
        let mut late = 0;
        for at in 0..300 {
            let device = record(at).sample;
            let ramp_restarted = at % 90 == 50;
            if ramp_restarted {
                first.restart_ramp();
            }
            let sweeps = [None, Some(0), Some(1), Some(3), Some(0)][at as usize % 5];
            let output = first.tick_by(&[device], Budget::again(sweeps));
            late += u32::from(output.flags.contains(Flags::LATE));
            let state_hash = Some(first.state_hash());
            recording.add(&Record { sweeps, ramp_restarted, state_hash, ..Record::of(at, device) });
        }
        // Play them.
        assert!(late > 50, "{late} late ticks");
        let trace = Reader::open(recording.bytes()).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let (mut again, ..) = tissue(&trace, Path::new("a.trace"), model).unwrap();
        let mut played = Played::default();
        assert_eq!(play(&trace, &mut again, Start::default(), &mut played), Ok(End::Complete));
        assert_eq!(played, Played { ticks: 300, commands: 0, compared: 300, has_touched: true });
        // The stage is in the same state: the next force is the same too.
        let next = record(300).sample;
        assert_eq!(again.tick(&next), first.tick(&next));
    }
}
