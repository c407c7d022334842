//! Charts as SVG and PNG. The font comes with the program, so a machine without any draws the same picture.

use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_host::picture::chart::Drawn;
pub use chaincell_host::picture::chart::{Axis, Chart, Style};

use super::raster;

/// A chart drawn as SVG and PNG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// The SVG document.
    pub svg: String,
    /// The PNG file, of the size of the document in its own units.
    pub png: Vec<u8>,
    /// Points not drawn: not finite, or not positive on a logarithmic axis.
    pub left_out: usize,
}

impl Picture {
    /// Draws a chart. About a tenth of a second, most of it for the PNG.
    pub fn of(chart: &Chart) -> Result<Self> {
        let Drawn { svg, left_out } = chart.draw();
        let png = raster::png(&svg)?;
        Ok(Self { svg, png, left_out })
    }

    /// Writes `name.svg` and `name.png`.
    pub fn write(&self, folder: &Folder, name: &str) -> Result<()> {
        folder.write(&format!("{name}.svg"), self.svg.as_bytes())?;
        folder.write(&format!("{name}.png"), &self.png)
    }
}

/// A picture with its name (a file's, without ending) and caption.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Name of its files.
    pub name: String,
    /// What it shows, a sentence or two.
    pub caption: String,
    /// SVG and PNG.
    pub picture: Picture,
}

impl Figure {
    /// A picture under a name, with its caption.
    pub fn new(name: impl Into<String>, caption: impl Into<String>, picture: Picture) -> Self {
        Self { name: name.into(), caption: caption.into(), picture }
    }
}
