//! Tests of trace files while they are written.

use std::fs;
use std::path::PathBuf;

use chaincell_kernel::ToolPose;
use chaincell_kernel::trace::{CommandRecord, RECORD_BYTES, header_bytes};
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
    assert!(check_idle("`out`", &path).is_err() && check_place("`out`", &path, true).is_err());
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
