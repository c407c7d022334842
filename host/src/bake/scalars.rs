//! The scalars of a body: units, bounds and counts.

use chaincell_kernel::image::params;

use super::layout::{OrderedCells, holds_units};
use super::options::BakeOptions;
use crate::error::{Error, Result};

/// First value beyond the kernel's range of K [mean link lengths].
const SATURATION_END: f64 = 9.99e5;
/// The kernel's range of the largest energy [internal units].
const ENERGY_MIN: f64 = 1e-30;
const ENERGY_END: f64 = 9.99e17;

/// Returns the scalars of the body; `nodes` is the number of the input's nodes.
///
/// # Errors
/// A saturation below twice the largest coordinate, or units out of range.
pub(super) fn scalars(
    nodes: usize,
    body: &OrderedCells,
    options: &BakeOptions,
    weights: &[f32],
    degree_bound: f32,
    alpha: f32,
    stiffness_n_per_m: f32,
) -> Result<[u32; params::WORDS]> {
    let unit_m = f64::from(body.unit_m);
    if !holds_units(body.unit_m, stiffness_n_per_m) {
        return Err(Error::input(format!(
            "`stiffness_n_per_m` {stiffness_n_per_m} with links of {unit_m} m: forces or energies \
             leave the range of single precision; check `unit_m`"
        )));
    }
    // The saturation and the largest energy.
    let largest = body.rest.as_flattened().iter().fold(0.0_f32, |a, &x| a.max(x.abs()));
    let saturation = match options.saturation_m {
        None => 4.0 * largest,
        Some(k_m) if (2.0 * f64::from(largest)..SATURATION_END).contains(&(k_m / unit_m)) => {
            (k_m / unit_m) as f32
        }
        Some(k_m) => {
            return Err(Error::input(format!(
                "`saturation_m` {k_m}: must be at least twice the largest coordinate from the body's \
                 centre, {}, and below {} ({SATURATION_END:e} mean link lengths)",
                2.0 * f64::from(largest) * unit_m,
                SATURATION_END * unit_m
            )));
        }
    };
    let energy_max = match options.energy_max_j {
        Some(joule) => {
            let unit_j = 2.0 * f64::from(stiffness_n_per_m) * unit_m * unit_m;
            if !(ENERGY_MIN..ENERGY_END).contains(&(joule / unit_j)) {
                return Err(Error::input(format!(
                    "`energy_max_j` {joule:e}: must be from {:e} to {:e} for this body",
                    ENERGY_MIN * unit_j,
                    ENERGY_END * unit_j
                )));
            }
            (joule / unit_j) as f32
        }
        // That of eight cells of the largest weight, each displaced by the width of the body.
        None => 8.0 * weights.iter().copied().fold(0.0, f32::max) * largest * largest,
    };
    // The words of the section.
    let mut words = [0; params::WORDS];
    let mut real = |word: usize, value: f32| words[word] = value.to_bits();
    real(params::UNIT_M, body.unit_m);
    for (axis, &x) in body.centre_m.iter().enumerate() {
        real(params::CENTRE_M + axis, x);
    }
    real(params::STIFFNESS_N_PER_M, stiffness_n_per_m);
    real(params::ALPHA, alpha);
    real(params::SATURATION, saturation);
    real(params::RESISTANCE, options.resistance as f32);
    real(params::CAPACITANCE, options.capacitance as f32);
    real(params::DEGREE_BOUND, degree_bound);
    real(params::ENERGY_MAX, energy_max);
    words[params::CELLS] = body.all_cells() as u32;
    words[params::LINKS] = body.links.len() as u32;
    words[params::DIMENSION] = dimension(body);
    words[params::PARTS] = parts(body) as u32;
    words[params::INPUT_NODES] = nodes as u32;
    Ok(words)
}

/// Returns the number of axes along which the rest shape has an extent.
fn dimension(body: &OrderedCells) -> u32 {
    let extended = |axis: usize| body.rest.iter().any(|p| p[axis] != body.rest[0][axis]);
    (0..3).filter(|&axis| extended(axis)).count().max(1) as u32
}

/// Returns the number of connected parts.
fn parts(body: &OrderedCells) -> usize {
    let mut parent: Vec<usize> = (0..body.rest.len()).collect();
    let mut parts = parent.len();
    for &([i, j], _) in &body.links {
        let (a, b) = (root(&mut parent, i.into()), root(&mut parent, j.into()));
        if a != b {
            parent[a] = b;
            parts -= 1;
        }
    }
    parts
}

fn root(parent: &mut [usize], mut of: usize) -> usize {
    while parent[of] != of {
        parent[of] = parent[parent[of]];
        of = parent[of];
    }
    of
}
