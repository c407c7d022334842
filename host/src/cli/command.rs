//! `chaincell command`: sends a command to a running `serve`.

use chaincell_kernel::trace::Command;
use chaincell_kernel::{Choice, Cutting, Unloading};
use serde::Serialize;

use super::pins::{Place, place, stiffness};
use crate::choice;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::ipc;
use crate::session::ipc::command::{CommandClient, SWEEPS_MAX, refusal_text};
use crate::session::ipc::payload::CommandMessage;
use crate::session::ipc::services::Domain;
use crate::session::timing::clock::SECOND_NS;
use crate::terminal;
use crate::words::counted;

/// Longest wait for the reply \[ns\].
const REPLY_NS: u64 = 5 * SECOND_NS;

/// Reset, pause, set or save a running `serve`, or let its tool grip or pin, between two of its ticks.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell command --scene left reset\n  \
    chaincell command --scene left set sweeps=6\n  chaincell command set max_force_n=off\n  \
    chaincell command --scene left grip\n  chaincell command --scene left let-go --ticks 50\n  \
    chaincell command --scene left pin --tool 0\n  chaincell command --scene left pin --at 0,0,0.04,0.006\n  \
    chaincell command --scene left unpin 0 --ticks 50\n  \
    chaincell command --scene left snapshot\n\n\
    Exit code 0 when it was done, 1 when no reply came, 2 when it was refused or nobody\n    serves the scene.")]
pub struct Args {
    /// Name of the scene that `serve` was started with
    #[arg(long, value_name = "NAME", global = true)]
    scene: Option<String>,
    /// Print the reply as one JSON object
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Back to rest, the tool released
    Reset,
    /// Answer poses with force 0 and let no cell move
    Pause,
    /// Go on after a pause
    Resume,
    /// Set sweeps, max_force_n (a number or off), max_tool_step_m, unloading (off, release, retreat)
    /// or cut (on, off) as NAME=VALUE
    Set {
        /// The parameter and its value
        #[arg(value_name = "NAME=VALUE")]
        assignment: String,
    },
    /// Hold the tissue that the tool touches now, without slip, until let-go or until the tool is not
    /// engaged; needs a tool (--contact probe:RADIUS or --tool)
    Grip {
        #[command(flatten)]
        of: ToolArgs,
    },
    /// Save the session as it is now beside its trace, as TRACE.TICK.snapshot; for `serve --restore` and
    /// `replay --from TICK`
    Snapshot,
    /// Let go of what the tool grips
    LetGo {
        #[command(flatten)]
        of: ToolArgs,
        /// Ticks in which the pull falls to 0
        #[arg(long, default_value_t = LET_GO_TICKS, value_name = "T", allow_negative_numbers = true,
            value_parser = clap::value_parser!(u16).range(1..))]
        ticks: u16,
    },
    /// Pin what the tool grips, or what it touches, or with --at the surface around a place, where it is now: it is
    /// held in the world, and the tool may let go. A new pin takes the lowest free number, from 0
    Pin {
        #[command(flatten)]
        of: ToolArgs,
        /// Pin the surface within RADIUS of a point where it is now, rigidly or with a stiffness [N/m] in all, as
        /// --pin of `serve` does at the beginning; metres
        #[arg(long, value_name = "X,Y,Z,RADIUS[,N_PER_M]", allow_hyphen_values = true, value_parser = place,
            conflicts_with_all = ["tool", "stiffness"])]
        at: Option<Place>,
        /// Stiffness of the pin [N/m] [default: rigid]
        #[arg(long, value_name = "N_PER_M", allow_negative_numbers = true, value_parser = stiffness)]
        stiffness: Option<f32>,
    },
    /// Release a pin
    Unpin {
        /// Number of the pin
        #[arg(value_name = "PIN")]
        pin: u16,
        /// Ticks in which its force falls to 0
        #[arg(long, default_value_t = LET_GO_TICKS, value_name = "T", allow_negative_numbers = true,
            value_parser = clap::value_parser!(u16).range(1..))]
        ticks: u16,
    },
}

#[derive(Debug, clap::Args)]
struct ToolArgs {
    /// Which tool, from 0
    #[arg(long, default_value_t = 0, value_name = "N", allow_negative_numbers = true)]
    tool: u32,
}

/// Ticks in which a pull falls to 0 unless asked otherwise.
const LET_GO_TICKS: u16 = 20;

/// The printed report.
#[derive(Debug, Serialize)]
struct Printed {
    tick: u64,
    ticks_answered: u64,
    state_hash: String,
    /// The number of a pin that was set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pin: Option<u32>,
}

