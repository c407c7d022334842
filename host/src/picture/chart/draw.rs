//! The drawing itself: axes, grid and series, then guides, and a legend to the right of the frame.

use std::fmt::Write as _;

use super::pen::{FINE, GRID, GUIDE, INK, Ink, PAPER, line, text, text_upwards, text_width};
use super::span::Span;
use super::{Chart, Guide, SIZE_PX, Series, Style};

/// Okabe and Ito (2008) without yellow, which white swallows, and black, which is the text's.
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// Font sizes \[px\].
const TITLE: u32 = 34;
const TEXT: u32 = 29;
const SMALL: u32 = 26;
/// Air around everything, and between parts \[px\].
const MARGIN: f64 = 28.0;
const GAP: f64 = 14.0;
const WIDTH: u32 = 4;
const DASH: u32 = 18;
const MARKER: f64 = 9.0;
/// Width of the labels of the y axis, and of the sample of a line in the legend \[px\].
const LABELS: f64 = 120.0;
const SAMPLE: f64 = 64.0;
/// About how many ticks, along x and along y.
const TICKS: (usize, usize) = (8, 7);

/// Where the axes are on the picture.
struct Frame {
    x: Span,
    y: Span,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Frame {
    /// The place of a point; none where an axis has none for it.
    fn place(&self, [x, y]: [f64; 2]) -> Option<(f64, f64)> {
        Some((self.across(self.x.place(x)?), self.down(self.y.place(y)?)))
    }

    fn across(&self, at: f64) -> f64 {
        self.left + self.x.part(at) * (self.right - self.left)
    }

    fn down(&self, at: f64) -> f64 {
        self.bottom - self.y.part(at) * (self.bottom - self.top)
    }
}

/// The chart as an SVG document, and the number of points left out.
pub(super) fn svg(chart: &Chart) -> (String, usize) {
    let (wide, high) = (f64::from(SIZE_PX.0), f64::from(SIZE_PX.1));
    // Without a size of its own the document fills the page that shows it.
    let mut svg = format!(
        "<svg viewBox=\"0 0 {wide} {high}\" xmlns=\"http://www.w3.org/2000/svg\">\n\
         <rect width=\"{wide}\" height=\"{high}\" class=\"paper\" fill=\"{PAPER}\"/>\n"
    );
    // The frame: what the legend leaves, over the range of points and guides.
    let legend = legend_width(chart);
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let guides = |vertical: bool| {
        let along = chart.guides.iter().filter(move |guide| guide.vertical == vertical);
        along.map(|guide| guide.at)
    };
    let frame = Frame {
        x: Span::new(&chart.x, points().map(|point| point[0]).chain(guides(true)), TICKS.0),
        y: Span::new(&chart.y, points().map(|point| point[1]).chain(guides(false)), TICKS.1),
        left: MARGIN + f64::from(TEXT) + GAP + LABELS,
        right: wide - legend - MARGIN,
        top: MARGIN + f64::from(TITLE) + GAP,
        bottom: high - MARGIN - 2.0 * (f64::from(TEXT) + GAP),
    };
    axes(&mut svg, &frame, chart);
    // The series, a line for each run of points that have a place: lines below, markers above.
    let mut left_out = 0;
    let mut markers = String::new();
    for (at, series) in chart.series.iter().enumerate() {
        let places: Vec<Option<(f64, f64)>> =
            series.points.iter().map(|&point| frame.place(point)).collect();
        left_out += places.iter().filter(|place| place.is_none()).count();
        for run in places.split(Option::is_none) {
            let run: Vec<(f64, f64)> = run.iter().copied().flatten().collect();
            stroke(&mut svg, &run, series.style, at);
            if series.style.is_marked() {
                run.into_iter().for_each(|place| marker(&mut markers, place, at));
            }
        }
    }
    svg += &markers;
    // Guides and legend over all.
    for guide in &chart.guides {
        draw_guide(&mut svg, &frame, guide);
    }
    draw_legend(&mut svg, chart, wide - legend);
    (svg + "</svg>\n", left_out)
}

/// Title, grid, ticks with their labels and the axes' own titles.
fn axes(svg: &mut String, frame: &Frame, chart: &Chart) {
    let Frame { x, y, left, right, top, bottom } = frame;
    let middle = 0.5 * (left + right);
    // A title shrinks to the width that there is.
    let length = text_width(&chart.title, TITLE);
    let size = (f64::from(TITLE) * ((right - left) / length).min(1.0)) as u32;
    text(svg, (middle, top - GAP), size, "middle", &chart.title);
    for (ticks, colour) in [(&x.fine, &FINE), (&x.ticks, &GRID)] {
        for at in ticks.iter().map(|&at| frame.across(at)) {
            line(svg, &[(at, *top), (at, *bottom)], colour, 2, 0);
        }
    }
    for (ticks, colour) in [(&y.fine, &FINE), (&y.ticks, &GRID)] {
        for at in ticks.iter().map(|&at| frame.down(at)) {
            line(svg, &[(*left, at), (*right, at)], colour, 2, 0);
        }
    }
    line(svg, &[(*left, *top), (*left, *bottom), (*right, *bottom)], &INK, 2, 0);
    let (below, rise) = (bottom + f64::from(TEXT) + GAP / 2.0, 0.35 * f64::from(TEXT));
    for &at in &x.ticks {
        text(svg, (frame.across(at), below), TEXT, "middle", &x.label(at));
    }
    for &at in &y.ticks {
        text(svg, (left - GAP, frame.down(at) + rise), TEXT, "end", &y.label(at));
    }
    text(svg, (middle, below + f64::from(TEXT) + GAP), TEXT, "middle", &chart.x.title);
    let side = (MARGIN + f64::from(TEXT), 0.5 * (top + bottom));
    text_upwards(svg, side, TEXT, &chart.y.title);
}

/// The line of series number `at` along `run`.
fn stroke(svg: &mut String, run: &[(f64, f64)], style: Style, at: usize) {
    let (width, dash) = match style {
        Style::Line => (WIDTH, 0),
        Style::Dashed => (WIDTH, DASH),
        Style::MarkedLine => (WIDTH / 2, 0),
        Style::Markers => return,
    };
    if run.len() > 1 {
        line(svg, run, &Ink::plain(COLOURS[at % COLOURS.len()]), width, dash);
    }
}

/// The marker of series number `at`: octagon, square, triangle, diamond, triangle on its tip. The shape
/// moves on with the colours' second round, so that no pair comes twice soon.
fn marker(svg: &mut String, (x, y): (f64, f64), at: usize) {
    let r = MARKER;
    let corners: &[(f64, f64)] = match (at + at / COLOURS.len()) % 5 {
        0 => &[(-4., -r), (4., -r), (r, -4.), (r, 4.), (4., r), (-4., r), (-r, 4.), (-r, -4.)],
        1 => &[(-r, -r), (r, -r), (r, r), (-r, r)],
        2 => &[(0., -r - 3.), (r + 2., r), (-r - 2., r)],
        3 => &[(0., -r - 4.), (r + 4., 0.), (0., r + 4.), (-r - 4., 0.)],
        _ => &[(0., r + 3.), (r + 2., -r), (-r - 2., -r)],
    };
    let points: Vec<String> =
        corners.iter().map(|(dx, dy)| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
    let colour = COLOURS[at % COLOURS.len()];
    let _ = writeln!(svg, "<polygon points=\"{}\" fill=\"{colour}\"/>", points.join(" "));
}

/// A line across the frame with its label at its end, on a ground of its own.
fn draw_guide(svg: &mut String, frame: &Frame, guide: &Guide) {
    let span = if guide.vertical { &frame.x } else { &frame.y };
    let Some(at) = span.place(guide.at) else { return };
    let (wide, high) = (text_width(&guide.label, SMALL), f64::from(SMALL));
    let (ends, left, top) = if guide.vertical {
        let x = frame.across(at);
        ([(x, frame.bottom), (x, frame.top)], x + GAP, frame.top + GAP)
    } else {
        let y = frame.down(at);
        ([(frame.left, y), (frame.right, y)], frame.right - GAP - wide, y - GAP - high)
    };
    line(svg, &ends, &GUIDE, WIDTH - 1, DASH);
    let _ = writeln!(
        svg,
        "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{wide:.1}\" height=\"{high}\" class=\"paper\" \
         fill=\"{PAPER}\" fill-opacity=\"0.8\"/>"
    );
    text(svg, (left, top + 0.85 * high), SMALL, "start", &guide.label);
}

/// The lines of a label in the legend: it breaks at its commas.
fn lines(series: &Series) -> impl Iterator<Item = &str> {
    series.label.split_inclusive(", ").map(str::trim_end)
}

fn legend_width(chart: &Chart) -> f64 {
    let labels = chart.series.iter().flat_map(lines);
    let widest = labels.map(|label| text_width(label, TEXT)).fold(0.0, f64::max);
    if widest == 0.0 { 0.0 } else { SAMPLE + GAP + widest + MARGIN }
}

fn draw_legend(svg: &mut String, chart: &Chart, left: f64) {
    let mut top = MARGIN + f64::from(TITLE) + GAP;
    for (at, series) in chart.series.iter().enumerate().filter(|(_, of)| !of.label.is_empty()) {
        let middle = top + 0.5 * f64::from(TEXT);
        stroke(svg, &[(left, middle), (left + SAMPLE, middle)], series.style, at);
        if series.style.is_marked() {
            marker(svg, (left + 0.5 * SAMPLE, middle), at);
        }
        for words in lines(series) {
            text(svg, (left + SAMPLE + GAP, top + 0.85 * f64::from(TEXT)), TEXT, "start", words);
            top += f64::from(TEXT) + 8.0;
        }
        top += GAP;
    }
}
