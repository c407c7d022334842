//! What stands on a chart beside its axes, in pixels, with the font that comes along.

use std::fmt::Display;
use std::sync::OnceLock;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::SIZE_PX;
use chaincell_host::error::{Error, Result};

/// A place on the canvas \[px\], y downwards.
pub(super) type Place = (i32, i32);
/// The whole picture, or a part of it.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

pub(super) const INK: RGBColor = RGBColor(30, 30, 30);
/// Font sizes as plotters counts them: 1.24 times the em \[px\].
pub(super) const TITLE: i32 = 42;
pub(super) const TEXT: i32 = 36;
pub(super) const SMALL: i32 = 32;

const MARKER: i32 = 9;
const DASH: i32 = 18;

/// A white picture that writes into `text`.
pub(super) fn open(text: &mut String) -> Result<Area<'_>> {
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

/// Width of a text, and the height of its line whatever letters it has \[px\].
pub(super) fn measure(area: &Area<'_>, text: &str, size: i32) -> Result<Place> {
    let (wide, _) = area.estimate_text_size(text, &font(size)).map_err(failed)?;
    Ok((i32::try_from(wide).map_err(failed)?, size))
}

/// The size, at most `size`, at which a text is no longer than `room` \[px\].
pub(super) fn fit(area: &Area<'_>, text: &str, size: i32, room: i32) -> Result<i32> {
    let (wide, _) = measure(area, text, size)?;
    Ok(if wide > room { size * room / wide } else { size })
}

/// A text that begins at `at`, its middle at that height.
pub(super) fn text(area: &Area<'_>, text: &str, size: i32, at: Place) -> Result<()> {
    let style = font(size).pos(Pos::new(HPos::Left, VPos::Center));
    area.draw_text(text, &style, at).map_err(failed)
}

/// A small text of that size on a ground of its own, so that lines below do not cross it out.
pub(super) fn plate(area: &Area<'_>, words: &str, corner: Place, size: Place) -> Result<()> {
    let corners = [corner, (corner.0 + size.0, corner.1 + size.1)];
    area.draw(&Rectangle::new(corners, WHITE.mix(0.8).filled())).map_err(failed)?;
    text(area, words, SMALL, (corner.0, corner.1 + size.1 / 2))
}

pub(super) fn line(area: &Area<'_>, to: &[Place], colour: RGBColor, width: u32) -> Result<()> {
    area.draw(&PathElement::new(to, colour.stroke_width(width))).map_err(failed)
}

pub(super) fn dashes(area: &Area<'_>, to: &[Place], colour: RGBColor, width: u32) -> Result<()> {
    let (places, style) = (to.iter().copied(), colour.stroke_width(width));
    area.draw(&DashedPathElement::new(places, DASH, DASH / 2, style)).map_err(failed)
}

/// A marker of the given kind: circle, square, triangle, diamond, triangle on its tip.
pub(super) fn marker(area: &Area<'_>, (x, y): Place, colour: RGBColor, kind: usize) -> Result<()> {
    let r = MARKER;
    let corners: &[Place] = match kind % 5 {
        0 => return area.draw(&Circle::new((x, y), r, colour.filled())).map_err(failed),
        1 => &[(-r, -r), (r, -r), (r, r), (-r, r)],
        2 => &[(0, -r - 3), (r + 2, r), (-r - 2, r)],
        3 => &[(0, -r - 4), (r + 4, 0), (0, r + 4), (-r - 4, 0)],
        _ => &[(0, r + 3), (r + 2, -r), (-r - 2, -r)],
    };
    let corners: Vec<Place> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
    area.draw(&Polygon::new(corners, colour.filled())).map_err(failed)
}

pub(super) fn font(size: i32) -> TextStyle<'static> {
    TextStyle::from(("sans-serif", size).into_font()).color(&INK)
}

pub(super) fn failed(why: impl Display) -> Error {
    Error::check(format!("picture: {why}"))
}
