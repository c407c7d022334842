//! REPORT.md with its tables and pictures.

use std::fmt::Write as _;

use super::collect::Report;
use super::tables::{csv, duration, us};
use super::{hand, pictures, tools};
use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_host::words::counted;

/// What this report does not measure, and what does.
const OTHERS: &str = "## Figures of other commands

| figure | command |
| --- | --- |
| time of a tick, also by several threads, and round trip in the 1 kHz loop, beside the machine's own floor | `chaincell cosim`, `chaincell latency MODEL --worst` |
| the same for hours, under load | `chaincell cosim --load 1 --seconds 28800 --out night` |
| sweeps to equilibrium beside mass-spring, position-based dynamics, Jolt and rapier3d (needs CMake and a C++ compiler) | `cargo bench -p chaincell-lab --features baselines --bench baselines` |
| instructions of a sweep in its worst state (needs valgrind) | `cargo bench -p chaincell-lab --bench sweep` |
| instructions on microcontrollers, and the error of whole ticks beside them | `tests/firmware/run`, `tests/firmware/run --fit` |
";

/// Writes REPORT.md, report_summary.json, CSV files and pictures.
///
/// # Errors
/// Files that cannot be written.
pub fn write(report: &Report, folder: &Folder, command: &str) -> Result<()> {
    let pictures = pictures::write(report, folder)?;
    for (name, rows) in
        [("report_hand.csv", csv(&report.hand)), ("report_tools.csv", csv(&report.tools))]
    {
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
    let picture = |wanted: &str| {
        let mut text = String::new();
        for (name, caption) in pictures.iter().filter(|(name, _)| name.starts_with(wanted)) {
            let _ = writeln!(text, "![{caption}]({name}.png)\n");
        }
        text
    };
    let mut text = head(report, command);
    text += &hand::markdown(&report.hand, &picture(pictures::HAND));
    text += &tools::markdown(&report.tools, &picture(pictures::TOOLS));
    text + OTHERS
}

fn head(report: &Report, command: &str) -> String {
    let machine = &report.machine;
    let build =
        if machine.optimised { "" } else { " **Built without --release: no figure counts.**" };
    let bodies = if report.reference {
        "The liver is that of the reference data."
    } else {
        "No reference data was given (--reference, CHAINCELL_REFERENCE): the generated organ stands \
         for the liver."
    };
    let stopped = if report.interrupted { "**Interrupted: sections are missing.** " } else { "" };
    format!(
        "# Speed against error\n\n`{command}`, one thread, numbers in f32.{build} {bodies}\n\n\
         {stopped}Machine: {}, {} for this process, {}, AVX2 {}, load {} at the start. Measured in \
         {}. A sweep over the links of the first body takes {} us. Compare ratios within one report, \
         not times of two.\n\n",
        machine.processor,
        counted(machine.cores, "core"),
        machine.system,
        if machine.avx2 { "found" } else { "absent" },
        machine.load,
        duration(report.seconds),
        us(report.link_sweep_ns)
    )
}
