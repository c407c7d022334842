//! The drawing itself: plotters' axes and grid, then series, guides and legend.

use plotters::prelude::*;

use super::canvas::{self, Area, INK, Place, SMALL, TEXT, TITLE, failed, font};
use super::legend::Legend;
use super::span::Span;
use super::{Chart, SIZE_PX, Style};
use chaincell_host::error::Result;

/// Okabe and Ito (2008) without yellow, which white swallows, and black, which is the text's.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
const GUIDE: RGBColor = RGBColor(120, 120, 120);
const GRID: RGBColor = RGBColor(205, 205, 205);
const FINE: RGBColor = RGBColor(236, 236, 236);

const MARGIN: i32 = 28;
pub(super) const GAP: i32 = 14;
const WIDTH: u32 = 4;
/// About how many ticks, along x and along y.
const TICKS: (usize, usize) = (8, 7);

/// The chart as an SVG document, and the number of points left out.
pub(super) fn svg(chart: &Chart) -> Result<(String, usize)> {
    let mut text = String::new();
    let area = canvas::open(&mut text)?;
    let legend = Legend::new(&area, chart)?;
    let frame = Frame::new(&area, chart, legend.width)?;
    let (mut left_out, mut drawn) = (0, Vec::new());
    // Lines below, markers above.
    for (at, series) in chart.series.iter().enumerate() {
        let (runs, without) = frame.runs(&series.points);
        left_out += without;
        runs.iter().try_for_each(|run| line(&area, run, series.style, at))?;
        drawn.extend(runs.into_iter().flatten());
    }
    for (at, series) in chart.series.iter().enumerate() {
        for run in frame.runs(&series.points).0 {
            markers(&area, &run, series.style, at)?;
        }
    }
    frame.guides(&area, chart, &drawn)?;
    legend.draw(&area, frame.end)?;
    area.present().map_err(failed)?;
    drop((area, frame));
    let text: String = text.split_inclusive('\n').filter(|line| has_length(line)).collect();
    let size = format!("width=\"{}\" height=\"{}\" viewBox", SIZE_PX.0, SIZE_PX.1);
    // Without a size of its own the document fills the page that shows it.
    Ok((text.replacen(&size, "viewBox", 1), left_out))
}

/// Whether a line of the document is no stroke of one point alone, such as the last dash of a line
/// may be: the PNG's renderer complains of it.
pub(super) fn has_length(line: &str) -> bool {
    let points = line.split_once(" points=\"").map_or("", |(_, rest)| rest);
    let mut points = points.split('"').next().unwrap_or_default().split_whitespace();
    let first = points.next();
    first.is_none() || points.any(|point| Some(point) != first)
}

/// The axes, and where numbers stand between them.
struct Frame<'a> {
    axes: ChartContext<'a, SVGBackend<'a>, Cartesian2d<Span, Span>>,
    x: Span,
    y: Span,
    /// Upper right corner.
    end: Place,
}

impl<'a> Frame<'a> {
    /// Draws title, axes and grid beside a legend of that width.
    fn new(area: &Area<'a>, chart: &Chart, legend: i32) -> Result<Self> {
        let points = || chart.series.iter().flat_map(|series| &series.points);
        let guides = |vertical: bool| {
            let along = chart.guides.iter().filter(move |guide| guide.vertical == vertical);
            along.map(|guide| guide.at)
        };
        let x = Span::new(&chart.x, points().map(|point| point[0]).chain(guides(true)), TICKS.0);
        let y = Span::new(&chart.y, points().map(|point| point[1]).chain(guides(false)), TICKS.1);
        let mut widest = 0;
        for &tick in &y.ticks {
            widest = widest.max(canvas::measure(area, &y.label(tick), TEXT)?.0);
        }
        let (left, below) = (TEXT + GAP + widest + GAP, 2 * (TEXT + GAP));
        let (plot, _) = area.split_horizontally(SIZE_PX.0 as i32 - legend);
        let wide = SIZE_PX.0 as i32 - legend - 2 * MARGIN;
        let high = SIZE_PX.1 as i32 - below - TITLE - 2 * MARGIN;
        let title = canvas::fit(area, &chart.title, TITLE, wide)?;
        let names = canvas::fit(area, &chart.x.title, TEXT, wide - left)?.min(canvas::fit(
            area,
            &chart.y.title,
            TEXT,
            high,
        )?);
        let mut axes = ChartBuilder::on(&plot)
            .margin(MARGIN)
            .caption(&chart.title, font(title))
            .set_label_area_size(LabelAreaPosition::Left, left)
            .set_label_area_size(LabelAreaPosition::Bottom, below)
            .build_cartesian_2d(x.clone(), y.clone())
            .map_err(failed)?;
        axes.configure_mesh()
            .bold_line_style(GRID.stroke_width(2))
            .light_line_style(FINE.stroke_width(2))
            .axis_style(INK.stroke_width(2))
            .label_style(font(TEXT))
            .axis_desc_style(font(names))
            .set_all_tick_mark_size(GAP / 2)
            .x_desc(&chart.x.title)
            .y_desc(&chart.y.title)
            .draw()
            .map_err(failed)?;
        let end = axes.backend_coord(&(x.to, y.to));
        Ok(Self { axes, x, y, end })
    }

