//! The drawing itself: plotters' axes, grid and series, then guides and a legend to the right of the
//! frame, since plotters' own would cover the data.

use std::fmt::Display;
use std::sync::OnceLock;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::span::Span;
use super::{Chart, Guide, SIZE_PX, Series, Style};
use chaincell_host::error::{Error, Result};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Axes<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Span, Span>>;

/// Okabe and Ito (2008) without yellow, which white swallows, and black, which is the text's.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
const INK: RGBColor = RGBColor(30, 30, 30);
const GUIDE: RGBColor = RGBColor(120, 120, 120);
const GRID: RGBColor = RGBColor(205, 205, 205);
const FINE: RGBColor = RGBColor(236, 236, 236);

/// Font sizes as plotters counts them: 1.24 times the em \[px\].
const TITLE: i32 = 42;
const TEXT: i32 = 36;
const SMALL: i32 = 32;
const MARGIN: i32 = 28;
const GAP: i32 = 14;
const WIDTH: u32 = 4;
const DASH: i32 = 18;
const MARKER: i32 = 9;
/// Width of the labels of the y axis, and of the sample of a line in the legend \[px\].
const LABELS: i32 = 120;
const SAMPLE: i32 = 64;
/// About how many ticks, along x and along y.
const TICKS: (usize, usize) = (8, 7);

/// The chart as an SVG document, and the number of points left out.
pub(super) fn svg(chart: &Chart) -> Result<(String, usize)> {
    let mut text = String::new();
    let area = open(&mut text)?;
    let legend = legend_width(&area, chart)?;
    let (plot, side) = area.split_horizontally(SIZE_PX.0 as i32 - legend);
    let ((x, y), mut axes) = axes(&plot, chart, legend)?;
    let mut left_out = 0;
    let mut runs: Vec<Vec<Vec<(f64, f64)>>> = Vec::new();
    for series in &chart.series {
        let places: Vec<Option<(f64, f64)>> =
            series.points.iter().map(|&[a, b]| Some((x.place(a)?, y.place(b)?))).collect();
        left_out += places.iter().filter(|place| place.is_none()).count();
        let of_series = places.split(Option::is_none).filter(|run| !run.is_empty());
        runs.push(of_series.map(|run| run.iter().copied().flatten().collect()).collect());
    }
    // Lines below, markers above.
    for (at, (series, runs)) in chart.series.iter().zip(&runs).enumerate() {
        runs.iter().try_for_each(|run| line(&mut axes, run, series.style, at))?;
    }
    for (at, (series, runs)) in chart.series.iter().zip(&runs).enumerate() {
        let marked = runs.iter().flatten().filter(|_| series.style.is_marked());
        axes.draw_series(marked.map(|&place| EmptyElement::at(place) + marker(at)))
            .map_err(failed)?;
    }
    for guide in &chart.guides {
        draw_guide(&area, &axes, guide, if guide.vertical { &x } else { &y })?;
    }
    draw_legend(&side, chart)?;
    area.present().map_err(failed)?;
    drop((area, plot, side, axes));
    let text: String = text.split_inclusive('\n').filter(|line| has_length(line)).collect();
    let size = format!("width=\"{}\" height=\"{}\" viewBox", SIZE_PX.0, SIZE_PX.1);
    // Without a size of its own the document fills the page that shows it.
    Ok((text.replacen(&size, "viewBox", 1), left_out))
}

/// A white picture that writes into `text`, with the font that comes along.
fn open(text: &mut String) -> Result<Area<'_>> {
    static FONT: OnceLock<bool> = OnceLock::new();
    let register = || {
        let font = dejavu::sans::regular();
        plotters::style::register_font("sans-serif", FontStyle::Normal, font).is_ok()
    };
    if !FONT.get_or_init(register) {
        return Err(failed("the font does not load"));
    }
    let root = SVGBackend::with_string(text, SIZE_PX).into_drawing_area();
    root.fill(&WHITE).map_err(failed)?;
    Ok(root)
}

/// Draws title, axes and grid; gives what the axes span.
fn axes<'a>(plot: &Area<'a>, chart: &Chart, legend: i32) -> Result<((Span, Span), Axes<'a>)> {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let guides = |vertical: bool| {
        let along = chart.guides.iter().filter(move |guide| guide.vertical == vertical);
        along.map(|guide| guide.at)
    };
    let x = Span::new(&chart.x, points().map(|point| point[0]).chain(guides(true)), TICKS.0);
    let y = Span::new(&chart.y, points().map(|point| point[1]).chain(guides(false)), TICKS.1);
    // A title shrinks to the width that there is.
    let wide = SIZE_PX.0 as i32 - legend - 2 * MARGIN;
    let length = width(plot, &chart.title, TITLE)?;
    let title = if length > wide { TITLE * wide / length } else { TITLE };
    let mut axes = ChartBuilder::on(plot)
        .margin(MARGIN)
        .caption(&chart.title, font(title))
        .set_label_area_size(LabelAreaPosition::Left, TEXT + GAP + LABELS)
        .set_label_area_size(LabelAreaPosition::Bottom, 2 * (TEXT + GAP))
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(failed)?;
    axes.configure_mesh()
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(FINE.stroke_width(2))
        .axis_style(INK.stroke_width(2))
        .label_style(font(TEXT))
        .axis_desc_style(font(TEXT))
        .set_all_tick_mark_size(GAP / 2)
        .x_desc(&chart.x.title)
        .y_desc(&chart.y.title)
        .draw()
        .map_err(failed)?;
    Ok(((x, y), axes))
}

