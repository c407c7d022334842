//! `chaincell mirror`: sends a session's trace to followers while it grows.

use std::io::{self, BufWriter, IsTerminal};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use crate::error::{Error, Result};
use crate::interrupt;
use crate::remote::frame::{Ask, Frame};
use crate::remote::mirror::{Mirror, Stopped};
use crate::remote::place::Place;
use crate::terminal;

/// Most followers of one mirror that listens.
const FOLLOWERS_MAX: usize = 64;
/// Longest wait for what a follower asks, and for one that does not read.
const TALK: Duration = Duration::from_secs(5);
/// Time between looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(20);

/// Send a session to `chaincell follow` while it is recorded: by standard output, or to all that connect.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  chaincell follow --scene far -- ssh theatre chaincell mirror session\n  \
    chaincell mirror session | chaincell follow -\n  \
    chaincell mirror session --listen 127.0.0.1:7100\n\n\
    Reads the trace that `serve --out session` or `--record` writes; the session does not wait for it.\n\
    A server takes a snapshot for a follower that joins more than 2,000 records behind the newest one.\n\
    Ends when the recording has ended and all of it is sent."
)]
pub struct Args {
    /// Trace of `serve`, `cosim` or `run`, which may still be written, the folder of such a run, or the scene of a
    /// server that records
    #[arg(value_name = "SESSION")]
    session: PathBuf,
    /// Model file of the session, for followers that have none [default: model.chaincell beside the trace]
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Listen here for any number of followers, up to 64 at a time, until Ctrl-C
    #[arg(long, value_name = "ADDRESS:PORT", conflicts_with_all = ["goes_on", "has_model", "packed"])]
    listen: Option<SocketAddr>,
    /// Let it be another address than this machine's own: anyone who reaches it may read the session,
    /// nothing is encrypted
    #[arg(long, requires = "listen")]
    open_to_network: bool,
    /// The place where a follower goes on after a cut; `follow` adds it to the words of its program
    #[arg(long, value_name = "SEAL:RECORD", value_parser = Ask::goes_on_of)]
    goes_on: Option<(u32, u32)>,
    /// Checksum of the model that a follower has; `follow` adds it to the words of its program
    #[arg(long, value_name = "CHECKSUM", value_parser = Ask::model_of)]
    has_model: Option<u32>,
    /// Send records packed; `follow` adds it to the words of its program
    #[arg(long)]
    packed: bool,
}

pub fn execute(args: &Args) -> Result<()> {
    let place = Place::find(&args.session, args.model.clone())?;
    let mirror = Mirror::open(&place)?;
    if args.model.is_some() {
        mirror.check_model()?;
    }
    if let Some(address) = args.listen {
        return listen(address, args.open_to_network, &place);
    }
    let out = io::stdout();
    if out.is_terminal() {
        return Err(Error::input(
            "standard output is a terminal, and a mirror sends bytes: pipe it into chaincell follow -, or pass \
             --listen",
        ));
    }
    let ask = Ask { goes_on: args.goes_on, model: args.has_model, packed: args.packed };
    match mirror.send(&mut BufWriter::new(out.lock()), &ask)? {
        Stopped::Ended | Stopped::Gone => Ok(()),
        Stopped::Asked => Err(Error::Interrupted),
    }
}

/// Sends the session to each follower that connects, until Ctrl-C.
fn listen(address: SocketAddr, is_open: bool, place: &Place) -> Result<()> {
    if !address.ip().is_loopback() && !is_open {
        return Err(Error::input(format!(
            "--listen {address}: anyone who reaches this address could read the session; take {}, and ssh to get \
             there, or pass --open-to-network",
            SocketAddr::new(IpAddr::from([127, 0, 0, 1]), address.port())
        )));
    }
    let failed = |why: io::Error| Error::input(format!("--listen {address}: {why}"));
    let listener = TcpListener::bind(address).map_err(failed)?;
    listener.set_nonblocking(true).map_err(failed)?;
    let bound = listener.local_addr().map_err(failed)?;
    terminal::say(format_args!("listening on {bound}; follow with chaincell follow tcp:{bound}"))?;
    terminal::say("ready")?;
    let followers = Arc::new(AtomicUsize::new(0));
    while !interrupt::asked() {
        match listener.accept() {
            Ok((stream, _)) if followers.load(Ordering::Relaxed) < FOLLOWERS_MAX => {
                followers.fetch_add(1, Ordering::Relaxed);
                let (place, count) = (place.clone(), Arc::clone(&followers));
                thread::spawn(move || {
                    if let Err(why) = answer(stream, &place) {
                        log::warn!("a follower that connected got nothing: {why}");
                    }
                    count.fetch_sub(1, Ordering::Relaxed);
                });
            }
            // One too many hears nothing, and tries again.
            Ok(_) => {}
            Err(why) if why.kind() == io::ErrorKind::WouldBlock => thread::sleep(LOOK),
            Err(why) => {
                log::warn!("cannot take a follower: {why}");
                thread::sleep(LOOK);
            }
        }
    }
    Err(Error::Interrupted)
}

/// Answers one follower.
fn answer(stream: TcpStream, place: &Place) -> Result<()> {
    let failed = |why: io::Error| Error::check(why);
    stream.set_nonblocking(false).map_err(failed)?;
    stream.set_read_timeout(Some(TALK)).map_err(failed)?;
    stream.set_write_timeout(Some(TALK)).map_err(failed)?;
    stream.set_nodelay(true).map_err(failed)?;
    let ask = match Frame::read(&mut &stream).map_err(failed)? {
        Frame::Ask(ask) => ask,
        _ => return Err(Error::check("it is no follower")),
    };
    Mirror::open(place)?.send(&mut BufWriter::new(&stream), &ask).map(|_| ())
}
