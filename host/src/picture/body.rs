//! What is shown: triangles, their colour, lines along some of their edges.

use std::f64::consts::{PI, TAU};

/// How a body is coloured.
#[derive(Debug, Clone, PartialEq)]
pub enum Paint {
    /// A value at every point, shown by the sheet's colour bar.
    Values(Vec<f64>),
    /// One colour, sRGB.
    Plain([u8; 3]),
}

/// A surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Points `[point][axis]` \[m\].
    pub points_m: Vec<[f64; 3]>,
    /// Corners of each triangle; either side may face the eye.
    pub triangles: Vec<[u32; 3]>,
    /// Colour.
    pub paint: Paint,
    /// Lines between points, drawn on the surface; none for a plain one.
    pub wires: Vec<[u32; 2]>,
    /// Shown in the very colours of the colour bar, without light and shade: a cut face.
    pub unlit: bool,
}

impl Body {
    /// A sphere of one colour, in about `fine` rings of latitude.
    ///
    /// `centre_m` and `radius_m` \[m\], `colour` in sRGB.
    #[must_use]
    pub fn sphere(centre_m: [f64; 3], radius_m: f64, colour: [u8; 3], fine: u32) -> Self {
        let mut sphere = Self::rounded([0.0; 3], radius_m, colour, fine);
        for point in &mut sphere.points_m {
            *point = std::array::from_fn(|x| centre_m[x] + point[x]);
        }
        sphere
    }

    /// Everything within a radius of a box of these half edges around the origin: a sphere whose eighths are
    /// moved apart.
    ///
    /// `half_m` and `radius_m` \[m\], `colour` in sRGB.
    #[must_use]
    pub fn rounded(half_m: [f64; 3], radius_m: f64, colour: [u8; 3], fine: u32) -> Self {
        // No ring on the equator and no point on the planes x = 0 and y = 0: each belongs to one eighth.
        let (rings, round) = (fine | 1, (2 * fine).next_multiple_of(4));
        let point = |ring: u32, at: u32| {
            let polar = PI * f64::from(ring) / f64::from(rings);
            let turn = TAU * (f64::from(at) + 0.5) / f64::from(round);
            let unit = [polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()];
            std::array::from_fn(|x| radius_m * unit[x] + half_m[x].copysign(unit[x]))
        };
        let points_m = (0..=rings).flat_map(|ring| (0..round).map(move |at| point(ring, at)));
        let id = |ring: u32, at: u32| ring * round + at % round;
        let squares = (0..rings).flat_map(|ring| (0..round).map(move |at| (ring, at)));
        let triangles = squares.flat_map(|(ring, at)| {
            let (a, b) = (id(ring, at), id(ring, at + 1));
            let (c, d) = (id(ring + 1, at), id(ring + 1, at + 1));
            [[a, c, d], [a, d, b]]
        });
        // At either end the points lie in the corners of the box.
        let lids = [0, rings].into_iter().flat_map(|ring| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|eighth| id(ring, eighth * round / 4));
            [[a, b, c], [a, c, d]]
        });
        Self {
            points_m: points_m.collect(),
            triangles: triangles.chain(lids).collect(),
            paint: Paint::Plain(colour),
            wires: Vec::new(),
            unlit: false,
        }
    }
}
