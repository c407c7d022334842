//! Bodies as pixels.

use super::body::Body;
use super::camera::View;
use super::frame::Frame;
use super::shade;

/// Pixels row by row from the top, sRGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pixels {
    /// Width and height \[px\].
    pub size_px: (u32, u32),
    /// Colour of every pixel.
    pub rgb: Vec<[u8; 3]>,
}

impl Pixels {
    /// All white.
    #[must_use]
    pub fn white(size_px: (u32, u32)) -> Self {
        Self { size_px, rgb: vec![[255; 3]; size_px.0 as usize * size_px.1 as usize] }
    }

    /// Puts other pixels over these, their upper left corner at a place. Rows that do not fit are left out.
    pub fn paste(&mut self, (left, top): (u32, u32), other: &Self) {
        let (width, wide) = (self.size_px.0 as usize, other.size_px.0 as usize);
        for (y, row) in other.rgb.chunks_exact(wide.max(1)).enumerate() {
            let from = (top as usize + y) * width + left as usize;
            if let Some(to) = self.rgb.get_mut(from..from + row.len()) {
                to.copy_from_slice(row);
            }
        }
    }

    /// Mixes a colour into a pixel, `cover` from 0 to 1; outside nothing.
    pub(super) fn blend(&mut self, (x, y): (usize, usize), colour: [u8; 3], cover: f32) {
        if x >= self.size_px.0 as usize {
            return;
        }
        if let Some(pixel) = self.rgb.get_mut(y * self.size_px.0 as usize + x) {
            *pixel = std::array::from_fn(|c| {
                let (from, to) = (f32::from(pixel[c]), f32::from(colour[c]));
                (from + cover * (to - from)).round() as u8
            });
        }
    }

    /// Fills a rectangle, left, top, width and height.
    pub(super) fn fill(&mut self, [left, top, width, height]: [u32; 4], colour: [u8; 3]) {
        for (x, y) in (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y))) {
            self.blend((x as usize, y as usize), colour, 1.0);
        }
    }
}

/// Draws bodies on white; values from `range[0]` to `range[1]` take the palette's colours from end to end,
/// lines are `wire_px` fine pixels wide. Each pixel is the mean of `fine` by `fine`. Memory: 32 bytes a fine
/// pixel; time: a second for some million of them.
#[must_use]
pub fn raster(bodies: &[Body], view: View, range: [f64; 2], fine: u32, wire_px: f32) -> Pixels {
    let size_px = view.size_px();
    let view = view.finer(fine);
    let mut frame = Frame::new(&view);
    bodies.iter().for_each(|body| frame.draw(&view, body, range, wire_px));
    let light = shade::shade(&frame);
    Pixels { size_px, rgb: shade::shrink(&light, frame.width, fine as usize) }
}
