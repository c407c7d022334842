//! Curves in time: the hold of a muscle, loops of loading and unloading, oscillations of a cervix.

use std::f64::consts::TAU;
use std::path::Path;

use super::comparison::Compared;
use super::specimen::{Block, Lattice, Machine, Specimen};
use crate::experiments::paper::mechanics::Loop;
use crate::experiments::relaxation::curve::{self, Curve};
use crate::experiments::relaxation::{identify, rounded};
use chaincell_host::bake::tissue::{Branch, KnownTissue};
use chaincell_host::error::Result;

/// The block in the machine.
const BAR: Block = Block { size_m: [0.01, 0.01, 0.025], edge_m: 0.005, lattice: Lattice::Askew };
/// Ticks a second of a hold of minutes, and of oscillations.
const SLOW_HZ: u32 = 20;
const FAST_HZ: u32 = 1000;
/// The measured motion: strain, its rate \[1/s\], end of the hold \[s\].
pub const STRAIN: f64 = 0.3;
const RATE_PER_S: f64 = 0.05;
const END_S: f64 = 300.0;
/// A slower one, and the share of the peak that is published to fade in it, about.
pub const SLOW_RATE_PER_S: f64 = 0.005;
pub const SLOW_FADED: f64 = 0.5;
/// Moments of lines in a decade of time.
const A_DECADE: f64 = 16.0;
/// Ticks of a way of a loop, about.
const WAY_TICKS: f64 = 200.0;
/// Times of a way \[s\]: of a muscle to its strain, of a cervix to a strain.
const MUSCLE_WAYS_S: [f64; 3] = [60.0, 6.0, 0.6];
const CERVIX_WAYS_S: [f64; 3] = [0.5, 0.05, 0.017];
const CERVIX_STRAIN: f64 = 0.05;
/// Strain of oscillations, their frequencies \[Hz\], and their periods, of which the last one counts.
const SWING: f64 = 0.01;
const FREQUENCIES_HZ: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 30.0];
const PERIODS: u32 = 4;
/// Human cervix: frequency \[Hz\], storage modulus \[Pa\], tangent of the loss angle (Ultrason. Imaging 32, 2010, 214).
pub const CERVIX: [[f64; 3]; 2] = [[1.0, 4700.0, 0.35], [30.0, 7900.0, 0.45]];

/// A pressure with the strain at which it is felt.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Felt {
    /// Force by area at rest \[Pa\].
    nominal_pa: f64,
    /// Force by area now \[Pa\].
    cauchy_pa: f64,
}

/// One tick of compression.
fn press(machine: &mut Machine<'_>, strain: f64) -> Result<Felt> {
    let nominal_pa = -machine.stretch(1.0 - strain)?;
    let across = machine.strain().across;
    Ok(Felt { nominal_pa, cauchy_pa: nominal_pa / (across * across) })
}

/// Follows strains in time; returns the pressure by area now at each moment of `times_s`, ascending \[Pa\].
fn follow(
    specimen: &Specimen,
    hz: u32,
    strain: impl Fn(f64) -> f64,
    times_s: &[f64],
) -> Result<Vec<f64>> {
    let mut machine = specimen.machine()?;
    let tick_s = 1.0 / f64::from(hz);
    let (mut tick, mut before, mut now) = (0_u32, 0.0, 0.0);
    let mut found = Vec::new();
    for &time_s in times_s {
        while f64::from(tick) * tick_s < time_s {
            tick += 1;
            before = now;
            now = press(&mut machine, strain(f64::from(tick) * tick_s))?.cauchy_pa;
        }
        // Between the last two ticks.
        let late = f64::from(tick) - time_s / tick_s;
        found.push(now + late * (before - now));
    }
    Ok(found)
}

/// Linear between points of ascending time, and constant after the last one.
fn linear(points: &[[f64; 2]], time_s: f64) -> f64 {
    let pair = points.windows(2).find(|pair| time_s < pair[1][0]);
    match pair {
        Some([[from_s, from], [to_s, to]]) if time_s > *from_s => {
            from + (to - from) * (time_s - from_s) / (to_s - from_s)
        }
        Some([[_, from], _]) => *from,
        _ => points.last().map_or(0.0, |point| point[1]),
    }
}

