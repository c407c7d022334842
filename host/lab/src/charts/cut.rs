//! A solid cut open along a plane: the rest of its skin, and the cut face.

use std::collections::BTreeMap;

use chaincell_host::picture::{Body, Paint};

use crate::reference::vectors::{dot, minus};

/// Points of one part, those that the plane adds among them.
struct Part<'b> {
    whole: &'b Body,
    /// Distance of every point before the plane; what is before it goes.
    before: &'b [f64],
    normal: [f64; 3],
    cut: Body,
    kept: BTreeMap<u32, u32>,
    added: BTreeMap<[u32; 2], u32>,
}

/// Cuts a body of `tetrahedra` open: what lies before the plane through `through_m` \[m\] on the
/// side of `normal` goes. Gives skin and cut face; values are interpolated along edges.
pub fn cut(
    whole: &Body,
    tetrahedra: &[[u32; 4]],
    through_m: [f64; 3],
    normal: [f64; 3],
) -> [Body; 2] {
    let before: Vec<f64> =
        whole.points_m.iter().map(|p| dot(minus(*p, through_m), normal)).collect();
    let mut skin = Part::new(whole, &before, normal);
    for triangle in &whole.triangles {
        skin.triangle(*triangle);
    }
    let mut face = Part::new(whole, &before, normal);
    for corners in tetrahedra {
        face.tetrahedron(*corners);
    }
    [skin.cut, Body { unlit: true, ..face.cut }]
}

impl<'b> Part<'b> {
    fn new(whole: &'b Body, before: &'b [f64], normal: [f64; 3]) -> Self {
        let paint = match &whole.paint {
            Paint::Values(_) => Paint::Values(Vec::new()),
            Paint::Plain(colour) => Paint::Plain(*colour),
        };
        let (points_m, triangles, wires) = (Vec::new(), Vec::new(), Vec::new());
        let cut = Body { points_m, triangles, paint, wires, unlit: false };
        Self { whole, before, normal, cut, kept: BTreeMap::new(), added: BTreeMap::new() }
    }

    fn goes(&self, id: u32) -> bool {
        self.before[id as usize] > 0.0
    }

    /// The part's own number of a point `share` of the way from `a` to `b`.
    fn push(&mut self, a: u32, b: u32, share: f64) -> u32 {
        let mix = |a: f64, b: f64| a + share * (b - a);
        let (from, to) = (self.whole.points_m[a as usize], self.whole.points_m[b as usize]);
        self.cut.points_m.push(std::array::from_fn(|x| mix(from[x], to[x])));
        if let (Paint::Values(own), Paint::Values(values)) =
            (&mut self.cut.paint, &self.whole.paint)
        {
            own.push(mix(values[a as usize], values[b as usize]));
        }
        self.cut.points_m.len() as u32 - 1
    }

    fn keep(&mut self, id: u32) -> u32 {
        if let Some(&known) = self.kept.get(&id) {
            return known;
        }
        let new = self.push(id, id, 0.0);
        self.kept.insert(id, new);
        new
    }

    /// Where an edge whose ends lie on either side crosses the plane.
    fn cross(&mut self, a: u32, b: u32) -> u32 {
        let key = [a.min(b), a.max(b)];
        if let Some(&known) = self.added.get(&key) {
            return known;
        }
        let [from, to] = key.map(|id| self.before[id as usize]);
        let new = self.push(key[0], key[1], from / (from - to));
        self.added.insert(key, new);
        new
    }

    /// What is left of a triangle.
    fn triangle(&mut self, corners: [u32; 3]) {
        let mut outline = Vec::with_capacity(4);
        for at in 0..3 {
            let (here, next) = (corners[at], corners[(at + 1) % 3]);
            if !self.goes(here) {
                let point = self.keep(here);
                outline.push(point);
            }
            if self.goes(here) != self.goes(next) {
                let point = self.cross(here, next);
                outline.push(point);
            }
        }
        for at in 2..outline.len() {
            self.cut.triangles.push([outline[0], outline[at - 1], outline[at]]);
        }
    }

    /// The plane's part within a tetrahedron, turned towards the side that goes.
    fn tetrahedron(&mut self, corners: [u32; 4]) {
        let (gone, left): (Vec<u32>, Vec<u32>) = corners.iter().partition(|&&id| self.goes(id));
        let outline: Vec<u32> = match (gone.as_slice(), left.as_slice()) {
            (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
                [b, c, d].map(|id| self.cross(a, id)).to_vec()
            }
            (&[a, b], &[c, d]) => {
                [[a, c], [a, d], [b, d], [b, c]].map(|[a, b]| self.cross(a, b)).to_vec()
            }
            _ => return,
        };
        for at in 2..outline.len() {
            let [a, b, c] = [outline[0], outline[at - 1], outline[at]];
            let [p, q, r] = [a, b, c].map(|id| self.cut.points_m[id as usize]);
            let (u, v) = (minus(q, p), minus(r, p));
            let area = std::array::from_fn(|x| {
                u[(x + 1) % 3] * v[(x + 2) % 3] - u[(x + 2) % 3] * v[(x + 1) % 3]
            });
            let turned = dot(area, self.normal) < 0.0;
            self.cut.triangles.push(if turned { [a, c, b] } else { [a, b, c] });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::mesh::{MeshOptions, load};

    fn area(body: &Body) -> f64 {
        let half = |[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|id| body.points_m[*id as usize]);
            let (u, v) = (minus(b, a), minus(c, a));
            let (uu, vv, uv) = (dot(u, u), dot(v, v), dot(u, v));
            0.5 * (uu * vv - uv * uv).max(0.0).sqrt()
        };
        body.triangles.iter().map(half).sum()
    }

    /// A box cut across: the face is a rectangle, skin and values end at the plane.
    #[test]
    fn a_box_has_a_rectangular_face() {
        let mesh = load("box:5x4x3x0.01", &MeshOptions::default()).unwrap();
        let values = mesh.nodes_m.iter().map(|p| p[0]).collect();
        let whole = Body {
            points_m: mesh.nodes_m.clone(),
            triangles: mesh.triangles.clone(),
            paint: Paint::Values(values),
            wires: vec![],
            unlit: false,
        };
        let normal = [1.0, 0.0, 0.0];
        let [skin, face] = cut(&whole, &mesh.tetrahedra, [0.003, 0.0, 0.0], normal);
        assert!((area(&face) - 0.03 * 0.02).abs() < 1e-12, "{}", area(&face));
        let sides = 2.0 * (0.03 + 0.02) * 0.023 + 0.03 * 0.02;
        assert!((area(&skin) - sides).abs() < 1e-12, "{}", area(&skin));
        for part in [&skin, &face] {
            let Paint::Values(values) = &part.paint else { panic!("no values") };
            let pairs = part.points_m.iter().zip(values);
            assert!(pairs.clone().all(|(p, value)| (p[0] - value).abs() < 1e-15));
            assert!(pairs.clone().all(|(p, _)| p[0] < 0.003 + 1e-15));
        }
        assert!(face.points_m.iter().all(|p| (p[0] - 0.003).abs() < 1e-15));
    }

    #[test]
    fn a_plane_beside_leaves_all_or_nothing() {
        let ball = Body::sphere([0.0; 3], 1.0, [9; 3], 6);
        let count = ball.triangles.len();
        let kept =
            |at: f64| cut(&ball, &[], [at, 0.0, 0.0], [1.0, 0.0, 0.0]).map(|b| b.triangles.len());
        assert_eq!((kept(2.0), kept(-2.0)), ([count, 0], [0, 0]));
    }
}
