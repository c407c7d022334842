//! Texts on pixels.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::raster::Pixels;

/// Height of a line \[px\].
pub(super) const LINE_PX: u32 = 24;

/// Width of a text \[px\].
pub(super) fn width(text: &str) -> u32 {
    (text.chars().count() * get_raster_width(FontWeight::Regular, RasterHeight::Size24)) as u32
}

/// Writes a text in dark grey, its upper left corner at a place; a character that the font has not is `?`.
/// What lies outside is left out.
pub(super) fn write(pixels: &mut Pixels, (left, top): (u32, u32), text: &str) {
    let raster = |letter| get_raster(letter, FontWeight::Regular, RasterHeight::Size24);
    let mut left = left as usize;
    for letter in text.chars() {
        let Some(glyph) = raster(letter).or_else(|| raster('?')) else { continue };
        for (y, row) in glyph.rows().enumerate() {
            for (x, &cover) in row.iter().enumerate() {
                pixels.blend((left + x, top as usize + y), [30; 3], f32::from(cover) / 255.0);
            }
        }
        left += glyph.width();
    }
}
