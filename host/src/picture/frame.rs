//! The nearest surface at every pixel: depth, normal, colour.

use super::body::{Body, Paint};
use super::camera::View;
use super::palette;
use crate::mesh::corner_normals;

/// Lines lie this much nearer than the surface that they are drawn on \[px\].
const WIRE_LIFT: f32 = 4.0;
/// Least cosine between planes across whose edge light is smoothed.
const SMOOTH: f64 = 0.6;

/// What is seen at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    /// Towards the eye \[px\]; minus infinity where nothing is.
    pub depth: f32,
    /// Unit normal of the side that is seen: right, up, towards the eye.
    pub normal: [f32; 3],
    /// Amounts of light that the surface gives back.
    pub colour: [f32; 3],
    /// Whether a line covers it.
    pub wire: bool,
    /// Whether light leaves it alone.
    pub unlit: bool,
}

const NOTHING: Seen = Seen {
    depth: f32::NEG_INFINITY,
    normal: [0.0; 3],
    colour: [1.0; 3],
    wire: false,
    unlit: false,
};

/// A point of a body on the picture.
#[derive(Clone, Copy)]
struct Vertex {
    at: [f32; 3],
    part: f32,
}

/// A picture under way.
pub(super) struct Frame {
    pub width: usize,
    pub height: usize,
    /// Row by row from the top.
    pub pixels: Vec<Seen>,
}

impl Frame {
    /// Nothing seen yet.
    pub fn new(view: &View) -> Self {
        let (width, height) = (view.size_px().0 as usize, view.size_px().1 as usize);
        Self { width, height, pixels: vec![NOTHING; width * height] }
    }

    /// Draws a body; values from `range[0]` to `range[1]` take the colours from end to end. Lines
    /// are `wire_px` wide.
    pub fn draw(&mut self, view: &View, body: &Body, range: [f64; 2], wire_px: f32) {
        let part = |at: usize| match &body.paint {
            Paint::Plain(_) => 0.0,
            Paint::Values(values) => {
                let value = values.get(at).copied().unwrap_or(f64::NAN);
                ((value - range[0]) / (range[1] - range[0])) as f32
            }
        };
        let points = body.points_m.iter().enumerate();
        let vertices: Vec<Vertex> = points
            .map(|(at, &point)| Vertex { at: view.place(point).map(|x| x as f32), part: part(at) })
            .collect();
        let plain = match body.paint {
            Paint::Plain(colour) => Some(palette::linear(colour)),
            Paint::Values(_) => None,
        };
        let normals = corner_normals(&body.points_m, &body.triangles, SMOOTH);
        for (triangle, normals) in body.triangles.iter().zip(normals) {
            let Some(normals) = normals else { continue };
            let normals = normals.map(|normal| view.turn(normal).map(|x| x as f32));
            let corners = triangle.map(|id| vertices[id as usize]);
            self.triangle(corners, normals, plain, body.unlit);
        }
        for [a, b] in &body.wires {
            if let (Some(a), Some(b)) = (vertices.get(*a as usize), vertices.get(*b as usize)) {
                self.wire(a.at, b.at, wire_px);
            }
        }
    }

    fn triangle(
        &mut self,
        [a, b, c]: [Vertex; 3],
        normals: [[f32; 3]; 3],
        plain: Option<[f32; 3]>,
        unlit: bool,
    ) {
        // Rows count downwards: a side that turns counter-clockwise, the normals' own, has a negative area.
        let area = edge(a.at, b.at, c.at);
        if !area.is_normal() {
            return;
        }
        let side = if area < 0.0 { 1.0 } else { -1.0 };
        let span = |axis: usize, room: usize| {
            let [a, b, c] = [a.at[axis], b.at[axis], c.at[axis]];
            let (from, to) = (a.min(b).min(c).max(0.0), a.max(b).max(c).min(room as f32));
            from.floor() as usize..(to.ceil() as usize).min(room)
        };
        for y in span(1, self.height) {
            for x in span(0, self.width) {
                let at = [x as f32 + 0.5, y as f32 + 0.5, 0.0];
                let u = [edge(b.at, c.at, at), edge(c.at, a.at, at), edge(a.at, b.at, at)]
                    .map(|u| u / area);
                if u.iter().any(|&u| u < 0.0) {
                    continue;
                }
                let mix = |of: [f32; 3]| u[0] * of[0] + u[1] * of[1] + u[2] * of[2];
                let depth = mix([a.at[2], b.at[2], c.at[2]]);
                let Some(pixel) = self.pixels.get_mut(y * self.width + x) else { continue };
                if depth <= pixel.depth {
                    continue;
                }
                let normal = std::array::from_fn(|axis| side * mix(normals.map(|of| of[axis])));
                let part = mix([a.part, b.part, c.part]);
                let colour = plain.unwrap_or_else(|| palette::light(part.into()));
                *pixel = Seen { depth, normal: unit(normal), colour, wire: false, unlit };
            }
        }
    }