/// The hold of a muscle.
pub struct Hold {
    /// Times \[s\] and strains of the motion, from rest.
    pub motion: Vec<[f64; 2]>,
    /// The moments that are compared \[s\].
    pub times_s: Vec<f64>,
    /// The moments of lines, those that are compared among them \[s\].
    pub drawn_s: Vec<f64>,
    /// The moment from which the strain is held \[s\].
    pub held_from_s: f64,
    /// The measured pressure at each moment \[Pa\]; none without reference data.
    pub measured_pa: Option<Vec<f64>>,
    /// A name, the number of cells and the pressure of each body \[Pa\].
    pub bodies: Vec<Held>,
}

/// A body that is held.
pub struct Held {
    /// Options of its bake.
    pub options: String,
    /// Number of its cells.
    pub cells: usize,
    /// Its pressure at each moment that is compared \[Pa\].
    pub pressure_pa: Vec<f64>,
    /// The same at each moment of lines \[Pa\].
    pub drawn_pa: Vec<f64>,
    /// Share of its peak that fades at the slower rate.
    pub slow_faded: Option<f64>,
}

impl Hold {
    /// The motion of the measured curve, or the like without one, to an end \[s\].
    pub fn new(folder: Option<&Path>, end_s: Option<f64>) -> Result<Self> {
        let file = folder.map(|folder| folder.join("tissue/muscle_relaxation_f05.csv"));
        let measured: Option<Curve> = file.map(|file| curve::read(&file)).transpose()?;
        let held_from_s = measured
            .as_ref()
            .map_or(STRAIN / RATE_PER_S, |of| of.points[of.points.len() - of.held][0]);
        let motion = match &measured {
            Some(of) => of.points.clone(),
            None => vec![[0.0; 2], [held_from_s, STRAIN]],
        };
        // Moments in even shares of time, on the way in from its twentieth part on.
        let even = |from_s: f64, first_s: f64, last_s: f64| -> Vec<f64> {
            let since_s = (0..).map(|at| first_s * 10_f64.powf(f64::from(at) / A_DECADE));
            since_s.map(|since_s| from_s + since_s).take_while(|time_s| *time_s < last_s).collect()
        };
        let mut drawn_s = even(0.0, 0.05 * held_from_s, held_from_s);
        drawn_s.push(held_from_s);
        drawn_s.extend(even(held_from_s, 0.1, END_S));
        let mut times_s: Vec<f64> = match &measured {
            Some(of) => of.points[1..].iter().map(|point| point[0]).collect(),
            None => drawn_s.clone(),
        };
        // Both up to the end that was asked for, in ascending order.
        times_s.retain(|time_s| end_s.is_none_or(|end_s| *time_s < end_s));
        let last_s = times_s.last().copied().unwrap_or_default();
        drawn_s.extend(&times_s);
        drawn_s.retain(|time_s| *time_s <= last_s);
        drawn_s.sort_by(f64::total_cmp);
        drawn_s.dedup();
        let measured_pa = measured.map(|of| of.response[1..=times_s.len()].to_vec());
        let bodies = Vec::new();
        Ok(Self { motion, times_s, drawn_s, held_from_s, measured_pa, bodies })
    }

    /// Adds a body of a tissue of the table.
    pub fn add(&mut self, name: &str, is_slow_too: bool) -> Result<()> {
        let of = KnownTissue::find(name)?;
        let body = self.body(&of, format!("--tissue {name}"), is_slow_too)?;
        self.bodies.push(body);
        Ok(())
    }

