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
//! products and no pass. z.Hz would cost a pass; it is taken as [`CURVATURE`] r.z: M is built from
//! a bound of H, and links resist along their direction only, so about a third of the bound is
//! met. What that guess misses, the next step along s makes good.
//!
//! Source: A. V. Knyazev, Toward the optimal preconditioned eigensolver, 2001 (the local subspace);
//! E. Polak and G. Ribiere, 1969 (z_last . r kept, since H changes from step to step).

/// z.Hz over r.z.
const CURVATURE: f32 = 0.4;
/// Range of alpha and beta.
const ALPHA: [f32; 2] = [0.5, 3.0];
const BETA: [f32; 2] = [-0.5, 1.0];
/// Where the tool has pushed in between, the last way is no secant: the body goes on as it went.
const PUSHED: [f32; 2] = [1.5, 0.75];

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
    /// alpha and beta of this step.
    pub fn choose(&mut self, products: Products) -> [f32; 2] {
        let Products { rz, rs, rz_last } = products;
        let step = match *self {
            Self::None => [1.0, 0.0],
            Self::Pushed => [PUSHED[0], if rs > 0.0 { PUSHED[1] } else { 0.0 }],
            Self::Secant(before) => secant(rz, rs, rz_last, before),
        };
        *self = Self::Secant(step[0] * rz + step[1] * rs);
        step
    }
}

/// The local minimum of the model, in units of r.z, which may be as small as floats get.
fn secant(rz: f32, rs: f32, rz_last: f32, before: f32) -> [f32; 2] {
    let (along, mixed, curved) = (rs / rz, (rz_last - rz) / rz, (before - rs) / rz);
    let finite = along.is_finite() && mixed.is_finite() && curved.is_finite();
    // Not convex on the last way: forget it.
    if !finite || curved <= 0.0 {
        return [1.0, 0.0];
    }
    let (full, floor) = (CURVATURE * curved - mixed * mixed, 0.1 * CURVATURE * curved);
    let alpha = clamp((curved - along * mixed) / if full > floor { full } else { floor }, ALPHA);
    [alpha, clamp((along - alpha * mixed) / curved, BETA)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_solved_in_its_subspace() {
        // H = diag(0.4, 0.1) along z = (1, 0) and s = (0, 1), r = (1, 0.05): r.z = 1.
        let mut last = Last::Secant(0.05 + 0.1);
        let [alpha, beta] = last.choose(Products { rz: 1.0, rs: 0.05, rz_last: 1.0 });
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
            assert_eq!(Last::Secant(before).choose(Products { rz, rs, rz_last }), [1.0, 0.0]);
        }
        let any = Products { rz: 1.0, rs: -1.0, rz_last: 0.0 };
        assert_eq!(Last::None.choose(any), [1.0, 0.0]);
        assert_eq!(Last::Pushed.choose(any), [PUSHED[0], 0.0]);
        assert_eq!(Last::Pushed.choose(Products { rs: 1.0, ..any }), PUSHED);
    }
}
