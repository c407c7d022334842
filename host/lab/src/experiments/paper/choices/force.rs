//! Four readings of "the force", on the same states.

use chaincell_kernel::Unloading;
use serde::Serialize;

use super::{PRESS_TIME, press};
use crate::experiments::paper::body::{Body, Source, Tool};
use crate::reference::vectors::dot;
use chaincell_host::error::Result;

/// Half the step of the differences, of the depth.
const DELTA: f64 = 0.01;
/// Steps of a settled press.
const STEPS: u32 = 25;

/// The readings on one state \[N\].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Readings {
    /// The state, in words.
    pub state: String,
    /// What the kernel publishes: sum of k d over the links of all contact cells.
    pub published_n: f64,
    /// The paper's sum of mu (`P_j` - `P_c`) over the contact cells in double precision, times 2 k.
    pub adjustments_n: f64,
    /// The same over the middle contact cell alone.
    pub one_cell_n: f64,
    /// What the fixed cells feel.
    pub fixed_n: f64,
    /// Change of the links' energy over that of the depth.
    pub energy_slope_n: f64,
}

/// The readings on the plane and on an organ, settled and under way.
///
/// # Errors
/// As [`Tool::press`].
pub fn readings(plane: &Body, depth_m: f64, step: f64) -> Result<Vec<Readings>> {
    let organ = Source::organ(true)?;
    let body = organ.with_alpha(0.0)?;
    let shallow_m = 0.5 * f64::from(body.model()?.unit_m());
    Ok(vec![
        settled(plane, "plane, one contact cell, settled", depth_m)?,
        under_way(plane, "plane, at the end of a press in network time 30", depth_m, step)?,
        settled(
            &body,
            &format!("{}, {} contact cells, settled", organ.words, body.contacts.len()),
            shallow_m,
        )?,
    ])
}

fn settled(body: &Body, state: &str, depth_m: f64) -> Result<Readings> {
    let mut tool = body.quasi_static(Unloading::Off)?;
    for at in 1..STEPS {
        tool.settle(depth_m * (1.0 - DELTA) * f64::from(at) / f64::from(STEPS))?;
    }
    let below = tool.settle(depth_m * (1.0 - DELTA))?.energy_j;
    let published_n = tool.settle(depth_m)?.force_n;
    let at = tool.positions();
    let above = tool.settle(depth_m * (1.0 + DELTA))?.energy_j;
    let slope = (above - below) / (2.0 * DELTA * depth_m);
    of_state(body, &tool, &at, state, (published_n, slope))
}

fn under_way(body: &Body, state: &str, depth_m: f64, step: f64) -> Result<Readings> {
    let (mut tool, published_n) = press(body, depth_m, step)?;
    let energy_unit_j = f64::from(body.model()?.energy_unit_j());
    let at = tool.positions();
    let before = tool.links().energy(&at);
    // The next tick of the same press.
    let further_m = depth_m * step / PRESS_TIME;
    tool.press(depth_m + further_m)?;
    let next = tool.positions();
    let slope = (tool.links().energy(&next) - before) * energy_unit_j / further_m;
    of_state(body, &tool, &at, state, (published_n, slope))
}

fn of_state(
    body: &Body,
    tool: &Tool<'_>,
    at: &[[f64; 3]],
    state: &str,
    (published_n, energy_slope_n): (f64, f64),
) -> Result<Readings> {
    let model = body.model()?;
    let along = |cells: &[usize]| {
        let force = tool.links().force(at, cells);
        dot(force, body.direction) * f64::from(model.force_unit_n())
    };
    let fixed: Vec<usize> = model.fixed().iter().map(|&cell| usize::from(cell)).collect();
    let inner = |&&cell: &&u16| {
        let links = model.neighbours(usize::from(cell));
        links.filter(|&(_, other)| body.contacts.iter().any(|&c| usize::from(c) == other)).count()
    };
    let middle = body.contacts.iter().max_by_key(inner).map_or(0, |&cell| usize::from(cell));
    Ok(Readings {
        state: state.to_owned(),
        published_n,
        adjustments_n: body.push_of(tool.links(), at)?,
        one_cell_n: -along(&[middle]),
        fixed_n: along(&fixed),
        energy_slope_n,
    })
}
