//! A baked body, with and without a coarse level.

use chaincell_kernel::Model;

use super::shape::Shape;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes};
use chaincell_host::error::{Error, Result};

/// Distance of the coarse basis functions where a body has them [mean link lengths].
const HATS: BasisSpacing = BasisSpacing::Links(2.5);

/// A baked body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    shape: Shape,
    plain: ImageBytes,
    hats: Option<ImageBytes>,
}

impl Body {
    /// Bakes a shape without hats, and with them where it has room for them.
    ///
    /// # Errors
    /// As the bake.
    pub fn new(shape: Shape, options: &BakeOptions) -> Result<Self> {
        let options = BakeOptions { coarse_basis: BasisSpacing::None, ..options.clone() };
        let plain = shape.bake(&options)?;
        let hats = shape.bake(&BakeOptions { coarse_basis: HATS, ..options }).ok();
        let hats = hats.filter(|image| {
            Model::from_bytes(image.as_bytes()).is_ok_and(|model| model.hats() > 0)
        });
        Ok(Self { shape, plain, hats })
    }

    /// The model, with hats or without; none where there is no room for hats.
    ///
    /// # Errors
    /// None for an image that was baked here.
    pub fn model(&self, hats: bool) -> Result<Option<Model<'_>>> {
        let image = if hats { self.hats.as_ref() } else { Some(&self.plain) };
        image.map(|image| Model::from_bytes(image.as_bytes()).map_err(Error::check)).transpose()
    }

    /// The model without hats.
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
