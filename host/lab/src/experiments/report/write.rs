//! REPORT.md with its tables and pictures.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::collect::Report;
use super::exact::{HOLD_TICKS, PRESS_TICKS, RESIDUAL};
use super::hand;
use super::model;
use super::pictures;
use super::press::{Errors, PressRow};
use super::snaps::{FIRST_TICK, Snaps};
use super::specimen;
use super::tables::{Columns, Table, csv, duration, percent, times, us};
use super::tools;
use crate::states::STRETCH;
use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_host::words::counted;

/// What this report does not measure, and what does.
const OTHERS: &str = "## Figures of other commands

| figure | command |
| --- | --- |
| time of a tick and round trip in the 1 kHz loop, beside the machine's own floor | `chaincell cosim`, `chaincell latency MODEL --worst` |
| the same for hours, under load | `chaincell cosim --load 1 --seconds 28800 --out night` |
| Jolt and rapier3d on the bodies of \"Time to equilibrium\" (needs CMake and a C++ compiler) | `cargo bench -p chaincell-lab --features baselines --bench baselines` |
| instructions of a sweep (needs valgrind) | `cargo bench -p chaincell-lab --bench sweep -- --count` |
| instructions on microcontrollers, and the error of whole ticks beside them | `tests/firmware/run`, `tests/firmware/run --fit` |
";

/// Writes REPORT.md, report_summary.json, CSV files and pictures.
///
/// # Errors
/// Files that cannot be written.
pub fn write(report: &Report, folder: &Folder, command: &str) -> Result<()> {
    let pictures = pictures::write(report, folder)?;
    let path: Vec<Value> = (report.budget_path.iter())
        .map(|(tick, of)| json!({ "tick": tick, "field": of.field, "force": of.force }))
        .collect();
    for (name, rows) in [
        ("report_press.csv", csv(&report.rows)),
        ("report_hand.csv", csv(&report.hand)),
        (model::CSV, csv(&report.model.rows)),
        (model::RUNNING_CSV, csv(&report.model.running)),
        (specimen::CSV, csv(&report.specimen)),
        ("report_tools.csv", csv(&report.tools)),
        ("report_settle.csv", csv(&report.settled)),
        ("report_time.csv", csv(&path)),
    ] {
        // What was not measured leaves no file.
        if !rows.is_empty() {
            folder.write(name, rows.as_bytes())?;
        }
    }
    folder.write_json("report_summary.json", report)?;
    folder.write("REPORT.md", markdown(report, &pictures, command).as_bytes())
}

/// The report as Markdown.
fn markdown(report: &Report, pictures: &[(String, String)], command: &str) -> String {
    let mut text = head(report, command);
    let picture = |text: &mut String, wanted: &str| {
        for (name, caption) in pictures.iter().filter(|(name, _)| name.starts_with(wanted)) {
            let _ = writeln!(text, "![{caption}]({name}.png)\n");
        }
    };
    text += "## Error against time\n\n";
    picture(&mut text, "report_field");
    text += &track(report);
    picture(&mut text, "report_time");
    picture(&mut text, "report_force");
    let mut of_hand = String::new();
    picture(&mut of_hand, pictures::HAND);
    text += &hand::markdown(&report.hand, &of_hand);
    let mut of_model = String::new();
    picture(&mut of_model, model::PICTURE);
    text += &model::markdown(&report.model, &of_model);
    let mut of_specimen = String::new();
    picture(&mut of_specimen, specimen::PICTURE);
    text += &specimen::markdown(&report.specimen, &of_specimen);
    text += &tools::markdown(&report.tools);
    text += &sweep(report);
    text += &settled(report);
    text += &presses(report);
    text + OTHERS
}

