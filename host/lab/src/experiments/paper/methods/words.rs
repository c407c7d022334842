//! The comparison as tables, picture and text.

use std::fmt::Write as _;

use super::Comparison;
use super::body::{HOLD_TICKS, PRESS_TICKS};
use super::measure::{Row, TURN_DEGREES, of_plane};
use super::method::{Kind, SWEEPS};
use crate::charts::plot::{Axis, Chart, Style};
use crate::experiments::report::tables::{Table, percent};
use crate::reference::profile::middle_row;
use chaincell_host::error::{Error, Result};

/// Largest rise of the energy that counts as rounding of single precision, over the energy.
const ENERGY_ROUNDING: f64 = 1e-6;

/// The table of a body, with its caption.
pub fn table(of: &Comparison) -> (String, Table) {
    let yes = |is: bool| if is { "yes" } else { "no" };
    let table = Table::of(&of.rows)
        .column("method", |row| row.method.name())
        .column("non-linearity of the profile", |row| row.nonlinearity.map_or("-".into(), short))
        .column("contact force [N]", |row| {
            row.force_n.map_or("none".to_owned(), |force| format!("{force:.4}"))
        })
        .column("off the energy minimum [% of depth]", |row| percent(row.off_minimum))
        .column("elements looked at in a tick", |row| row.visited_per_tick)
        .column("each at most once", |row| yes(row.at_most_once))
        .column("time a tick / track", |row| {
            row.time_ratio.map_or("not measured".to_owned(), |ratio| format!("{ratio:.2}"))
        })
        .column("largest rise of energy in a tick of the hold, after a sudden move [%]", |row| {
            format!("{}, {}", percent(row.energy_rise), percent(row.energy_rise_sudden))
        })
        .column("turned with its move, off [% of depth]", |row| percent(row.turned))
        .column("same bits again", |row| yes(row.repeats))
        .column("same bits on every target", |row| row.portable)
        .table();
    let times = if of.rows.iter().any(|row| row.time_ratio.is_some()) {
        "times are medians of the ticks of the press, taken in turn"
    } else {
        "times are measured by an optimised build only"
    };
    let caption = format!(
        "{}, in {PRESS_TICKS} ticks, then held for {HOLD_TICKS}; {SWEEPS} link passes a tick where \
         a method sweeps; links of {} N/m without slack, those of the chains with alpha {}; turned \
         by {TURN_DEGREES} degrees about z; the exact minimum has {:.4} N; {times}.",
        of.body.source,
        super::body::STIFFNESS_N_PER_M,
        short(of.body.alpha),
        of.body.force_n(&of.exact),
    );
    (caption, table)
}

/// Up to three decimals; what is but rounding in powers of ten.
fn short(x: f64) -> String {
    if x.abs() >= 1e-3 || x == 0.0 {
        format!("{x:.3}").trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{x:.0e}")
    }
}

