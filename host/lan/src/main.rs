//! `chaincell-lan`: options, and the commands for the key, the tissue's side and the hand's.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use chaincell_client::clock::span_ns;
use chaincell_client::{Error, Kind, Result};
use chaincell_lan::agent::{Agent, LIMIT_NS, News};
use chaincell_lan::hand::{Hand, Options};
use chaincell_lan::key::{Key, random};
use chaincell_lan::play::play;
use chaincell_lan::run::{Scene, run};
use chaincell_lan::socket::Socket;
use chaincell_lan::{path, report};
use clap::{Parser, Subcommand};

/// Control a served scene from another machine of a wired LAN.
#[derive(Debug, Parser)]
#[command(
    name = "chaincell-lan",
    version,
    after_help = "Examples:\n  \
    chaincell-lan key lan.key                                     # once; then copy it to the other machine\n  \
    chaincell serve liver.chaincell --tool sphere:0.012 --delay-ticks auto --device omega --scene left &\n  \
    chaincell-lan agent --listen 0.0.0.0:7200 --key lan.key --scene left\n  \
    chaincell-lan hand 10.0.0.5:7200 --key lan.key path.csv       # on the other machine\n\n\
    The agent refuses a network whose round trip takes more than 6 ms in more than one of 1,000 cases.\n\
    Datagrams are authenticated by the key, and not encrypted.\n\
    Exit codes: 0 ended, 1 refused or lost, 2 bad usage or nobody there."
)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a key of 32 random bytes in a new file
    Key {
        /// The file
        file: PathBuf,
    },
    /// Stand beside the tissue, as the only controller of its scene
    Agent {
        /// Address and port of this machine, for UDP; port 0 takes a free one
        #[arg(long, value_name = "ADDR:PORT")]
        listen: String,
        /// File of the key
        #[arg(long, value_name = "FILE")]
        key: PathBuf,
        /// Name of the scene, as given to `chaincell serve`
        #[arg(long, value_name = "NAME")]
        scene: Option<String>,
        /// Longest wait for `chaincell serve` [s]
        #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
        wait_for_server_s: f64,
        /// Print the report as JSON
        #[arg(long)]
        json: bool,
    },
    /// Play a file of poses at 1 kHz, in place of a device
    Hand {
        /// Host and port of the agent
        #[arg(value_name = "ADDR:PORT")]
        agent: String,
        /// Poses of one tool: tick,x_m,y_m,z_m,engaged
        path: PathBuf,
        /// File of the key
        #[arg(long, value_name = "FILE")]
        key: PathBuf,
        /// Longest wait for the agent [s]
        #[arg(long, value_name = "S", default_value_t = 5.0, allow_negative_numbers = true)]
        wait_s: f64,
        /// Print the report as JSON
        #[arg(long)]
        json: bool,
    },
}

fn main() -> ExitCode {
    let asked = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&asked);
    let caught = ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed))
        .map_err(|why| Error::new(Kind::Argument, format!("cannot catch Ctrl-C: {why}")));
    let stop = || asked.load(Ordering::Relaxed);
    let ended = caught.and_then(|()| match Args::parse().command {
        Command::Key { file } => make_key(&file),
        Command::Agent { listen, key, scene, wait_for_server_s, json } => {
            span_ns("--wait-for-server-s", wait_for_server_s)
                .and_then(|wait_ns| agent(&listen, &key, scene.as_deref(), wait_ns, json, stop))
        }
        Command::Hand { agent, path, key, wait_s, json } => span_ns("--wait-s", wait_s)
            .and_then(|wait_ns| hand(agent, &path, &key, wait_ns, json, stop)),
    });
    ended.unwrap_or_else(|why| {
        eprintln!("chaincell-lan: {why}");
        ExitCode::from(if why.kind() == Kind::Refused { 1 } else { 2 })
    })
}

fn make_key(file: &Path) -> Result<ExitCode> {
    Key::create(file)?;
    println!("{}: copy it to the other machine, readable by its owner alone", file.display());
    Ok(ExitCode::SUCCESS)
}

fn agent(
    listen: &str,
    key: &Path,
    scene: Option<&str>,
    server_wait_ns: u64,
    json: bool,
    stop: impl Fn() -> bool + Copy,
) -> Result<ExitCode> {
    // Key and port first: they need no server.
    let key = Key::read(key)?;
    let socket = Socket::listen(listen)?;
    // A system that has random numbers once has them again.
    random::<16>()?;
    let mut agent = Agent::new(key, LIMIT_NS, || random().unwrap_or_default());
    let mut scene = Scene::open(scene, server_wait_ns, stop)?;
    eprintln!("chaincell-lan: listens at {}", socket.address()?);
    let report = run(&mut agent, &socket, &mut scene, stop, say)?;
    if json {
        println!("{}", report.to_json());
    } else {
        println!("{report}");
    }
    Ok(ExitCode::SUCCESS)
}

fn say(news: News) {
    let ms = |ns: u64| ns as f64 * 1e-6;
    let text = match news {
        News::Began(address) => format!("{address} has the agent; measuring its round trip"),
        News::Opened(p999_ns) => format!("poses go on; round trip p99.9 {:.2} ms", ms(p999_ns)),
        News::Refused(p999_ns) => format!(
            "refused: round trip p99.9 {:.2} ms, above {:.0} ms; the force falls",
            ms(p999_ns),
            ms(LIMIT_NS)
        ),
        News::Silent => "the hand is silent; another one may begin".to_owned(),
        News::Fallen => "no poses: the tissue's force has fallen to 0".to_owned(),
    };
    eprintln!("chaincell-lan: {text}");
}

fn hand(
    agent: String,
    path: &Path,
    key: &Path,
    wait_ns: u64,
    json: bool,
    stop: impl Fn() -> bool + Copy,
) -> Result<ExitCode> {
    let poses = path::read(path)?;
    let options = Options { wait_ns, ..Options::new(agent, Key::read(key)?) };
    let mut hand = Hand::open(options, stop)?;
    let report: report::PlayReport = play(&mut hand, &poses, stop, |_, _| ())?;
    if json {
        println!("{}", report.to_json());
    } else {
        println!("{report}");
    }
    if report.is_failed {
        eprintln!("chaincell-lan: {}", report.ended);
    }
    Ok(ExitCode::from(u8::from(report.is_failed)))
}
