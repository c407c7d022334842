//! Light on what is seen: key, fill and sky, darker in corners.

use super::frame::{Frame, Seen};
use super::palette;

/// Towards the key light and the fill light: right, up, towards the eye.
const KEY: [f32; 3] = [-0.42, 0.55, 0.72];
const FILL: [f32; 3] = [0.8, 0.1, 0.6];
const KEY_LIGHT: f32 = 0.72;
const FILL_LIGHT: f32 = 0.16;
const SKY_LIGHT: f32 = 0.36;
const GLOSS: f32 = 0.06;
/// How much a corner that sees half the sky loses of it.
const CORNERS: f32 = 2.2;
/// Samples around a pixel, and how far they go as a part of the picture's width.
const SAMPLES: u32 = 36;
const REACH: f32 = 0.045;
/// Distance of the pixels at which corners are looked for, and how far from each other they are taken for one
/// surface: height over the tangent plane, cosine between normals.
const STEP: usize = 4;
const BEND: f32 = 2.0;
const TURN: f32 = 0.9;
/// What a line leaves of the light.
const WIRE: f32 = 0.42;

/// Light of every pixel of a frame, on a white ground.
pub(super) fn shade(frame: &Frame) -> Vec<[f32; 3]> {
    let corners = Corners::new(frame);
    let lit = frame.pixels.iter().enumerate().map(|(at, pixel)| {
        if !pixel.depth.is_finite() {
            return [1.0; 3];
        }
        if pixel.unlit {
            return pixel.colour;
        }
        let open = 1.0 - (CORNERS * corners.at(at)).min(0.85);
        surface(pixel, open)
    });
    lit.collect()
}

/// How much of the sky is hidden, looked for at every few pixels.
struct Corners<'a> {
    frame: &'a Frame,
    around: Vec<(i64, i64)>,
    reach: f32,
    /// Places in a row of the grid.
    columns: usize,
    /// Row by row; the places lie [`STEP`] pixels apart, and on the last pixels.
    hidden: Vec<f32>,
}

impl<'a> Corners<'a> {
    fn new(frame: &'a Frame) -> Self {
        let reach = REACH * frame.width as f32;
        let [columns, rows] = [frame.width, frame.height].map(|length| length / STEP + 2);
        let corners = Self { frame, around: spiral(reach), reach, columns, hidden: Vec::new() };
        let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        let hidden = places.map(|(x, y)| {
            let at = corners.pixel(x, y);
            if frame.pixels[at].depth.is_finite() { corners.look(at) } else { 0.0 }
        });
        let hidden = hidden.collect();
        Self { hidden, ..corners }
    }

    /// Index of the pixel of a place of the grid.
    fn pixel(&self, x: usize, y: usize) -> usize {
        let (x, y) = (x * STEP, y * STEP);
        y.min(self.frame.height - 1) * self.frame.width + x.min(self.frame.width - 1)
    }

    /// Between the four places around where these are on the pixel's surface, else looked for at the pixel.
    fn at(&self, at: usize) -> f32 {
        let (x, y) = (at % self.frame.width, at / self.frame.width);
        let share = [x, y].map(|along| (along % STEP) as f32 / STEP as f32);
        let mut sum = 0.0;
        for (right, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (column, row) = (x / STEP + right, y / STEP + down);
            if !self.is_one_surface(at, self.pixel(column, row)) {
                return self.look(at);
            }
            let weight = [(right, share[0]), (down, share[1])]
                .map(|(step, share)| if step == 1 { share } else { 1.0 - share });
            sum += weight[0] * weight[1] * self.hidden[row * self.columns + column];
        }
        sum
    }

    fn is_one_surface(&self, at: usize, other: usize) -> bool {
        let [own, far] = [at, other].map(|at| &self.frame.pixels[at]);
        let width = self.frame.width;
        let along = |at: usize| [(at % width) as f32, -((at / width) as f32)];
        let (from, to) = (along(at), along(other));
        let way = [to[0] - from[0], to[1] - from[1], far.depth - own.depth];
        far.depth.is_finite()
            && dot(way, own.normal).abs() <= BEND
            && dot(own.normal, far.normal) >= TURN
    }

    /// How much of the sky the surface around a pixel hides, 0 to about 1/2.
    fn look(&self, at: usize) -> f32 {
        corner(self.frame, at, &self.around, self.reach)
    }
}