    /// Adds a body without bands whose branches are found from the measured hold alone, by `chaincell relaxation`'s
    /// law, and whose modulus then meets the hold best.
    pub fn add_fitted(&mut self, branches: usize) -> Result<()> {
        let Some(measured_pa) = self.measured_pa.clone() else { return Ok(()) };
        let is_held = |time_s: f64| time_s >= self.held_from_s;
        let pairs =
            || self.times_s.iter().zip(&measured_pa).filter(|(time_s, _)| is_held(**time_s));
        let rest = std::iter::once([0.0; 2]);
        let held = Curve {
            points: rest.chain(pairs().map(|(&time_s, _)| [time_s, STRAIN])).collect(),
            response: std::iter::once(0.0).chain(pairs().map(|(_, &pa)| pa)).collect(),
            unit: "Pa",
            held: pairs().count(),
        };
        let found = identify(&held, branches, &[])?;
        let of_each =
            |&[ratio, time_s]: &[f64; 2]| Branch { ratio: rounded(ratio), time_s: rounded(time_s) };
        let muscle = KnownTissue::find("muscle")?;
        let branches: Vec<Branch> = found.branches.iter().map(of_each).collect();
        let of = KnownTissue { stiffening: Vec::new(), branches, ..muscle };
        let mut body = self.body(&of, String::new(), true)?;
        // Stress is in proportion to the modulus.
        let answers = || {
            let each = self.times_s.iter().zip(&body.pressure_pa);
            each.filter(|(time_s, _)| is_held(**time_s)).map(|(_, pa)| *pa)
        };
        let product: f64 = answers().zip(pairs()).map(|(answer, (_, pa))| answer * pa).sum();
        let factor = product / answers().map(|answer| answer * answer).sum::<f64>();
        let both = body.pressure_pa.iter_mut().chain(&mut body.drawn_pa);
        both.for_each(|pa| *pa *= factor);
        body.options = format!("--young-pa {:.0}", factor * of.young_pa);
        for Branch { ratio, time_s } in &of.branches {
            body.options += &format!(" --branch {ratio:.3},{time_s:.3}");
        }
        self.bodies.push(body);
        Ok(())
    }

    fn body(&self, of: &KnownTissue, options: String, is_slow_too: bool) -> Result<Held> {
        let specimen = Specimen::new(BAR, of, SLOW_HZ)?;
        let strain = |time_s| linear(&self.motion, time_s);
        let drawn_pa = follow(&specimen, SLOW_HZ, strain, &self.drawn_s)?;
        let line: Vec<[f64; 2]> =
            self.drawn_s.iter().zip(&drawn_pa).map(|(time_s, pa)| [*time_s, *pa]).collect();
        let pressure_pa = self.times_s.iter().map(|time_s| linear(&line, *time_s)).collect();
        let slow_faded = if is_slow_too {
            let rise_s = STRAIN / SLOW_RATE_PER_S;
            let strain = |time_s: f64| (SLOW_RATE_PER_S * time_s).min(STRAIN);
            let ends = follow(&specimen, SLOW_HZ, strain, &[rise_s, rise_s + END_S])?;
            Some(1.0 - ends[1] / ends[0])
        } else {
            None
        };
        Ok(Held { options, cells: specimen.cells, pressure_pa, drawn_pa, slow_faded })
    }

    /// Share of the peak that has faded at the end.
    pub fn faded(pressure_pa: &[f64]) -> f64 {
        let peak_pa = pressure_pa.iter().copied().fold(0.0, f64::max);
        1.0 - pressure_pa.last().copied().unwrap_or_default() / peak_pa
    }

    /// The comparisons: the whole curve, and the hold alone.
    pub fn compared(&self) -> Vec<Compared> {
        let Some(measured_pa) = &self.measured_pa else { return Vec::new() };
        let part = |body: &Held, curve: &str, from_s: f64| {
            let rows = self.times_s.iter().zip(measured_pa).zip(&body.pressure_pa);
            let rows = rows.filter(|((time_s, _), _)| **time_s >= from_s);
            let (points, answers) =
                rows.map(|((&time_s, &pa), &answer)| ([time_s, pa], answer)).unzip();
            Compared {
                tissue: "pig muscle",
                curve: curve.to_owned(),
                body: body.options.clone(),
                cells: body.cells,
                points,
                answers,
            }
        };
        let each = self.bodies.iter().flat_map(|body| {
            [part(body, "5 %/s to 30 %, then held", 0.0), part(body, "the hold", self.held_from_s)]
        });
        each.collect()
    }
}

/// A loop of loading and unloading.
pub struct Cycle {
    /// The tissue of the table.
    pub tissue: &'static str,
    /// Time of a way \[s\].
    pub way_s: f64,
    /// Largest strain.
    pub strain: f64,
    /// Strain and force by area at rest \[Pa\].
    pub turn: Loop,
    /// Strain and force by area now, both ways \[Pa\].
    pub cauchy: Vec<[f64; 2]>,
}

/// Loops of a muscle and of a cervix, the slowest first.
pub fn cycles() -> Result<Vec<Cycle>> {
    let muscle = MUSCLE_WAYS_S.map(|way_s| cycle("muscle", way_s, STRAIN));
    let cervix = CERVIX_WAYS_S.map(|way_s| cycle("cervix", way_s, CERVIX_STRAIN));
    muscle.into_iter().chain(cervix).collect()
}