/// A method's name and its `[distance from the centre, height]` \[mm\].
type Profile = (&'static str, Vec<[f64; 2]>);

/// The profiles on one side of the centre, the exact one first.
fn half_profiles(of: &Comparison) -> Result<Vec<Profile>> {
    let [nx, ny, _] = of.body.nodes;
    let states = of.rows.iter().map(|row| (row.method.name(), &row.positions_m));
    [("energy minimum", &of.exact)]
        .into_iter()
        .chain(states)
        .map(|(name, positions_m)| {
            let profile = middle_row(positions_m, [nx, ny])?;
            let half = profile.into_iter().skip(nx / 2);
            Ok((name, half.map(|p| p.map(|x| 1e3 * x)).collect()))
        })
        .collect()
}

/// The profiles of all methods on one axis.
pub fn profiles(of: &Comparison) -> Result<Chart> {
    let mut chart = Chart::new(
        "Profile of the pulled plane by method",
        Axis::linear("distance from the centre along the middle row [mm]"),
        Axis::linear("height [mm]"),
    );
    for (at, (name, profile)) in half_profiles(of)?.into_iter().enumerate() {
        let style = if at == 0 { Style::Dashed } else { Style::MarkedLine };
        chart = chart.series(name, style, &profile);
    }
    Ok(chart)
}

/// What the picture shows.
pub fn caption(of: &Comparison) -> String {
    let near = of.rows.iter().filter(|row| row.off_minimum < 0.01).map(|row| row.method.name());
    let near = near.collect::<Vec<_>>().join("; ");
    format!(
        "The middle row of the {} after {PRESS_TICKS} ticks of pull and {HOLD_TICKS} of hold, from \
         the centre to the fixed border. On the dashed line, within 1 % of the depth: {near}.",
        of.body.source
    )
}

/// The profiles as CSV, a row a point.
pub fn profile_csv(of: &Comparison) -> Result<String> {
    let mut text = String::from("method,distance_mm,height_mm\n");
    for (name, profile) in half_profiles(of)? {
        for [distance, height] in profile {
            // Names may hold commas.
            let _ = writeln!(text, "{},{distance:.6},{height:.6}", name.replace(',', ";"));
        }
    }
    Ok(text)
}

/// What the figures say.
pub fn text(plane: &Comparison, cuboid: &Comparison) -> Result<Vec<String>> {
    Ok(vec![shape(plane)?, behaviour(plane, cuboid)?, cost(plane)?])
}

fn row(of: &Comparison, kind: Kind) -> Result<&Row> {
    let row = of.rows.iter().find(|row| row.method == kind);
    row.ok_or_else(|| Error::check(format!("{} was not measured", kind.name())))
}

/// The shapes against the pyramid and against the minimum.
fn shape(plane: &Comparison) -> Result<String> {
    let bent = |kind| Result::Ok(short(row(plane, kind)?.nonlinearity.unwrap_or_default()));
    let off = |kind| Result::Ok(percent(row(plane, kind)?.off_minimum));
    let exact = of_plane(&plane.body, &plane.exact)?.unwrap_or_default();
    Ok(format!(
        "On its lattice traditional ChainMail takes the pyramid of the paper's Fig. 4b: its profile is straight \
         to rounding (non-linearity {}). The minimum of the links' energy is curved, but little \
         ({}), and a method that has come to rest shows just that: track ({}) and the mass-spring \
         system ({}) are within {} and {} % of the depth of it after {} ticks. A deeper curve is \
         one still on its way: the network under euler ({}) is {} % off by then, position-based \
         dynamics at the links' own stiffness ({}) {} %. Relaxation bends ChainMail too ({}), yet \
         to another shape, {} % off.",
        bent(Kind::Lattice)?,
        short(exact),
        bent(Kind::Track)?,
        bent(Kind::MassSpring)?,
        off(Kind::Track)?,
        off(Kind::MassSpring)?,
        PRESS_TICKS + HOLD_TICKS,
        bent(Kind::Euler)?,
        off(Kind::Euler)?,
        bent(Kind::PositionBased)?,
        off(Kind::PositionBased)?,
        bent(Kind::Graph)?,
        off(Kind::Graph)?,
    ))
}

/// Force, energy and the axes.
fn behaviour(plane: &Comparison, cuboid: &Comparison) -> Result<String> {
    let force = |kind| Result::Ok(row(plane, kind)?.force_n.unwrap_or_default());
    let turned = |of, kind| Result::Ok(percent(row(of, kind)?.turned));
    Ok(format!(
        "ChainMail knows neither force nor energy; a force would have to be made up from the shape. \
         The links of the exact shape pull with {:.4} N, those of track with {:.4} N, and those of \
         euler, not yet relaxed, with {:.4} N. {} The bounds of a chain follow the axes of space: \
         turned by {TURN_DEGREES} degrees together with its move, the lattice's shape is {} % of \
         the depth off on the plane and {} % on the box, where track is off by rounding ({} and {} \
         %). Relaxation forgets the axes ({} and {} %). Position-based dynamics takes link after link, and turning numbers them anew: {} and \
         {} %.",
        plane.body.force_n(&plane.exact),
        force(Kind::Track)?,
        force(Kind::Euler)?,
        energy(plane, cuboid),
        turned(plane, Kind::Lattice)?,
        turned(cuboid, Kind::Lattice)?,
        turned(plane, Kind::Track)?,
        turned(cuboid, Kind::Track)?,
        turned(plane, Kind::Graph)?,
        turned(cuboid, Kind::Graph)?,
        turned(plane, Kind::PositionBased)?,
        turned(cuboid, Kind::PositionBased)?,
    ))
}

/// Which methods raise the links' energy by more than rounding while nothing moves.
fn energy(plane: &Comparison, cuboid: &Comparison) -> String {
    let largest = |at: usize| {
        let rows = [plane, cuboid].into_iter().filter_map(|of| of.rows.get(at));
        rows.map(|row| row.energy_rise.max(row.energy_rise_sudden)).fold(0.0, f64::max)
    };
    let rising: Vec<String> = (Kind::ALL.iter().enumerate())
        .filter(|&(at, _)| largest(at) > ENERGY_ROUNDING)
        .map(|(at, kind)| format!("{} (up to {} %)", kind.name(), percent(largest(at))))
        .collect();
    let found = if rising.is_empty() { "with no method".to_owned() } else { rising.join(", ") };
    format!(
        "While the node is held, after the slow and after a sudden move, the links' energy rises in \
         a tick by more than rounding with: {found}. For the network it is proven that it cannot, \
         from any state."
    )
}

/// What it costs.
fn cost(plane: &Comparison) -> Result<String> {
    let [chain, track] = [row(plane, Kind::Lattice)?, row(plane, Kind::Track)?];
    let times = chain.time_ratio.map_or_else(
        || "Times are measured by an optimised build only.".to_owned(),
        |ratio| format!("Its median tick takes {ratio:.2} times as long as one of track."),
    );
    let repeat = plane.rows.iter().filter(|row| row.repeats).count();
    Ok(format!(
        "What speaks for ChainMail is its cost: on the plane the dearest tick looks at {} elements, \
         each at most once, where {SWEEPS} link passes look at {}. {times} A second run ends in the \
         same bits with {repeat} of {} methods; the same bits on every target are tested for the \
         network alone.",
        chain.visited_per_tick,
        track.visited_per_tick,
        plane.rows.len(),
    ))
}
