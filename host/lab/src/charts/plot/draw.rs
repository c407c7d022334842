//! The drawing itself: frame and grid, guides, series, front, notes, legend.

use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, INK, Place, SMALL, TEXT, TITLE};
use super::labels::{Rect, Room, wrap};
use super::span::Span;
use super::{Chart, SIZE_PX, Style};
use chaincell_host::error::Result;

/// Okabe and Ito (2008) without yellow, which white swallows, and black, which is the front's.
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
const GAP: i32 = 14;
const WIDTH: u32 = 4;
/// Length of the sample of a line in the legend, and the legend's largest width.
const SAMPLE: i32 = 64;
const LEGEND: i32 = SIZE_PX.0 as i32 / 3;
/// About how many ticks, along x and along y.
const TICKS: (usize, usize) = (8, 7);

/// The chart as an SVG document, and the number of points left out.
pub(super) fn svg(chart: &Chart) -> Result<(String, usize)> {
    let mut text = String::new();
    let canvas = Canvas::new(&mut text)?;
    let legend = Legend::new(&canvas, chart)?;
    let frame = Frame::new(&canvas, chart, legend.width)?;
    frame.axes(&canvas, chart)?;
    let mut room = Room::new(frame.rect);
    let mut left_out = 0;
    // Lines below, markers above, so that the front hides none.
    for (at, series) in chart.series.iter().enumerate() {
        let (runs, without) = frame.runs(&series.points);
        left_out += without;
        runs.iter().try_for_each(|run| line(&canvas, run, series.style, at))?;
        runs.iter().for_each(|run| room.take_path(run, series.style != Style::Markers));
    }
    let front = chart.front.as_ref().map(|(_, points)| frame.runs(points));
    let (front, without) = front.unwrap_or_default();
    left_out += without;
    for run in &front {
        canvas.line(run, INK, WIDTH)?;
        room.take_path(run, true);
    }
    for (at, series) in chart.series.iter().enumerate() {
        for run in frame.runs(&series.points).0 {
            markers(&canvas, &run, series.style, at)?;
        }
    }
    front.iter().flatten().try_for_each(|&place| canvas.ring(place))?;
    frame.guides(&canvas, chart, &mut room)?;
    frame.notes(&canvas, chart, &mut room)?;
    legend.draw(&canvas, frame.rect)?;
    canvas.finish()?;
    // Without a size of its own the document fills the page that shows it.
    let size = format!("width=\"{}\" height=\"{}\" viewBox", SIZE_PX.0, SIZE_PX.1);
    Ok((text.replacen(&size, "viewBox", 1), left_out))
}

/// Where numbers stand on the canvas.
struct Frame {
    x: Span,
    y: Span,
    rect: Rect,
}

impl Frame {
    fn new(canvas: &Canvas<'_>, chart: &Chart, legend: i32) -> Result<Self> {
        let front = chart.front.iter().flat_map(|(_, points)| points);
        let points = || chart.series.iter().flat_map(|series| &series.points).chain(front.clone());
        let guides = |vertical: bool| {
            let along = chart.guides.iter().filter(move |guide| guide.vertical == vertical);
            along.map(|guide| guide.at)
        };
        let x = Span::new(&chart.x, points().map(|point| point[0]).chain(guides(true)), TICKS.0);
        let y = Span::new(&chart.y, points().map(|point| point[1]).chain(guides(false)), TICKS.1);
        let mut widest = 0;
        for &tick in &y.ticks {
            widest = widest.max(canvas.measure(&y.label(tick), TEXT)?.0);
        }
        let left = MARGIN + TEXT + GAP + widest + GAP;
        let top = MARGIN + TITLE + GAP;
        let width = SIZE_PX.0 as i32 - left - legend - MARGIN;
        let height = SIZE_PX.1 as i32 - top - 2 * (TEXT + GAP) - MARGIN;
        Ok(Self { x, y, rect: Rect { left, top, width, height } })
    }

    fn place(&self, [x, y]: [f64; 2]) -> Option<Place> {
        Some((self.across(self.x.place(x)?), self.down(self.y.place(y)?)))
    }

    fn across(&self, x: f64) -> i32 {
        let part = (x - self.x.from) / (self.x.to - self.x.from);
        self.rect.left + (part * f64::from(self.rect.width)).round() as i32
    }

    fn down(&self, y: f64) -> i32 {
        let part = (y - self.y.from) / (self.y.to - self.y.from);
        self.rect.bottom() - (part * f64::from(self.rect.height)).round() as i32
    }

    /// The points that have a place, in runs between those that have none, and the number of those.
    fn runs(&self, points: &[[f64; 2]]) -> (Vec<Vec<Place>>, usize) {
        let places: Vec<Option<Place>> = points.iter().map(|&point| self.place(point)).collect();
        let runs = places.split(Option::is_none).filter(|run| !run.is_empty());
        let runs = runs.map(|run| run.iter().copied().flatten().collect()).collect();
        (runs, places.iter().filter(|place| place.is_none()).count())
    }

