//! `chaincell state`: looks at the states that a running `serve` sends.

use std::path::PathBuf;

use serde::Serialize;

use crate::engine::Nodes;
use crate::error::{Error, Result};
use crate::files::output::cells_csv;
use crate::files::whole::write_whole;
use crate::interrupt;
use crate::session::ipc::payload::{NodePosition, StateHeader};
use crate::session::ipc::services::{Domain, SceneServices};
use crate::session::ipc::state::StateReader;
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS, now_ns, sleep_until_ns};
use crate::terminal;
use crate::words::counted;

/// Span between looks for a state \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;
/// Span between lines \[ns\].
const LINE_NS: u64 = SECOND_NS;
/// Longest wait for the first state of a server \[ns\].
const FIRST_NS: u64 = 5 * SECOND_NS;

/// Look at the states that a running `serve` sends: a line a second, until it ends or Ctrl-C.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell state --scene left --once --csv now.csv\n\n\
    Any program may read them: service chaincell/left/state, see chaincell_host::session::ipc::payload.")]
pub struct Args {
    /// Name of the scene that `serve` was started with
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// End after the first state
    #[arg(long)]
    once: bool,
    /// At the end, write the last state here: node,x_m,y_m,z_m by ascending node
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print JSON objects, one a line
    #[arg(long)]
    json: bool,
}

type State = (StateHeader, Vec<NodePosition>);

/// What is printed of a state.
#[derive(Debug, Serialize)]
struct Printed {
    tick: u64,
    ticks_answered: u64,
    state_hash: String,
    nodes: u32,
    flags: u32,
}

pub fn execute(args: &Args) -> Result<()> {
    let scene = SceneServices::open(args.scene.as_deref(), &Domain::default())?;
    let reader = StateReader::open(&scene)?;
    if !reader.is_served() {
        return Err(Error::input(format!(
            "no states on {}; start chaincell serve with the same --scene and a --state-hz above 0",
            scene.label()
        )));
    }
    let mut last: Option<State> = None;
    let ended = watch(args, &reader, &mut last);
    let Some((_, nodes)) = last else {
        ended?;
        return Err(Error::check(format!("no state came on {}", scene.label())));
    };
    if let Some(path) = &args.csv {
        let (ids, positions_m) =
            nodes.iter().map(|node| (node.node, node.position_m.map(f64::from))).unzip();
        write_whole(path, cells_csv(&Nodes { ids, positions_m }).as_bytes())?;
    }
    ended
}

/// Prints states until the end, and keeps the last.
fn watch(args: &Args, reader: &StateReader, last: &mut Option<State>) -> Result<()> {
    let give_up_ns = now_ns() + FIRST_NS;
    let mut line_ns = 0;
    loop {
        interrupt::check()?;
        // Looked at first: what a server sends right before its end is still taken.
        let served = reader.is_served();
        match reader.take()? {
            Some(state) => {
                if now_ns() >= line_ns {
                    tell(args, &state.0)?;
                    line_ns = now_ns() + LINE_NS;
                }
                *last = Some(state);
                if args.once {
                    return Ok(());
                }
            }
            None if !served => return Ok(()),
            None if last.is_none() && now_ns() >= give_up_ns => {
                return Err(Error::check(
                    "no state for 5 s: the server is busy, or was killed; restart chaincell serve",
                ));
            }
            None => sleep_until_ns(now_ns() + LOOK_NS),
        }
    }
}

fn tell(args: &Args, header: &StateHeader) -> Result<()> {
    let report = Printed {
        tick: header.tick,
        ticks_answered: header.ticks_answered,
        state_hash: format!("{:016x}", header.state_hash),
        nodes: header.nodes,
        flags: header.flags,
    };
    if args.json {
        return terminal::say_json(&report);
    }
    terminal::say(format_args!(
        "tick {}, {} answered, {}, flags {}, state hash {}",
        report.tick,
        report.ticks_answered,
        counted(report.nodes, "node"),
        report.flags,
        report.state_hash
    ))
}
