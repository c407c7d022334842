//! Strokes and texts on the SVG, in pixels, with the font that comes along.

use std::fmt::Display;
use std::sync::OnceLock;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::SIZE_PX;
use super::labels::Rect;
use chaincell_host::error::{Error, Result};

/// A place on the canvas \[px\], y downwards.
pub(super) type Place = (i32, i32);

pub(super) const INK: RGBColor = RGBColor(30, 30, 30);
/// Font sizes as plotters counts them: 1.24 times the em \[px\].
pub(super) const TITLE: i32 = 42;
pub(super) const TEXT: i32 = 36;
pub(super) const SMALL: i32 = 32;

const MARKER: i32 = 9;
const RING: i32 = 16;
const DASH: i32 = 18;

/// A drawing under way.
pub(super) struct Canvas<'a> {
    root: DrawingArea<SVGBackend<'a>, Shift>,
}

impl<'a> Canvas<'a> {
    /// A white canvas that writes into `text`.
    pub fn new(text: &'a mut String) -> Result<Self> {
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
        Ok(Self { root })
    }

    /// Writes the end of the document.
    pub fn finish(self) -> Result<()> {
        self.root.present().map_err(failed)
    }

    /// Width and height of a text \[px\].
    pub fn measure(&self, text: &str, size: i32) -> Result<Place> {
        let (wide, _) = self.root.estimate_text_size(text, &font(size)).map_err(failed)?;
        // The line's height, whatever letters it has.
        Ok((i32::try_from(wide).map_err(failed)?, size))
    }

    /// The size, at most `size`, at which a text is no longer than `room` \[px\].
    pub fn fit(&self, text: &str, size: i32, room: i32) -> Result<i32> {
        let (wide, _) = self.measure(text, size)?;
        Ok(if wide > room { size * room / wide } else { size })
    }

    /// A text whose anchor stands at `at`.
    pub fn text(&self, text: &str, size: i32, at: Place, across: HPos, down: VPos) -> Result<()> {
        let style = font(size).pos(Pos::new(across, down));
        self.root.draw_text(text, &style, at).map_err(failed)
    }

    /// A text read from below, centred on `at`.
    pub fn upright(&self, text: &str, size: i32, at: Place) -> Result<()> {
        let style = font(size).transform(FontTransform::Rotate270);
        let style = style.pos(Pos::new(HPos::Center, VPos::Top));
        self.root.draw_text(text, &style, at).map_err(failed)
    }

    /// A text on a ground of its own, so that lines below do not cross it out.
    pub fn plate(&self, text: &str, rect: Rect) -> Result<()> {
        let corners = [(rect.left, rect.top), (rect.right(), rect.bottom())];
        let ground = WHITE.mix(0.8).filled();
        self.root.draw(&Rectangle::new(corners, ground)).map_err(failed)?;
        self.text(text, SMALL, (rect.left, rect.top + rect.height / 2), HPos::Left, VPos::Center)
    }

    pub fn line(&self, places: &[Place], colour: RGBColor, width: u32) -> Result<()> {
        self.root.draw(&PathElement::new(places, colour.stroke_width(width))).map_err(failed)
    }

    pub fn dashes(&self, places: &[Place], colour: RGBColor, width: u32) -> Result<()> {
        dashes(places).iter().try_for_each(|dash| self.line(dash, colour, width))
    }

    pub fn frame(&self, rect: Rect) -> Result<()> {
        let corners = [(rect.left, rect.top), (rect.right(), rect.bottom())];
        self.root.draw(&Rectangle::new(corners, INK.stroke_width(2))).map_err(failed)
    }

    /// A marker of the given kind: circle, square, triangle, diamond, triangle on its tip.
    pub fn marker(&self, (x, y): Place, colour: RGBColor, kind: usize) -> Result<()> {
        let r = MARKER;
        let corners: &[Place] = match kind % 5 {
            0 => {
                let circle = Circle::new((x, y), r, colour.filled());
                return self.root.draw(&circle).map_err(failed);
            }
            1 => &[(-r, -r), (r, -r), (r, r), (-r, r)],
            2 => &[(0, -r - 3), (r + 2, r), (-r - 2, r)],
            3 => &[(0, -r - 4), (r + 4, 0), (0, r + 4), (-r - 4, 0)],
            _ => &[(0, r + 3), (r + 2, -r), (-r - 2, -r)],
        };
        let corners: Vec<Place> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
        self.root.draw(&Polygon::new(corners, colour.filled())).map_err(failed)
    }

    pub fn ring(&self, at: Place) -> Result<()> {
        self.root.draw(&Circle::new(at, RING, INK.stroke_width(3))).map_err(failed)
    }
}

/// The dashes along a line through some places.
fn dashes(places: &[Place]) -> Vec<Vec<Place>> {
    let whole = |(x, y): (f64, f64)| (x.round() as i32, y.round() as i32);
    let (mut all, mut dash) = (Vec::new(), places.first().copied().into_iter().collect::<Vec<_>>());
    let (mut drawn, mut left) = (true, f64::from(DASH));
    for pair in places.windows(2) {
        let [mut here, to] = [pair[0], pair[1]].map(|(x, y)| (f64::from(x), f64::from(y)));
        loop {
            let way = (to.0 - here.0, to.1 - here.1);
            let far = way.0.hypot(way.1);
            if far <= left {
                left -= far;
                dash.push(pair[1]);
                break;
            }
            here = (here.0 + way.0 * left / far, here.1 + way.1 * left / far);
            dash.push(whole(here));
            let ended = std::mem::replace(&mut dash, vec![whole(here)]);
            if drawn {
                all.push(ended);
            }
            drawn = !drawn;
            left = f64::from(if drawn { DASH } else { DASH / 2 });
        }
    }
    all.extend(drawn.then_some(dash));
    // A stroke of no length is no stroke.
    all.iter_mut().for_each(Vec::dedup);
    all.retain(|dash| dash.len() > 1);
    all
}

fn font(size: i32) -> TextStyle<'static> {
    TextStyle::from(("sans-serif", size).into_font()).color(&INK)
}

fn failed(why: impl Display) -> Error {
    Error::check(format!("picture: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_go_round_corners_and_none_is_a_point() {
        let line = dashes(&[(0, 0), (20, 0), (20, 20)]);
        assert_eq!(line, [vec![(0, 0), (18, 0)], vec![(20, 7), (20, 20)]]);
        assert_eq!(dashes(&[(0, 0), (27, 0)]), [[(0, 0), (18, 0)]]);
        assert!(dashes(&[(5, 5), (5, 5)]).is_empty() && dashes(&[]).is_empty());
    }
}
