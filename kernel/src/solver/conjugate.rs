//! How far to go along the new direction and along the last one.
//!
//! The state goes from y along z (the preconditioned residual, z = M r) and s (the last way
//! taken): y' = y + alpha z + beta s. In the quadratic model of the energy the best pair solves
//!
//! ```text
//! | z.Hz  z.Hs | |alpha|   | r.z |
//! | z.Hs  s.Hs | |beta |  = | r.s |
//! ```
//!
//! the locally optimal form of conjugate gradients. H s is the change of the residual on the last
//! way, so s.Hs = s . (r_last - r) and z.Hs = z . (r_last - r) = z_last . r - z . r cost two inner
//! products and no pass. z.Hz would cost a pass; it is taken as a part of r.z. Where M is built from
//! a bound of H that is [`BOUNDED`]: links resist along their direction only, so about a third of
//! the bound is met. Where M follows H itself it is 1 to 2, as far as both parts of M take the same
//! motion, and more in a body that is stiffer than at rest: a [`Guess`] rises with every pass that
//! is discarded, and falls back slowly. What it misses, the next step along s makes good.
//!
//! Source: A. V. Knyazev, Toward the optimal preconditioned eigensolver, 2001 (the local subspace);
//! E. Polak and G. Ribiere, 1969 (z_last . r kept, since H changes from step to step).

use crate::number::kept::{Kept, Pass, kept, named};

/// z.Hz over r.z of a direction that is within the bound of the curvature.
pub(super) const BOUNDED: f32 = 0.4;
/// Range of alpha, for that curvature, and of beta.
const ALPHA: [f32; 2] = [0.5, 3.0];
const BETA: [f32; 2] = [-0.5, 1.0];
/// Where the tool has pushed in between, the last way is no secant: the body goes on as it went, with
/// this alpha for that curvature, and this beta.
pub(super) const PUSHED: f32 = 1.5;
const GOES_ON: f32 = 0.75;
/// The alpha where a sphere has pushed the surface: the direction is mostly the sphere's doing.
pub(super) const PUSHED_BY_SPHERE: f32 = 2.5;
/// What a sphere adds to z.Hz over r.z: both parts of M take the motion of the surface under it.
pub(super) const OF_SPHERE: f32 = 0.5;

/// Inner products of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Products {
    /// r . z.
    pub rz: f32,
    /// r . s, s = the last way.
    pub rs: f32,
    /// r . `z_last`.
    pub rz_last: f32,
}

/// What the next choice needs of the last one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Last {
    /// There is no last way.
    None,
    /// `r_last` . s as the last pass had it.
    Secant(f32),
    /// The tool pushed since.
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
    /// alpha and beta of this step along a direction of so much z.Hz over r.z; `pushed` is the alpha
    /// behind a push, for the curvature of [`BOUNDED`].
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

/// A step along z alone that the guess does not take too far.
fn careful(curvature: f32) -> f32 {
    let alpha = BOUNDED / curvature;
    if alpha < 1.0 { alpha } else { 1.0 }
}

/// The local minimum of the model, in units of r.z, which may be as small as floats get.
fn secant(products: Products, before: f32, curvature: f32) -> [f32; 2] {
    let Products { rz, rs, rz_last } = products;
    let (along, mixed, curved) = (rs / rz, (rz_last - rz) / rz, (before - rs) / rz);
    let finite = along.is_finite() && mixed.is_finite() && curved.is_finite();
    // Not convex on the last way: forget it.
    if !finite || curved <= 0.0 {
        return [careful(curvature), 0.0];
    }
    let (full, floor) = (curvature * curved - mixed * mixed, 0.1 * curvature * curved);
    let range = ALPHA.map(|alpha| alpha * (BOUNDED / curvature));
    let alpha = clamp((curved - along * mixed) / if full > floor { full } else { floor }, range);
    [alpha, clamp((along - alpha * mixed) / curved, BETA)]
}

/// z.Hz over r.z of a direction that follows H, as far as the guard has let it: what it is above
/// that of a body that is as stiff as at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Guess(f32);

kept!(Guess { 0: f32 });

impl Guess {
    /// That of a body that is as stiff as at rest.
    pub const REST: Self = Self(0.0);
    /// With it the guard discards few passes.
    const AT_REST: f32 = 1.5;
    /// Beyond it a step is not worth its pass.
    const MOST: f32 = 20.0;
    /// Of what it has risen a pass leaves so much. A body that is stiffer than at rest stays so for
    /// as long as the tool presses: a guess that falls back within fewer passes is wrong over and
    /// over, and each time costs a pass.
    const KEPT: f32 = 0.999;

    /// How much steeper a direction is taken to be than it was, behind a pass that was discarded, and
    /// where a tool had pushed the surface in between.
    const RISE: f32 = 2.0;
    const RISE_PUSHED: f32 = 1.15;
    /// Of what it has risen a pass under such a tool leaves so much: what the tool meets changes as it
    /// goes, and a guess that stays high makes the body lag behind it.
    const KEPT_PUSHED: f32 = 0.99;

    pub fn value(self) -> f32 {
        Self::AT_REST + self.0
    }

    fn rise(&mut self, factor: f32) {
        let more = factor * self.value();
        self.0 = (if more < Self::MOST { more } else { Self::MOST }) - Self::AT_REST;
    }

    /// After a pass behind a push of the surface that the guard discarded.
    pub fn judge_pushed(&mut self) {
        self.rise(Self::RISE_PUSHED);
    }

    /// After a pass under a tool on the surface that it did not.
    pub fn fall_back(&mut self) {
        self.0 *= Self::KEPT_PUSHED;
    }

    /// After a pass: whether the guard discarded it.
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
