//! How long a tick takes on this machine, compared with the period of the poses.

use std::fmt;
use std::time::{Duration, Instant};

use chaincell_kernel::{Flags, Model, ToolPose};
use serde::Serialize;

use crate::bake::tissue::DEVICE_HZ;
use crate::cli::offline::Offline;
use crate::engine::place::place;
use crate::engine::staged::{Staged, baked_hz};
use crate::engine::tissue::TissueEngine;
use crate::error::Result;
use crate::session::loops::serve::ServeReport;
use crate::session::timing::clock::SECOND_NS;
use crate::session::timing::histogram::Summary;
use crate::words::{counted, rate};

/// Ticks that are timed of a body without a run, and the time in which they are begun.
const TICKS: u32 = 20;
const LONGEST: Duration = Duration::from_millis(200);

/// Time of a tick, and its sweeps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pace {
    /// Time of a tick over the period of the poses: median, and that of 99 of 100 ticks.
    pub load_p50: f64,
    pub load_p99: f64,
    /// Sweeps of the median tick, and of all but one in 100 ticks.
    pub sweeps_p50: u64,
    pub sweeps_p1: u64,
    /// Most sweeps of a tick.
    pub sweeps_max: u64,
    /// Number of cells for which all sweeps would take 80 % of the period.
    pub cells_fitting: u64,
    /// Poses in a second.
    #[serde(skip)]
    hz: u32,
}

/// Fewer cells are no body.
const CELLS_MIN: u64 = 20;
/// The part of a period that a tick may take.
const USABLE: f64 = 0.8;

impl Pace {
    /// Of ticks of which each made all its sweeps; `None` without any.
    pub fn of_all_sweeps(step: &Summary, sweeps: u16, cells: usize, hz: u32) -> Option<Self> {
        Self::new(step, [sweeps.into(); 3], cells, hz)
    }

    /// Of a served session whose ticks make at most `sweeps_max` sweeps, `None` where they end by the force's error:
    /// then the median tick counts. `None` without a pose.
    pub fn of_served(
        report: &ServeReport,
        sweeps_max: Option<u16>,
        cells: usize,
        hz: u32,
    ) -> Option<Self> {
        let p50 = report.sweeps.p50;
        let [p1, most] = sweeps_max.map_or([p50; 2], |most| [report.sweeps.p1, most.into()]);
        Self::new(&report.step_ns, [p50, p1, most], cells, hz)
    }

    fn new(step: &Summary, [p50, p1, most]: [u64; 3], cells: usize, hz: u32) -> Option<Self> {
        if step.max == 0 {
            return None;
        }
        let [load_p50, load_p99] =
            [step.p50, step.p99].map(|ns| ns as f64 * f64::from(hz) / SECOND_NS as f64);
        let of_all = load_p50 * most as f64 / p50.max(1) as f64;
        let cells_fitting = (cells as f64 * USABLE / of_all.max(1e-9)) as u64;
        let (sweeps_p50, sweeps_p1, sweeps_max) = (p50, p1, most);
        Some(Self { load_p50, load_p99, sweeps_p50, sweeps_p1, sweeps_max, cells_fitting, hz })
    }

    /// Times some ticks of a sphere that presses into a model; `None` where there is no place for one.
    ///
    /// Cost: at most some 20 ticks, or 0.2 s.
    pub fn measured(model: &Model<'_>) -> Option<Self> {
        if !model.has_contact_surface() {
            return None;
        }
        let radius_m = 2.0 * f64::from(model.unit_m());
        let hz = baked_hz(model).map_or(DEVICE_HZ, |hz| hz.round() as u32);
        let contact = format!("--contact=probe:{radius_m}");
        let tissue = Offline::parse([contact, format!("--device-hz={hz}")]);
        let mut tissue = tissue.and_then(|of| of.staged(*model)).ok()?;
        let steps = timed(&mut tissue, radius_m).ok()?;
        let at = |share: usize| steps.get(share * steps.len().saturating_sub(1) / 100).copied();
        let (p50, p99) = (at(50)?, at(99)?);
        let step = Summary { p50, p99, max: p99, ..Summary::default() };
        let sweeps = tissue.engine().network().settings().sweeps;
        Self::of_all_sweeps(&step, sweeps, model.body_cells(), hz)
    }
}