/// The line of series number `at` along `run`.
fn line(axes: &mut Axes<'_>, run: &[(f64, f64)], style: Style, at: usize) -> Result<()> {
    let colour = COLOURS[at % COLOURS.len()];
    let run = run.iter().copied();
    match style {
        Style::Markers => Ok(()),
        Style::Dashed => axes
            .draw_series(DashedLineSeries::new(run, DASH, DASH / 2, colour.stroke_width(WIDTH)))
            .map(|_| ())
            .map_err(failed),
        Style::Line | Style::MarkedLine => {
            let width = if style == Style::Line { WIDTH } else { WIDTH / 2 };
            let series = LineSeries::new(run, colour.stroke_width(width));
            axes.draw_series(series).map(|_| ()).map_err(failed)
        }
    }
}

/// The marker of series number `at`: square, triangle, diamond, triangle on its tip, octagon. The shape
/// moves on with the colours' second round, so that no pair comes twice soon.
fn marker(at: usize) -> Polygon<(i32, i32)> {
    let r = MARKER;
    let corners = match (at + at / COLOURS.len()) % 5 {
        0 => vec![(-4, -r), (4, -r), (r, -4), (r, 4), (4, r), (-4, r), (-r, 4), (-r, -4)],
        1 => vec![(-r, -r), (r, -r), (r, r), (-r, r)],
        2 => vec![(0, -r - 3), (r + 2, r), (-r - 2, r)],
        3 => vec![(0, -r - 4), (r + 4, 0), (0, r + 4), (-r - 4, 0)],
        _ => vec![(0, r + 3), (r + 2, -r), (-r - 2, -r)],
    };
    Polygon::new(corners, COLOURS[at % COLOURS.len()].filled())
}

/// A line across the frame with its label at its end, on a ground of its own.
fn draw_guide(area: &Area<'_>, axes: &Axes<'_>, guide: &Guide, span: &Span) -> Result<()> {
    let Some(at) = span.place(guide.at) else { return Ok(()) };
    let (across, along) = (axes.x_range(), axes.y_range());
    let ends = match guide.vertical {
        true => [(at, along.start), (at, along.end)],
        false => [(across.start, at), (across.end, at)],
    };
    let ends = ends.map(|end| axes.backend_coord(&end));
    let style = GUIDE.stroke_width(WIDTH - 1);
    area.draw(&plotters::element::DashedPathElement::new(ends, DASH, DASH / 2, style))
        .map_err(failed)?;
    let (x, y) = ends[1];
    let wide = width(area, &guide.label, SMALL)?;
    let (left, top) =
        if guide.vertical { (x + GAP, y + GAP) } else { (x - GAP - wide, y - GAP - SMALL) };
    let corners = [(left, top), (left + wide, top + SMALL)];
    area.draw(&Rectangle::new(corners, WHITE.mix(0.8).filled())).map_err(failed)?;
    text(area, &guide.label, SMALL, (left, top + SMALL / 2))
}

/// The lines of a label in the legend: it breaks at its commas.
fn lines(series: &Series) -> impl Iterator<Item = &str> {
    series.label.split_inclusive(", ").map(str::trim_end)
}

fn legend_width(area: &Area<'_>, chart: &Chart) -> Result<i32> {
    let mut widest = 0;
    for label in chart.series.iter().flat_map(lines) {
        widest = widest.max(width(area, label, TEXT)?);
    }
    Ok(if widest == 0 { 0 } else { SAMPLE + GAP + widest + MARGIN })
}

fn draw_legend(side: &Area<'_>, chart: &Chart) -> Result<()> {
    let mut top = MARGIN + TITLE + GAP;
    for (at, series) in chart.series.iter().enumerate().filter(|(_, of)| !of.label.is_empty()) {
        let middle = top + TEXT / 2;
        let colour = COLOURS[at % COLOURS.len()];
        let ends = [(0, middle), (SAMPLE, middle)];
        match series.style {
            Style::Markers => Ok(()),
            Style::Dashed => {
                let style = colour.stroke_width(WIDTH);
                let dashes = plotters::element::DashedPathElement::new(ends, DASH, DASH / 2, style);
                side.draw(&dashes)
            }
            _ => side.draw(&PathElement::new(ends, colour.stroke_width(WIDTH))),
        }
        .map_err(failed)?;
        if series.style.is_marked() {
            side.draw(&(EmptyElement::at((SAMPLE / 2, middle)) + marker(at))).map_err(failed)?;
        }
        for words in lines(series) {
            text(side, words, TEXT, (SAMPLE + GAP, top + TEXT / 2))?;
            top += TEXT + 4;
        }
        top += GAP;
    }
    Ok(())
}

/// Width of a text \[px\].
fn width(area: &Area<'_>, text: &str, size: i32) -> Result<i32> {
    let (wide, _) = area.estimate_text_size(text, &font(size)).map_err(failed)?;
    i32::try_from(wide).map_err(failed)
}

fn font(size: i32) -> TextStyle<'static> {
    TextStyle::from(("sans-serif", size).into_font()).color(&INK)
}

/// A text that begins at its place, its middle at that height.
fn text(area: &Area<'_>, text: &str, size: i32, at: (i32, i32)) -> Result<()> {
    let style = font(size).pos(Pos::new(HPos::Left, VPos::Center));
    area.draw_text(text, &style, at).map_err(failed)
}

/// Whether a line of the document is no stroke of one point alone, such as the last dash of a line
/// may be: the PNG's renderer complains of it.
pub(super) fn has_length(line: &str) -> bool {
    let points = line.split_once(" points=\"").map_or("", |(_, rest)| rest);
    let mut points = points.split('"').next().unwrap_or_default().split_whitespace();
    let first = points.next();
    first.is_none() || points.any(|point| Some(point) != first)
}

fn failed(why: impl Display) -> Error {
    Error::check(format!("picture: {why}"))
}
