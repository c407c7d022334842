//! A baked body, with and without a coarse level.

use chaincell_kernel::Model;

use super::shape::Shape;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes};
use chaincell_host::error::{Error, Result};

/// Distance of the coarse basis functions where a body has them [mean link lengths].
const COARSE: BasisSpacing = BasisSpacing::Links(2.5);

/// A baked body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    shape: Shape,
    plain: ImageBytes,
    coarse: Option<ImageBytes>,
}

impl Body {
    /// Bakes a shape without a coarse level, and with them where it has room for them.
    ///
    /// # Errors
    /// As the bake.
    pub fn new(shape: Shape, options: &BakeOptions) -> Result<Self> {
        let options = BakeOptions { coarse_basis: BasisSpacing::None, ..options.clone() };
        let plain = shape.bake(&options)?;
        let coarse = shape.bake(&BakeOptions { coarse_basis: COARSE, ..options }).ok();
        let coarse = coarse.filter(|image| {
            Model::from_bytes(image.as_bytes()).is_ok_and(|model| model.coarse_functions() > 0)
        });
        Ok(Self { shape, plain, coarse })
    }

    /// The model, with a coarse level or without; none where there is no room for coarse functions.
    ///
    /// # Errors
    /// None for an image that was baked here.
    pub fn model(&self, coarse: bool) -> Result<Option<Model<'_>>> {
        let image = if coarse { self.coarse.as_ref() } else { Some(&self.plain) };
        image.map(|image| Model::from_bytes(image.as_bytes()).map_err(Error::check)).transpose()
    }

    /// The model without a coarse level.
    ///
    /// # Errors
    /// As [`Self::model`].
    pub fn plain(&self) -> Result<Model<'_>> {
        Model::from_bytes(self.plain.as_bytes()).map_err(Error::check)
    }

    /// Cells of the nodes that the tool holds, ascending.
    #[must_use]
    pub fn held(&self, model: &Model<'_>) -> Vec<u16> {
        self.shape.cells(model)
    }
}