/// Times of ticks in which a sphere presses in by half its radius, ascending \[ns\]; none where the tissue takes no
/// such pose.
fn timed(tissue: &mut Staged<'_>, radius_m: f64) -> Result<Vec<u64>> {
    let way = place(tissue.engine().network().model(), tissue.engine().contact(), None)?;
    let begin = Instant::now();
    let mut steps = Vec::new();
    for tick in 1..=TICKS {
        let depth_m = 0.5 * radius_m * f64::from(tick) / f64::from(TICKS);
        let position_m: [f32; 3] =
            std::array::from_fn(|axis| (way.touch_m[axis] + depth_m * way.direction[axis]) as f32);
        let start = Instant::now();
        let output = tissue.tick(&ToolPose::at(position_m.into(), 1));
        if output.flags.contains(Flags::BAD_SAMPLE) {
            return Ok(Vec::new());
        }
        steps.push(u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX));
        if begin.elapsed() > LONGEST {
            break;
        }
    }
    steps.sort_unstable();
    Ok(steps)
}

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { load_p50, load_p99, sweeps_p50, sweeps_p1, sweeps_max, cells_fitting, hz } =
            *self;
        let period = match hz {
            DEVICE_HZ => "millisecond".to_owned(),
            _ => format!("{} ms", 1e3 / f64::from(hz)),
        };
        let rate = rate(hz);
        let of = |sweeps: u64| counted(sweeps, "sweep");
        let remedy = if cells_fitting < CELLS_MIN {
            "no body is small enough for this core: take a faster one, or fewer --sweeps".to_owned()
        } else {
            format!("for all of them bake some {cells_fitting} cells, or take a faster core")
        };
        if sweeps_p50 < sweeps_max {
            return write!(
                f,
                "does NOT fit {rate} on this machine: time for {sweeps_p50} of {} in the median tick; {remedy}",
                of(sweeps_max)
            );
        }
        let tick = format!("a tick of {} takes", of(sweeps_max));
        if load_p50 > 1.0 {
            return write!(
                f,
                "does NOT fit {rate} on this machine: {tick} {load_p50:.1} times its {period}; {remedy}"
            );
        }
        let [median, most] = [load_p50, load_p99].map(|load| 100.0 * load);
        let but = if load_p99 > 1.0 { ", one tick in 100 does not" } else { "" };
        write!(
            f,
            "fits {rate} on this machine{but}: {tick} {median:.0} % of its {period}, 99 of 100 ticks at most \
             {most:.0} %"
        )?;
        if sweeps_p1 < sweeps_max {
            write!(f, "; one in 100 ticks had time for {} or fewer", of(sweeps_p1))?;
        }
        if load_p99 > 1.0 {
            write!(f, "; by the body or by other programs: end those and run it again")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pace(step_us: [u64; 2], sweeps: [u64; 3]) -> String {
        pace_at(1000, step_us, sweeps)
    }

    fn pace_at(hz: u32, step_us: [u64; 2], sweeps: [u64; 3]) -> String {
        let [p50, p99] = step_us.map(|us| 1000 * us);
        let step = Summary { p50, p99, max: p99, ..Summary::default() };
        Pace::new(&step, sweeps, 5000, hz).unwrap().to_string()
    }

    #[test]
    fn it_says_whether_the_body_fits_and_by_how_much() {
        assert_eq!(
            pace([260, 370], [4, 4, 4]),
            "fits 1 kHz on this machine: a tick of 4 sweeps takes 26 % of its millisecond, 99 of 100 ticks at \
             most 37 %"
        );
        let text = pace([2600, 6000], [4, 4, 4]);
        assert!(
            text.contains("does NOT fit 1 kHz") && text.contains("2.6 times its milli"),
            "{text}"
        );
        assert!(text.contains("bake some 1538 cells"), "{text}");
        let text = pace_at(500, [260, 370], [4, 4, 4]);
        assert!(text.starts_with("fits 500 Hz") && text.contains("13 % of its 2 ms"), "{text}");
        let text = pace([900_000, 990_000], [4, 4, 4]);
        assert!(text.contains("no body is small enough"), "{text}");
        let text = pace([800, 990], [1, 1, 4]);
        assert!(text.contains("time for 1 of 4 sweeps in the median tick"), "{text}");
        assert!(text.contains("bake some 1250 cells"), "{text}");
        let text = pace([260, 990], [4, 1, 4]);
        assert!(text.ends_with("one in 100 ticks had time for 1 sweep or fewer"), "{text}");
        let text = pace([260, 4400], [4, 4, 4]);
        assert!(text.starts_with("fits 1 kHz on this machine, one tick in 100 does not"), "{text}");
        assert!(text.contains("at most 440 %; by the body or by other programs"), "{text}");
        assert_eq!(Pace::of_all_sweeps(&Summary::default(), 4, 100, 1000), None);
    }
}
