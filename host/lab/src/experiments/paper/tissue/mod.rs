//! Measured tissue beside baked bodies, and Fig. 5b and 5c for tissue that relaxes.
//!
//! - `specimen`: the testing machine, a block between two clamps.
//! - `quasi_static`: curves without time: cortex, liver.
//! - `in_time`: the hold of a muscle, loops, oscillations of a cervix.
//! - `comparison`: measured points beside answers, with their misfit.
//! - `pictures`: the charts in time.
//!
//! Measured curves are files of the reference data. Without them the bodies are shown alone.

mod comparison;
mod in_time;
mod pictures;
mod quasi_static;
mod specimen;

use serde_json::{Value, json};

use crate::experiments::page::table::{Table, csv, percent};
use crate::experiments::page::{Context, Numbers, Section};
use chaincell_host::error::Result;
use comparison::{Compared, table};
use in_time::{Cycle, Hold, SLOW_FADED};

/// End of the hold of a quick run \[s\].
const QUICK_S: f64 = 20.0;
/// Tissues that no picture shows, and the reason.
const MISSING: [(&str, &str); 6] = [
    ("fat", "its source has a modulus and a branch of 700 s, no curve"),
    (
        "gluteus, prostate, muscle_rat, heel_fat, scalp, fat_cheek",
        "numbers of abstracts and of models, no curve",
    ),
    ("brain_cortex in time", "the curves have no time: nothing says how it relaxes"),
    (
        "liver in time",
        "the forces have depths, no speed and no time; thickness and support are not known either",
    ),
    ("loops", "no unloading and no loop area of these tissues was found"),
    (
        "muscle at other rates and depths",
        "of 0.5 %/s the share that fades is published, no curve is in the data",
    ),
];

/// Tissue in the machine, beside what was measured.
pub fn section(context: &Context) -> Result<Section> {
    let folder = context.reference.as_deref();
    let is_long = !context.quick;
    // The hold of a muscle.
    let mut hold = Hold::new(folder, context.quick.then_some(QUICK_S))?;
    hold.add("muscle", is_long)?;
    if is_long {
        hold.add("muscle_3", true)?;
        hold.add_fitted(2)?;
        hold.add_fitted(3)?;
    }
    let cycles = in_time::cycles()?;
    let swing = in_time::cervix()?;
    // Figures and comparisons in the order of the page.
    let (relaxation, links_misfit) = pictures::relaxation(&hold)?;
    let mut figures = vec![pictures::loops(&hold, &cycles)?, relaxation, pictures::muscle(&hold)?];
    let mut compared = hold.compared();
    let mut modulus_pa = None;
    if let Some(folder) = folder {
        let liver = quasi_static::liver(folder)?;
        figures.push(quasi_static::liver_figure(&liver)?);
        modulus_pa = Some(liver.young_pa);
        compared.extend(liver.compared);
        let brain = quasi_static::brain(folder)?;
        figures.push(quasi_static::brain_figure(&brain)?);
        compared.extend(brain);
    }
    figures.push(pictures::cervix(&swing)?);
    compared.extend(swing.compared());
    Ok(Section {
        key: "tissue",
        title: "Measured tissue (Fig. 5b and 5c for tissue that relaxes)".into(),
        results: vec![("Fig. 5b and 5c: as in living tissue", result(&hold, &cycles))],
        text: text(folder.is_some(), links_misfit),
        figures,
        tables: tables(&hold, &cycles, &compared),
        numbers: vec![Numbers { name: "paper_tissue".into(), csv: numbers(&compared) }],
        json: json!({
            "compared": compared.iter().map(Compared::json).collect::<Vec<Value>>(),
            "cycles": cycles.iter().map(cycle_json).collect::<Vec<Value>>(),
            "faded": hold.bodies.iter().map(|body| json!({
                "body": body.options,
                "at_5_percent_per_s": Hold::faded(&body.pressure_pa),
                "at_half_percent_per_s": body.slow_faded,
            })).collect::<Vec<Value>>(),
            "links_misfit": links_misfit,
            "liver_young_pa": modulus_pa,
        }),
    })
}

fn cycle_json(of: &Cycle) -> Value {
    json!({
        "tissue": of.tissue,
        "way_s": of.way_s,
        "strain": of.strain,
        "loop_area_of_loading_work": of.turn.relative(),
    })
}

/// Loops and hold of a muscle in a sentence.
fn result(hold: &Hold, cycles: &[Cycle]) -> String {
    let muscle = cycles.iter().filter(|of| of.tissue == "muscle");
    let (ways, kept): (Vec<String>, Vec<String>) =
        muscle.map(|of| (of.way_s.to_string(), percent(of.turn.relative()))).unzip();
    let mut fits = hold.bodies.iter().filter(|body| body.options.contains("--branch"));
    let fitted = fits.next_back().map_or_else(String::new, |body| {
        let mut of_body = hold.compared().into_iter().filter(|of| of.body == body.options);
        let misfit = of_body.next_back().map(|of| of.misfit());
        format!(
            " A body that is fitted to a measured hold meets it within {} % rms.",
            percent(misfit)
        )
    });
    format!(
        "With branches the tissue keeps a part of the work, no link restored: a block of --tissue muscle {} % of a \
         loop of {} s each way. Its force fades over decades of time.{fitted}",
        kept.join(", "),
        ways.join(", ")
    )
}

