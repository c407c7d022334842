//! A board that stands by: sessions of this machine on its serial line, whole, from a snapshot, cut and damaged.

use std::fmt::Write;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, ensure};
use chaincell_kernel::trace::{RECORD_BYTES, Reader};
use serde::Deserialize;

use crate::board;
use crate::emulate::{Said, run_on_line};
use crate::target::Target;

/// Name in `--only`.
pub const NAME: &str = "m7-stand-by";
/// Ticks of the press, and the record within whose bytes the stream is cut.
const TICKS: u32 = 200;
const CUT: usize = 120;
/// Tissue and stage of the sessions.
const OPTIONS: [&str; 8] =
    ["--contact", "cells:122", "--scheme", "track", "--device", "omega", "--max-force-n", "4"];
/// Longest run of the board, also where this machine is busy with others \[s\]; it takes one.
const SECONDS: u32 = 300;
/// Ticks of a served press, and how often it is played: ten minutes, in which a busy machine finds time for two
/// commands.
const SERVED_TICKS: u32 = 2000;
const PRESSES: &str = "300";
/// A tick in which the tool is well inside.
const INSIDE: u64 = 500;
/// Bytes of a frame's kind and length, and of its checksum.
const HEAD: usize = 5;
const SUM: usize = 4;

/// Recorded sessions.
pub struct Session<'a> {
    chaincell: &'a Path,
    folder: PathBuf,
    model: PathBuf,
    /// False if this machine was too busy to save the served session in mid-press.
    is_served: bool,
}

/// What `chaincell replay` reports.
#[derive(Deserialize)]
struct Replayed {
    state_hash: String,
    hashes_compared: u64,
}

impl<'a> Session<'a> {
    /// Records a press without a clock, and a served session that is killed after a snapshot.
    pub fn record(chaincell: &'a Path, models: &Path) -> Result<Self> {
        let folder = models.join("stand-by");
        fs::create_dir_all(&folder)?;
        let model = folder.join("body.chaincell");
        let mut session = Self { chaincell, folder, model, is_served: false };
        let stiff = ["--coarse", "none", "--lean", "--stiffness-n-per-m", "400"];
        session.call(["bake", "box:6x6x4x0.01", "-o"], &session.model, &stiff)?;
        let (path, out) = (session.folder.join("press.csv"), session.folder.join("press"));
        write_path(&path, TICKS, |tick| -f64::from(tick) / 32768.0)?;
        let words = ["--path", text(&path)?, "--out", text(&out)?, "--force", "--picture", "off"];
        session.call(["run"], &session.model, &[&words[..], &OPTIONS].concat())?;
        session.is_served = session.serve()?;
        Ok(session)
    }

    /// The model of all of them.
    pub fn model(&self) -> &Path {
        &self.model
    }

    /// Serves presses by a tissue that has not the time for all sweeps, with a snapshot and a command in them, and
    /// kills the server. Returns false if the presses ended before that.
    fn serve(&self) -> Result<bool> {
        let out = self.folder.join("served");
        let _ = fs::remove_dir_all(&out);
        let scene = format!("board-{}", std::process::id());
        let mut serve = Command::new(self.chaincell);
        serve.arg("serve").arg(&self.model).args(OPTIONS).args(["--scene", &scene]);
        serve.arg("--out").arg(&out).args(["--late-share", "off", "--inject", "sweep:0.3@1"]);
        serve.stdout(Stdio::piped()).stderr(Stdio::null());
        let mut server = Killed(serve.spawn().context("serve")?);
        let lines = server.0.stdout.take().context("its output")?;
        let mut lines = BufReader::new(lines).lines();
        ensure!(lines.any(|line| line.is_ok_and(|line| line == "ready")), "serve is not ready");
        let path = self.folder.join("served.csv");
        let depth_m = |tick: u32| 1.2e-5 * f64::from(tick.min(SERVED_TICKS - tick).min(500));
        write_path(&path, SERVED_TICKS, |tick| -depth_m(tick))?;
        let mut control = Command::new(self.chaincell);
        control.args(["control", "--scene", &scene, "--late-share", "off", "--repeat", PRESSES]);
        let control = control.arg("--path").arg(&path);
        let control = control.stdout(Stdio::null()).stderr(Stdio::null());
        let mut control = Killed(control.spawn().context("control")?);
        // A snapshot where the tool is well inside, then a command, some time after which the server is killed.
        let limit = &["set", "max_force_n=1", "--json"][..];
        let mut tick = 0;
        for (words, until) in [(&["snapshot", "--json"][..], INSIDE), (limit, INSIDE + 300)] {
            while tick < until {
                if control.0.try_wait()?.is_some() {
                    return Ok(false);
                }
                let said = self.call(["command", "--scene"], Path::new(&scene), words);
                // One that is refused, as it came too soon, is sent again.
                tick = said.map_or(tick, |said| tick_of(&said).unwrap_or(tick));
            }
        }
        drop(server);
        Ok(true)
    }

