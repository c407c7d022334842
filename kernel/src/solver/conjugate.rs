//! Step lengths along the new direction and along the last step.
//!
//! The state moves from y along z (the preconditioned residual, z = M r) and s (the last step): y' = y +
//! alpha z + beta s. In the quadratic model of the energy the best pair solves
//!
//! ```text
//! | z.Hz  z.Hs | |alpha|   | r.z |
//! | z.Hs  s.Hs | |beta |  = | r.s |
//! ```
//!
//! the locally optimal form of conjugate gradients. H s is the change of the residual over the last step, so
//! s.Hs = s . (r_last - r) and z.Hs = z . (r_last - r) = z_last . r - z . r cost two inner products and no
//! pass. z.Hz would cost a pass; it is estimated as a multiple of r.z. If M is built from a bound of H, the
//! factor is [`BOUNDED`]: links resist only along their direction, so about a third of the bound is reached.
//! If M follows H itself, the factor is 1 to 2, since both parts of M contain the same motion, and more in a
//! body that is stiffer than at rest: a [`Guess`] rises with every discarded pass and falls slowly. The next
//! step along s corrects its error.
//!
//! Source: A. V. Knyazev, Toward the optimal preconditioned eigensolver, 2001 (the local subspace);
//! E. Polak and G. Ribiere, 1969 (z_last . r kept, since H changes from step to step).

use crate::number::kept::{Kept, Pass, kept, named};

/// z.Hz over r.z of a direction whose curvature is bounded.
pub(super) const BOUNDED: f32 = 0.4;
/// Range of alpha, for that curvature, and range of beta.
const ALPHA: [f32; 2] = [0.5, 3.0];
const BETA: [f32; 2] = [-0.5, 1.0];
/// If the tool moved in between, no secant is available: this alpha, for that curvature, and this beta.
pub(super) const PUSHED: f32 = 1.5;
const GOES_ON: f32 = 0.75;
/// The alpha after a tool has pushed the surface: the direction is mostly due to the tool.
pub(super) const PUSHED_BY_SPHERE: f32 = 2.2;
/// Increase of z.Hz over r.z under a tool: both parts of M contain the motion of the surface under it.
pub(super) const OF_SPHERE: f32 = 0.5;

/// Inner products of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Products {
    /// r . z.
    pub rz: f32,
    /// r . s, s = the last step.
    pub rs: f32,
    /// r . `z_last`.
    pub rz_last: f32,
}

/// The last step, as the next choice needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Last {
    /// There is no last step.
    None,
    /// `r_last` . s of the last pass.
    Secant(f32),
    /// The tool has moved since.
    Pushed,
}

impl Kept for Last {
    const LAYOUT: u32 = named(0, "none, secant, pushed");
    const BLANK: Self = Self::None;

    fn keep(&mut self, pass: &mut Pass<'_>) {
        let (mut which, mut secant) = match *self {
            Self::None => (0_u8, 0.0),
            Self::Secant(secant) => (1, secant),
            Self::Pushed => (2, 0.0),
        };
        which.keep(pass);
        secant.keep(pass);
        *self = match which {
            0 => Self::None,
            1 => Self::Secant(secant),
            2 => Self::Pushed,
            _ => return pass.refuse(),
        };
    }
}

#[inline]
fn clamp(value: f32, [low, high]: [f32; 2]) -> f32 {
    if value > high {
        high
    } else if value > low {
        value
    } else {
        low
    }
}

impl Last {
    /// Returns alpha and beta along a direction whose z.Hz over r.z is `curvature`; `pushed` is the alpha
    /// after a tool push, for the curvature [`BOUNDED`].
    #[inline]
    pub fn choose(&mut self, products: Products, curvature: f32, pushed: f32) -> [f32; 2] {
        let Products { rz, rs, .. } = products;
        let step = match *self {
            Self::None => [careful(curvature), 0.0],
            Self::Pushed => {
                let alpha = pushed * (BOUNDED / curvature);
                [alpha, if rs > 0.0 { GOES_ON } else { 0.0 }]
            }
            Self::Secant(before) => secant(products, before, curvature),
        };
        *self = Self::Secant(step[0] * rz + step[1] * rs);
        step
    }
}

/// A step along z alone that is not longer than the estimate allows.
fn careful(curvature: f32) -> f32 {
    let alpha = BOUNDED / curvature;
    if alpha < 1.0 { alpha } else { 1.0 }
}

/// The local minimum of the model, in units of r.z, which may be as small as floats get.
fn secant(products: Products, before: f32, curvature: f32) -> [f32; 2] {
    let Products { rz, rs, rz_last } = products;
    let (along, mixed, curved) = (rs / rz, (rz_last - rz) / rz, (before - rs) / rz);
    let finite = along.is_finite() && mixed.is_finite() && curved.is_finite();
    // Not convex along the last step: ignore it.
    if !finite || curved <= 0.0 {
        return [careful(curvature), 0.0];
    }
    let (full, floor) = (curvature * curved - mixed * mixed, 0.1 * curvature * curved);
    let range = ALPHA.map(|alpha| alpha * (BOUNDED / curvature));
    let alpha = clamp((curved - along * mixed) / if full > floor { full } else { floor }, range);
    [alpha, clamp((along - alpha * mixed) / curved, BETA)]
}