fn text(has_data: bool, links_misfit: f64) -> Vec<String> {
    let data = if has_data {
        "Measured curves are those of the reference data."
    } else {
        "SKIPPED measured curves: no reference data was given, so bodies stand alone; name the folder by \
         `--reference` or CHAINCELL_REFERENCE."
    };
    vec![
        format!(
            "{data} Every line is the answer of a baked body in the kernel's ticks: a block between two clamps, whose \
             strain is measured between marks in its middle, or a block under a ball. Misfits are shares of the \
             largest measured value."
        ),
        format!(
            "5b and 5c with branches need neither restored links nor the network's own time: the way back lies below \
             the way in, and the force fades over decades of time. Links fade too, by diffusion; with the time constant \
             that suits them best they stay {} % of the first force (rms) from the first curve of the picture.",
            percent(links_misfit)
        ),
    ]
}

fn tables(hold: &Hold, cycles: &[Cycle], compared: &[Compared]) -> Vec<(String, Table)> {
    let measured = hold.measured_pa.as_deref();
    let faded = Table::of(&hold.bodies)
        .column("body", |body| body.options.as_str())
        .column("5 %/s [%]", |body| percent(Hold::faded(&body.pressure_pa)))
        .column("measured [%]", |_| percent(measured.map(Hold::faded)))
        .column("0.5 %/s [%]", |body| percent(body.slow_faded))
        .column("published, about [%]", |_| percent(SLOW_FADED))
        .table();
    let cycles = Table::of(cycles)
        .column("tissue", |of| of.tissue)
        .column("strain [%]", |of| percent(of.strain))
        .column("each way [s]", |of| of.way_s)
        .column("work kept [% of that given]", |of| percent(of.turn.relative()))
        .table();
    let missing = Table::of(MISSING).column("tissue", |row| row.0).column("reason", |row| row.1);
    let mut all = vec![("Measured curves beside baked bodies".to_owned(), table(compared))];
    // A short run has no end of the hold.
    if hold.bodies.iter().any(|body| body.slow_faded.is_some()) {
        let caption =
            "Muscle: share of the peak that fades in a hold of 300 s; another rate is predicted";
        all.push((caption.to_owned(), faded));
    }
    all.push(("5b: loops of tissue that relaxes".to_owned(), cycles));
    all.push(("Not compared".to_owned(), missing.table()));
    all
}

/// The points with their answers.
fn numbers(compared: &[Compared]) -> String {
    let rows = compared.iter().flat_map(|of| {
        of.points.iter().zip(&of.answers).map(|(point, answer)| {
            json!({
                "tissue": of.tissue,
                "curve": of.curve,
                "body": of.body,
                "x": point[0],
                "measured": point[1],
                "answer": answer,
            })
        })
    });
    csv(&rows.collect::<Vec<Value>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// The folder of reference data, where there is one.
    fn reference(test: &str) -> Option<PathBuf> {
        let folder = std::env::var_os("CHAINCELL_REFERENCE").map(PathBuf::from);
        if folder.is_none() {
            println!("SKIPPED {test}: CHAINCELL_REFERENCE is not set");
        }
        folder
    }

    /// Misfits in order.
    fn misfits(all: &[Compared]) -> Vec<f64> {
        for of in all {
            println!("{}, {}, {}: {:.4}", of.tissue, of.curve, of.body, of.misfit());
        }
        all.iter().map(Compared::misfit).collect()
    }

    #[test]
    fn a_cervix_swings_as_published() {
        let found = misfits(&in_time::cervix().unwrap().compared());
        assert!(found.iter().all(|misfit| *misfit < 0.03), "{found:?}");
    }

    #[test]
    fn a_cortex_is_met_along_the_lattice() {
        let Some(folder) = reference("a_cortex_is_met_along_the_lattice") else { return };
        let found = misfits(&quasi_static::brain(&folder).unwrap());
        let limits = [0.03, 0.06, 0.13, 0.05, 0.18, 0.1];
        assert!(found.iter().zip(limits).all(|(misfit, limit)| *misfit < limit), "{found:?}");
        // The band acts along links: askew to all of them the body resists compression less.
        assert!(found[4] > 2.0 * found[1], "{found:?}");
    }

    #[test]
    fn a_liver_is_met_by_one_modulus() {
        let Some(folder) = reference("a_liver_is_met_by_one_modulus") else { return };
        let liver = quasi_static::liver(&folder).unwrap();
        let (young_pa, found) = (liver.young_pa, misfits(&liver.compared));
        assert!((20e3..26e3).contains(&young_pa) && found[1] < 0.06, "{young_pa} Pa, {found:?}");
    }

    #[test]
    fn a_hold_of_a_muscle_is_met_by_two_branches() {
        let Some(folder) = reference("a_hold_of_a_muscle_is_met_by_two_branches") else { return };
        let mut hold = Hold::new(Some(&folder), None).unwrap();
        hold.add("muscle", false).unwrap();
        hold.add_fitted(2).unwrap();
        // The whole curve and the hold, by the table, then by a fit to the hold without bands.
        let found = misfits(&hold.compared());
        let limits = [0.42, 0.4, 0.25, 0.025];
        assert!(found.iter().zip(limits).all(|(misfit, limit)| *misfit < limit), "{found:?}");
    }
}