    /// A line on the surface, hidden where something is in front.
    fn wire(&mut self, from: [f32; 3], to: [f32; 3], width: f32) {
        let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).ceil().max(1.0);
        let half = (0.5 * width) as i64;
        for step in 0..=steps as u32 {
            let part = step as f32 / steps;
            let [x, y, depth] =
                std::array::from_fn(|axis| from[axis] + part * (to[axis] - from[axis]));
            for (dx, dy) in (-half..=half).flat_map(|dx| (-half..=half).map(move |dy| (dx, dy))) {
                let (x, y) = (x as i64 + dx, y as i64 + dy);
                if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
                    continue;
                }
                let pixel = &mut self.pixels[y as usize * self.width + x as usize];
                let on_surface = pixel.depth.is_finite() && depth + WIRE_LIFT >= pixel.depth;
                pixel.wire |= on_surface;
            }
        }
    }
}

/// Twice the signed area of a triangle on the picture.
fn edge(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Of length one.
fn unit(normal: [f32; 3]) -> [f32; 3] {
    let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length < 1e-6 { [0.0, 0.0, 1.0] } else { normal.map(|x| x / length) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(height: f64, colour: [u8; 3]) -> Body {
        let points_m = vec![[0.0, 0.0, height], [1.0, 0.0, height], [0.0, 1.0, height]];
        let (triangles, paint) = (vec![[0, 1, 2]], Paint::Plain(colour));
        Body { points_m, triangles, paint, wires: vec![], unlit: false }
    }

    /// From above, y up: the unit square over 10 by 10 pixels.
    fn view() -> View {
        let corners = [[0.0; 3], [1.0, 1.0, 0.0]];
        View::fit(corners.iter(), [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], (10, 10), 0.0)
    }

    fn drawn(bodies: &[Body]) -> Frame {
        let mut frame = Frame::new(&view());
        bodies.iter().for_each(|body| frame.draw(&view(), body, [0.0, 1.0], 1.0));
        frame
    }

    #[test]
    fn a_triangle_covers_its_half_of_the_square() {
        let frame = drawn(&[triangle(0.0, [255, 0, 0])]);
        let covered = |x: usize, y: usize| frame.pixels[10 * y + x].depth.is_finite();
        // Its right angle stands at the lower left.
        assert!(covered(0, 9) && covered(8, 9) && covered(0, 1) && covered(4, 6));
        assert!(!covered(9, 0) && !covered(6, 2) && !covered(9, 8));
        let pixel = frame.pixels[10 * 6 + 2];
        assert_eq!((pixel.colour, pixel.normal), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
    }

    #[test]
    fn the_nearer_one_is_seen_whatever_the_order() {
        let (near, far) = (triangle(0.5, [255, 0, 0]), triangle(-0.5, [0, 255, 0]));
        for order in [[near.clone(), far.clone()], [far, near]] {
            assert_eq!(drawn(&order).pixels[10 * 6 + 2].colour, [1.0, 0.0, 0.0]);
        }
    }

    /// The sides of a box have the light of their own plane up to its edges, however many triangles meet there.
    #[test]
    fn sides_that_meet_at_an_edge_are_not_smoothed() {
        let points_m: Vec<[f64; 3]> =
            (0..8).map(|at| [1, 2, 4].map(|bit| f64::from(u8::from(at & bit != 0)))).collect();
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let paint = Paint::Plain([200; 3]);
        let cube = Body { points_m, triangles, paint, wires: vec![], unlit: false };
        let view = View::fit(cube.points_m.iter(), [1.0, 0.6, 0.8], [0.0, 0.0, 1.0], (60, 60), 2.0);
        let mut frame = Frame::new(&view);
        frame.draw(&view, &cube, [0.0, 1.0], 0.0);
        let mut seen: Vec<[i32; 3]> = (frame.pixels.iter().filter(|pixel| pixel.depth.is_finite()))
            .map(|pixel| pixel.normal.map(|x| (1e3 * x).round() as i32))
            .collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 3, "the first: {:?}", &seen[..seen.len().min(9)]);
        assert!(seen.iter().all(|normal| normal[2] > 0), "{seen:?}");
    }

    #[test]
    fn lines_lie_on_their_surface_and_hide_behind_others() {
        let mut lined = triangle(0.0, [255, 0, 0]);
        lined.wires = vec![[1, 2]];
        let wired = |frame: &Frame| frame.pixels.iter().filter(|pixel| pixel.wire).count();
        assert!(wired(&drawn(&[lined.clone()])) > 5);
        assert_eq!(wired(&drawn(&[triangle(1.0, [0; 3]), lined])), 0);
    }
}
