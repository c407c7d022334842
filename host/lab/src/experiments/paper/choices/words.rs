//! What the choices change, in sentences and tables.

use super::{DEPTH_M, PRESS_TIME, Range, Results, SATURATIONS};
use crate::experiments::report::tables::{Table, percent};

fn signed(fraction: f64) -> String {
    format!("{}{} %", if fraction > 0.0 { "+" } else { "" }, percent(fraction))
}

/// Relative change of a figure.
fn change(from: f64, to: f64) -> f64 {
    to / from - 1.0
}

/// How many states a set of runs ends in.
pub fn hashes(ranges: &[Range]) -> usize {
    let mut all: Vec<&str> = ranges.iter().map(|range| range.state_hash.as_str()).collect();
    all.sort_unstable();
    all.dedup();
    all.len()
}

/// Largest difference of the forces of a set, of the largest.
fn spread(ranges: &[Range]) -> f64 {
    let forces = || ranges.iter().map(|range| range.force_n);
    let (low, high) = (forces().fold(f64::INFINITY, f64::min), forces().fold(0.0, f64::max));
    1.0 - low / high
}

/// The paragraphs.
pub fn text(found: &Results) -> Vec<String> {
    vec![range(found), force(found), current(found)]
}

fn range(found: &Results) -> String {
    let leaks: Vec<Range> =
        found.beyond.iter().filter(|range| range.k_of_largest == SATURATIONS[0]).cloned().collect();
    let same = match hashes(&found.within) {
        1 => "the state hash is the same for all of them, so is every bit".to_owned(),
        count => format!("there are {count} different state hashes"),
    };
    format!(
        "The plane with 8 neighbours, alpha 0, its centre pressed by {} mm in network time \
         {PRESS_TIME}. K from 2 to 8 times the largest coordinate and R_x from 0.5 to 4: in the \
         linear range {same}. Pressed to {} mm, beyond the smallest K, the output of the held cell \
         stays at K and the force differs by up to {} %. R_x {} there: its leak pulls on free cells \
         beyond K, and the press takes {} there.",
        1e3 * DEPTH_M,
        found.beyond.first().map_or(0.0, |range| 1e3 * range.depth_m),
        percent(spread(&found.beyond)),
        if hashes(&leaks) == 1 { "changes no bit" } else { "changes the state" },
        if hashes(&leaks) == 1 { "none" } else { "some" },
    )
}

fn force(found: &Results) -> String {
    let differ = |of: fn(&super::Readings) -> f64| -> String {
        let each = found.readings.iter().map(|row| signed(change(row.published_n, of(row))));
        each.collect::<Vec<_>>().join(", ")
    };
    let states: Vec<&str> = found.readings.iter().map(|row| row.state.as_str()).collect();
    format!(
        "The paper does not say how the force is computed. The one published here is the sum of k d \
         over the links of the contact cells. Against it, in the states ({}): the paper's own \
         adjustments, sum of mu (P_j - P_c), times 2 k (with k = 0.5 N/m the same number), {}; the \
         middle contact cell alone {}; the reaction at the fixed cells {}; the derivative of the \
         energy along the press {}. Settled, all but the single cell agree, as they must at a \
         minimum of the energy; under way the border has not heard of the press yet, and part of the tool's work is lost on the \
         way, so only the sum over the contact cells is what the tool feels.",
        states.join("; "),
        differ(|row| row.adjustments_n),
        differ(|row| row.one_cell_n),
        differ(|row| row.fixed_n),
        differ(|row| row.energy_slope_n),
    )
}

fn current(found: &Results) -> String {
    let of = |k: f64, alpha: f64| {
        let rows =
            found.yields.iter().filter(move |at| at.stiffness_n_per_m == k && at.alpha == alpha);
        let each: Vec<String> = rows
            .map(|at| format!("{:.0} -> {:.1} mm", 1e3 * at.input_m, 1e3 * at.displacement_m))
            .collect();
        each.join(", ")
    };
    let apart = found.yields.iter().map(|at| change(at.curve_displacement_m, at.displacement_m));
    let apart = apart.fold(0.0, |largest: f64, change| largest.max(change.abs()));
    format!(
        "The paper sets the current source I to the input displacement. Taken by the letter of Eq. \
         2 that is a rate, a length a unit of network time, and acts as a load of 2 k I on the \
         contact cell. Where the cell settles then is another thing than the input: {} at alpha 0, \
         {} at alpha 0.05 (`--drive current`; within {} % of what the settled curve of force over \
         displacement says). The displacement is the same for every stiffness that all links share, the force proportional to it, for the \
         input enters in lengths. Here the input is a prescribed position: the cell is where the \
         tool is.",
        of(20.0, 0.0),
        of(20.0, 0.05),
        percent(apart)
    )
}

/// The tables with their captions.
pub fn tables(found: &Results) -> Vec<(String, Table)> {
    vec![
        ("K and R_x: within the linear range, and pressed beyond K".into(), ranges(found)),
        ("Readings of the force [N]".into(), readings(found)),
        ("The input displacement as current source".into(), yields(found)),
    ]
}

fn ranges(found: &Results) -> Table {
    Table::of(found.within.iter().chain(&found.beyond))
        .column("depth [mm]", |range| format!("{:.0}", 1e3 * range.depth_m))
        .column("K [of the largest coordinate]", |range| range.k_of_largest)
        .column("R_x", |range| range.r_x)
        .column("force [N]", |range| format!("{:.5}", range.force_n))
        .column("state hash", |range| &range.state_hash)
        .table()
}

fn readings(found: &Results) -> Table {
    Table::of(&found.readings)
        .column("state", |row| &row.state)
        .column("published: sum of k d", |row| format!("{:.5}", row.published_n))
        .column("sum of mu (P_j - P_c), times 2 k", |row| format!("{:.5}", row.adjustments_n))
        .column("middle contact cell alone", |row| format!("{:.5}", row.one_cell_n))
        .column("reaction at the fixed cells", |row| format!("{:.5}", row.fixed_n))
        .column("dE/dd by differences", |row| format!("{:.5}", row.energy_slope_n))
        .table()
}

fn yields(found: &Results) -> Table {
    Table::of(&found.yields)
        .column("k [N/m]", |at| at.stiffness_n_per_m)
        .column("alpha", |at| at.alpha)
        .column("input [mm]", |at| format!("{:.0}", 1e3 * at.input_m))
        .column("as current: cell at [mm]", |at| format!("{:.1}", 1e3 * at.displacement_m))
        .column("force [N]", |at| format!("{:.4}", at.force_n))
        .column("as position: force [N]", |at| format!("{:.2e}", at.prescribed_force_n))
        .table()
}
