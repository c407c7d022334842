//! A tree of boxes around triangles or tetrahedra: it finds the elements near a point without testing all.

use crate::mesh::geometry::{cross, dot, minus};

/// Most elements in one box.
const LEAF: usize = 4;

/// A box with two boxes or a few elements in it.
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// First of its elements in `order`, and their number.
    first: u32,
    count: u32,
    /// Index of the second of its boxes; the first is the next node. 0 for a box of elements.
    second: u32,
}

/// Corners of elements, triangles by default, and the boxes around them.
pub(in crate::mesh) struct Tree<const N: usize = 3> {
    corners: Vec<[[f64; 3]; N]>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

/// The point of the triangles that is nearest to another.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub(super) triangle: u32,
    pub(super) place: [f64; 3],
    pub(super) part: Part,
    pub(super) square: f64,
}

/// The part of a triangle that a point of it lies on.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Part {
    Face,
    /// From this corner to the next.
    Edge(usize),
    Corner(usize),
}

impl<const N: usize> Tree<N> {
    /// Builds the tree of elements, of which there must be at least one.
    pub(in crate::mesh) fn new(corners: Vec<[[f64; 3]; N]>) -> Self {
        let order = (0..corners.len() as u32).collect();
        let mut tree = Self { corners, order, nodes: Vec::new() };
        tree.split(0, tree.corners.len());
        tree
    }

    fn split(&mut self, first: usize, end: usize) {
        let elements = self.order[first..end].iter();
        let [low, high] = bounds(elements.flat_map(|of| self.corners[*of as usize]));
        let (own, count) = (self.nodes.len(), end - first);
        self.nodes.push(Node { low, high, first: first as u32, count: count as u32, second: 0 });
        if count <= LEAF {
            return;
        }
        let extent = |axis: &usize| high[*axis] - low[*axis];
        let axis = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        let corners = &self.corners;
        let middle =
            |element: &u32| corners[*element as usize].iter().map(|c| c[axis]).sum::<f64>();
        self.order[first..end].select_nth_unstable_by(count / 2, |a, b| {
            middle(a).total_cmp(&middle(b)).then(a.cmp(b))
        });
        self.split(first, first + count / 2);
        self.nodes[own].second = self.nodes.len() as u32;
        self.split(first + count / 2, end);
    }

    /// Returns the opposite corners of the box around all elements.
    pub(super) fn bounds(&self) -> [[f64; 3]; 2] {
        [self.nodes[0].low, self.nodes[0].high]
    }

    /// Number of elements.
    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// Corners of an element.
    pub(in crate::mesh) fn corners(&self, element: u32) -> [[f64; 3]; N] {
        self.corners[element as usize]
    }

    /// Squared distance of a point from a box.
    fn square_to(&self, node: u32, place: [f64; 3]) -> f64 {
        let node = &self.nodes[node as usize];
        let away = |axis: usize| {
            let outside = (node.low[axis] - place[axis]).max(place[axis] - node.high[axis]);
            outside.max(0.0)
        };
        (0..3).map(|axis| away(axis) * away(axis)).sum()
    }

    /// Calls `take` with the elements of higher numbers whose boxes meet that of an element.
    pub(in crate::mesh) fn meeting(&self, element: u32, mut take: impl FnMut(u32)) {
        let own = bounds(self.corners[element as usize]);
        let meets = |[low, high]: [[f64; 3]; 2]| {
            (0..3).all(|axis| low[axis] <= own[1][axis] && high[axis] >= own[0][axis])
        };
        let mut open = vec![0u32];
        while let Some(at) = open.pop() {
            let node = &self.nodes[at as usize];
            if !meets([node.low, node.high]) {
                continue;
            }
            if node.second > 0 {
                open.extend([node.second, at + 1]);
                continue;
            }
            for other in &self.order[node.first as usize..][..node.count as usize] {
                if *other > element && meets(bounds(self.corners[*other as usize])) {
                    take(*other);
                }
            }
        }
    }
}

