//! Faces that a strip opens: the part of the body at rest between two places of a piece of an edge.
//!
//! A face opens when the strip crosses the line between the middles of its two tetrahedra. Consecutive strips
//! share a border, so that no line slips between them; a line on the border belongs to both, and a middle on the
//! strip lies on its positive side. Looked at are the faces of the tetrahedra that the edge passes, before and
//! after.

use super::body::CutBody;
use super::place::Point;
use crate::number::cell::{dot, sub};
use crate::number::turn::cross;

/// Most tetrahedra that a strip passes.
const PASSED_MAX: usize = 20;

/// Two ends of a piece of an edge at rest, before and after.
#[derive(Clone, Copy)]
pub(super) struct Strip {
    pub before: [[f32; 3]; 2],
    pub after: [[f32; 3]; 2],
}

/// Six times the volume of a tetrahedron.
fn volume(a: [f32; 3], b: [f32; 3], c: [f32; 3], d: [f32; 3]) -> f32 {
    dot(cross(sub(b, a), sub(c, a)), sub(d, a))
}

/// Returns true if a line crosses a triangle; a point on its plane lies on the positive side.
fn crosses([p, q]: [[f32; 3]; 2], [a, b, c]: [[f32; 3]; 3]) -> bool {
    let is_above = |point| volume(a, b, c, point) >= 0.0;
    let around = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    let is_through = around.iter().all(|x| *x >= 0.0) || around.iter().all(|x| *x <= 0.0);
    is_through && is_above(p) != is_above(q)
}

impl Strip {
    fn crosses(&self, line: [[f32; 3]; 2]) -> bool {
        let ([a, b], [c, d]) = (self.before, self.after);
        crosses(line, [a, b, d]) || crosses(line, [a, d, c])
    }
}

impl CutBody<'_, '_> {
    /// Opens the faces that a strip crosses; the first end of the edge is in these tetrahedra, before and after.
    pub(super) fn open_strip(&mut self, strip: &Strip, tetrahedra: [usize; 2]) {
        // Collect the tetrahedra that the edge passes.
        let (mut passed, mut count) = ([0; PASSED_MAX], 0);
        for (tetrahedron, [start, end]) in tetrahedra.into_iter().zip([strip.before, strip.after]) {
            let start = Point { tetrahedron, rest: start };
            self.walk(start, end, |tetrahedron| {
                let is_known = passed.iter().take(count).any(|&known| known == tetrahedron);
                if let Some(slot) = passed.get_mut(count).filter(|_| !is_known) {
                    *slot = tetrahedron;
                    count += 1;
                }
            });
        }
        // Look at their closed faces.
        for tetrahedron in passed.into_iter().take(count) {
            for corner in 0..4 {
                if self.is_crossed(strip, tetrahedron, corner) {
                    self.open_face(tetrahedron, corner);
                }
            }
        }
    }

    /// Returns true if a strip crosses the line between the middles of a closed face's tetrahedra.
    fn is_crossed(&self, strip: &Strip, tetrahedron: usize, corner: usize) -> bool {
        let other = self.across(tetrahedron, corner);
        let other = other.filter(|_| !self.is_open(tetrahedron, corner));
        let middles = other.and_then(|(other, _)| {
            Some([self.middle_at_rest(tetrahedron)?, self.middle_at_rest(other)?])
        });
        middles.is_some_and(|middles| strip.crosses(middles))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_strips_leave_no_line_out() {
        // Two strips side by side and one behind the first: lines through every point of all three.
        let square = |x: f32, y: f32| Strip {
            before: [[x, y, 0.0], [x + 1.0, y, 0.0]],
            after: [[x, y + 1.0, 0.0], [x + 1.0, y + 1.0, 0.0]],
        };
        let strips = [square(0.0, 0.0), square(1.0, 0.0), square(0.0, 1.0)];
        for place in 0..400 {
            let (x, y) = (0.125 * (place % 20) as f32, 0.125 * (place / 20) as f32);
            let line = [[x, y, -0.5], [x, y, 0.5]];
            let count = strips.iter().filter(|strip| strip.crosses(line)).count();
            let is_over = (x <= 2.0 && y <= 1.0) || (x <= 1.0 && y <= 2.0);
            assert_eq!(count > 0, is_over, "{x} {y}: {count}");
        }
        // On the plane is above it.
        let on = |z: f32| strips[0].crosses([[0.5, 0.25, z], [0.5, 0.25, 1.0]]);
        assert!(!on(0.0) && on(-0.1));
    }
}
