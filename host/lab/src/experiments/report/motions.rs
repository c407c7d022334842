//! Motions of a hand that holds cells: what the tables of errors play, tick by tick at 1 kHz.

use std::f64::consts::TAU;

use chaincell_kernel::ToolPose;
use nalgebra::Vector3;

/// Seconds of a tick.
const TICK_S: f64 = 1e-3;
/// How circles begin: straight in at this speed to this depth.
const CIRCLES_SPEED_MM_PER_S: f64 = 50.0;
const CIRCLES_DEPTH_MM: f64 = 6.0;
/// Radius and frequency of the circles.
const RADIUS_MM: f64 = 4.0;
const CIRCLES_HZ: f64 = 2.0;
/// Amplitude along either of its two axes, and frequency of the tremor.
const TREMOR_MM: f64 = 0.3;
const TREMOR_HZ: f64 = 9.0;
/// When circles and tremor begin, and how long they take to be whole \[s\].
const BEGIN_S: f64 = 0.1;
const GROW_S: f64 = 0.1;
/// Ticks of the circles.
const CIRCLES_TICKS: usize = 800;

/// A motion from the place where the cells are taken hold of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Straight inwards.
    Straight {
        /// Speed \[mm/s\].
        speed_mm_per_s: f64,
        /// Where it ends \[mm\].
        depth_mm: f64,
    },
    /// Straight in, then circles at that depth, with a tremor.
    Circles,
}

impl Motion {
    /// Straight in, as the table of microcontrollers has it.
    pub const SLOW: Self = Self::Straight { speed_mm_per_s: 50.0, depth_mm: 15.0 };

    /// Last tick of the motion.
    pub fn ticks(self) -> usize {
        match self {
            Self::Straight { speed_mm_per_s, depth_mm } => {
                (depth_mm / (speed_mm_per_s * TICK_S) + 1e-6).floor() as usize
            }
            Self::Circles => CIRCLES_TICKS,
        }
    }

    /// The tool at a tick, with `inward` of length 1; at tick 0 it takes hold.
    pub fn sample(self, tick: usize, inward: [f64; 3]) -> ToolPose {
        let way_mm = self.way_mm(tick as f64 * TICK_S, Vector3::from(inward));
        ToolPose::at(way_mm.map(|x| (1e-3 * x) as f32), 1)
    }

    fn way_mm(self, time_s: f64, inward: Vector3<f64>) -> Vector3<f64> {
        let speed_mm_per_s = match self {
            Self::Straight { speed_mm_per_s, .. } => return speed_mm_per_s * time_s * inward,
            Self::Circles => CIRCLES_SPEED_MM_PER_S,
        };
        let axis = if inward.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let side = inward.cross(&axis).normalize();
        let other = inward.cross(&side);
        let part = ((time_s - BEGIN_S) / GROW_S).clamp(0.0, 1.0);
        let angle = TAU * CIRCLES_HZ * time_s;
        let circle = side * (angle.cos() - 1.0) + other * angle.sin();
        let tremor = (side + inward) * (TAU * TREMOR_HZ * time_s).sin();
        let depth_mm = (speed_mm_per_s * time_s).min(CIRCLES_DEPTH_MM);
        depth_mm * inward + part * (RADIUS_MM * circle + TREMOR_MM * tremor)
    }

    /// What it is, for tables.
    pub fn words(self) -> String {
        match self {
            Self::Straight { speed_mm_per_s, depth_mm } => {
                format!("straight at {speed_mm_per_s} mm/s to {depth_mm} mm")
            }
            Self::Circles => "circles with tremor".to_owned(),
        }
    }

    /// What the motions are, for the text of a report.
    pub fn description() -> String {
        format!(
            "Circles with tremor: in at {CIRCLES_SPEED_MM_PER_S} mm/s to {CIRCLES_DEPTH_MM} mm, \
             then circles of {RADIUS_MM} mm radius at {CIRCLES_HZ} Hz across the press and a tremor \
             of {TREMOR_MM} mm at {TREMOR_HZ} Hz along and across it, {CIRCLES_TICKS} ms in all."
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INWARD: [f64; 3] = [0.0, 0.0, -1.0];
    const STRAIGHT: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 15.0 };

    fn at_mm(motion: Motion, tick: usize) -> Vector3<f64> {
        1e3 * motion.sample(tick, INWARD).position_m.map(f64::from)
    }

    #[test]
    fn a_straight_press_has_its_speed_and_ends_within_its_depth() {
        assert!(at_mm(STRAIGHT, 0).norm() < 1e-12);
        assert!((at_mm(STRAIGHT, 100).z + 8.0).abs() < 1e-6);
        let end = -at_mm(STRAIGHT, STRAIGHT.ticks()).z;
        assert!((14.9..=15.0).contains(&end), "{end}");
    }

    #[test]
    fn circles_begin_straight_and_have_their_radius_and_no_jump() {
        let begin = at_mm(Motion::Circles, 50);
        assert!((begin.z + 2.5).abs() < 1e-6 && begin.xy().norm() < 1e-9, "{begin}");
        let ticks = 0..=Motion::Circles.ticks();
        let places: Vec<Vector3<f64>> = ticks.map(|tick| at_mm(Motion::Circles, tick)).collect();
        let widest = places.iter().map(|at| at.xy().norm()).fold(0.0, f64::max);
        let least = 2.0 * RADIUS_MM - TREMOR_MM;
        assert!((least..least + 2.0 * TREMOR_MM).contains(&widest), "{widest}");
        let step = places.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max);
        assert!(step < 0.15, "{step}");
        // The fastest tremor moves the depth too.
        let depths = places.iter().skip(200).map(|at| -at.z);
        let deepest = depths.fold(0.0, f64::max);
        assert!((deepest - CIRCLES_DEPTH_MM - TREMOR_MM).abs() < 0.01, "{deepest}");
    }
}
