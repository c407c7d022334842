//! The comparison as tables, picture and text.

use std::fmt::Write as _;

use super::Comparison;
use super::body::{HOLD_TICKS, PRESS_TICKS};
use super::measure::{Row, TURN_DEGREES, of_plane};
use super::method::{Kind, SWEEPS};
use crate::error::{Error, Result};
use crate::paper::profile::middle_row;
use crate::plot::{Axis, Chart, Style};
use crate::report::tables::{Table, percent};

/// The table of a body, with its caption.
pub fn table(of: &Comparison) -> (String, Table) {
    let mut table = Table::new(&[
        "method",
        "non-linearity of the profile",
        "contact force [N]",
        "off the energy minimum [% of depth]",
        "elements looked at in a tick",
        "each at most once",
        "time a tick / track",
        "largest rise of energy in a tick [%]",
        "turned by 30 degrees, off [% of depth]",
        "same bits again",
        "same bits on every target",
    ]);
    for row in &of.rows {
        let yes = |is: bool| if is { "yes" } else { "no" }.to_owned();
        let ratio = |ratio: f64| format!("{ratio:.2}");
        table.row(vec![
            row.method.name().into(),
            row.nonlinearity.map_or("-".into(), short),
            row.force_n.map_or("none".into(), |force| format!("{force:.4}")),
            percent(row.off_minimum),
            row.visited_per_tick.to_string(),
            yes(row.at_most_once),
            row.time_ratio.map_or("not measured".into(), ratio),
            percent(row.energy_rise),
            percent(row.turned),
            yes(row.repeats),
            row.portable.into(),
        ]);
    }
    let times = if of.rows.iter().any(|row| row.time_ratio.is_some()) {
        "times are medians of the ticks of the press, taken in turn"
    } else {
        "times are measured by an optimised build only"
    };
    let caption = format!(
        "{}, in {PRESS_TICKS} ticks, then held for {HOLD_TICKS}; {SWEEPS} link passes a tick where \
         a method sweeps; links of {} N/m without slack, those of the chains with alpha {}; the \
         exact minimum has {:.4} N; {times}.",
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

/// The profiles by name, `[distance from the centre, height]` \[mm\] on one side of the centre.
fn half_profiles(of: &Comparison) -> Result<Vec<(&'static str, Vec<[f64; 2]>)>> {
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
    format!(
        "The middle row of the {} after {PRESS_TICKS} ticks of pull and {HOLD_TICKS} of hold, from \
         the centre to the fixed border: traditional ChainMail takes the straight flank of a \
         pyramid, methods with an elastic energy hang in a curve.",
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
    let of = |comparison: &'_ Comparison, kind: Kind| -> Result<Row> {
        let row = comparison.rows.iter().find(|row| row.method == kind);
        row.cloned().ok_or_else(|| Error::check(format!("{} was not measured", kind.name())))
    };
    let _ = (of(plane, Kind::Track)?, of(cuboid, Kind::Track)?, TURN_DEGREES, of_plane);
    Ok(vec![])
}
