//! Traces end to end: recorded by `run`, by a scene as firmware plays it, replayed,
//! damaged.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

use std::path::{Path, PathBuf};
use std::time::Duration;

use chaincell_kernel::trace::{Header, Origin, Reader, Record, Writer, header_bytes};
use chaincell_kernel::{Choice, Dynamics, TissueMut};
use chaincell_scenes::{Act, Run, SCENES, Scene, stage};
use chaincell_tests::files::{Row, bake, content, play, scratch, summary, text, write_path};
use chaincell_tests::process::SHORT;
use chaincell_tests::{Ended, Running, run};
use crc::{CRC_32_ISO_HDLC, Crc};
use rustix::process::Signal;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A press with lost and bad samples and a release.
fn press() -> Vec<Row> {
    (0..120_u16)
        .map(|tick| {
            let z = if tick % 37 == 20 { f32::NAN } else { -0.0004 * f32::from(tick.min(60)) };
            let number = u64::from(tick) + 3 * u64::from(tick / 50);
            (number, [0.0, 0.001, z], u32::from(tick < 90))
        })
        .collect()
}

/// A model, a trace that `run` recorded with it, and what `run` said.
struct Session {
    folder: tempfile::TempDir,
    model: PathBuf,
    trace: PathBuf,
    state_hash: String,
}

fn session(how: &[&str]) -> Session {
    let folder = scratch();
    let options = ["--diagonals", "--alpha", "0.01"];
    let model = bake(folder.path(), "plane:11x11x0.01", &options);
    let (path, out) = (folder.path().join("path.csv"), folder.path().join("out"));
    let trace = folder.path().join("a.trace");
    write_path(&path, press());
    let options = [&["--recorded", "--trace", text(&trace)], how].concat();
    play(&model, &path, &out, &options).with(0);
    let state_hash = summary(&out)["state_hash"].as_str().unwrap().to_owned();
    Session { folder, model, trace, state_hash }
}

fn replay(trace: &Path, model: &Path) -> Ended {
    run(["replay", text(trace), "--model", text(model), "--json"])
}

/// The trace's parts, for tests that put them together otherwise.
fn parts(bytes: &[u8]) -> (Header, Vec<u32>, Vec<Record>) {
    let trace = Reader::open(bytes).unwrap();
    let mut records = Vec::new();
    let keep = |_, record: &Record| {
        records.push(*record);
        Ok::<(), ()>(())
    };
    trace.records(keep).unwrap();
    (*trace.header(), trace.contacts().collect(), records)
}

fn written(header: &Header, ids: &[u32], records: &[Record]) -> Vec<u8> {
    let mut bytes = vec![0; header_bytes(ids.len())];
    let (mut writer, _) = Writer::begin(header, ids, &mut bytes).unwrap();
    records.iter().for_each(|record| bytes.extend(writer.record(record)));
    bytes
}

/// A trace with two bytes of its header changed and the header's checksum made right again.
fn reworded(whole: &[u8], front: usize, at: usize, to: u16) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    bytes[at..at + 2].copy_from_slice(&to.to_le_bytes());
    let mut digest = CRC.digest();
    digest.update(&bytes[..60]);
    digest.update(&bytes[64..front]);
    let checksum = digest.finalize().to_le_bytes();
    bytes[60..64].copy_from_slice(&checksum);
    bytes
}

#[test]
fn what_run_records_is_replayed_to_the_same_bits() {
    for how in [
        &["--scheme", "track", "--unloading", "retreat", "--max-force-n", "0.2"][..],
        &["--scheme", "euler", "--step", "0.03", "--contact", "60,61,48"],
        &["--scheme", "track", "--contact", "probe:0.025"],
        &["--scheme", "rkl2", "--time-constant-s", "0.002"],
        &["--scheme", "rkl2", "--sweeps", "9"],
        &["--scheme", "track", "--precision", "fixed"],
        &["--scheme", "euler", "--precision", "fixed"],
        &["--scheme", "track", "--drive", "current"],
        &["--scheme", "track", "--max-tool-step-m", "0.002", "--unloading", "off"],
    ] {
        let session = session(how);
        let ended = replay(&session.trace, &session.model).with(0);
        let found = ended.json();
        assert_eq!(found["ticks"], 120, "{how:?}");
        assert_eq!(found["hashes_compared"], 120);
        assert_eq!(found["state_hash"], session.state_hash);
        assert_eq!(found["scheme"], how[1]);
        let number = if how[2] == "--precision" { how[3] } else { "f32" };
        assert_eq!(found["precision"], number);
        assert_eq!(found["end"], "complete");
        assert!(found["first_difference"].is_null());
        // The folder has the same trace, and the model.
        let out = session.folder.path().join("out");
        assert_eq!(
            std::fs::read(out.join("session.trace")).unwrap(),
            std::fs::read(&session.trace).unwrap()
        );
        let said = run(["replay", text(&out)]).with(0);
        assert!(said.out.contains("120 ticks replayed to the same bits"), "{}", said.out);
    }
}

