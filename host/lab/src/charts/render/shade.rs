//! Light on what is seen: key, fill and sky, corners, distance, a shadow on the ground.

use super::body::Body;
use super::camera::View;
use super::frame::{Frame, Seen};
use super::palette;
use crate::reference::vectors::{self, norm, plus};

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
/// How far the farthest point fades to white.
const FADE: f32 = 0.06;
/// Darkness of the ground's shadow, and the width of its rim as a part of the picture's width.
const SHADOW: f32 = 0.30;
const RIM: f32 = 0.012;
/// What a line leaves of the light.
const WIRE: f32 = 0.42;

/// Light of every pixel of a frame, on a white ground with the shadow `ground` (0 to 1).
pub(super) fn shade(frame: &Frame, ground: Option<&[f32]>) -> Vec<[f32; 3]> {
    let depths = || frame.pixels.iter().map(|pixel| pixel.depth).filter(|depth| depth.is_finite());
    let (far, near) =
        depths().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), d| (a.min(d), b.max(d)));
    let around = spiral(REACH * frame.width as f32);
    let reach = REACH * frame.width as f32;
    let lit = frame.pixels.iter().enumerate().map(|(at, pixel)| {
        if !pixel.depth.is_finite() {
            let dark = ground.and_then(|ground| ground.get(at)).copied().unwrap_or(0.0);
            return [1.0 - SHADOW * dark; 3];
        }
        let open = 1.0 - (CORNERS * corner(frame, at, &around, reach)).min(0.85);
        let distance = (near - pixel.depth) / (near - far).max(1e-6);
        let haze = FADE * distance * distance;
        surface(pixel, open).map(|c| c + haze * (1.0 - c))
    });
    lit.collect()
}

/// Light from one pixel's surface.
fn surface(pixel: &Seen, open: f32) -> [f32; 3] {
    if pixel.unlit {
        return pixel.colour;
    }
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

/// The bodies pressed flat on the ground below them, light falling against `up`.
pub(super) fn fallen(bodies: &[Body], up: [f64; 3]) -> Vec<Body> {
    let size = norm(up).max(1e-12);
    let up = up.map(|x| x / size);
    let tall = |p: &[f64; 3]| vectors::dot(*p, up);
    let points = || bodies.iter().flat_map(|body| &body.points_m);
    let (low, high) = points()
        .map(tall)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
    let floor = low - 0.02 * (high - low);
    let down = |p: &[f64; 3]| plus(*p, floor - tall(p), up);
    let flat = bodies.iter().map(|body| Body {
        points_m: body.points_m.iter().map(down).collect(),
        wires: Vec::new(),
        ..body.clone()
    });
    flat.collect()
}

/// The shadow on the ground: 0 to 1 a pixel.
pub(super) fn ground(view: &View, bodies: &[Body], up: [f64; 3]) -> Vec<f32> {
    let (width, height) = (view.size_px().0 as usize, view.size_px().1 as usize);
    let mut flat = Frame::new(view);
    for shadow in fallen(bodies, up) {
        flat.draw(view, &shadow, [0.0, 1.0], 0.0);
    }
    let mut dark: Vec<f32> =
        flat.pixels.iter().map(|pixel| f32::from(u8::from(pixel.depth.is_finite()))).collect();
    let rim = (RIM * width as f32) as usize;
    for _ in 0..3 {
        dark = smooth(&smooth(&dark, width, height, rim), height, width, rim);
    }
    dark
}

/// Means over `2 rim + 1` pixels along the rows, the picture turned over its diagonal.
fn smooth(values: &[f32], width: usize, height: usize, rim: usize) -> Vec<f32> {
    let mut turned = vec![0.0; values.len()];
    let window = (2 * rim + 1) as f32;
    for (y, row) in values.chunks_exact(width).enumerate() {
        let mut sum: f32 = row.iter().take(rim).sum();
        for x in 0..width {
            sum += row.get(x + rim).copied().unwrap_or(0.0);
            if x > rim {
                sum -= row[x - rim - 1];
            }
            turned[x * height + y] = sum / window;
        }
    }
    turned
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
    use crate::charts::render::Paint;

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
            let lit = shade(&frame, None);
            let foot = view.place([0.51, 0.5, 0.0]);
            lit[foot[1] as usize * 200 + foot[0] as usize][0]
        });
        assert!(walled < 0.9 * flat, "{walled} {flat}");
    }

    #[test]
    fn a_shadow_lies_under_the_body_with_a_soft_rim() {
        let view =
            View::fit(square().points_m.iter(), [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], (200, 200), 50.0);
        let dark = ground(&view, &[square()], [0.0, 0.0, 1.0]);
        assert!(dark[100 * 200 + 100] > 0.999 && dark[5 * 200 + 5] < 1e-6);
        assert!((0.2..0.8).contains(&dark[100 * 200 + 50]));
    }

    #[test]
    fn pixels_are_means_of_light() {
        let light = [[1.0; 3], [0.0; 3], [0.0; 3], [1.0; 3]];
        assert_eq!(shrink(&light, 2, 2), [[188; 3]]);
    }
}
