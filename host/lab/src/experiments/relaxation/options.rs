//! Options of a bake of the tissue that a curve was found to be of.

use super::Found;
use chaincell_host::bake::tissue::{Band, Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell, bake};
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
    let branches: Vec<Branch> = (found.branches.iter())
        .map(|&[ratio, time_s]| Branch { ratio: rounded(ratio), time_s: rounded(time_s) })
        .collect();
    let bands: Vec<Band> = (found.stiffening.iter().filter(|_| is_stress))
        .map(|&[half_width, modulus]| Band { half_width, modulus_pa: rounded(modulus) })
        .collect();
    let young_pa = if is_stress { rounded(found.modulus) } else { YOUNG_PA };
    // A bake of a small body.
    let mut text = if is_stress { format!("--young-pa {young_pa}") } else { String::new() };
    for Branch { ratio, time_s } in &branches {
        text += &format!(" --branch {ratio},{time_s}");
    }
    let of_bands = bands.iter().map(|band| format!("{}={}", band.half_width, band.modulus_pa));
    let of_bands: Vec<String> = of_bands.collect();
    if !bands.is_empty() {
        text += &format!(" --stiffening {}", of_bands.join(","));
    }
    let relaxation = Relaxation { branches, is_instant: false, device_hz: DEVICE_HZ };
    let uniform = Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(0.45));
    let tissue = Tissue { stiffening: bands, relaxation: Some(relaxation), ..uniform };
    let mesh = load("box:3x3x3x0.01", &MeshOptions::default())?;
    let tried = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
    bake(&mesh, &mesh.default_fixed, &tried)?;
    Ok(text.trim_start().to_owned())
}

/// A number of five digits.
fn rounded(number: f64) -> f64 {
    format!("{number:.4e}").parse().unwrap_or(number)
}
