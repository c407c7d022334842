//! The nearest surface at every pixel: depth, normal, colour.

use super::body::{Body, Paint};
use super::camera::View;
use super::palette;
use crate::mesh::vertex_normals;

/// Lines lie this much nearer than the surface that they are drawn on \[px\].
const WIRE_LIFT: f32 = 4.0;

/// What is seen at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    /// Towards the eye \[px\]; minus infinity where nothing is.
    pub depth: f32,
    /// Unit normal on the side of the eye: right, up, towards the eye.
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
    normal: [f32; 3],
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
        let normals = vertex_normals(&body.points_m, &body.triangles);
        let part = |at: usize| match &body.paint {
            Paint::Plain(_) => 0.0,
            Paint::Values(values) => {
                let value = values.get(at).copied().unwrap_or(f64::NAN);
                ((value - range[0]) / (range[1] - range[0])) as f32
            }
        };
        let points = body.points_m.iter().zip(normals).enumerate();
        let vertices: Vec<Vertex> = points
            .map(|(at, (&point, normal))| Vertex {
                at: view.place(point).map(|x| x as f32),
                normal: view.turn(normal.unwrap_or_default()).map(|x| x as f32),
                part: part(at),
            })
            .collect();
        let plain = match body.paint {
            Paint::Plain(colour) => Some(palette::linear(colour)),
            Paint::Values(_) => None,
        };
        for triangle in &body.triangles {
            let [a, b, c] = triangle.map(|id| vertices.get(id as usize));
            if let (Some(a), Some(b), Some(c)) = (a, b, c) {
                self.triangle([*a, *b, *c], plain, body.unlit);
            }
        }
        for [a, b] in &body.wires {
            if let (Some(a), Some(b)) = (vertices.get(*a as usize), vertices.get(*b as usize)) {
                self.wire(a.at, b.at, wire_px);
            }
        }
    }

    fn triangle(&mut self, [a, b, c]: [Vertex; 3], plain: Option<[f32; 3]>, unlit: bool) {
        let area = edge(a.at, b.at, c.at);
        if !area.is_normal() {
            return;
        }
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
                let normal = std::array::from_fn(|axis| {
                    mix([a.normal[axis], b.normal[axis], c.normal[axis]])
                });
                let part = mix([a.part, b.part, c.part]);
                let colour = plain.unwrap_or_else(|| palette::light(part.into()));
                *pixel = Seen { depth, normal: facing(normal), colour, wire: false, unlit };
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

/// Of length one, on the side of the eye.
fn facing(normal: [f32; 3]) -> [f32; 3] {
    let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length < 1e-6 {
        return [0.0, 0.0, 1.0];
    }
    let scale = if normal[2] < 0.0 { -1.0 / length } else { 1.0 / length };
    normal.map(|x| scale * x)
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

    #[test]
    fn lines_lie_on_their_surface_and_hide_behind_others() {
        let mut lined = triangle(0.0, [255, 0, 0]);
        lined.wires = vec![[1, 2]];
        let wired = |frame: &Frame| frame.pixels.iter().filter(|pixel| pixel.wire).count();
        assert!(wired(&drawn(&[lined.clone()])) > 5);
        assert_eq!(wired(&drawn(&[triangle(1.0, [0; 3]), lined])), 0);
    }
}
