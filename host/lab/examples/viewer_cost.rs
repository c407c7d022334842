//! Effect of a page of `chaincell view` on the ticks of a session, on this machine:
//!
//! ```sh
//! cargo build --release && cargo run --release -p chaincell-lab --example viewer_cost
//! ```
//!
//! Plays pairs of sessions of `chaincell cosim`, one with `chaincell view` and an open page, one without, and
//! prints the 99th percentile of the tick of each, then the ratio of the smallest ones: what else the machine
//! does only adds to them. Fails if a pose stays without an answer, or if the ratio is above 1.05. Arguments: the
//! number of pairs, 5 unless given, and the seconds of a session, 8.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{SystemTime, UNIX_EPOCH};

use chaincell_host::error::{Error, Result};
use chaincell_host::session::supervise::program;
use chaincell_lab::cli::exit_code;
use serde_json::{Value, json};

/// Most that a page may add to the tick.
const RATIO_MAX: f64 = 1.05;

/// A program that ends with this value.
struct Ending(Child);

impl Drop for Ending {
    fn drop(&mut self) {
        // Both fail only for a program that has ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn failed(doing: &str) -> impl Fn(std::io::Error) -> Error + '_ {
    move |why| Error::check(format!("cannot {doing}: {why}"))
}

/// The address that `chaincell view` prints.
fn view(chaincell: &Path, model: &Path, scene: &str) -> Result<(Ending, String)> {
    let mut command = Command::new(chaincell);
    command.arg("view").arg(model).args(["--scene", scene, "--no-open"]).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(failed("start chaincell view"))?;
    let out = child.stdout.take();
    let ending = Ending(child);
    let first = out.and_then(|out| BufReader::new(out).lines().next());
    let address = first.ok_or_else(|| Error::check("chaincell view prints no address"))?;
    Ok((ending, address.map_err(failed("read the address"))?))
}

/// Opens the page of an address, and takes frames for as long as they come; their number.
fn take_frames(address: &str) -> Result<usize> {
    let refused = || Error::check(format!("{address} is no page of chaincell view"));
    let (host, token) =
        address.strip_prefix("http://").and_then(|of| of.split_once("/#")).ok_or_else(refused)?;
    let mut stream = TcpStream::connect(host).map_err(failed("connect"))?;
    let head = format!(
        "GET /live HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nUpgrade: websocket\r\n\
         Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
         Sec-WebSocket-Protocol: chaincell, {token}\r\n\r\n"
    );
    stream.write_all(head.as_bytes()).map_err(failed("write"))?;
    let mut reader = BufReader::new(stream.try_clone().map_err(failed("read"))?);
    let mut line = String::new();
    while reader.read_line(&mut line).map_err(failed("read"))? > 2 {
        line.clear();
    }
    let mut frames = 0;
    // A text `seen`, masked by zeros, for each binary message.
    while let Ok(is_frame) = take_message(&mut reader) {
        if is_frame {
            frames += 1;
            stream.write_all(b"\x81\x84\0\0\0\0seen").map_err(failed("write"))?;
        }
    }
    Ok(frames)
}

/// Takes a message of the server; whether it is a frame.
fn take_message(reader: &mut impl Read) -> std::io::Result<bool> {
    let mut head = [0; 2];
    reader.read_exact(&mut head)?;
    let mut length = [0; 8];
    let words = match head[1] {
        126 => 2,
        127 => 8,
        short => {
            length[7] = short;
            0
        }
    };
    reader.read_exact(&mut length[8 - words..])?;
    let mut body = reader.take(u64::from_be_bytes(length));
    std::io::copy(&mut body, &mut std::io::sink())?;
    Ok(head[0] & 15 == 2)
}

/// Plays a session, with a page or without; the report, and the frames that the page took.
fn session(place: &Place, seconds: &str, with_page: bool) -> Result<(Value, usize)> {
    let mut command = Command::new(&place.chaincell);
    command.arg("cosim").arg(&place.model).args(["--scene", &place.scene, "--seconds", seconds]);
    command.args(["--late-share", "off", "--json"]).stdout(Stdio::piped());
    let page =
        if with_page { Some(view(&place.chaincell, &place.model, &place.scene)?) } else { None };
    let taken = page.as_ref().map(|(_, address)| {
        let address = address.clone();
        std::thread::spawn(move || take_frames(&address))
    });
    let played = command.output().map_err(failed("run chaincell cosim"))?;
    drop(page);
    let frames = match taken.map(std::thread::JoinHandle::join) {
        Some(Ok(frames)) => frames?,
        Some(Err(_)) => return Err(Error::check("the page's thread ended early")),
        None => 0,
    };
    let text = String::from_utf8_lossy(&played.stdout);
    let report = text.lines().last().and_then(|line| serde_json::from_str(line).ok());
    Ok((report.ok_or_else(|| Error::check("chaincell cosim gives no report"))?, frames))
}

/// The program, its model and its scene.
struct Place {
    chaincell: PathBuf,
    model: PathBuf,
    scene: String,
}

fn run() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let pairs = arguments.next().map_or(Ok(5), |text| text.parse());
    let pairs: usize = pairs.map_err(|_| Error::input("give the number of pairs, as in 5"))?;
    let seconds = arguments.next().unwrap_or_else(|| "8".into());
    let beside = std::env::current_exe()
        .ok()
        .and_then(|own| Some(own.parent()?.parent()?.join("chaincell")));
    let chaincell = beside.filter(|path| path.is_file()).or_else(|| program::find("chaincell"));
    let chaincell =
        chaincell.ok_or_else(|| Error::input("no chaincell: run cargo build --release"))?;
    let folder = tempfile::tempdir().map_err(failed("make a folder"))?;
    let model = folder.path().join("organ.chaincell");
    let image = chaincell_host::bake::organ()?;
    std::fs::write(&model, image.as_bytes()).map_err(failed("write the model"))?;
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let place = Place { chaincell, model, scene: format!("viewer-cost-{}", since.as_nanos()) };
    let mut smallest_us = [f64::INFINITY; 2];
    let (mut answered, mut unanswered) = (0, 0);
    for pair in 0..pairs {
        for (with_page, smallest_us) in [false, true].into_iter().zip(&mut smallest_us) {
            let (report, frames) = session(&place, &seconds, with_page)?;
            let p99_us = report["step_ns"]["p99"].as_f64().unwrap_or(f64::NAN) * 1e-3;
            *smallest_us = smallest_us.min(p99_us);
            if with_page {
                answered += report["ticks_answered"].as_u64().unwrap_or(0);
                unanswered += report["ticks_unanswered"].as_u64().unwrap_or(u64::MAX);
            }
            println!(
                "{}",
                json!({ "pair": pair, "page": with_page, "step_p99_us": p99_us, "frames": frames })
            );
        }
    }
    let ratio = smallest_us[1] / smallest_us[0];
    let report = json!({
        "step_p99_us": smallest_us, "ratio": ratio, "answered_with_page": answered, "unanswered_with_page": unanswered,
    });
    println!("{report}");
    if unanswered > 0 || ratio.is_nan() || ratio > RATIO_MAX {
        return Err(Error::check(
            "a page has an effect on the ticks; repeat this on a machine that does nothing else",
        ));
    }
    Ok(())
}

fn main() -> ExitCode {
    exit_code(run())
}
