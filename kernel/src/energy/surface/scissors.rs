//! Scissors: two straight blades whose edges cross, and the crossing cuts.
//!
//! Both blades turn about a pivot, by half of the opening angle to either side of -z, in the plane of y and z.
//! Each edge is a line that passes the pivot at the offset. The two lines cross on the axis, at the distance
//!
//! ```text
//! r = offset / sin(opening / 2), at most the length of the blades
//! dr / d opening = -r sqrt(r^2 - offset^2) / (2 offset)
//! ```
//!
//! from the pivot: near it while the scissors are open, at the tip once they are closed. The tissue's force on
//! the edge along -z times dr / d opening is its torque on the handles, by the principle of virtual work.

use crate::number::kept::kept;
use crate::number::sqrt::sqrt;

/// Radians in a count of a pose's opening: 2^-16 of a full turn.
pub(crate) const COUNT_RAD: f32 = core::f32::consts::TAU / 65536.0;

/// The two blades of scissors.
///
/// ```
/// use chaincell_kernel::Scissors;
///
/// let scissors = Scissors { length_m: 0.04, offset_m: 0.004 };
/// assert!((scissors.crossing_m(1.0472) - 0.008).abs() < 1e-6); // [m] from the pivot, open by 60 degrees
/// assert_eq!(scissors.crossing_m(0.0), 0.04); // closed
/// // Tissue of 10 mm thickness and 100 J/m2 presses the edge back with 1 N.
/// let torque_n_m = scissors.opening_torque_n_m(-1.0, 1.0472);
/// assert!((torque_n_m - 0.00693).abs() < 1e-5); // [N m], it resists closing
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scissors {
    /// Length of the blades from the pivot \[m\].
    pub length_m: f32,
    /// Distance of each edge's line from the pivot \[m\], above 0 and below the length.
    pub offset_m: f32,
}

impl Scissors {
    /// Distance of the crossing of the edges from the pivot \[m\]; the opening is 0 to pi \[rad\].
    #[must_use]
    pub fn crossing_m(&self, opening_rad: f32) -> f32 {
        crossing(self.length_m, self.offset_m, 0.5 * opening_rad)
    }

    /// Change of that distance with the opening, never above 0 \[m/rad\]. At the tip it is that of opening.
    #[must_use]
    pub fn slope_m_per_rad(&self, opening_rad: f32) -> f32 {
        slope(self.crossing_m(opening_rad), self.offset_m)
    }

    /// Torque of the tissue on the handles \[N m\], from the tissue's force on the edge in the direction of
    /// cutting, below 0 where it presses the edge back \[N\]. Above 0 it resists closing.
    #[must_use]
    pub fn opening_torque_n_m(&self, forward_n: f32, opening_rad: f32) -> f32 {
        forward_n * self.slope_m_per_rad(opening_rad)
    }
}

/// Distance of the crossing from the pivot, in the unit of the other two lengths.
fn crossing(length: f32, offset: f32, half_rad: f32) -> f32 {
    let sine = sine(half_rad);
    if offset < length * sine { offset / sine } else { length }
}

/// Change of the distance with the opening, in the same unit over rad.
fn slope(crossing: f32, offset: f32) -> f32 {
    let squared = (crossing - offset) * (crossing + offset);
    -0.5 * crossing * sqrt(if squared > 0.0 { squared } else { 0.0 }) / offset
}

/// Sine of an angle from 0 to a quarter turn \[rad\], within 2e-7: the series to the eleventh power.
fn sine(angle_rad: f32) -> f32 {
    let squared = angle_rad * angle_rad;
    let of_parts = [110.0, 72.0, 42.0, 20.0, 6.0];
    angle_rad * of_parts.iter().fold(1.0, |sum, part| 1.0 - squared / part * sum)
}

