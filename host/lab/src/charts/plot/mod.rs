//! Charts of a report: lines and markers over linear or decimal-logarithmic axes, as SVG and PNG.
//!
//! The font comes with the program, so a machine without any draws the same picture. Colours are
//! those of Okabe and Ito (2008), told apart with every common colour vision; markers differ in
//! shape too.

mod draw;
pub(crate) mod raster;
mod span;

use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;

/// Width and height of the PNG and of the SVG's own units \[px\]: to be shown at half that size,
/// sharp on dense screens.
pub const SIZE_PX: (u32, u32) = (1920, 1200);

/// How an axis maps numbers to places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal distances, equal steps.
    Linear,
    /// Equal distances, equal factors; takes positive numbers only.
    Log10,
}

/// An axis with its title, unit included: `error of the force [%]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    title: String,
    scale: Scale,
}

impl Axis {
    /// A linear axis over the range of the data.
    pub fn linear(title: &str) -> Self {
        Self { title: title.into(), scale: Scale::Linear }
    }

    /// A logarithmic axis over the range of the data.
    pub fn log10(title: &str) -> Self {
        Self { title: title.into(), scale: Scale::Log10 }
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// A solid line.
    Line,
    /// A dashed line.
    Dashed,
    /// Markers alone.
    Markers,
    /// Markers joined by a thin line.
    MarkedLine,
}

impl Style {
    fn is_marked(self) -> bool {
        matches!(self, Self::Markers | Self::MarkedLine)
    }
}

/// Points that belong together; one that is left out interrupts the line.
#[derive(Debug, Clone, PartialEq)]
struct Series {
    label: String,
    points: Vec<[f64; 2]>,
    style: Style,
}

/// A line across the frame.
#[derive(Debug, Clone, PartialEq)]
struct Guide {
    vertical: bool,
    at: f64,
    label: String,
}

/// A chart drawn as SVG and PNG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// The SVG document.
    pub svg: String,
    /// The PNG file of [`SIZE_PX`].
    pub png: Vec<u8>,
    /// Points not drawn: not finite, or not positive on a logarithmic axis.
    pub left_out: usize,
}

impl Picture {
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

/// A chart to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    title: String,
    x: Axis,
    y: Axis,
    series: Vec<Series>,
    guides: Vec<Guide>,
}

impl Chart {
    /// An empty chart.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        let (series, guides) = (Vec::new(), Vec::new());
        Self { title: title.into(), x, y, series, guides }
    }

    /// Adds a series; `points` as x, y in the axes' units, a line in the given order. An empty
    /// label keeps it out of the legend.
    pub fn series(mut self, label: &str, style: Style, points: &[[f64; 2]]) -> Self {
        self.series.push(Series { label: label.into(), points: points.to_vec(), style });
        self
    }

    /// Adds a vertical guide line at `x`.
    pub fn vertical(mut self, x: f64, label: &str) -> Self {
        self.guides.push(Guide { vertical: true, at: x, label: label.into() });
        self
    }

    /// Adds a horizontal guide line at `y`.
    pub fn horizontal(mut self, y: f64, label: &str) -> Self {
        self.guides.push(Guide { vertical: false, at: y, label: label.into() });
        self
    }

    /// Draws the chart. About a tenth of a second, most of it for the PNG.
    pub fn draw(&self) -> Result<Picture> {
        let (svg, left_out) = draw::svg(self)?;
        let png = raster::png(&svg)?;
        Ok(Picture { svg, png, left_out })
    }
}

/// Round values from `range[0]` to `range[1]`, about `count` of them, with their labels.
pub(crate) fn ticks([from, to]: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let span = span::Span::between(Scale::Linear, (from, to), count);
    span.ticks.iter().map(|&tick| (tick, span.label(tick))).collect()
}

#[cfg(test)]
mod tests;
