//! Reading a baked model, with errors that name the file.

use std::io::Read;
use std::path::Path;

use chaincell_kernel::Model;

use crate::bake::ImageBytes;
use crate::error::{Error, Result};
use crate::input;

/// Share of a bound that single precision may have taken from it.
const ROUNDING: f64 = 1.0e-3;
/// Largest image that is read: 65,535 cells with 2,000,000 nodes stay below it.
const BYTES_MAX: u64 = 1 << 30;

/// The bytes of a model file, aligned as the kernel reads them.
pub fn read(path: &Path) -> Result<ImageBytes> {
    let failed = |why: std::io::Error| Error::file("read model", path, why);
    let mut bytes = Vec::new();
    let file = input::open(path).map_err(|why| {
        Error::file("read model", path, format!("{why}; a model is made by chaincell bake"))
    })?;
    file.take(BYTES_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(Error::file("read model", path, format_args!("more than {BYTES_MAX} bytes")));
    }
    Ok(ImageBytes::copy(&bytes))
}

/// The model in those bytes.
pub fn parse<'a>(image: &'a ImageBytes, path: &Path) -> Result<Model<'a>> {
    let refuse = |why: &dyn std::fmt::Display| Error::file("read model", path, why);
    let model = Model::from_bytes(image.as_bytes()).map_err(|why| refuse(&why))?;
    check_bounds(&model).map_err(|cell| {
        refuse(&format_args!(
            "the bound of the curvature at cell {cell} is too small for its shape: bake again"
        ))
    })?;
    let mut ids = model.input_id().to_vec();
    ids.sort_unstable();
    match ids.windows(2).find(|pair| pair[0] == pair[1]) {
        None => Ok(model),
        Some(pair) => {
            Err(refuse(&format_args!("two cells have the input id {}: bake again", pair[0])))
        }
    }
}

/// Checks that the bound of every cell is at least the sum of the magnitudes of its row, which the
/// kernel has no memory to look at; else the first cell where it is not. The bound of a body that can be cut is
/// another one, by its tetrahedra, which the sum of a row may exceed.
fn check_bounds(model: &Model<'_>) -> std::result::Result<(), usize> {
    if model.tetrahedra_to_cut() > 0 {
        return Ok(());
    }
    let (mut row, mut touched) = (vec![0.0_f64; model.cells()], Vec::new());
    for cell in 0..model.cells() {
        model.each_of_bound_row(cell, |other, element| {
            if row[other] == 0.0 {
                touched.push(other);
            }
            row[other] += f64::from(element);
        });
        let mut sum = 0.0;
        for other in touched.drain(..) {
            sum += std::mem::take(&mut row[other]).abs();
        }
        if f64::from(model.cell_bound(cell)) < (1.0 - ROUNDING) * sum {
            return Err(cell);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::tissue::Tissue;
    use crate::bake::{BakeOptions, PerCell, bake};
    use crate::mesh::{MeshOptions, load};
    use chaincell_kernel::image::{CHECKSUM_OFFSET, checksum};

    /// A bound that the kernel takes, since it is above the diagonal, and that is too small.
    #[test]
    fn a_bound_below_its_row_is_refused_by_its_cell() {
        let mesh = load("box:5x5x4x0.01", &MeshOptions::default()).unwrap();
        let of = PerCell::Uniform;
        let tissue = Some(Tissue::new(of(5000.0), of(0.45)));
        let options = BakeOptions { tissue, ..BakeOptions::default() };
        let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
        let place = Path::new("body.chaincell");
        let model = parse(&image, place).unwrap();
        let cell = (0..model.cells()).find(|&cell| !model.is_fixed(cell as u16)).unwrap();
        let mut bytes = image.as_bytes().to_vec();
        // The cell's bound and its mobility, wherever they stand.
        let (bound, less) = (model.cell_bound(cell), 0.6 * model.cell_bound(cell));
        for (from, to) in [(bound, less), (1.0 / bound, 1.0 / less)] {
            for word in bytes.chunks_exact_mut(4).filter(|word| **word == from.to_le_bytes()) {
                word.copy_from_slice(&to.to_le_bytes());
            }
        }
        let sum = checksum(&bytes).to_le_bytes();
        bytes[CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4].copy_from_slice(&sum);
        let forged = ImageBytes::copy(&bytes);
        Model::from_bytes(forged.as_bytes()).unwrap();
        let why = parse(&forged, place).unwrap_err().to_string();
        assert!(why.contains("body.chaincell") && why.contains("cell "), "{why}");
    }
}