fn cycle(tissue: &'static str, way_s: f64, strain: f64) -> Result<Cycle> {
    let of = KnownTissue::find(tissue)?;
    // A branch takes a tick at least.
    let least_hz = of.branches.iter().map(|branch| 2.0 / branch.time_s).fold(0.0, f64::max);
    let hz = (WAY_TICKS / way_s).max(least_hz).clamp(f64::from(SLOW_HZ), f64::from(FAST_HZ)) as u32;
    let specimen = Specimen::new(BAR, &of, hz)?;
    let mut machine = specimen.machine()?;
    let ticks = (way_s * f64::from(hz)).round().max(1.0) as u32;
    let (mut ways, mut cauchy) = ([vec![[0.0; 2]], Vec::new()], vec![[0.0; 2]]);
    for tick in 1..=2 * ticks {
        let up = f64::from(tick.min(2 * ticks - tick)) / f64::from(ticks);
        let felt = press(&mut machine, strain * up)?;
        let way = usize::from(tick > ticks);
        ways[way].push([strain * up, felt.nominal_pa]);
        cauchy.push([strain * up, felt.cauchy_pa]);
    }
    let [loading, back] = ways;
    let unloading = loading.last().copied().into_iter().chain(back).collect();
    Ok(Cycle { tissue, way_s, strain, turn: Loop::new(loading, unloading), cauchy })
}

/// Storage and loss modulus of a body at frequencies.
pub struct Swing {
    /// Number of cells.
    pub cells: usize,
    /// Frequency \[Hz\], storage and loss modulus \[Pa\].
    pub moduli: Vec<[f64; 3]>,
}

/// Oscillations of `--tissue cervix`.
pub fn cervix() -> Result<Swing> {
    let specimen = Specimen::new(BAR, &KnownTissue::find("cervix")?, FAST_HZ)?;
    let mut moduli = Vec::new();
    for hz in FREQUENCIES_HZ {
        let mut machine = specimen.machine()?;
        let period = (f64::from(FAST_HZ) / hz).round() as u32;
        // Cosine and sine parts of stress and strain in the last period.
        let (mut stress, mut strain) = ([0.0; 2], [0.0; 2]);
        for tick in 1..=PERIODS * period {
            let (sine, cosine) = (TAU * f64::from(tick) / f64::from(period)).sin_cos();
            let stress_pa = machine.stretch(1.0 + SWING * sine)?;
            if tick > (PERIODS - 1) * period {
                let felt = machine.strain().along - 1.0;
                for (parts, value) in [(&mut stress, stress_pa), (&mut strain, felt)] {
                    parts[0] += value * cosine;
                    parts[1] += value * sine;
                }
            }
        }
        let square = strain[0] * strain[0] + strain[1] * strain[1];
        let storage_pa = (stress[1] * strain[1] + stress[0] * strain[0]) / square;
        let loss_pa = (stress[0] * strain[1] - stress[1] * strain[0]) / square;
        moduli.push([f64::from(FAST_HZ) / f64::from(period), storage_pa, loss_pa]);
    }
    Ok(Swing { cells: specimen.cells, moduli })
}

impl Swing {
    /// The comparisons with the published moduli.
    pub fn compared(&self) -> Vec<Compared> {
        let part = |curve: &str, place: usize, of: fn([f64; 3]) -> f64| Compared {
            tissue: "human cervix",
            curve: curve.to_owned(),
            body: "--tissue cervix".to_owned(),
            cells: self.cells,
            points: CERVIX.iter().map(|row| [row[0], of(*row)]).collect(),
            answers: [self.moduli.first(), self.moduli.last()]
                .into_iter()
                .flatten()
                .map(|row| row[place])
                .collect(),
        };
        vec![
            part("storage modulus at 1 and 30 Hz", 1, |[_, storage_pa, _]| storage_pa),
            part("loss modulus at 1 and 30 Hz", 2, |[_, storage_pa, tangent]| storage_pa * tangent),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_is_linear_and_then_held() {
        let motion = [[0.0, 0.0], [2.0, 0.4], [3.0, 0.1]];
        let at = [0.0, 1.0, 2.0, 2.5, 9.0].map(|time_s| linear(&motion, time_s));
        for (found, wanted) in at.iter().zip([0.0, 0.2, 0.4, 0.25, 0.1]) {
            assert!((found - wanted).abs() < 1e-12, "{at:?}");
        }
    }
}