/// The trace of a scene in its own tissue, as firmware dumps it.
struct Dump(u32);

impl Act for Dump {
    type Output = Option<Vec<u8>>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        let mut trace = vec![0; header_bytes(scene.held.len())];
        let (mut writer, _) = run.begin_trace(&mut trace)?;
        (0..self.0).for_each(|_| trace.extend(writer.record(&run.record())));
        Some(trace)
    }
}

#[test]
fn what_a_scene_dumps_is_replayed_to_the_same_bits() {
    let folder = scratch();
    let (trace, model) = (folder.path().join("a.trace"), folder.path().join("a.chaincell"));
    let tiers = |scene: &'static Scene| scene.tiers.iter().map(move |&tier| (scene, tier));
    for (scene, tier) in SCENES.into_iter().flat_map(tiers) {
        // A trace holds no tools but one sphere.
        let Some(dumped) = stage(scene.name, tier, Dump(150)).unwrap() else { continue };
        std::fs::write(&trace, dumped).unwrap();
        std::fs::write(&model, scene.image).unwrap();
        let found = replay(&trace, &model).with(0).json();
        assert_eq!(found["hashes_compared"], 150, "{}", scene.name);
        assert_eq!(
            (&found["scheme"], &found["precision"]),
            (&scene.scheme.into(), &tier.name().into())
        );
    }
}

/// A trace of another revision of the arithmetic names the release to take.
#[test]
fn a_trace_of_an_earlier_revision_names_its_release() {
    let session = session(&[]);
    let (header, ids, records) = parts(&std::fs::read(&session.trace).unwrap());
    let header = Header { origin: Origin { revision: 1, release: [0, 1, 7] }, ..header };
    std::fs::write(&session.trace, written(&header, &ids, &records)).unwrap();
    let ended = replay(&session.trace, &session.model).with(2);
    let told = "revision 1 of the arithmetic";
    assert!(ended.err.contains(told) && ended.err.contains("0.1.7"), "{}", ended.err);
}

#[test]
fn an_altered_tick_is_named() {
    let session = session(&[]);
    let (header, ids, mut records) = parts(&std::fs::read(&session.trace).unwrap());
    records[70].sample.position_m.x += 0.002;
    std::fs::write(&session.trace, written(&header, &ids, &records)).unwrap();
    let ended = replay(&session.trace, &session.model).with(1);
    let wanted = format!("tick {} (record 70) is the first that differs", records[70].tick);
    assert!(ended.err.contains(&wanted), "{}", ended.err);
    let found = ended.json();
    assert_eq!(found["first_difference"]["record"], 70);
    assert_eq!(found["first_difference"]["tick"], 73);
    assert_eq!(found["ticks"], 71);
}

#[test]
fn a_cut_trace_is_replayed_as_far_as_it_goes() {
    let session = session(&[]);
    let whole = std::fs::read(&session.trace).unwrap();
    std::fs::write(&session.trace, &whole[..whole.len() - 48 * 20 - 7]).unwrap();
    let ended = replay(&session.trace, &session.model).with(0);
    assert!(ended.err.contains("note: ") && ended.err.contains("cut within record 99"));
    assert_eq!(ended.json()["ticks"], 99);
    assert_eq!(ended.json()["end"], "cut within record 99");
}

