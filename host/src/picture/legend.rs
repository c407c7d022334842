//! Texts of a picture: title, what the colours mean, and a scale bar.

use super::chart::ticks;
use super::letters::{self, LINE_PX};
use super::palette;
use super::raster::Pixels;

/// Width of the legend, at the right edge \[px\].
pub(super) const WIDTH_PX: u32 = 250;
/// Air around texts \[px\].
const MARGIN: u32 = 20;
/// Width of the colour bar, and of the mark at a value \[px\].
const BAR: u32 = 32;
const MARK: u32 = 8;
/// Longest scale bar \[px\].
const SCALE_PX: f64 = 200.0;
const INK: [u8; 3] = [30; 3];

/// Writes title, legend of displacements from `range_mm` and scale bar on a picture.
pub(super) fn write(pixels: &mut Pixels, title: &str, range_mm: [f64; 2], pixels_per_m: f64) {
    let (width, height) = pixels.size_px;
    letters::write(pixels, (MARGIN, MARGIN - 4), title);
    scale_bar(pixels, height - MARGIN, pixels_per_m);
    // The bar with a value at each of its marks; its name above.
    let label = "displacement [mm]";
    letters::write(pixels, (width - MARGIN - letters::width(label), 2 * MARGIN + LINE_PX), label);
    let left = width - WIDTH_PX + 60;
    let (top, bottom) = (3 * MARGIN + 3 * LINE_PX, height - 3 * MARGIN);
    let long = bottom - top;
    for y in 0..long {
        let part = 1.0 - (f64::from(y) + 0.5) / f64::from(long);
        pixels.fill([left, top + y, BAR, 1], palette::srgb(part));
    }
    frame(pixels, [left, top, BAR, long]);
    for (value, label) in ticks(range_mm, 6) {
        let part = (value - range_mm[0]) / (range_mm[1] - range_mm[0]);
        let y = top + (f64::from(long) * (1.0 - part)).round() as u32;
        pixels.fill([left + BAR, y.max(1) - 1, MARK, 2], INK);
        letters::write(pixels, (left + BAR + MARK + 6, y - LINE_PX / 2), &label);
    }
}

/// A thin line around a rectangle.
fn frame(pixels: &mut Pixels, [left, top, width, height]: [u32; 4]) {
    pixels.fill([left, top, width, 1], INK);
    pixels.fill([left, top + height - 1, width, 1], INK);
    pixels.fill([left, top, 1, height], INK);
    pixels.fill([left + width - 1, top, 1, height], INK);
}

/// A round length at the lower left, its ends marked.
fn scale_bar(pixels: &mut Pixels, bottom: u32, pixels_per_m: f64) {
    let (length_m, label) = round_length(SCALE_PX / pixels_per_m);
    let long = (length_m * pixels_per_m).round() as u32;
    pixels.fill([MARGIN, bottom - 2, long, 2], INK);
    pixels.fill([MARGIN, bottom - 10, 2, 10], INK);
    pixels.fill([MARGIN + long - 2, bottom - 10, 2, 10], INK);
    letters::write(pixels, (MARGIN + 8, bottom - 6 - LINE_PX), &label);
}

/// The largest of 1, 2 and 5 times a power of ten that is no longer than `most_m`, with its label in mm.
#[must_use]
pub fn round_length(most_m: f64) -> (f64, String) {
    let power = 10_f64.powf(most_m.log10().floor());
    let lead = [5.0, 2.0].into_iter().find(|lead| lead * power <= most_m).unwrap_or(1.0);
    let length_m = lead * power;
    // Nine digits hide the rounding of the power.
    let millimetres = format!("{:.9}", 1e3 * length_m);
    (length_m, format!("{} mm", millimetres.trim_end_matches('0').trim_end_matches('.')))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_are_round() {
        for (most_m, label) in
            [(0.0199, "10 mm"), (0.02, "20 mm"), (0.7, "500 mm"), (3e-6, "0.002 mm")]
        {
            assert_eq!(round_length(most_m).1, label, "{most_m}");
        }
    }
}