fn head(report: &Report, command: &str) -> String {
    let machine = &report.machine;
    let noise = report.sweep.map_or(String::from("not measured"), |sweep| {
        format!(
            "the 99th percentile of one and the same plain sweep is {:.2} times its median",
            sweep.noise
        )
    });
    let build =
        if machine.optimised { "" } else { " **Built without --release: no figure counts.**" };
    let bodies = if report.reference {
        "The liver and the bodies of the press test are those of the reference data."
    } else {
        "No reference data was given (--reference, CHAINCELL_REFERENCE): the generated organ stands \
         for the liver, and generated boxes of about the same size for the slab and the block."
    };
    let stopped = if report.interrupted { "**Interrupted: sections are missing.** " } else { "" };
    format!(
        "# Speed against error\n\n`{command}`, one thread, numbers in f32.{build} {bodies}\n\n\
         {stopped}Machine: {}, {} for this process, {}, AVX2 {}, load {} at the start. Measured in {}. Noise: \
         {noise}. Compare ratios within one report, not times of two.\n\n",
        machine.processor,
        counted(machine.cores, "core"),
        machine.system,
        if machine.avx2 { "found" } else { "absent" },
        machine.load,
        duration(report.seconds)
    )
}

fn track(report: &Report) -> String {
    let Some(track) = &report.track else { return String::new() };
    let snaps = &track.snaps;
    let inside = match snaps.ticks.is_empty() {
        true => "The exact path has no snap.".to_owned(),
        false => format!(
            "The exact path snaps from one equilibrium to another at tick {:?}; ticks left out as \
             snaps: {} %. There the field is off by up to {} %, the force by up to {} %.",
            snaps.ticks,
            snaps.share_words(),
            percent(track.largest_in_snaps.field),
            percent(track.largest_in_snaps.force)
        ),
    };
    format!(
        "`track` in half a millisecond a tick (chosen by an earlier timing; here the median is {} us): \
         {} on `{}`, cells held by the tool. From tick \
         {FIRST_TICK} on the field is within {} %, the force within {} %; 20 ms after the press \
         {} % and {} %. {inside}\n\n",
        us(track.tick_ns_p50),
        counted(track.sweeps, "sweep"),
        track.scene,
        percent(track.field_error_max),
        percent(track.force_error_max),
        percent(track.field_error_after_20ms),
        percent(track.force_error_after_20ms)
    )
}

fn sweep(report: &Report) -> String {
    let Some(sweep) = &report.sweep else { return String::new() };
    let mut rows = Vec::new();
    let mut row = |what: String, ns: u64| rows.push((what, ns));
    for (state, loops) in [("mixed", sweep.mixed), ("stretched", sweep.stretched)] {
        row(format!("plain per-cell loop, {state}"), loops.scalar_ns);
        row(format!("`track`, {state}"), loops.simd_ns);
        row(format!("`track` without vector unit, {state}"), loops.once_per_link_ns);
        row(format!("`track` with its coarse level, {state}"), loops.hats_ns);
    }
    let share = |ns: u64| percent(ns as f64 / sweep.mixed.simd_ns.max(1) as f64);
    let table = Table::of(&rows)
        .column("a sweep", |(what, _)| what)
        .column("median [us]", |(_, ns)| us(*ns))
        .column("of the worst case [%]", |(_, ns)| share(*ns));
    format!(
        "## The sweep\n\nThe time of one sweep from a given state; a sweep has no error of its own. \
         Worst case, `mixed`: {} of {} links out of their band, {} cells; links too long and links \
         too short follow each other without a pattern, so a branch predictor cannot know which is \
         next. `stretched`: positions scaled by {}, all links too long, so that the plain loop's \
         branches are all foreseen. Ratio of the plain loop to `track`: {:.2} mixed, {:.2} \
         stretched. {:.0} sweeps of `track` a millisecond, {:.0} with the coarse level.\n\n{}",
        sweep.taut_links,
        sweep.links,
        sweep.cells,
        STRETCH,
        ratio(sweep.mixed.scalar_ns, sweep.mixed.simd_ns),
        ratio(sweep.stretched.scalar_ns, sweep.stretched.simd_ns),
        ratio(1_000_000, sweep.mixed.simd_ns),
        ratio(1_000_000, sweep.mixed.hats_ns),
        table.table().markdown()
    )
}