/// Light from one pixel's surface.
fn surface(pixel: &Seen, open: f32) -> [f32; 3] {
    let n = pixel.normal;
    let key = dot(n, KEY).max(0.0) * (0.5 + 0.5 * open);
    let fill = dot(n, FILL).max(0.0);
    let sky = SKY_LIGHT * (0.75 + 0.25 * n[1]) * open;
    // Half way between the key light and the eye.
    let half = [KEY[0], KEY[1], KEY[2] + 1.0];
    let shine = (dot(n, half) / dot(half, half).sqrt()).max(0.0).powi(40);
    let light = KEY_LIGHT * key + FILL_LIGHT * fill + sky;
    let wire = if pixel.wire { WIRE } else { 1.0 };
    pixel.colour.map(|c| wire * (c * light + GLOSS * shine * open))
}

/// Offsets of the samples, evenly over a disc.
fn spiral(reach: f32) -> Vec<(i64, i64)> {
    let golden = 2.399_963_2_f32;
    let sample = |at: u32| {
        let part = (at as f32 + 0.5) / SAMPLES as f32;
        let (sine, cosine) = (golden * at as f32).sin_cos();
        ((reach * part.sqrt() * cosine) as i64, (reach * part.sqrt() * sine) as i64)
    };
    (0..SAMPLES).map(sample).filter(|&offset| offset != (0, 0)).collect()
}

/// How much of the sky the surface around hides, 0 to about 1/2.
fn corner(frame: &Frame, at: usize, around: &[(i64, i64)], reach: f32) -> f32 {
    let Seen { depth, normal, .. } = frame.pixels[at];
    let (x, y) = ((at % frame.width) as i64, (at / frame.width) as i64);
    let mut hidden = 0.0;
    for &(dx, dy) in around {
        let (sx, sy) = (x + dx, y + dy);
        if sx < 0 || sy < 0 || sx as usize >= frame.width || sy as usize >= frame.height {
            continue;
        }
        let other = frame.pixels[sy as usize * frame.width + sx as usize].depth;
        if !other.is_finite() {
            continue;
        }
        let way = [dx as f32, -dy as f32, other - depth];
        let squared = dot(way, way);
        let high = dot(way, normal) / squared.sqrt();
        hidden += (high - 0.12).max(0.0) / (1.0 + squared / (9.0 * reach * reach));
    }
    hidden / around.len().max(1) as f32
}

/// Bytes of a picture whose every pixel is the mean of `fine` by `fine` of these.
pub(super) fn shrink(light: &[[f32; 3]], width: usize, fine: usize) -> Vec<[u8; 3]> {
    let rows = light.chunks_exact(width * fine);
    let share = 1.0 / (fine * fine) as f32;
    let pixels = rows.flat_map(|rows| {
        (0..width / fine).map(move |x| {
            let mut sum = [0.0; 3];
            for pixel in (0..fine).flat_map(|y| &rows[y * width + x * fine..][..fine]) {
                (0..3).for_each(|c| sum[c] += share * pixel[c].min(1.0));
            }
            palette::encode(sum)
        })
    });
    pixels.collect()
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::body::{Body, Paint};
    use crate::picture::camera::View;

    fn square() -> Body {
        let points_m = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let (triangles, paint) = (vec![[0, 1, 2], [0, 2, 3]], Paint::Plain([200; 3]));
        Body { points_m, triangles, paint, wires: vec![], unlit: false }
    }

    #[test]
    fn a_flat_surface_has_no_corners_and_a_wall_makes_one() {
        let mut wall = square();
        wall.points_m = vec![[0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, 1.0, 0.9], [0.5, 0.0, 0.9]];
        let [flat, walled] = [vec![square()], vec![square(), wall]].map(|bodies| {
            let points = bodies.iter().flat_map(|body| &body.points_m);
            let view = View::fit(points, [0.3, 0.0, 1.0], [0.0, 1.0, 0.0], (200, 200), 20.0);
            let mut frame = Frame::new(&view);
            bodies.iter().for_each(|body| frame.draw(&view, body, [0.0, 1.0], 0.0));
            let lit = shade(&frame);
            let foot = view.place([0.51, 0.5, 0.0]);
            lit[foot[1] as usize * 200 + foot[0] as usize][0]
        });
        assert!(walled < 0.9 * flat, "{walled} {flat}");
    }
}
