//! Options of a bake of the tissue that a curve was found to be of.

use super::Found;
use chaincell_host::bake::tissue::{Band, Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell, bake};
use chaincell_host::cli::values::tissue_options;
use chaincell_host::error::Result;
use chaincell_host::mesh::{MeshOptions, load};

/// Young's modulus of the body that is tried \[Pa\], if the curve has forces.
const YOUNG_PA: f64 = 1000.0;

/// Returns the options, with numbers of five digits; of a curve of forces those of the branches alone.
///
/// # Errors
/// What a bake refuses of them: a small body is baked. Cost: milliseconds.
pub fn options(found: &Found) -> Result<String> {
    let is_stress = found.unit == "Pa";
    let (branches, mut bands) = rounded_parts(found);
    if !is_stress {
        bands.clear();
    }
    let young_pa = if is_stress { rounded(found.modulus) } else { YOUNG_PA };
    let young = if is_stress { format!("--young-pa {young_pa}") } else { String::new() };
    let pairs: Vec<[f64; 2]> = branches.iter().map(|of| [of.ratio, of.time_s]).collect();
    let text = young + &tissue_options(&pairs, false, &bands);
    // A bake of a small body.
    let relaxation = Relaxation { branches, is_instant: false, device_hz: DEVICE_HZ };
    let tissue = Tissue {
        stiffening: bands,
        relaxation: Some(relaxation),
        ..Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(0.45))
    };
    let mesh = load("box:3x3x3x0.01", &MeshOptions::default())?;
    let tried = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
    bake(&mesh, &mesh.default_fixed, &tried)?;
    Ok(text.trim_start().to_owned())
}

/// Returns the branches and the bands that were found, with numbers of five digits.
#[must_use]
pub fn rounded_parts(found: &Found) -> (Vec<Branch>, Vec<Band>) {
    let branches = found.branches.iter().map(|of| of.map(rounded));
    let branches = branches.map(|[ratio, time_s]| Branch { ratio, time_s }).collect();
    let bands = found.stiffening.iter();
    (branches, bands.map(|&[width, pa]| Band::new(width, rounded(pa))).collect())
}

/// Returns a number with five digits, as the options have it.
#[must_use]
pub fn rounded(number: f64) -> f64 {
    format!("{number:.4e}").parse().unwrap_or(number)
}