    /// Title, grid, frame, labels of the ticks, titles of the axes.
    fn axes(&self, canvas: &Canvas<'_>, chart: &Chart) -> Result<()> {
        let Rect { left, top, .. } = self.rect;
        let (right, bottom) = (self.rect.right(), self.rect.bottom());
        for (colour, xs, ys) in
            [(FINE, &self.x.fine, &self.y.fine), (GRID, &self.x.ticks, &self.y.ticks)]
        {
            for x in xs.iter().map(|&x| self.across(x)) {
                canvas.line(&[(x, top), (x, bottom)], colour, 2)?;
            }
            for y in ys.iter().map(|&y| self.down(y)) {
                canvas.line(&[(left, y), (right, y)], colour, 2)?;
            }
        }
        canvas.frame(self.rect)?;
        for &x in &self.x.ticks {
            let at = (self.across(x), bottom + GAP);
            canvas.text(&self.x.label(x), TEXT, at, HPos::Center, VPos::Top)?;
        }
        for &y in &self.y.ticks {
            let at = (left - GAP, self.down(y));
            canvas.text(&self.y.label(y), TEXT, at, HPos::Right, VPos::Center)?;
        }
        let size = canvas.fit(&chart.title, TITLE, SIZE_PX.0 as i32 - left - MARGIN)?;
        canvas.text(&chart.title, size, (left, MARGIN), HPos::Left, VPos::Top)?;
        let below = (left + self.rect.width / 2, bottom + 2 * GAP + TEXT);
        let size = canvas.fit(&chart.x.title, TEXT, self.rect.width)?;
        canvas.text(&chart.x.title, size, below, HPos::Center, VPos::Top)?;
        let size = canvas.fit(&chart.y.title, TEXT, self.rect.height)?;
        canvas.upright(&chart.y.title, size, (MARGIN, top + self.rect.height / 2))
    }

    fn guides(&self, canvas: &Canvas<'_>, chart: &Chart, room: &mut Room) -> Result<()> {
        let Rect { left, top, .. } = self.rect;
        let (right, bottom) = (self.rect.right(), self.rect.bottom());
        let mut labels = Vec::new();
        for guide in &chart.guides {
            let span = if guide.vertical { &self.x } else { &self.y };
            let Some(at) = span.place(guide.at) else { continue };
            let (x, y) = (self.across(at), self.down(at));
            let ends =
                if guide.vertical { [(x, bottom), (x, top)] } else { [(left, y), (right, y)] };
            canvas.dashes(&ends, GUIDE, 3)?;
            room.take_path(&ends, true);
            labels.push((ends, &guide.label));
        }
        for (ends, label) in labels {
            let rect = room.place(&[ends[1], ends[0]], canvas.measure(label, SMALL)?);
            canvas.plate(label, rect)?;
        }
        Ok(())
    }

    fn notes(&self, canvas: &Canvas<'_>, chart: &Chart, room: &mut Room) -> Result<()> {
        for note in &chart.notes {
            let Some(place) = self.place(note.at) else { continue };
            let rect = room.place(&[place], canvas.measure(&note.text, SMALL)?);
            canvas.plate(&note.text, rect)?;
        }
        Ok(())
    }
}

/// The line of the series number `at` along `run`.
fn line(canvas: &Canvas<'_>, run: &[Place], style: Style, at: usize) -> Result<()> {
    let colour = COLOURS[at % COLOURS.len()];
    match style {
        Style::Line => canvas.line(run, colour, WIDTH),
        Style::Dashed => canvas.dashes(run, colour, WIDTH),
        Style::MarkedLine => canvas.line(run, colour, WIDTH / 2),
        Style::Markers => Ok(()),
    }
}

/// The markers of the series number `at` along `run`.
fn markers(canvas: &Canvas<'_>, run: &[Place], style: Style, at: usize) -> Result<()> {
    if matches!(style, Style::Line | Style::Dashed) {
        return Ok(());
    }
    // The shape moves on with the colours' second round, so that no pair comes twice soon.
    let (colour, kind) = (COLOURS[at % COLOURS.len()], at + at / COLOURS.len());
    run.iter().try_for_each(|&place| canvas.marker(place, colour, kind))
}

/// An entry: number and style of the series, or none for the front; the label's lines.
type Entry = (Option<(usize, Style)>, Vec<String>);

/// What stands to the right of the frame.
struct Legend {
    entries: Vec<Entry>,
    /// With the gap to the frame \[px\].
    width: i32,
}

impl Legend {
    fn new(canvas: &Canvas<'_>, chart: &Chart) -> Result<Self> {
        let series = chart.series.iter().enumerate();
        let all = series
            .map(|(at, series)| (Some((at, series.style)), series.label.as_str()))
            .chain(chart.front.iter().map(|(label, _)| (None, label.as_str())))
            .filter(|(_, label)| !label.is_empty());
        let (mut entries, mut widest) = (Vec::new(), 0);
        for (sample, label) in all {
            // A text that cannot be measured takes a line of its own.
            let width = |text: &str| canvas.measure(text, TEXT).map_or(LEGEND, |size| size.0);
            let lines = wrap(label, LEGEND - SAMPLE - 2 * GAP, width);
            widest = lines.iter().map(|line| width(line)).fold(widest, i32::max);
            entries.push((sample, lines));
        }
        let width = if entries.is_empty() { 0 } else { GAP + SAMPLE + GAP + widest };
        Ok(Self { entries, width })
    }

    fn draw(&self, canvas: &Canvas<'_>, frame: Rect) -> Result<()> {
        let (left, mut top) = (frame.right() + GAP, frame.top);
        for (sample, lines) in &self.entries {
            let middle = top + TEXT / 2;
            let ends = [(left, middle), (left + SAMPLE, middle)];
            let centre = (left + SAMPLE / 2, middle);
            match *sample {
                None => {
                    canvas.line(&ends, INK, WIDTH)?;
                    canvas.ring(centre)?;
                }
                Some((at, style)) => {
                    line(canvas, &ends, style, at)?;
                    markers(canvas, &[centre], style, at)?;
                }
            }
            for words in lines {
                let at = (left + SAMPLE + GAP, top + TEXT / 2);
                canvas.text(words, TEXT, at, HPos::Left, VPos::Center)?;
                top += TEXT + 4;
            }
            top += GAP;
        }
        Ok(())
    }
}
