//! Charts: lines and markers over linear or decimal-logarithmic axes, as SVG. Colours are those of Okabe
//! and Ito (2008), told apart with every common colour vision; markers differ in shape too.

mod draw;
pub mod pen;
mod span;

/// Width and height of the document in its own units, and of its PNG \[px\]: to be shown at half that size,
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
    #[must_use]
    pub fn linear(title: &str) -> Self {
        Self { title: title.into(), scale: Scale::Linear }
    }

    /// A logarithmic axis over the range of the data.
    #[must_use]
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

/// A chart as an SVG document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawn {
    /// The document, dark on white.
    pub svg: String,
    /// Points not drawn: not finite, or not positive on a logarithmic axis.
    pub left_out: usize,
}

impl Drawn {
    /// The document for a file of its own: light on dark where the reader's screen is dark.
    #[must_use]
    pub fn in_both_lights(&self) -> String {
        self.svg.replacen(">\n", &format!(">\n{}", pen::dark_style()), 1)
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
    #[must_use]
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        let (series, guides) = (Vec::new(), Vec::new());
        Self { title: title.into(), x, y, series, guides }
    }

    /// Adds a series; `points` as x, y in the axes' units, a line in the given order. An empty
    /// label keeps it out of the legend.
    #[must_use]
    pub fn series(mut self, label: &str, style: Style, points: &[[f64; 2]]) -> Self {
        self.series.push(Series { label: label.into(), points: points.to_vec(), style });
        self
    }

    /// Adds a vertical guide line at `x`.
    #[must_use]
    pub fn vertical(mut self, x: f64, label: &str) -> Self {
        self.guides.push(Guide { vertical: true, at: x, label: label.into() });
        self
    }

    /// Adds a horizontal guide line at `y`.
    #[must_use]
    pub fn horizontal(mut self, y: f64, label: &str) -> Self {
        self.guides.push(Guide { vertical: false, at: y, label: label.into() });
        self
    }

    /// Draws the chart: some milliseconds.
    #[must_use]
    pub fn draw(&self) -> Drawn {
        let (svg, left_out) = draw::svg(self);
        Drawn { svg, left_out }
    }
}

/// Round values from `range[0]` to `range[1]`, about `count` of them, with their labels.
#[must_use]
pub fn ticks([from, to]: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let span = span::Span::between(Scale::Linear, (from, to), count);
    span.ticks.iter().map(|&tick| (tick, span.label(tick))).collect()
}

#[cfg(test)]
mod tests;