/// Estimate of z.Hz over r.z of a direction that follows H, from the guard's decisions: its excess over the
/// value of a body at rest stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Guess(f32);

kept!(Guess { 0: f32 });

impl Guess {
    /// Excess of a body at rest stiffness.
    pub const REST: Self = Self(0.0);
    /// With this value the guard discards few passes.
    const AT_REST: f32 = 1.5;
    /// Beyond it a step is not worth its pass.
    const MOST: f32 = 20.0;
    /// Share of the excess that remains after a pass. A body that is stiffer than at rest stays so while the
    /// tool presses: an estimate that falls within fewer passes is wrong again and again, and each time costs
    /// a pass.
    const KEPT: f32 = 0.999;

    /// Factors by which a discarded pass raises the estimate, the second if a tool had pushed the surface in
    /// between.
    const RISE: f32 = 2.0;
    const RISE_PUSHED: f32 = 1.15;
    /// Share of the excess that remains after a pass under such a tool: the contact changes as the tool
    /// moves, and an estimate that stays high makes the body lag.
    const KEPT_PUSHED: f32 = 0.99;

    pub fn value(self) -> f32 {
        Self::AT_REST + self.0
    }

    fn rise(&mut self, factor: f32) {
        let more = factor * self.value();
        self.0 = (if more < Self::MOST { more } else { Self::MOST }) - Self::AT_REST;
    }

    /// Raises the estimate after a discarded pass that followed a push of the surface.
    pub fn judge_pushed(&mut self) {
        self.rise(Self::RISE_PUSHED);
    }

    /// Lowers the estimate after an accepted pass under a tool on the surface.
    pub fn fall_back(&mut self) {
        self.0 *= Self::KEPT_PUSHED;
    }

    /// Adjusts the estimate after a pass.
    pub fn judge(&mut self, is_discarded: bool) {
        if is_discarded {
            self.rise(Self::RISE);
        } else {
            self.0 *= Self::KEPT;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_solved_in_its_subspace() {
        // H = diag(0.4, 0.1) along z = (1, 0) and s = (0, 1), r = (1, 0.05): r.z = 1.
        let mut last = Last::Secant(0.05 + 0.1);
        let [alpha, beta] =
            last.choose(Products { rz: 1.0, rs: 0.05, rz_last: 1.0 }, BOUNDED, PUSHED);
        assert!((alpha - 2.5).abs() < 1e-5 && (beta - 0.5).abs() < 1e-5, "{alpha} {beta}");
        assert_eq!(last, Last::Secant(alpha + beta * 0.05));
    }

    #[test]
    fn what_cannot_be_used_is_forgotten() {
        for (rz, rs, rz_last, before) in [
            (0.0, 0.0, 0.0, 0.0),
            (1e-45, 1.0, 1.0, 2.0),
            (1.0, 0.5, 0.0, 0.1),
            (1.0, f32::NAN, 0.0, 1.0),
        ] {
            assert_eq!(
                Last::Secant(before).choose(Products { rz, rs, rz_last }, BOUNDED, PUSHED),
                [1.0, 0.0]
            );
        }
        let any = Products { rz: 1.0, rs: -1.0, rz_last: 0.0 };
        assert_eq!(Last::None.choose(any, BOUNDED, PUSHED), [1.0, 0.0]);
        assert_eq!(Last::Pushed.choose(any, BOUNDED, PUSHED), [PUSHED, 0.0]);
        assert_eq!(
            Last::Pushed.choose(Products { rs: 1.0, ..any }, BOUNDED, PUSHED),
            [PUSHED, GOES_ON]
        );
    }

    #[test]
    fn a_guess_shortens_steps_and_falls_back() {
        let mut guess = Guess::REST;
        let any = Products { rz: 1.0, rs: 1.0, rz_last: 0.0 };
        let [first, _] = Last::Pushed.choose(any, guess.value(), PUSHED);
        assert!((first - 0.4).abs() < 1e-6, "{first}");
        (0..20).for_each(|_| guess.judge(true));
        assert_eq!(guess.value(), Guess::MOST);
        let [alpha, beta] = Last::Pushed.choose(any, guess.value(), PUSHED);
        assert!((alpha - 0.03).abs() < 1e-6 && beta == GOES_ON, "{alpha} {beta}");
        assert!((Last::None.choose(any, guess.value(), PUSHED)[0] - 0.02).abs() < 1e-6);
        (0..10_000).for_each(|_| guess.judge(false));
        assert!((guess.value() - 1.5).abs() < 1e-3);
    }
}
