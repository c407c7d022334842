//! Branches and bands of a tissue as texts of the command line.

use crate::bake::tissue::{Band, Branch};

/// Value of `--branch`.
#[derive(Debug, Clone, Copy)]
pub struct BranchOrNone(pub Option<Branch>);

/// Value of `--stiffening`.
#[derive(Debug, Clone, Default)]
pub struct Bands(pub Vec<Band>);

/// Reads bands with commas, or `none`.
pub fn stiffening(text: &str) -> Result<Bands, String> {
    if text == "none" {
        return Ok(Bands::default());
    }
    text.split(',').map(str::parse).collect::<Result<_, _>>().map(Bands)
}

/// Reads a branch, or `none`.
pub fn branch(text: &str) -> Result<BranchOrNone, &'static str> {
    if text == "none" {
        return Ok(BranchOrNone(None));
    }
    let numbers = text.split_once(',').map(|(ratio, time_s)| {
        [ratio, time_s].map(|number| number.trim().parse::<f64>().ok().filter(|x| x.is_finite()))
    });
    match numbers {
        Some([Some(ratio), Some(time_s)]) => Ok(BranchOrNone(Some(Branch { ratio, time_s }))),
        _ => Err("give G,TAU, a ratio of shear moduli and a time in seconds, as 2,0.1; or none"),
    }
}
