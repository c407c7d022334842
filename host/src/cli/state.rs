//! `chaincell state`: looks at the states that a running `serve` sends.

use std::path::PathBuf;

use serde::Serialize;

use super::watch::{Until, WatchArgs, watch};
use crate::engine::Nodes;
use crate::error::{Error, Result};
use crate::files::output::cells_csv;
use crate::files::whole::write_whole;
use crate::session::ipc::payload::{NodePosition, StateHeader};
use crate::session::ipc::services::SceneServices;
use crate::session::ipc::state::StateReader;
use crate::session::ipc::stress::{NodeStress, StressHeader, StressReader};
use crate::terminal;
use crate::words::counted;

/// Look at the states that a running `serve` sends: a line a second, until it ends or Ctrl-C.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell state --scene left --once --csv now.csv\n\n\
    Any program may read them: services chaincell/left/state and chaincell/left/stress,\n\
    see chaincell_client::state and chaincell_client::stress.")]
pub struct Args {
    #[command(flatten)]
    watch: WatchArgs,
    /// Look at strain and stress in place of positions; the server computes them while somebody reads
    #[arg(long)]
    stress: bool,
    /// At the end, write the last state here: node,x_m,y_m,z_m by ascending node; with --stress
    /// node,stretch_1,stretch_2,stretch_3,von_mises_pa,mean_stress_pa
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

type State = (StateHeader, Vec<NodePosition>);

/// The printed part of a state.
#[derive(Debug, Serialize)]
struct Printed {
    tick: u64,
    ticks_answered: u64,
    state_hash: String,
    nodes: u32,
    flags: u32,
    /// As `info` prints it.
    model_checksum: String,
}

pub fn execute(args: &Args) -> Result<()> {
    let scene = args.watch.open()?;
    if args.stress {
        return stresses(args, &scene);
    }
    let reader = StateReader::open(&scene)?;
    if !args.watch.server.wait(&scene, &reader)? {
        return Err(Error::input(format!(
            "no states on {}; start chaincell serve with the same --scene and a --state-hz above 0",
            scene.label()
        )));
    }
    let mut last: Option<State> = None;
    let until = Until { end_ns: u64::MAX, once: args.watch.once };
    let ended = watch(&reader, until, |state, is_told| {
        if is_told {
            tell(args, &state.0)?;
        }
        last = Some(state);
        Ok(())
    });
    let Some((_, nodes)) = last else {
        ended?;
        return Err(Error::check(format!("no state came on {}", scene.label())));
    };
    if let Some(path) = &args.csv {
        let (ids, positions_m) =
            nodes.iter().map(|node| (node.node, node.position_m.map(f64::from))).unzip();
        write_whole(path, cells_csv(&Nodes { ids, positions_m }).as_bytes())?;
    }
    ended.map(|_| ())
}

/// The printed part of a pass over the stresses.
#[derive(Debug, Serialize)]
struct PrintedStress {
    tick: u64,
    first_tick: u64,
    nodes: u32,
    /// As `info` prints it.
    model_checksum: String,
    /// The node with the largest stress after von Mises, and that.
    node: u32,
    largest_von_mises_pa: f32,
}

/// Looks at strain and stress.
fn stresses(args: &Args, scene: &SceneServices) -> Result<()> {
    let reader = StressReader::open(scene)?;
    if !args.watch.server.wait(scene, &reader)? {
        return Err(Error::input(format!(
            "no stresses on {}; start chaincell serve with the same --scene, a --state-hz above 0, and a body of \
             chaincell bake with --young-pa or --tissue",
            scene.label()
        )));
    }
    let mut last = None;
    let until = Until { end_ns: u64::MAX, once: args.watch.once };
    let ended = watch(&reader, until, |(header, nodes), is_told| {
        if is_told {
            tell_stresses(args, &header, &nodes)?;
        }
        last = Some(nodes);
        Ok(())
    });
    let Some(nodes) = last else {
        ended?;
        return Err(Error::check(format!("no stresses came on {}", scene.label())));
    };
    if let Some(path) = &args.csv {
        write_whole(path, stress_csv(&nodes).as_bytes())?;
    }
    ended.map(|_| ())
}

fn tell_stresses(args: &Args, header: &StressHeader, nodes: &[NodeStress]) -> Result<()> {
    let most = nodes.iter().max_by(|a, b| a.von_mises_pa.total_cmp(&b.von_mises_pa));
    let most = most.copied().unwrap_or_default();
    let report = PrintedStress {
        tick: header.tick,
        first_tick: header.first_tick,
        nodes: header.nodes,
        model_checksum: format!("{:08x}", header.model_checksum),
        node: most.node,
        largest_von_mises_pa: most.von_mises_pa,
    };
    if args.watch.print.json {
        return terminal::say_json(&report);
    }
    terminal::say(format_args!(
        "ticks {} to {}, {}, stress after von Mises up to {:.0} Pa at node {}",
        report.first_tick,
        report.tick,
        counted(report.nodes, "node"),
        report.largest_von_mises_pa,
        report.node
    ))
}

fn stress_csv(nodes: &[NodeStress]) -> String {
    let mut text = "node,stretch_1,stretch_2,stretch_3,von_mises_pa,mean_stress_pa\n".to_owned();
    for NodeStress { node, stretches: [a, b, c], von_mises_pa, mean_pa } in nodes {
        text += &format!("{node},{a},{b},{c},{von_mises_pa},{mean_pa}\n");
    }
    text
}

fn tell(args: &Args, header: &StateHeader) -> Result<()> {
    let report = Printed {
        tick: header.tick,
        ticks_answered: header.ticks_answered,
        state_hash: format!("{:016x}", header.state_hash),
        nodes: header.nodes,
        flags: header.flags,
        model_checksum: format!("{:08x}", header.model_checksum),
    };
    if args.watch.print.json {
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
