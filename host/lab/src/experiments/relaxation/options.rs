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
    let branches: Vec<[f64; 2]> = found.branches.iter().map(|of| of.map(rounded)).collect();
    let bands = found.stiffening.iter().filter(|_| is_stress);
    let bands: Vec<Band> = bands.map(|&[width, pa]| Band::new(width, rounded(pa))).collect();
    let young_pa = if is_stress { rounded(found.modulus) } else { YOUNG_PA };
    let young = if is_stress { format!("--young-pa {young_pa}") } else { String::new() };
    let text = young + &tissue_options(&branches, false, &bands);
    // A bake of a small body.
    let branches = branches.into_iter().map(|[ratio, time_s]| Branch { ratio, time_s }).collect();
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

/// Returns a number with five digits, as the options have it.
#[must_use]
pub fn rounded(number: f64) -> f64 {
    format!("{number:.4e}").parse().unwrap_or(number)
}