#[test]
fn what_cannot_be_played_is_refused_with_reason_and_remedy() {
    let session = session(&[]);
    let other = bake(
        &{
            let place = session.folder.path().join("other");
            std::fs::create_dir(&place).unwrap();
            place
        },
        "plane:9x9x0.01",
        &[],
    );
    let ended = replay(&session.trace, &other).with(2);
    for wanted in ["recorded with the model of checksum", "give the model of the recording"] {
        assert!(ended.err.contains(wanted), "{}", ended.err);
    }
    let whole = std::fs::read(&session.trace).unwrap();
    let changed = |at: usize, to: u8| {
        let mut bytes = whole.clone();
        bytes[at] = to;
        bytes
    };
    let front = header_bytes(Reader::open(&whole).unwrap().contacts().len());
    let (header, ids, records) = parts(&whole);
    let hashless: Vec<Record> =
        records.iter().map(|record| Record { state_hash: None, ..*record }).collect();
    for (bytes, reason, remedy) in [
        (b"tick,x_m,y_m\n".to_vec(), "not a chaincell trace", "run --trace"),
        (Vec::new(), "not a chaincell trace", "run --trace"),
        (changed(8, 9), "format version 9 is not 5", "take the release that wrote it"),
        (changed(30, 1), "the header is damaged", "copy it again"),
        (whole[..front - 1].to_vec(), "stops within its header", "copy it again"),
        (whole[..front].to_vec(), "holds no tick", "record again"),
        (whole[..front + 47].to_vec(), "holds no tick", "record again"),
        (
            changed(front + 5 * 48 + 12, 77),
            "record 5 is damaged",
            "5 ticks before it replayed to the same bits",
        ),
        (reworded(&whole, front, 20, 99), "scheme 99", "take the release"),
        (reworded(&whole, front, 22, 9), "number type 9", "take the release"),
        (
            reworded(&whole, front, 64, 7),
            "revision 7 of the arithmetic",
            "replay it with chaincell 0.2.0",
        ),
        (written(&header, &[0], &records), "--contact", "fixed"),
        (written(&header, &[4000], &records), "contact node 4000 is no cell", "record again"),
        (written(&header, &ids, &hashless), "no state hash", "--hash-every 1"),
    ] {
        std::fs::write(&session.trace, bytes).unwrap();
        let ended = replay(&session.trace, &session.model).with(2);
        for wanted in [reason, remedy] {
            assert!(ended.err.contains(wanted), "wanted `{wanted}`, got {}", ended.err);
        }
    }
    let missing = session.folder.path().join("missing.trace");
    assert!(replay(&missing, &session.model).with(2).err.contains("cannot read trace"));
}

#[test]
fn ctrl_c_ends_a_replay_within_a_long_tick() {
    let folder = scratch();
    let model = bake(folder.path(), "plane:120x120x0.01", &[]);
    let (path, out) = (folder.path().join("path.csv"), folder.path().join("out"));
    write_path(&path, [(0, [0.0; 3], 1), (1, [0.0, 0.0, -0.01], 1)]);
    play(&model, &path, &out, &[]).with(0);
    // Its second tick then takes tens of seconds.
    let trace = out.join("session.trace");
    let (mut header, ids, records) = parts(&std::fs::read(&trace).unwrap());
    header.settings.sweeps = u16::MAX;
    std::fs::write(&trace, written(&header, &ids, &records)).unwrap();
    let mut replay = Running::chaincell(["replay", text(&out)]);
    std::thread::sleep(Duration::from_secs(2));
    assert!(replay.is_running(), "the tick is too short for this test");
    replay.signal(Signal::INT);
    let ended = replay.end(SHORT).with(130);
    assert!(ended.err.contains("interrupted") && ended.out.is_empty(), "{ended:?}");
}

#[test]
fn a_trace_takes_no_others_place_and_costs_no_earlier_results() {
    let folder = scratch();
    let model = bake(folder.path(), "plane:9x9x0.01", &[]);
    let (path, out) = (folder.path().join("path.csv"), folder.path().join("out"));
    write_path(&path, [(0, [0.0; 3], 1)]);
    let trace = out.join("a.trace");
    let traced = |trace: &Path, how: &[&str]| {
        play(&model, &path, &out, &[&["--trace", text(trace)], how].concat())
    };
    traced(&trace, &[]).with(0);
    let before = content(folder.path());
    let nowhere = folder.path().join("no/such/a.trace");
    for (place, how, wanted) in [
        (&trace, &[][..], "pass --force"),
        (&nowhere, &["--force"], "no/such/a.trace"),
        (&out, &["--force"], "it is there and no file"),
        (&model, &["--force"], "it is the input"),
        (&path, &["--force"], "it is the input"),
    ] {
        let ended = traced(place, how).with(2);
        assert!(ended.err.contains(wanted), "wanted `{wanted}`, got {}", ended.err);
        assert_eq!(content(folder.path()), before, "{}", place.display());
    }
    traced(&trace, &["--force"]).with(0);
    replay(&trace, &model).with(0);
}
