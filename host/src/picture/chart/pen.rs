//! Texts and lines of an SVG document.

use std::fmt::{self, Write as _};

/// A colour, and its stand-in on a dark screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ink {
    /// Class of the elements that have it.
    name: &'static str,
    light: &'static str,
    dark: &'static str,
}

impl Ink {
    /// A colour that is the same on any screen.
    #[must_use]
    pub const fn plain(colour: &'static str) -> Self {
        Self { name: "plain", light: colour, dark: colour }
    }
}

impl fmt::Display for Ink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.light)
    }
}

/// Colour of texts and axes.
pub const INK: Ink = Ink { name: "ink", light: "#1e1e1e", dark: "#e6e6e6" };
/// Colour of the ground.
pub const PAPER: Ink = Ink { name: "paper", light: "#ffffff", dark: "#14161a" };
/// Colours of guide lines, of the grid, and of its fine lines.
pub const GUIDE: Ink = Ink { name: "guide", light: "#787878", dark: "#969696" };
pub(super) const GRID: Ink = Ink { name: "grid", light: "#cdcdcd", dark: "#44484f" };
pub(super) const FINE: Ink = Ink { name: "fine", light: "#ececec", dark: "#24272c" };

/// The colours of a dark screen, as the style element of a document.
pub(super) fn dark_style() -> String {
    let mut rules = String::new();
    for Ink { name, dark, .. } in [INK, PAPER, GUIDE, GRID, FINE] {
        let _ = writeln!(
            rules,
            "text.{name}, rect.{name} {{ fill: {dark} }} polyline.{name} {{ stroke: {dark} }}"
        );
    }
    format!("<style>@media (prefers-color-scheme: dark) {{\n{rules}}}</style>\n")
}

/// Widths of the characters from 32 to 126 in DejaVu Sans, the widest of the common fonts
/// \[thousandths of the size\].
const WIDTHS: [u16; 95] = [
    317, 400, 459, 837, 636, 950, 779, 274, 390, 390, 500, 837, 317, 360, 317, 336, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 636, 336, 336, 837, 837, 837, 530, 1000, 684, 686, 698, 770, 631,
    575, 774, 751, 294, 294, 655, 557, 862, 748, 787, 603, 787, 694, 634, 610, 731, 684, 988, 685,
    610, 685, 390, 336, 390, 837, 500, 500, 612, 634, 549, 634, 615, 352, 634, 633, 277, 277, 579,
    277, 974, 633, 611, 634, 634, 411, 520, 392, 633, 591, 817, 591, 591, 524, 636, 336, 636, 837,
];

/// Width of a text in the widest of the common fonts \[px\], 0 of none.
#[must_use]
pub fn text_width(text: &str, size: u32) -> f64 {
    let width = |letter: char| {
        let at = (letter as usize).checked_sub(32).and_then(|at| WIDTHS.get(at));
        f64::from(at.copied().unwrap_or(650))
    };
    text.chars().map(width).sum::<f64>() * f64::from(size) / 1000.0
}

/// A text beside a place; `anchor` is `start`, `middle` or `end`.
pub fn text(into: &mut String, (x, y): (f64, f64), size: u32, anchor: &str, what: &str) {
    let place = format!("x=\"{x:.1}\" y=\"{y:.1}\"");
    placed(into, &place, size, anchor, what);
}

/// A text that runs upwards through a place, its middle there.
pub fn text_upwards(into: &mut String, (x, y): (f64, f64), size: u32, what: &str) {
    let place = format!("transform=\"translate({x:.1} {y:.1}) rotate(-90)\"");
    placed(into, &place, size, "middle", what);
}

fn placed(into: &mut String, place: &str, size: u32, anchor: &str, what: &str) {
    let _ = writeln!(
        into,
        "<text {place} text-anchor=\"{anchor}\" font-family=\"sans-serif\" font-size=\"{size}\" \
         class=\"ink\" fill=\"{INK}\">{}</text>",
        escape(what)
    );
}

/// A line through places, `dash` pixels drawn and half as many not where that is above 0.
pub fn line(into: &mut String, places: &[(f64, f64)], ink: &Ink, width: u32, dash: u32) {
    let points: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let dashes = match dash {
        0 => String::new(),
        dash => format!(" stroke-dasharray=\"{dash} {}\"", dash / 2),
    };
    let _ = writeln!(
        into,
        "<polyline points=\"{}\" fill=\"none\" class=\"{}\" stroke=\"{ink}\" \
         stroke-width=\"{width}\"{dashes}/>",
        points.join(" "),
        ink.name
    );
}

/// A text that means itself between tags and in attributes.
#[must_use]
pub fn escape(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&#39;")
}
