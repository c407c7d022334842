//! Texts and lines of an SVG document.

use std::fmt::Write as _;

/// Colour of texts and axes.
pub const INK: &str = "#1e1e1e";

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
         fill=\"{INK}\">{}</text>",
        escape(what)
    );
}

/// A line through places, `dash` pixels drawn and half as many not where that is above 0.
pub fn line(into: &mut String, places: &[(f64, f64)], colour: &str, width: u32, dash: u32) {
    let points: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let dashes = match dash {
        0 => String::new(),
        dash => format!(" stroke-dasharray=\"{dash} {}\"", dash / 2),
    };
    let _ = writeln!(
        into,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dashes}/>",
        points.join(" ")
    );
}

/// A text that means itself between tags and in attributes.
pub fn escape(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&#39;")
}