    fn place(&self, [x, y]: [f64; 2]) -> Option<Place> {
        Some(self.axes.backend_coord(&(self.x.place(x)?, self.y.place(y)?)))
    }

    /// The points that have a place, in runs between those that have none, and the number of those.
    fn runs(&self, points: &[[f64; 2]]) -> (Vec<Vec<Place>>, usize) {
        let places: Vec<Option<Place>> = points.iter().map(|&point| self.place(point)).collect();
        let runs = places.split(Option::is_none).filter(|run| !run.is_empty());
        let runs = runs.map(|run| run.iter().copied().flatten().collect()).collect();
        (runs, places.iter().filter(|place| place.is_none()).count())
    }

    /// Lines across the frame, each with its label at one of its ends, on the side where it covers
    /// the fewest of the points drawn.
    fn guides(&self, area: &Area<'_>, chart: &Chart, drawn: &[Place]) -> Result<()> {
        for guide in &chart.guides {
            let span = if guide.vertical { &self.x } else { &self.y };
            let Some(at) = span.place(guide.at) else { continue };
            let ends = match guide.vertical {
                true => [(at, self.y.from), (at, self.y.to)],
                false => [(self.x.from, at), (self.x.to, at)],
            };
            let [start, end] = ends.map(|end| self.axes.backend_coord(&end));
            canvas::dashes(area, &[start, end], GUIDE, 3)?;
            let (width, height) = canvas::measure(area, &guide.label, SMALL)?;
            let covered = |&(left, top): &Place| {
                let across = left - GAP..left + width + GAP;
                let down = top - GAP..top + height + GAP;
                drawn.iter().filter(|(x, y)| across.contains(x) && down.contains(y)).count()
            };
            let (before, behind) = (-GAP - width, GAP);
            let (above, below) = (-GAP - height, GAP);
            let corners = match guide.vertical {
                true => [(end, behind, below), (end, before, below), (start, behind, above)],
                false => [(end, before, above), (start, behind, above), (end, before, below)],
            };
            let corners = corners.map(|((x, y), across, down)| (x + across, y + down));
            let corner = corners.into_iter().min_by_key(covered).unwrap_or(end);
            canvas::plate(area, &guide.label, corner, (width, height))?;
        }
        Ok(())
    }
}

/// The line of the series number `at` along `run`.
pub(super) fn line(area: &Area<'_>, run: &[Place], style: Style, at: usize) -> Result<()> {
    let colour = COLOURS[at % COLOURS.len()];
    match style {
        Style::Line => canvas::line(area, run, colour, WIDTH),
        Style::Dashed => canvas::dashes(area, run, colour, WIDTH),
        Style::MarkedLine => canvas::line(area, run, colour, WIDTH / 2),
        Style::Markers => Ok(()),
    }
}

/// The markers of the series number `at` along `run`.
pub(super) fn markers(area: &Area<'_>, run: &[Place], style: Style, at: usize) -> Result<()> {
    if matches!(style, Style::Line | Style::Dashed) {
        return Ok(());
    }
    // The shape moves on with the colours' second round, so that no pair comes twice soon.
    let (colour, kind) = (COLOURS[at % COLOURS.len()], at + at / COLOURS.len());
    run.iter().try_for_each(|&place| canvas::marker(area, place, colour, kind))
}
