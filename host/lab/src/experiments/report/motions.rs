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
/// How long a press is held \[s\].
const HELD_S: f64 = 0.15;
/// How a slide begins: from this distance before the touch to this depth, in this time.
const SLIDE_FROM_MM: f64 = -2.0;
const SLIDE_TO_MM: f64 = 8.0;
const SLIDE_BEGIN_S: f64 = 0.15;
/// Speed aside, and how long it goes away \[s\].
const SLIDE_MM_PER_S: f64 = 100.0;
const SLIDE_AWAY_S: f64 = 0.25;
/// Ticks of a slide.
const SLIDE_TICKS: usize = 600;
/// Frequency and phase of a slide's tremor, inwards, along and across the slide.
const SLIDE_TREMOR: [[f64; 2]; 3] = [[9.0, 0.0], [11.0, 1.0], [8.0, 2.0]];
/// How long that tremor takes to be whole \[s\].
const SLIDE_GROW_S: f64 = 0.05;

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
    /// Straight in, from a distance before the touch if it is negative, then held for [`HELD_S`].
    Press {
        /// Where it begins \[mm\].
        from_mm: f64,
        /// Where it ends \[mm\].
        to_mm: f64,
        /// In this time \[s\].
        press_s: f64,
    },
    /// Straight in, then aside and half of the way back at 0.1 m/s, with a tremor.
    Slide,
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
            Self::Press { press_s, .. } => ((press_s + HELD_S) / TICK_S).round() as usize,
            Self::Slide => SLIDE_TICKS,
        }
    }

    /// The tool at a tick, with `inward` of length 1; at tick 0 it takes hold.
    pub fn sample(self, tick: usize, inward: [f64; 3]) -> ToolPose {
        let way_mm = self.way_mm(tick as f64 * TICK_S, Vector3::from(inward));
        ToolPose::at(way_mm.map(|x| (1e-3 * x) as f32), 1)
    }

    fn way_mm(self, time_s: f64, inward: Vector3<f64>) -> Vector3<f64> {
        let axis = if inward.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let side = inward.cross(&axis).normalize();
        let other = inward.cross(&side);
        let speed_mm_per_s = match self {
            Self::Straight { speed_mm_per_s, .. } => return speed_mm_per_s * time_s * inward,
            Self::Press { from_mm, to_mm, press_s } => {
                return (from_mm + (to_mm - from_mm) * (time_s / press_s).min(1.0)) * inward;
            }
            Self::Slide => {
                let [depth_mm, along_mm, across_mm] = slide_mm(time_s);
                return depth_mm * inward + along_mm * side + across_mm * other;
            }
            Self::Circles => CIRCLES_SPEED_MM_PER_S,
        };
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
            Self::Press { from_mm, to_mm, press_s } => {
                let ms = 1e3 * press_s;
                format!("{:.0} mm in {ms:.0} ms, to {to_mm:.0} mm deep", to_mm - from_mm)
            }
            Self::Slide => "slides and trembles at 0.1 m/s".to_owned(),
        }
    }

    /// What the slide is, for the text of a report.
    pub const SLIDES: &str = "Presses are held for 150 ms. The slide: in to 8 mm in 150 ms, then aside at \
                              0.1 m/s for 250 ms and back for 200 ms, with a tremor of 0.3 mm at 8 to 11 Hz.";

    /// What the motions are, for the text of a report.
    pub fn description() -> String {
        format!(
            "Circles with tremor: in at {CIRCLES_SPEED_MM_PER_S} mm/s to {CIRCLES_DEPTH_MM} mm, \
             then circles of {RADIUS_MM} mm radius at {CIRCLES_HZ} Hz across the press and a tremor \
             of {TREMOR_MM} mm at {TREMOR_HZ} Hz along and across it, {CIRCLES_TICKS} ms in all."
        )
    }
}

/// Place of a slide after this time, inwards, along and across the slide \[mm\].
fn slide_mm(time_s: f64) -> [f64; 3] {
    let part = (time_s / SLIDE_BEGIN_S).min(1.0);
    let slid_s = (time_s - SLIDE_BEGIN_S).max(0.0);
    let (away_s, back_s) = (slid_s.min(SLIDE_AWAY_S), (slid_s - SLIDE_AWAY_S).max(0.0));
    let way_mm = [
        SLIDE_FROM_MM + (SLIDE_TO_MM - SLIDE_FROM_MM) * part,
        SLIDE_MM_PER_S * (away_s - back_s),
        0.0,
    ];
    let grown = (slid_s / SLIDE_GROW_S).min(1.0);
    std::array::from_fn(|axis| {
        let [hz, phase] = SLIDE_TREMOR[axis];
        let tremor = (TAU * hz * time_s + phase).sin() - phase.sin();
        way_mm[axis] + grown * TREMOR_MM * tremor
    })
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

    #[test]
    fn a_press_stops_and_a_slide_comes_half_of_the_way_back_at_its_speed() {
        let press = Motion::Press { from_mm: -20.0, to_mm: 23.0, press_s: 0.15 };
        assert_eq!(press.ticks(), 300);
        let depths = [0, 150, 300].map(|tick| -at_mm(press, tick).z);
        assert!((depths[0] + 20.0).abs() < 1e-5 && (depths[1] - 23.0).abs() < 1e-5, "{depths:?}");
        assert_eq!(depths[1], depths[2]);
        let ticks = 0..=Motion::Slide.ticks();
        let places: Vec<Vector3<f64>> = ticks.map(|tick| at_mm(Motion::Slide, tick)).collect();
        let aside = |tick: usize| places[tick].xy().norm();
        assert!(aside(150) < 1e-6 && (aside(400) - 25.0).abs() < 1.0, "{}", aside(400));
        assert!((aside(600) - 5.0).abs() < 1.0, "{}", aside(600));
        let steps = places[200..].windows(2).map(|pair| (pair[1] - pair[0]).norm());
        let step = steps.fold(0.0, f64::max);
        assert!(0.1 < step && step < 0.15, "{step}");
    }
}
