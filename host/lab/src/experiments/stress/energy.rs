//! The energy of a published state in double precision: what the certified level is held against.

use chaincell_kernel::Model;

use chaincell_host::engine::Engine;

/// What fixed point leaves open of a length [mean link lengths].
pub const FIXED_RESOLUTION: f64 = 8.0 / 16_777_216.0;

/// Sum of k d^2 / 2 in double precision at the published positions \[J\], and its allowance \[J\]:
/// see [`of_positions`].
#[must_use]
pub fn energy_j(engine: &mut Engine<'_>, resolution: f64) -> (f64, f64) {
    let positions_m = engine.positions_m();
    of_positions(engine.network().model(), &positions_m, false, resolution)
}

/// Sum of k d^2 / 2 in double precision \[J\], with the bands as they are or `closed`, and its
/// allowance \[J\]: 4 eps (E + sum of k u d) for the kernel's sum, and what the rounding of each
/// stored coordinate, an eps of it or `resolution` mean link lengths, does to every link.
///
/// Cost: one root a link.
#[must_use]
pub fn of_positions(
    model: &Model<'_>,
    positions_m: &[[f64; 3]],
    closed: bool,
    resolution: f64,
) -> (f64, f64) {
    let eps = f64::from(f32::EPSILON);
    let from_centre = |cell: usize| {
        let away = |axis: usize| positions_m[cell][axis] - f64::from(model.centre_m()[axis]);
        (0..3).map(|axis| away(axis).powi(2)).sum::<f64>().sqrt()
    };
    let (mut energy, mut allowance) = (0.0, 0.0);
    for i in 0..model.cells() {
        for link in model.row(i) {
            let j = usize::from(model.upper()[link]);
            let u: f64 = (0..3)
                .map(|axis| (positions_m[j][axis] - positions_m[i][axis]).powi(2))
                .sum::<f64>()
                .sqrt();
            let l0 = f64::from(model.rest_lengths()[link]) * f64::from(model.unit_m());
            let alpha = if closed { 0.0 } else { f64::from(model.link_alpha(link)) };
            let d = (u - (1.0 + alpha) * l0).max((1.0 - alpha) * l0 - u).max(0.0);
            let k = f64::from(model.link_weight(link)) * f64::from(model.stiffness_n_per_m());
            // A step and its sum with the position round once each.
            let rounding =
                eps * (from_centre(i) + from_centre(j)) + resolution * f64::from(model.unit_m());
            energy += 0.5 * k * d * d;
            allowance += 4.0 * eps * (0.5 * k * d * d + k * u * d);
            allowance += k * rounding * (d + 0.5 * rounding);
        }
    }
    (energy, allowance)
}