fn ratio(a: u64, b: u64) -> f64 {
    a as f64 / b.max(1) as f64
}

fn settled(report: &Report) -> String {
    if report.settled.is_empty() {
        return String::new();
    }
    let table = Table::of(&report.settled)
        .column("body", |row| row.scene)
        .column("method", |row| &row.method)
        .column("sweeps", |row| match row.settles {
            true => row.sweeps.to_string(),
            false => "not reached".to_owned(),
        })
        .column("field / force alone", |row| format!("{} / {}", row.field_sweeps, row.force_sweeps))
        .column("median [ms]", |row| format!("{:.3}", row.ms))
        .column("p99 [ms]", |row| format!("{:.3}", row.ms_p99))
        .column("converged field off the exact minimum [%]", |row| percent(row.off_minimum));
    format!(
        "## Time to equilibrium\n\nOne cell pressed by a tenth of the height in one step and held, \
         until the field stays within 5 % and the force within 1 % of what the method itself \
         converges to. {}.\n\n{}",
        report.settled_sources.join(". "),
        table.table().markdown()
    )
}

fn presses(report: &Report) -> String {
    let mut text = format!(
        "## A press by 3 mean link lengths in {PRESS_TICKS} ms\n\nAgainst the path of exact energy \
         minima of the same links, followed in f64 to a residual of {RESIDUAL:e} mean link lengths. \
         Field: |u - u_exact| over the larger of |u_exact| and a fifth of its last value (L2 over \
         cells), force: relative to the exact one; largest values. {} Residual and energy above the minimum at the end, \
         {HOLD_TICKS} ms after the press. A sweep is one link pass. Worst case: a tick from \
         positions scaled by {}. A flat plane resists with the cube of the depth: at the start its \
         exact force is next to nothing, and any error of it many times that. Energies a hair below \
         the minimum are the rounding of the tool's position to f32.\n\n",
        Snaps::rule(),
        STRETCH
    );
    for scene in &report.scenes {
        let snaps = if scene.snaps.ticks.is_empty() {
            "no snap".to_owned()
        } else {
            let share = scene.snaps.share_words();
            format!(
                "snaps at tick {:?}, left out as such: {share} % of the ticks",
                scene.snaps.ticks
            )
        };
        let _ = writeln!(
            text,
            "### {}\n\n{}: {}, {}, {} held by the tool, {:.1} mm deep; {} exact moments, residual \
             at most {:.0e}; {snaps}.\n",
            scene.name,
            scene.source,
            counted(scene.cells, "cell"),
            counted(scene.links, "link"),
            counted(scene.contacts, "cell"),
            1e3 * scene.depth_m,
            scene.moments,
            scene.reference_residual
        );
        let rows = report.rows.iter().filter(|row| row.scene == scene.name);
        text += &press_table(rows).table().markdown();
    }
    text
}

fn press_table<'r>(rows: impl Iterator<Item = &'r PressRow>) -> Columns<&'r PressRow> {
    let both = |errors: Errors| format!("{} / {}", percent(errors.field), percent(errors.force));
    Table::of(rows)
        .column("scheme", |row| row.scheme)
        .column("sweeps", |row| row.sweeps)
        .column("tick p50 / p99 / max [us]", |row| times(row.tick_ns))
        .column("worst p50 [us]", |row| us(row.worst_tick_ns.p50))
        .column("field / force during [%]", |row| both(row.largest))
        .column("in snaps [%]", |row| both(row.largest_in_snaps))
        .column("at the end [%]", |row| both(row.at_end))
        .column("20 ms after [%]", |row| both(row.after_20ms))
        .column("100 ms after [%]", |row| both(row.after_100ms))
        .column("residual", |row| format!("{:.0e}", row.residual))
        .column("energy above [%]", |row| percent(row.energy_above))
}
