//! The charts of tissue in time.

use super::in_time::{CERVIX, Cycle, Hold, Swing};
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use crate::experiments::paper::mechanics::{TIME_CONSTANT_S, interpolate, relax};
use crate::experiments::report::scene::Source;
use chaincell_host::error::Result;

/// The links beside it: cells of the organ, depth [mean link lengths], time in which they relax \[s\].
const ORGAN: usize = 1000;
const JUMP: f64 = 0.5;
const SECONDS: f64 = 10.0;
/// Stretches of their time that are tried: the first one, and how many in a decade.
const FIRST: f64 = 1e-2;
const TRIED: i32 = 240;
const A_DECADE: f64 = 40.0;

/// The hold over the time since its beginning, as shares of the pressure there.
pub fn relaxation(hold: &Hold) -> Result<(Figure, f64)> {
    let axes = (
        Axis::log10("time since the strain is held [s]"),
        Axis::linear("force, share of the first"),
    );
    let mut chart = Chart::new("5c: tissue that relaxes, beside links", axes.0, axes.1);
    let shares = |times_s: &[f64], pa: &[f64]| -> Vec<[f64; 2]> {
        let held = times_s.iter().zip(pa).filter(|(time_s, _)| **time_s >= hold.held_from_s);
        let held: Vec<[f64; 2]> =
            held.map(|(time_s, pa)| [time_s - hold.held_from_s, *pa]).collect();
        let first = held.first().map_or(1.0, |point| point[1]);
        held.iter().skip(1).map(|point| [point[0], point[1] / first]).collect()
    };
    let measured = hold.measured_pa.as_deref().map(|pa| shares(&hold.times_s, pa));
    if let Some(measured) = &measured {
        chart = chart.series("pig muscle, measured", Style::Markers, measured);
    }
    for body in &hold.bodies {
        let label = short(&body.options);
        chart = chart.series(&label, Style::Line, &shares(&hold.drawn_s, &body.drawn_pa));
    }
    // Links, their time stretched so that they meet the first of these curves best.
    let meant =
        measured.or_else(|| hold.bodies.first().map(|body| shares(&hold.drawn_s, &body.drawn_pa)));
    let (links, misfit) = links(&meant.unwrap_or_default())?;
    let chart = chart.series("links, time stretched", Style::Dashed, &links);
    let caption = format!(
        "Compression to 30 % at 5 %/s, then held: shares of the force at the beginning of the hold. Points, \
         where the reference data were given, are measured (Van Loocke and others). Blocks of tissue relax by their branches in the kernel's ticks. Links as the \
         paper has them, an organ of {ORGAN} cells after a jump, relax by diffusion; the paper leaves their time \
         constant open, here it is the one that meets the first curve best."
    );
    Ok((Figure::new("paper_fig5c_tissue", caption, Picture::of(&chart)?), misfit))
}

/// The relaxation of links with their time stretched to meet a curve, as shares of their first force, and the root
/// mean square distance that is left.
fn links(meant: &[[f64; 2]]) -> Result<(Vec<[f64; 2]>, f64)> {
    let body = Source::organ(Some(ORGAN))?.with_alpha(0.0)?;
    let depth_m = JUMP * f64::from(body.model()?.unit_m());
    let found = relax(&body, depth_m, SECONDS, TIME_CONSTANT_S)?;
    let [last_s, last_n] = found.curve.last().copied().unwrap_or([1.0; 2]);
    let share = |time_s: f64| {
        let before = if time_s > last_s { last_n } else { found.first_n };
        interpolate(&found.curve, time_s).unwrap_or(before) / found.first_n
    };
    let misfit = |stretch: f64| {
        let squares = meant.iter().map(|point| (share(point[0] / stretch) - point[1]).powi(2));
        (squares.sum::<f64>() / meant.len().max(1) as f64).sqrt()
    };
    let tried = (0..TRIED).map(|at| FIRST * 10_f64.powf(f64::from(at) / A_DECADE));
    let best = tried.map(|stretch| (misfit(stretch), stretch));
    let (misfit, stretch) = best.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 1.0));
    Ok((meant.iter().map(|point| [point[0], share(point[0] / stretch)]).collect(), misfit))
}