impl Tree {
    /// Returns the nearest point of the triangles.
    pub(super) fn nearest(&self, place: [f64; 3]) -> Nearest {
        let mut best = Nearest { triangle: 0, place, part: Part::Face, square: f64::INFINITY };
        let mut open = vec![(self.square_to(0, place), 0u32)];
        while let Some((square, at)) = open.pop() {
            if square >= best.square {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.second == 0 {
                for triangle in &self.order[node.first as usize..][..node.count as usize] {
                    let (near, part) = nearest_of(self.corners[*triangle as usize], place);
                    let way = minus(place, near);
                    let square = dot(way, way);
                    if square < best.square {
                        best = Nearest { triangle: *triangle, place: near, part, square };
                    }
                }
                continue;
            }
            let one = (self.square_to(at + 1, place), at + 1);
            let other = (self.square_to(node.second, place), node.second);
            let (near, far) = if one.0 <= other.0 { (one, other) } else { (other, one) };
            open.extend([far, near]);
        }
        best
    }
}

/// Returns the box around points.
#[inline]
pub(super) fn bounds(places: impl IntoIterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in places {
        for axis in 0..3 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
    [low, high]
}

/// Returns the point of a triangle nearest to a point (Ericson, Real-Time Collision Detection, 5.1.5).
fn nearest_of([a, b, c]: [[f64; 3]; 3], place: [f64; 3]) -> ([f64; 3], Part) {
    let (ab, ac) = (minus(b, a), minus(c, a));
    let along =
        |way: [f64; 3], from: [f64; 3], t: f64| [0, 1, 2].map(|axis| from[axis] + t * way[axis]);
    // Corners and edges in turn, each with its region of the plane; else the face.
    let from = minus(place, a);
    let (d1, d2) = (dot(ab, from), dot(ac, from));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Part::Corner(0));
    }
    let from = minus(place, b);
    let (d3, d4) = (dot(ab, from), dot(ac, from));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Part::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (along(ab, a, d1 / (d1 - d3)), Part::Edge(0));
    }
    let from = minus(place, c);
    let (d5, d6) = (dot(ab, from), dot(ac, from));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Part::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (along(ac, a, d2 / (d2 - d6)), Part::Edge(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (along(minus(c, b), b, share), Part::Edge(1));
    }
    let sum = va + vb + vc;
    let inside = along(ac, along(ab, a, vb / sum), vc / sum);
    (inside, Part::Face)
}

/// Returns the middle of a triangle.
pub(super) fn middle([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
}

/// Returns twice the area of a triangle, as a vector along its normal.
pub(super) fn area2([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    cross(minus(b, a), minus(c, a))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn corners() -> impl Strategy<Value = Vec<[[f64; 3]; 3]>> {
        let place = prop::array::uniform3(-1.0..1.0);
        prop::collection::vec(prop::array::uniform3(place), 1..60)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// The distance equals the least of all triangles, and no sampled point of one is nearer.
        #[test]
        fn nearest_is_that_of_all(all in corners(), place in prop::array::uniform3(-2.0..2.0)) {
            let tree = Tree::new(all.clone());
            let near = tree.nearest(place);
            let squares = all.iter().map(|own| {
                let way = minus(place, nearest_of(*own, place).0);
                dot(way, way)
            });
            prop_assert_eq!(near.square, squares.fold(f64::INFINITY, f64::min));
            for [a, b, c] in all {
                for (s, t) in (0..6).flat_map(|i| (0..6 - i).map(move |j| (i as f64 / 5.0, j as f64 / 5.0))) {
                    let point = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
                    let way = minus(place, point);
                    prop_assert!(dot(way, way) >= near.square * (1.0 - 1e-9));
                }
            }
        }

        #[test]
        fn meeting_boxes_are_those_of_all(all in corners()) {
            let tree = Tree::new(all.clone());
            for (own, corners) in (0..).zip(&all) {
                let mut found = Vec::new();
                tree.meeting(own, |other| found.push(other));
                found.sort_unstable();
                let [low, high] = bounds(*corners);
                let meets = |other: &u32| {
                    let [from, to] = bounds(all[*other as usize]);
                    (0..3).all(|k| from[k] <= high[k] && to[k] >= low[k])
                };
                let wanted: Vec<u32> = (own + 1..all.len() as u32).filter(meets).collect();
                prop_assert_eq!(found, wanted);
            }
        }
    }
}
