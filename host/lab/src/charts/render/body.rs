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
    /// A sphere of one colour, in `fine` rings of latitude.
    ///
    /// `centre_m` and `radius_m` \[m\], `colour` in sRGB.
    pub fn sphere(centre_m: [f64; 3], radius_m: f64, colour: [u8; 3], fine: u32) -> Self {
        let round = 2 * fine;
        let point = |ring: u32, at: u32| {
            let polar = PI * f64::from(ring) / f64::from(fine);
            let turn = TAU * f64::from(at) / f64::from(round);
            let unit = [polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()];
            std::array::from_fn(|x| centre_m[x] + radius_m * unit[x])
        };
        let points_m = (0..=fine).flat_map(|ring| (0..round).map(move |at| point(ring, at)));
        let id = |ring: u32, at: u32| ring * round + at % round;
        let squares = (0..fine).flat_map(|ring| (0..round).map(move |at| (ring, at)));
        let triangles = squares.flat_map(|(ring, at)| {
            let (a, b) = (id(ring, at), id(ring, at + 1));
            let (c, d) = (id(ring + 1, at), id(ring + 1, at + 1));
            [[a, c, d], [a, d, b]]
        });
        Self {
            points_m: points_m.collect(),
            triangles: triangles.collect(),
            paint: Paint::Plain(colour),
            wires: Vec::new(),
            unlit: false,
        }
    }
}
