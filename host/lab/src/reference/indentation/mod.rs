//! A smooth rigid sphere pressed into a round slab: force and energy by finite elements in double
//! precision.
//!
//! The slab turns around the sphere's way, so a half section is enough: quadrilaterals of eight nodes
//! with nine integration points, fine near the sphere and coarser away from it. Its bottom is held,
//! side and top are free. The top's points meet the sphere without friction, by a penalty so stiff
//! that it gives way by a small part of the depth. Each depth is a minimum of the energy, found by
//! Newton's method from the one before.

mod band;
mod descent;
mod element;
mod grid;
mod law;
mod sphere;
#[cfg(test)]
mod tests;

use chaincell_host::error::{Error, Result};
use descent::Section;
pub use law::Law;
use law::Moduli;
use sphere::Sphere;

/// Elements of `element_m` reach so many radii of the circle in which the sphere cuts the height of
/// the top at last.
const FINE: f64 = 1.25;
/// The sphere goes by so many radii between two minima, at most.
const STRIDE: f64 = 0.05;
/// Pressure of the penalty at a depth of an element [Young's moduli].
const PENALTY: f64 = 400.0;

/// A round slab, held at its bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Radius \[m\].
    pub radius_m: f64,
    /// Height \[m\].
    pub height_m: f64,
    /// Young's modulus \[Pa\].
    pub young_pa: f64,
    /// Poisson's ratio, from 0 to below 0.5.
    pub poisson: f64,
    /// How the material answers strain.
    pub law: Law,
}

/// The sphere at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Press {
    /// How far the sphere is from where it first touches the top \[m\].
    pub depth_m: f64,
    /// Force on the sphere along its way back \[N\].
    pub force_n: f64,
    /// Energy of the slab and of the penalty \[J\].
    pub energy_j: f64,
    /// Distance from the axis of the outermost point that touches, at rest \[m\].
    pub contact_m: f64,
    /// Deepest point in the sphere: what the penalty gives way \[m\].
    pub into_m: f64,
}

/// Presses a sphere into a slab to each of the depths, which rise; elements of `element_m` near it.
///
/// Cost: a second at 12 elements in a sphere's radius, four times that at twice as many.
///
/// # Errors
/// A length, modulus or depth out of its range; an equilibrium that was not found.
pub fn press(slab: &Slab, sphere_m: f64, element_m: f64, depths_m: &[f64]) -> Result<Vec<Press>> {
    let lengths = [slab.radius_m, slab.height_m, slab.young_pa, sphere_m, element_m];
    if !lengths.iter().all(|x| *x > 0.0 && x.is_finite()) || !(0.0..0.5).contains(&slab.poisson) {
        return Err(Error::input(format!(
            "{slab:?}, a sphere of {sphere_m} m, elements of {element_m} m: all of them above 0, \
             Poisson's ratio from 0 to below 0.5"
        )));
    }
    let shape = [slab.radius_m, slab.height_m];
    let deepest_m = depths_m.iter().copied().fold(0.0, f64::max).min(sphere_m);
    let circle_m = (deepest_m * (2.0 * sphere_m - deepest_m)).sqrt();
    let grid = grid::Grid::new(shape, FINE * circle_m, element_m);
    let mut section = Section::new(grid, Moduli::new(slab.young_pa, slab.poisson), slab.law);
    let sphere = |depth_m: f64| Sphere {
        radius_m: sphere_m,
        centre_m: slab.height_m + sphere_m - depth_m,
        stiffness: PENALTY * slab.young_pa / element_m,
        turns_m: element_m / PENALTY,
    };
    let mut reached_m = 0.0;
    let mut presses = Vec::new();
    for &depth_m in depths_m {
        if !(depth_m >= reached_m && depth_m < slab.height_m) {
            return Err(Error::input(format!(
                "depth {depth_m} m: rising from 0 to below the height {} m",
                slab.height_m
            )));
        }
        let strides = ((depth_m - reached_m) / (STRIDE * sphere_m)).ceil().max(1.0);
        for stride in 1..=strides as u32 {
            let depth_m = reached_m + f64::from(stride) / strides * (depth_m - reached_m);
            section.settle(&sphere(depth_m))?;
        }
        reached_m = depth_m;
        presses.push(section.press(&sphere(depth_m), depth_m));
    }
    Ok(presses)
}
