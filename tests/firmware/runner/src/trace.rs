//! Traces between this machine and the images: each plays what the other recorded.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use anyhow::{Context, Result, ensure};
use chaincell_kernel::Choice;
use chaincell_kernel::trace::{Reader, Writer, header_bytes};
use chaincell_scenes::{Tier, sample};

use crate::case::Ready;

/// Ticks of a trace: a press, a release, the next press and a bad sample.
pub const TICKS: u32 = 70;
/// The record that is altered, within a press.
pub const ALTERED: u32 = 57;

/// A sound trace and the same with one record altered.
pub struct Traces {
    pub sound: PathBuf,
    pub altered: PathBuf,
}

impl Traces {
    /// What `image/build.rs` reads of them.
    pub fn environment(&self) -> [(&'static str, String); 3] {
        [
            ("CHAINCELL_TRACE", self.sound.display().to_string()),
            ("CHAINCELL_ALTERED", self.altered.display().to_string()),
            ("CHAINCELL_TRACE_TICKS", TICKS.to_string()),
        ]
    }
}

/// Records the scene with `chaincell run --trace`.
pub fn record(ready: &Ready, tier: Tier, chaincell: &Path, folder: &Path) -> Result<Traces> {
    let stem = folder.join(format!("{}-{}", ready.case.name, tier.name()));
    let [path, out, sound] = ["csv", "run", "trace"].map(|end| stem.with_extension(end));
    let mut rows = String::from("tick,x_m,y_m,z_m,engaged\n");
    for tick in 0..TICKS {
        let sample = sample(ready.scene.reach_m, tick);
        let [x, y, z] = sample.position_m.into();
        writeln!(rows, "{tick},{x},{y},{z},{}", sample.engaged)?;
    }
    std::fs::write(&path, rows)?;
    let settings = ready.settings();
    let held: Vec<String> = ready.scene.held.iter().map(u32::to_string).collect();
    let mut run = Command::new(chaincell);
    run.arg("run").arg(&ready.model_path).arg("--path").arg(&path).arg("--recorded");
    run.arg("--out").arg(&out).arg("--force").arg("--trace").arg(&sound);
    run.args(["--contact", &held.join(","), "--scheme", ready.scene.scheme]);
    run.args(["--precision", tier.name(), "--unloading", settings.unloading.name()]);
    run.args(["--sweeps", &settings.sweeps.to_string()]);
    if settings.max_force_n.is_finite() {
        run.args(["--max-force-n", &settings.max_force_n.to_string()]);
    }
    let ran = output(run)?;
    ensure!(ran.status.success(), "{}: run: {}", ready.case.name, said(&ran));
    let altered = stem.with_extension("altered");
    std::fs::write(&altered, alter(&std::fs::read(&sound)?)?)?;
    Ok(Traces { sound, altered })
}

/// The trace with the sample of record [`ALTERED`] a little aside and all checksums sound.
fn alter(trace: &[u8]) -> Result<Vec<u8>> {
    let reader = Reader::open(trace)?;
    let ids: Vec<u32> = reader.contacts().collect();
    let mut altered = vec![0; header_bytes(ids.len())];
    let writer = Writer::begin(reader.header(), &ids, &mut altered);
    let (mut writer, _) = writer.context("no room for the header")?;
    let mut records = 0;
    reader.records(|index, record| {
        let mut record = *record;
        if index == ALTERED {
            record.sample.position_m.x += 0.001;
        }
        altered.extend(writer.record(&record));
        records += 1;
        anyhow::Ok(())
    })?;
    ensure!(records == TICKS, "{records} records, not {TICKS}");
    Ok(altered)
}

/// Plays an image's own trace with `chaincell replay`; and sees it name the altered record.
pub fn replay(ready: &Ready, trace: &[u8], chaincell: &Path, stem: &Path) -> Result<()> {
    let play = |trace: &[u8], end: &str| {
        let path = stem.with_extension(end);
        std::fs::write(&path, trace)?;
        let mut replay = Command::new(chaincell);
        replay.arg("replay").arg(&path).arg("--model").arg(&ready.model_path);
        output(replay)
    };
    let played = play(trace, "trace")?;
    let wanted = format!("{TICKS} ticks replayed to the same bits, {TICKS} state hashes compared");
    let well = played.status.success() && said(&played).contains(&wanted);
    ensure!(well, "the image's trace: {}", said(&played));
    let played = play(&alter(trace)?, "altered")?;
    let named = said(&played).contains(&format!("tick {ALTERED} "));
    let refused = played.status.code() == Some(1) && named;
    ensure!(refused, "the image's trace, tick {ALTERED} altered: {}", said(&played));
    Ok(())
}

fn output(mut command: Command) -> Result<Output> {
    command.output().with_context(|| format!("{}", command.get_program().display()))
}

/// What a program said.
fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|said| String::from_utf8_lossy(said)).concat()
}