    /// Standard output of a command of chaincell.
    fn call<const N: usize>(&self, verb: [&str; N], of: &Path, words: &[&str]) -> Result<Vec<u8>> {
        let mut command = Command::new(self.chaincell);
        let ran = command.args(verb).arg(of).args(words).output().context("chaincell")?;
        let said = String::from_utf8_lossy(&ran.stderr);
        ensure!(ran.status.success(), "chaincell {verb:?}: {said}");
        Ok(ran.stdout)
    }

    /// The bytes that `chaincell mirror` sends of a session.
    fn mirrored(&self, name: &str) -> Result<Vec<u8>> {
        self.call(["mirror"], &self.folder.join(name), &[])
    }

    /// State hash at the end of a session, by `chaincell replay`, and the number of hashes in it.
    fn replayed(&self, name: &str) -> Result<Replayed> {
        let said = self.call(["replay"], &self.folder.join(name), &["--json"])?;
        Ok(serde_json::from_slice(&said)?)
    }

    /// The ticks of the press with their hashes.
    fn hashes(&self) -> Result<Vec<(u64, u64)>> {
        let bytes = fs::read(self.folder.join("press/session.trace"))?;
        let mut hashes = Vec::new();
        Reader::open(&bytes)?.records(|_, record| {
            hashes.extend(record.state_hash.map(|hash| (record.tick, hash)));
            anyhow::Ok(())
        })?;
        Ok(hashes)
    }

    /// Puts all of it on the line of the board. Returns a line for each proof.
    pub fn prove(&self, target: &Target, image: &Path) -> Result<Vec<String>> {
        let on_line = |name: &str, stream: &[u8]| {
            let path = self.folder.join(name).with_extension("stream");
            fs::write(&path, stream)?;
            run_on_line(target, image, &path, SECONDS).with_context(|| name.to_owned())
        };
        let mut lines = Vec::new();
        // The whole session.
        let (stream, hashes) = (self.mirrored("press")?, self.hashes()?);
        let (said, is_well) = on_line("whole", &stream)?;
        ensure!(is_well && said.text("ended").is_ok(), "whole: {}", said.all());
        let compared = said.number("compared")?;
        ensure!(compared == u64::from(TICKS), "whole: {compared} hashes compared");
        same(&said, hashes.last())?;
        let (here, there) = (said.text("hash")?, self.replayed("press")?.state_hash);
        ensure!(here == there, "whole: hash {here}, that of the session {there}");
        lines.push(format!("a whole session, {compared} hashes compared"));
        lines.push(match self.is_served {
            true => self.late(on_line)?,
            false => {
                "SKIPPED a snapshot: the presses ended before this busy machine saved one".into()
            }
        });
        // A stream that ends in the middle of a press, within a record.
        let first = first_record(&stream)?;
        let cut = &stream[..first + CUT * RECORD_BYTES + 20];
        let (said, is_well) = on_line("cut", cut)?;
        ensure!(is_well && said.text("goes_on").is_ok(), "cut: {}", said.all());
        same(&said, hashes.get(CUT - 1))?;
        self.goes_on_as_here(&said, cut).context("cut")?;
        lines.push(format!("cut, {}", force(&said)?));
        lines.push(self.damage(&stream, &hashes, on_line)?);
        Ok(lines)
    }

    /// A late joiner's stream, of a server that was killed.
    fn late(&self, on_line: impl Fn(&str, &[u8]) -> Result<(Said, bool)>) -> Result<String> {
        let stream = self.mirrored("served")?;
        let (said, is_well) = on_line("late", &stream)?;
        let replayed = self.replayed("served")?;
        ensure!(is_well && said.text("goes_on").is_ok(), "late: {}", said.all());
        let (compared, all) = (said.number("compared")?, replayed.hashes_compared);
        ensure!((1..all).contains(&compared), "late: {compared} hashes compared of {all}");
        let (here, there) = (said.text("hash")?, &replayed.state_hash);
        ensure!(here == there, "late: hash {here}, that of the session {there}");
        ensure!(said.number("withheld_un")? == 0, "late: {}", said.all());
        self.goes_on_as_here(&said, &stream).context("late")?;
        Ok(format!("from a snapshot, {compared} of {all} hashes compared; goes on as this machine"))
    }

