//! Effect of a page of `chaincell view` on the ticks of a session, on this machine:
//!
//! ```sh
//! cargo build --release && cargo run --release -p chaincell-lab --example viewer_cost
//! ```
//!
//! Plays pairs of sessions of `chaincell serve` and `chaincell control`, a ball that presses the default body at
//! four sweeps a tick, one session with `chaincell view` and an open page, one without, each first in turn. Prints
//! the 99th percentile of the tick of each, then the ratio of the smallest ones: what else the machine does only
//! adds to them. Fails if a pose stays without an answer, or if the ratio is above 1.05. Arguments: the number of
//! pairs, 5 unless given, and the seconds of a session, 8. A session takes some seconds more than these; every
//! wait has a limit.

use std::ffi::OsString;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::mpsc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use chaincell_host::error::{Error, Result};
use chaincell_host::session::supervise::{CosimOptions, CosimReports, cosim, program};
use chaincell_lab::cli::exit_code;
use serde_json::json;

/// Most that a page may add to the tick.
const RATIO_MAX: f64 = 1.05;
/// The tool.
const RADIUS_M: &str = "0.012";
/// Longest wait for an address, a server or a message: two busy cores are slow.
const LIMIT: Duration = Duration::from_secs(60);

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

/// Starts `chaincell view`; the program and the address that it prints.
fn view(place: &Place) -> Result<(Ending, String)> {
    let mut command = Command::new(&place.chaincell);
    command.arg("view").arg(&place.model).args(["--scene", &place.scene, "--no-open"]);
    command.args(["--tool", &format!("sphere:{RADIUS_M}")]).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(failed("start chaincell view"))?;
    let out = child.stdout.take();
    let ending = Ending(child);
    // The thread ends with the program, whose end closes the pipe.
    let (sender, lines) = mpsc::channel();
    thread::spawn(move || {
        for line in out
            .into_iter()
            .flat_map(|out| BufReader::new(out).lines())
            .map_while(std::result::Result::ok)
        {
            let _ = sender.send(line);
        }
    });
    let address = lines.recv_timeout(LIMIT);
    let address =
        address.map_err(|why| Error::check(format!("chaincell view prints no address: {why}")))?;
    Ok((ending, address))
}

/// Opens the page of an address, and takes frames for as long as they come; their number.
fn take_frames(address: &str) -> Result<usize> {
    let refused = || Error::check(format!("{address} is no page of chaincell view"));
    let (host, token) =
        address.strip_prefix("http://").and_then(|of| of.split_once("/#")).ok_or_else(refused)?;
    let mut stream = TcpStream::connect(host).map_err(failed("connect"))?;
    stream.set_read_timeout(Some(LIMIT)).map_err(failed("limit a wait"))?;
    stream.set_write_timeout(Some(LIMIT)).map_err(failed("limit a wait"))?;
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
    loop {
        match take_message(&mut reader) {
            // A text `seen`, masked by zeros, for each binary message.
            Ok(true) => {
                frames += 1;
                stream.write_all(b"\x81\x84\0\0\0\0seen").map_err(failed("write"))?;
            }
            Ok(false) => {}
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                return Err(Error::check(format!(
                    "no message for {} s after {frames} frames",
                    LIMIT.as_secs()
                )));
            }
            // The page's server has ended.
            Err(_) => return Ok(frames),
        }
    }
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

/// An open page: its program, and the thread that takes its frames.
struct OpenPage {
    view: Ending,
    taking: JoinHandle<Result<usize>>,
}

impl OpenPage {
    fn open(place: &Place) -> Result<Self> {
        let (view, address) = view(place)?;
        Ok(Self { view, taking: thread::spawn(move || take_frames(&address)) })
    }

    /// Closes it; the frames that it took.
    fn close(self) -> Result<usize> {
        drop(self.view);
        self.taking.join().unwrap_or_else(|_| Err(Error::check("the page's thread ended early")))
    }
}

/// Plays a session, with a page or without; the reports, and the frames that the page took.
fn session(place: &Place, seconds: u64, with_page: bool) -> Result<(CosimReports, usize)> {
    let (model, scene, ticks) = (&place.model, place.scene.as_str(), (1000 * seconds).to_string());
    let contact = format!("probe:{RADIUS_M}");
    let common = ["--scene", scene, "--contact", &contact, "--late-share", "off", "--json"];
    let arguments =
        |words: &[&str]| words.iter().chain(&common).map(OsString::from).collect::<Vec<_>>();
    let mut serve_args =
        arguments(&["serve", "--budget-us", "off", "--sweeps", "4", "--ticks", &ticks]);
    serve_args.push(model.into());
    let mut control_args =
        arguments(&["control", "--depth-m", "0.01", "--seconds", &seconds.to_string()]);
    control_args.extend(["--model".into(), model.into()]);
    let options = CosimOptions {
        program: place.chaincell.clone(),
        serve_args,
        control_args,
        motion_ms: 1000 * seconds,
        ready_s: LIMIT.as_secs(),
    };
    let page = if with_page { Some(OpenPage::open(place)?) } else { None };
    let played = cosim(&options, |_| ());
    let frames = page.map_or(Ok(0), OpenPage::close)?;
    Ok((played?, frames))
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
    let seconds = arguments.next().map_or(Ok(8), |text| text.parse());
    let seconds: u64 =
        seconds.map_err(|_| Error::input("give the seconds of a session, as in 8"))?;
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
        for with_page in [pair % 2 == 1, pair % 2 == 0] {
            let (reports, frames) = session(&place, seconds, with_page)?;
            let p99_us = reports.serve.step_ns.p99 as f64 * 1e-3;
            let smallest_us = &mut smallest_us[usize::from(with_page)];
            *smallest_us = smallest_us.min(p99_us);
            if with_page {
                answered += reports.control.ticks_answered;
                unanswered += reports.control.ticks_unanswered;
            }
            let sent = [reports.serve.states_sent, reports.serve.contacts_sent];
            println!(
                "{}",
                json!({
                    "pair": pair, "page": with_page, "step_p99_us": p99_us, "frames": frames,
                    "states_and_contacts_sent": sent,
                })
            );
            if with_page && frames == 0 {
                return Err(Error::check("the page took no frame"));
            }
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
