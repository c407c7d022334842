//! A session that is recorded as slowly as a test likes.

use std::fs;
use std::path::Path;

use chaincell_host::bake::ImageBytes;
use chaincell_host::engine::staged::Staged;
use chaincell_host::engine::tissue::TissueEngine;
use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_host::files::recording::{Recording, TraceFile};
use chaincell_host::files::snapshot::{SessionSnapshot, place};
use chaincell_kernel::trace::{Command, CommandRecord, Record};
use chaincell_kernel::{Budget, Model, Network, Settings, TOOLS_MAX, ToolPose};
use tempfile::TempDir;

/// Ticks for which the trace has space.
const RECORDS: usize = 20_000;
/// A plane of 81 cells, as the other tests have it.
const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/plane9.chaincell");

/// A tissue, its trace, and the next tick.
pub struct Session {
    folder: TempDir,
    trace: TraceFile,
    begun: Vec<u8>,
    tissue: Staged<'static>,
    tick: u64,
}

/// The plane at rest with its middle cell held, and what its trace begins with.
fn plane() -> (Engine<'static>, Recording) {
    let image: &'static ImageBytes =
        Box::leak(Box::new(ImageBytes::copy(&fs::read(MODEL).unwrap())));
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let settings = Settings { sweeps: 3, ..Settings::for_model(&model) };
    let middle = model.cell_of_input(40).unwrap();
    let network = Network::new(model, settings).unwrap();
    let engine = Engine::new(network, Scheme::Track, &[middle]).unwrap();
    let begun = Recording::begin(&engine, Scheme::Track, Arithmetic::F32, None).unwrap();
    (engine, begun)
}

impl Session {
    /// A session of the plane in a folder of its own.
    pub fn begin() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::copy(MODEL, folder.path().join("model.chaincell")).unwrap();
        let (engine, recording) = plane();
        let begun = recording.bytes().to_vec();
        let path = folder.path().join("session.trace");
        let trace = TraceFile::create("--record", &path, false, recording, RECORDS).unwrap();
        Self { folder, trace, begun, tissue: Staged::new(engine, None).unwrap(), tick: 0 }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// A press, tick by tick.
    pub fn play(&mut self, ticks: u64) {
        self.play_from(0.002, ticks);
    }

    /// The same beside the first cell's place.
    pub fn play_from(&mut self, x_m: f32, ticks: u64) {
        for _ in 0..ticks {
            let depth_m = 0.004 * (0.05 * self.tick as f32).sin().abs();
            let position_m = [x_m, 0.001, -depth_m];
            let pose = ToolPose::at(position_m.into(), u32::from(self.tick > 0));
            self.tissue.tick_by(&[pose], Budget::All);
            let state_hash = Some(self.tissue.state_hash());
            assert!(self.trace.add(&Record { state_hash, ..Record::of(self.tick, pose) }));
            self.tick += 1;
        }
    }

    /// Takes a snapshot, as a server does that is asked for one.
    pub fn snapshot(&mut self) {
        let tick = self.tick - 1;
        let snapshot = SessionSnapshot {
            tick,
            publisher: 0,
            released: [true; TOOLS_MAX],
            is_paused: false,
            begun: self.begun.clone(),
            saved: self.tissue.saved().unwrap(),
        };
        let (bytes, checksum) = snapshot.to_bytes();
        fs::write(place(&self.folder().join("session.trace"), tick), bytes).unwrap();
        let state_hash = Some(self.tissue.state_hash());
        let command = Command::Snapshot { checksum };
        assert!(self.trace.add_command(&CommandRecord { tick, command, state_hash }));
    }

    /// Ends the recording. Returns its folder and the hash of the last state.
    pub fn end(self) -> (TempDir, String) {
        let Self { folder, trace, mut tissue, .. } = self;
        trace.finish().unwrap();
        (folder, format!("{:016x}", tissue.state_hash()))
    }
}

/// A recording of records that nobody has ticked, and its bytes.
pub fn fake(records: u64) -> (TempDir, Vec<u8>) {
    let (_, mut recording) = plane();
    for tick in 0..records {
        recording.add(&Record::of(tick, ToolPose::at([0.0_f32; 3].into(), 0)));
    }
    let folder = tempfile::tempdir().unwrap();
    let trace = recording.bytes().to_vec();
    fs::write(folder.path().join("session.trace"), &trace).unwrap();
    fs::copy(MODEL, folder.path().join("model.chaincell")).unwrap();
    (folder, trace)
}