    /// After the takeover the board has the bits and the forces that its program has on this machine.
    fn goes_on_as_here(&self, said: &Said, stream: &[u8]) -> Result<()> {
        let here = board::follow(&self.model, stream)?;
        for name in ["hash", "hash_after", "withheld_un", "largest_un", "step_un"] {
            let (there, here) = (said.text(name)?, here.text(name)?);
            ensure!(there == here, "{name} is {there} on the board, {here} on this machine");
        }
        ensure!(said.text("hash")? != said.text("hash_after")?, "the tissue has not moved");
        Ok(())
    }

    /// Flips a bit of the stream in many places: each is seen, and nothing is taken over.
    fn damage(
        &self,
        stream: &[u8],
        hashes: &[(u64, u64)],
        on_line: impl Fn(&str, &[u8]) -> Result<(Said, bool)>,
    ) -> Result<String> {
        let first = first_record(stream)?;
        let in_record = |record: usize, byte| first + record * RECORD_BYTES + byte;
        // Head, header, model, numbers of a frame, records, the checksum of the frame.
        let mut places = vec![3, 60, 5000, first - 8, first - 4];
        places.extend([(0, 0), (CUT, 9), (CUT, 33), (CUT, 47)].map(|(of, at)| in_record(of, at)));
        places.push(in_record(TICKS as usize, 2));
        let count = places.len();
        for place in places {
            let mut flipped = stream.to_vec();
            flipped[place] ^= 1 << (place % 8);
            let (said, is_well) = on_line("damaged", &flipped)?;
            let is_refused = !is_well && said.text("refused").is_ok();
            let stays = said.text("goes_on").is_err() && said.text("ended").is_err();
            ensure!(is_refused && stays, "byte {place} flipped: {}", said.all());
            // It stands at a state of the session.
            if said.number("compared").is_ok_and(|compared| compared > 0) {
                let last = said.number("compared")? as usize - 1;
                same(&said, hashes.get(last)).with_context(|| format!("byte {place}"))?;
            }
        }
        Ok(format!("{count} damaged streams refused, nothing taken over"))
    }
}

/// Writes a path along z of a tool that is engaged.
fn write_path(path: &Path, ticks: u32, z_m: impl Fn(u32) -> f64) -> Result<()> {
    let mut rows = String::from("tick,x_m,y_m,z_m,engaged\n");
    for tick in 0..ticks {
        writeln!(rows, "{tick},0,0,{},1", z_m(tick))?;
    }
    Ok(fs::write(path, rows)?)
}

/// The tick after which a command was carried out.
fn tick_of(reply: &[u8]) -> Option<u64> {
    serde_json::from_slice::<serde_json::Value>(reply).ok()?.get("tick")?.as_u64()
}

/// A program that is killed when it is no longer needed.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        // One that has ended cannot be killed.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The board stands where the session stood after a tick.
fn same(said: &Said, recorded: Option<&(u64, u64)>) -> Result<()> {
    let here = (said.number("tick")?, said.bits("hash")?);
    ensure!(Some(&here) == recorded, "the board is at {here:x?}, the session at {recorded:x?}");
    Ok(())
}

/// The force after a takeover: none before a release, then along the ramp.
fn force(said: &Said) -> Result<String> {
    let [withheld, largest, step, ramp] =
        ["withheld_un", "largest_un", "step_un", "ramp_step_un"].map(|name| said.number(name));
    let [withheld, largest, step, ramp] = [withheld?, largest?, step?, ramp?];
    ensure!(withheld == 0, "{withheld} uN before a release");
    ensure!(largest > 1_000_000, "the press has {largest} uN");
    ensure!(step <= ramp, "a step of {step} uN, the ramp's are {ramp} uN");
    Ok(format!("goes on to {largest} uN in steps of at most {step} uN, the ramp's {ramp} uN"))
}

/// Place of the first record in a stream that has no snapshot, by the lengths of its frames.
fn first_record(stream: &[u8]) -> Result<usize> {
    let mut place = b"CHAINMIR".len() + 4;
    loop {
        let head = stream.get(place..place + HEAD).context("no frame of records")?;
        let length: [u8; 4] = head[1..].try_into()?;
        if head[0] == 4 {
            return Ok(place + HEAD + 8);
        }
        place += HEAD + u32::from_le_bytes(length) as usize + SUM;
    }
}

fn text(path: &Path) -> Result<&str> {
    path.to_str().context("a path that is no text")
}