/// The options of a body as a legend has room for them.
fn short(options: &str) -> String {
    match options.matches("--branch").count() {
        0 => options.to_owned(),
        branches => format!("{branches} branches, fitted to the hold"),
    }
}

/// The hold of a muscle as it was measured.
pub fn muscle(hold: &Hold) -> Result<Figure> {
    let axes = (Axis::log10("time [s]"), Axis::linear("Cauchy stress, compression [Pa]"));
    let mut chart = Chart::new("Pig muscle: 5 %/s to 30 %, then held", axes.0, axes.1);
    let line = |times_s: &[f64], pa: &[f64]| -> Vec<[f64; 2]> {
        times_s.iter().zip(pa).map(|(time_s, pa)| [*time_s, *pa]).collect()
    };
    if let Some(measured) = &hold.measured_pa {
        chart = chart.series("measured", Style::Markers, &line(&hold.times_s, measured));
    }
    for body in &hold.bodies {
        chart =
            chart.series(&short(&body.options), Style::Line, &line(&hold.drawn_s, &body.drawn_pa));
    }
    let caption = "Pig muscle (Van Loocke and others, as tabled in LivingMatterLab/CANN) beside blocks in the kernel's \
                   ticks. Bands do not relax, and begin at other strains along other links: the tissues of the table \
                   have too little stress at 30 %. The body that is fitted to the hold has no bands: it meets the hold, \
                   and is too stiff in the rise.";
    Ok(Figure::new("paper_tissue_muscle", caption, Picture::of(&chart)?))
}

/// Loops of a muscle, with the loading that was measured.
pub fn loops(hold: &Hold, cycles: &[Cycle]) -> Result<Figure> {
    let axes = (Axis::linear("strain [%]"), Axis::linear("Cauchy stress, compression [Pa]"));
    let mut chart = Chart::new("5b: loading and unloading of --tissue muscle", axes.0, axes.1);
    let percent = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().map(|point| [100.0 * point[0], point[1]]).collect()
    };
    for of in cycles.iter().filter(|of| of.tissue == "muscle") {
        chart =
            chart.series(&format!("{} s each way", of.way_s), Style::Line, &percent(&of.cauchy));
    }
    if let Some(measured) = &hold.measured_pa {
        let rise = hold.motion.iter().skip(1).zip(measured);
        let rise = rise.filter(|(point, _)| point[0] <= hold.held_from_s);
        let points: Vec<[f64; 2]> = rise.map(|(point, pa)| [point[1], *pa]).collect();
        chart = chart.series("measured, 6 s, loading", Style::Markers, &percent(&points));
    }
    let caption = "The way back lies below the way in, as in living tissue, by the branches alone: no link is \
                   restored. At the end the clamps pull, since the block has not come back yet. Measured is the loading \
                   of a pig muscle in 6 s; no unloading was found to compare with.";
    Ok(Figure::new("paper_fig5b_tissue", caption, Picture::of(&chart)?))
}

/// Moduli of a cervix over the frequency.
pub fn cervix(of: &Swing) -> Result<Figure> {
    let axes = (Axis::log10("frequency [Hz]"), Axis::linear("modulus [Pa]"));
    let mut chart = Chart::new("Human cervix: published, and --tissue cervix", axes.0, axes.1);
    let published = [("storage, published", false), ("loss, published", true)];
    for (label, is_loss) in published {
        let value = |[_, storage_pa, tangent]: [f64; 3]| {
            if is_loss { storage_pa * tangent } else { storage_pa }
        };
        let points: Vec<[f64; 2]> = CERVIX.iter().map(|row| [row[0], value(*row)]).collect();
        chart = chart.series(label, Style::Markers, &points);
    }
    for (label, place) in [("storage", 1), ("loss", 2)] {
        let points: Vec<[f64; 2]> = of.moduli.iter().map(|row| [row[0], row[place]]).collect();
        chart = chart.series(label, Style::Line, &points);
    }
    let caption = "Storage and loss modulus of human cervix (Ultrason. Imaging 32, 2010, 214, abstract) at 1 and 30 Hz, \
                   and of a block that swings in the kernel's ticks. The branches were derived from these four numbers; \
                   between them nothing was measured.";
    Ok(Figure::new("paper_tissue_cervix", caption, Picture::of(&chart)?))
}