kept! {
    /// Where the edge of a tool lies on its axis: at the crossing of scissors, at its place for a blade.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct Crossing {
        /// Length and offset of the blades [mean link lengths]; 0 without scissors.
        length: f32,
        offset: f32,
        /// Distance from the pivot, and that of the tool's pose.
        pub at: f32,
        goal: f32,
        /// Motion in this tick.
        pub slid: f32,
        /// Force of the tissue on the edge in the direction of cutting, as published.
        pub push: f32,
    }
}

impl Crossing {
    /// No scissors.
    pub const NONE: Self =
        Self { length: 0.0, offset: 0.0, at: 0.0, goal: 0.0, slid: 0.0, push: 0.0 };

    /// Closed scissors.
    pub fn new(length: f32, offset: f32) -> Self {
        Self { length, offset, at: length, goal: length, ..Self::NONE }
    }

    /// Returns true for scissors.
    pub fn is_any(&self) -> bool {
        self.length > 0.0
    }

    /// Sets the goal from the opening of a pose.
    pub fn aim(&mut self, opening_turns_q16: u16) {
        if self.is_any() {
            let half_rad = 0.5 * COUNT_RAD * f32::from(opening_turns_q16);
            self.goal = crossing(self.length, self.offset, half_rad);
        }
    }

    /// Returns true if it is at its goal.
    pub fn is_there(&self) -> bool {
        self.at == self.goal
    }

    /// Moves it by a share of the way to its goal.
    pub fn go(&mut self, share: f32) {
        let way = self.goal - self.at;
        self.at = if share < 1.0 { self.at + share * way } else { self.goal };
    }

    /// Torque of the tissue on the handles.
    pub fn torque(&self) -> f32 {
        if self.is_any() { self.push * slope(self.at, self.offset) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::PI;

    const SCISSORS: Scissors = Scissors { length_m: 0.04, offset_m: 0.004 };

    #[test]
    fn the_edges_cross_where_their_lines_do() {
        for opening_rad in [0.25, 0.5, 1.0, 1.5, 2.5, PI] {
            let half = 0.5 * f64::from(opening_rad);
            // A point of one edge's line: its distance from the pivot across the line is the offset.
            let r = f64::from(SCISSORS.crossing_m(opening_rad));
            assert!((r * half.sin() - 0.004).abs() < 1e-9, "{opening_rad}: {r}");
        }
        let closed = 2.0 * (0.1_f32).asin();
        assert_eq!(SCISSORS.crossing_m(closed * 0.999), 0.04);
        assert!(SCISSORS.crossing_m(closed * 1.01) < 0.04);
        assert_eq!([0.0, -0.1].map(|rad| SCISSORS.crossing_m(rad)), [0.04; 2]);
    }

    #[test]
    fn the_slope_is_that_of_the_crossing() {
        for opening_rad in [0.25_f32, 0.5, 1.0, 2.0, 3.0] {
            let at = |rad: f64| 0.004 / (0.5 * rad).sin();
            let here = f64::from(opening_rad);
            let wanted = (at(here + 1e-5) - at(here - 1e-5)) / 2e-5;
            let found = f64::from(SCISSORS.slope_m_per_rad(opening_rad));
            assert!((found - wanted).abs() < 1e-4 * wanted.abs() + 1e-7, "{found} {wanted}");
        }
        // At the tip that of opening; wide open the crossing is nearest to the pivot.
        let most = SCISSORS.slope_m_per_rad(0.0);
        assert!(
            (most + 0.5 * 0.04 * (0.04_f32.powi(2) - 0.004_f32.powi(2)).sqrt() / 0.004).abs()
                < 1e-6
        );
        assert!(SCISSORS.slope_m_per_rad(PI).abs() < 1e-5);
        assert!(SCISSORS.opening_torque_n_m(-1.0, 1.0) > 0.0);
    }

    #[test]
    fn the_series_is_the_sine() {
        for step in 0..=1000 {
            let angle_rad = 0.001 * f64::from(step) * std::f64::consts::FRAC_PI_2;
            let apart = f64::from(sine(angle_rad as f32)) - angle_rad.sin();
            assert!(apart.abs() < 2e-7, "{angle_rad}: {apart}");
        }
    }
}