pub fn execute(args: &Args) -> Result<()> {
    let command = match &args.action {
        Action::Reset => Command::Reset,
        Action::Pause => Command::Pause,
        Action::Resume => Command::Resume,
        Action::Set { assignment } => set(assignment)?,
        Action::Grip { of } => Command::Grip { tool: of.tool },
        Action::Snapshot => Command::Snapshot { checksum: 0 },
        Action::LetGo { of, ticks } => Command::LetGo { tool: of.tool, ticks: *ticks },
        Action::Pin { at: Some(place), .. } => place.command(),
        Action::Pin { of, stiffness, at: None } => {
            let stiffness_n_per_m = stiffness.unwrap_or(f32::INFINITY);
            Command::Pin { tool: of.tool, stiffness_n_per_m }
        }
        Action::Unpin { pin, ticks } => Command::Unpin { pin: *pin, ticks: *ticks },
    };
    // Send it to the server and wait for the reply.
    let scene = ipc::open(args.scene.as_deref(), &Domain::default())?;
    let client = CommandClient::open(&scene)?;
    if !client.is_served() {
        return Err(Error::input(format!(
            "no server on {}; start chaincell serve with the same --scene",
            scene.label()
        )));
    }
    let reply = client.send(CommandMessage::new(&command), REPLY_NS, interrupt::asked)?;
    if reply.result != 0 {
        return Err(Error::input(format!(
            "refused (reason {}): {}",
            reply.reason,
            refusal_text(reply.reason)
        )));
    }
    // Print the reply.
    let report = Printed {
        tick: reply.tick,
        ticks_answered: reply.ticks_answered,
        state_hash: format!("{:016x}", reply.state_hash),
        pin: matches!(command, Command::Pin { .. } | Command::PinAt { .. }).then_some(reply.reason),
    };
    if args.json {
        return terminal::say_json(&report);
    }
    terminal::say(format_args!(
        "done after tick {}, {} answered; state hash {}",
        report.tick,
        counted(report.ticks_answered, "tick"),
        report.state_hash
    ))?;
    report.pin.map_or(Ok(()), |pin| terminal::say(format_args!("pin {pin}")))
}

/// The command of `NAME=VALUE`.
fn set(assignment: &str) -> Result<Command> {
    let refused = |why: &str| Error::input(format!("set {assignment}: {why}"));
    let Some((name, value)) = assignment.split_once('=') else {
        return Err(refused("name and value are wanted, as in sweeps=6"));
    };
    let length = || {
        let number = value.parse::<f32>().ok().filter(|x| *x > 0.0 && x.is_finite());
        number.ok_or_else(|| refused("the value must be a finite number above 0"))
    };
    match name {
        "sweeps" => match value.parse() {
            Ok(sweeps @ 1..=SWEEPS_MAX) => Ok(Command::Sweeps(sweeps)),
            _ => Err(refused(&format!("the value must be a whole number from 1 to {SWEEPS_MAX}"))),
        },
        "max_force_n" if value == "off" => Ok(Command::MaxForceN(f32::INFINITY)),
        "max_force_n" => length().map(Command::MaxForceN),
        "max_tool_step_m" => length().map(Command::MaxToolStepM),
        "unloading" => Unloading::from_name(value)
            .map(Command::Unloading)
            .ok_or_else(|| refused(&format!("the value must be {}", choice::names::<Unloading>()))),
        "cut" => Cutting::from_name(value)
            .map(Command::Cut)
            .ok_or_else(|| refused(&format!("the value must be {}", choice::names::<Cutting>()))),
        _ => Err(refused(
            "sweeps, max_force_n, max_tool_step_m, unloading and cut may be set while serve runs; for \
             others start it again",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments_become_commands_or_name_the_remedy() {
        assert_eq!(set("sweeps=6"), Ok(Command::Sweeps(6)));
        assert_eq!(set("max_force_n=off"), Ok(Command::MaxForceN(f32::INFINITY)));
        assert_eq!(set("max_tool_step_m=2e-3"), Ok(Command::MaxToolStepM(0.002)));
        assert_eq!(set("unloading=retreat"), Ok(Command::Unloading(Unloading::Retreat)));
        assert_eq!(set("cut=off"), Ok(Command::Cut(Cutting::Off)));
        for (bad, part) in [
            ("sweeps", "sweeps=6"),
            ("sweeps=0", "1 to 1000"),
            ("sweeps=1001", "1 to 1000"),
            ("max_force_n=nan", "above 0"),
            ("max_tool_step_m=inf", "above 0"),
            ("unloading=on", "retreat"),
            ("cut=yes", "on or off"),
            ("step=0.1", "start it again"),
            ("model=other.chaincell", "start it again"),
        ] {
            let error = set(bad).unwrap_err();
            assert!(error.exit_code() == 2 && error.to_string().contains(part), "{error}");
        }
    }
}
