//! REPORT.md with its tables and pictures.

use std::fmt::Write as _;

use chaincell_kernel::Choice as _;
use serde_json::{Value, json};

use super::collect::Report;
use super::exact::{HOLD_TICKS, PRESS_TICKS, RESIDUAL};
use super::hand;
use super::model;
use super::pictures;
use super::press::{Errors, PressRow};
use super::recommend::{BUDGETS_US, ERROR_MAX, Recommended, choose};
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
| the same for hours, under load | `chaincell soak --out soak` |
| Jolt and rapier3d on the bodies of \"Time to equilibrium\" (needs CMake and a C++ compiler) | `cargo bench -p chaincell-lab --features baselines --bench baselines` |
| instructions of a sweep (needs valgrind) | `cargo bench -p chaincell-lab --bench sweep -- --count` |
| instructions on microcontrollers, for `report --firmware FILE` | `tests/firmware/run --json > FILE` |
";

/// Writes REPORT.md, report_summary.json, CSV files and pictures.
///
/// # Errors
/// Files that cannot be written.
pub fn write(report: &Report, folder: &Folder, command: &str) -> Result<()> {
    let pictures = pictures::write(report, folder)?;
    let growth = report.growth.as_ref().map_or(&[][..], |growth| &growth.rows);
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
        ("report_numbers.csv", csv(&report.numbers)),
        ("report_flow.csv", csv(&report.flow)),
        ("report_growth.csv", csv(growth)),
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
    text += "## Which setting for which budget\n\n";
    picture(&mut text, "report_pareto");
    text += &budgets(report);
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
    text += &flow(report);
    picture(&mut text, "report_flow");
    text += &numbers(report);
    text += &growth(report);
    picture(&mut text, "report_growth");
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

/// The setting to take within each budget.
fn budgets(report: &Report) -> String {
    let rows = pictures::main_rows(report);
    let Some(first) = rows.first() else { return String::new() };
    let choices = BUDGETS_US.map(|budget_us| (budget_us, choose(&rows, budget_us)));
    let figure = |of: fn(&PressRow) -> String| {
        move |(_, choice): (f64, Option<Recommended<'_>>)| {
            choice.map_or("-".to_owned(), |choice| of(choice.row))
        }
    };
    let table = Table::of(choices)
        .column("budget a tick [us]", |(budget_us, _)| budget_us)
        .column("setting", |(_, choice)| setting(choice))
        .column("median tick [us]", figure(|row| us(row.tick_ns.p50)))
        .column("field, during the press [%]", figure(|row| percent(row.largest.field)))
        .column("force [%]", figure(|row| percent(row.largest.force)))
        .column("field 20 ms after [%]", figure(|row| percent(row.after_20ms.field)))
        .column("force 20 ms after [%]", figure(|row| percent(row.after_20ms.force)));
    format!(
        "Scene: the body `{}`, cells held by the tool, pressed by 3 mean link lengths in \
         {PRESS_TICKS} ms. A setting is recommended where its largest errors of field and force \
         during the press are within {} %; of those that fit the budget, the one with the least \
         error. Where none of the settings measured is within that bound, the table says so and \
         gives the one that comes nearest.\n\n{}",
        first.scene,
        percent(ERROR_MAX),
        table.table().markdown()
    )
}

/// A budget's setting in words.
fn setting(choice: Option<Recommended<'_>>) -> String {
    let Some(Recommended { qualifies, row }) = choice else {
        return "none: every setting takes longer".to_owned();
    };
    let setting = format!("{}, --sweeps {}", row.scheme, row.sweeps);
    if qualifies {
        return setting;
    }
    format!("none within {} %; the nearest: {setting}", percent(ERROR_MAX))
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
    let mut row = |what: String, ns: Option<u64>| rows.extend(ns.map(|ns| (what, ns)));
    for (state, loops) in [("mixed", sweep.mixed), ("stretched", sweep.stretched)] {
        row(format!("plain per-cell loop, {state}"), Some(loops.scalar_ns));
        row(format!("`track`, {state}"), Some(loops.simd_ns));
        row(format!("`track` without vector unit, {state}"), Some(loops.once_per_link_ns));
        row(format!("`track` with its coarse level, {state}"), Some(loops.hats_ns));
    }
    row("`track`, body at rest".into(), report.rest_ns);
    if let Some(local) = &report.local_press {
        let what = format!(
            "`track`, alpha {}, cells held by the tool pressed by {:.2} mean link lengths, which \
             moves {} % of the cells; {}",
            super::quiet::ALPHA,
            local.depth_links,
            percent(local.moved),
            force_off(local.force_error, local.force_off_n)
        );
        row(what, report.local_press_ns);
        let what = format!(
            "the same with the coarse level, which moves all cells; {}",
            force_off(local.hats_force_error, local.hats_force_off_n)
        );
        row(what, Some(local.hats_sweep_ns));
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

/// How far a force is from the one that it settles to, or why there is no such figure.
fn force_off(error: Option<f64>, off_n: f64) -> String {
    match error {
        Some(error) => format!("force off by {} %", percent(error)),
        None => format!(
            "error of the force: -, since it settles to no force (at the end of the press it was \
             {off_n:.1e} N)"
        ),
    }
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

fn flow(report: &Report) -> String {
    if report.flow.is_empty() {
        return String::new();
    }
    let table = Table::of(&report.flow)
        .column("scene", |row| row.scene)
        .column("scheme", |row| row.scheme)
        .column("step", |row| row.step)
        .column("t", |row| row.t)
        .column("link passes", |row| row.passes)
        .column("error [%]", |row| percent(row.error));
    format!(
        "## The relaxation in time\n\nThe plane with its centre held 50 mm away from t = 0 on, \
         against the exact trajectory of Eq. 2 (Dormand-Prince, f64). Error: largest distance of a \
         cell, as a fraction of the depth.\n\n{}",
        table.table().markdown()
    )
}

fn numbers(report: &Report) -> String {
    let Some(first) = report.numbers.first() else { return String::new() };
    let table = Table::of(&report.numbers)
        .column("scene", |row| row.scene)
        .column("scheme", |row| row.scheme.name())
        .column("number", |row| row.number.name())
        .column("median tick [us]", |row| us(row.tick_ns_p50))
        .column("field [%]", |row| percent(row.field))
        .column("force [%]", |row| percent(row.force))
        .column("force, largest on the way [%]", |row| percent(row.force_max));
    format!(
        "## Number types\n\nA press by 3 mean link lengths in 300 ticks, held to tick {}, {} a \
         tick, no hats (only f32 has them): against f32 under the same scheme. Field: largest \
         distance of a cell after the last tick, over the depth. `track` decides from sweep to sweep \
         by the last bits, so its way differs more than its end.\n\n{}{}",
        first.ticks,
        counted(first.sweeps, "sweep"),
        table.table().markdown(),
        firmware(report)
    )
}

/// Emulated microcontrollers.
fn firmware(report: &Report) -> String {
    if report.firmware.is_empty() {
        return String::new();
    }
    let table = Table::of(&report.firmware)
        .column("target", |row| &row.target)
        .column("scene", |row| &row.scene)
        .column("number", |row| &row.tier)
        .column("instructions a sweep", |row| row.instructions_per_sweep_worst)
        .column("a link", |row| format!("{:.0}", row.per_link()));
    format!(
        "On emulated microcontrollers, in their worst state; a sweep has no error of its own, and \
         `tests/firmware/run --fit` prints those of whole ticks:\n\n{}",
        table.table().markdown()
    )
}

fn growth(report: &Report) -> String {
    let Some(growth) = &report.growth else { return String::new() };
    let table = Table::of(&growth.rows)
        .column("cells", |row| row.cells)
        .column("links", |row| row.links)
        .column("sweep [us]", |row| us(row.sweep_ns))
        .column("ns a cell", |row| format!("{:.1}", row.sweep_ns as f64 / row.cells as f64))
        .column("ns a link", |row| format!("{:.2}", row.sweep_ns as f64 / row.links as f64))
        .column("plain loop [us]", |row| us(row.scalar_ns))
        .column("hats", |row| row.hats)
        .column("sweep with hats [us]", |row| us(row.hats_ns))
        .column("sweeps to settle", |row| row.settle_sweeps)
        .column("RAM a cell [bytes]", |row| format!("{:.1}", row.ram_bytes_per_cell))
        .column("flash a cell [bytes]", |row| format!("{:.1}", row.flash_bytes_per_cell));
    format!(
        "## Cost over size\n\nGenerated organs, `track`, the time of one sweep from its worst state; a \
         sweep has no error of its own. Slope of log(time) over \
         log(links): {:.2} (1 is linear). Sweeps to settle: with hats, held cells pressed by a mean \
         link length in one step, until the field stays within 5 % of its end. They depend on where \
         the press falls against the grid of the hats; a body has at most 400 hats, which stand \
         farther apart in a larger one and do less.\n\n{}",
        growth.slope,
        table.table().markdown()
    )
}
