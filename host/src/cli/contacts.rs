//! `chaincell contacts`: looks at the contacts that a running `serve` sends.

use serde::Serialize;

use super::watch::{Until, WatchArgs, watch};
use crate::error::{Error, Result};
use crate::session::ipc::contacts::{Contact, ContactReader, ContactsHeader};
use crate::session::timing::clock::{now_ns, span_ns};
use crate::terminal;
use crate::words::counted;

/// Look at the contacts that a running `serve` sends: a line a second, until it ends or Ctrl-C.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell contacts --scene left --seconds 10\n\n\
    They are there while tools touch a body (--contact probe:RADIUS or --tool). Any\n\
    program may read them: service chaincell/left/contacts, see chaincell_host::session::ipc::contacts.")]
pub struct Args {
    #[command(flatten)]
    watch: WatchArgs,
    /// End after S seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
}

/// The printed sums over the contacts of a tick.
#[derive(Debug, PartialEq, Serialize)]
struct Printed {
    tick: u64,
    ticks_answered: u64,
    contacts: u32,
    /// Sum of all forces.
    force_n: [f32; 3],
    /// Sum of the sizes of the normal forces.
    normal_n: f32,
    tangential_n: f32,
    largest_pressure_pa: f32,
    flags: u32,
}

impl Printed {
    fn of(header: &ContactsHeader, contacts: &[Contact]) -> Self {
        let size = |[x, y, z]: [f32; 3]| x.hypot(y).hypot(z);
        let axis = |axis: usize| {
            let along = contacts.iter().map(|of| of.normal_n[axis] + of.tangential_n[axis]);
            along.fold(0.0, |sum, force_n| sum + force_n)
        };
        let pressure = |of: &Contact| {
            if of.area_m2 > 0.0 { size(of.normal_n) / of.area_m2 } else { 0.0 }
        };
        let sum =
            |sizes: &dyn Fn(&Contact) -> f32| contacts.iter().map(sizes).fold(0.0, |a, b| a + b);
        Self {
            tick: header.tick,
            ticks_answered: header.ticks_answered,
            contacts: header.contacts,
            force_n: [axis(0), axis(1), axis(2)],
            normal_n: sum(&|of| size(of.normal_n)),
            tangential_n: sum(&|of| size(of.tangential_n)),
            largest_pressure_pa: contacts.iter().map(pressure).fold(0.0, f32::max),
            flags: header.flags,
        }
    }
}

pub fn execute(args: &Args) -> Result<()> {
    let end_ns = match args.seconds {
        Some(seconds) if seconds.is_nan() || seconds <= 0.0 => {
            return Err(Error::input("--seconds: must be above 0"));
        }
        Some(seconds) => now_ns().saturating_add(span_ns("`seconds`", seconds)?),
        None => u64::MAX,
    };
    let scene = args.watch.open()?;
    let reader = ContactReader::open(&scene)?;
    if !args.watch.server.wait(&scene, &reader)? {
        return Err(Error::input(format!(
            "no contacts on {}; start chaincell serve with the same --scene, --contact probe:RADIUS \
             or --tool, and a --state-hz above 0",
            scene.label()
        )));
    }
    let until = Until { end_ns, once: args.watch.once };
    let has_come = watch(&reader, until, |(header, contacts), is_told| {
        if is_told { tell(args, &Printed::of(&header, &contacts)) } else { Ok(()) }
    })?;
    if has_come {
        return Ok(());
    }
    Err(Error::check(format!("no contacts came on {}", scene.label())))
}

fn tell(args: &Args, printed: &Printed) -> Result<()> {
    if args.watch.print.json {
        return terminal::say_json(printed);
    }
    terminal::say(format_args!(
        "tick {}, {} answered, {}, normal {:.4} N, tangential {:.4} N, largest pressure {:.0} Pa, \
         flags {}",
        printed.tick,
        printed.ticks_answered,
        counted(printed.contacts, "contact"),
        printed.normal_n,
        printed.tangential_n,
        printed.largest_pressure_pa,
        printed.flags
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_of_sizes_and_the_force_is_a_sum_of_vectors() {
        let one = Contact { normal_n: [3.0, 4.0, 0.0], area_m2: 0.5, ..Contact::default() };
        let other = Contact {
            normal_n: [-3.0, 0.0, 0.0],
            tangential_n: [0.0, 0.0, 2.0],
            area_m2: 0.1,
            ..Contact::default()
        };
        let header = ContactsHeader { tick: 7, ticks_answered: 8, contacts: 2, flags: 1 };
        let found = Printed::of(&header, &[one, other]);
        assert_eq!(
            (found.force_n, found.normal_n, found.tangential_n),
            ([0.0, 4.0, 2.0], 8.0, 2.0)
        );
        assert_eq!((found.largest_pressure_pa, found.contacts), (30.0, 2));
        let none = Printed::of(&ContactsHeader { contacts: 0, ..header }, &[]);
        assert_eq!((none.normal_n, none.largest_pressure_pa), (0.0, 0.0));
    }
}
