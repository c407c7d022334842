//! Recognises bodies far from the scale of a hand: most of them were read in the wrong unit.

use crate::words::length;

/// Sizes that need no remark \[m\].
const SIZE_M: std::ops::RangeInclusive<f64> = 1e-3..=2.0;

/// A body of another size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnlikelySize {
    size_m: f64,
    unit_m: f64,
}

impl UnlikelySize {
    /// Looks at a body whose coordinates were read in units of `unit_m`; `None` for a likely size.
    #[must_use]
    pub fn of(nodes_m: &[[f64; 3]], unit_m: f64) -> Option<Self> {
        let along = |axis: usize| {
            let xs = nodes_m.iter().map(|node| node[axis]);
            let least = xs.clone().fold(f64::INFINITY, f64::min);
            xs.fold(f64::NEG_INFINITY, f64::max) - least
        };
        let size_m = [0, 1, 2].map(along).into_iter().fold(0.0, f64::max);
        let is_unlikely = !SIZE_M.contains(&size_m) && !nodes_m.is_empty();
        is_unlikely.then_some(Self { size_m, unit_m })
    }

    /// The size alone.
    #[must_use]
    pub fn size(&self) -> String {
        format!("the body is {} large", length(self.size_m))
    }

    /// The size with the unit in which the coordinates were read, and the other unit, which `option` takes.
    #[must_use]
    pub fn with_unit(&self, option: &str) -> String {
        let (is, other) = if self.unit_m == 1.0 { ("m", "mm") } else { ("mm", "m") };
        let size = self.size();
        format!("{size}, its coordinates read as {is}; {option} {other} reads them as {other}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Filling, MeshOptions, from_surface};

    /// A cube of 190, meant in mm.
    #[test]
    fn a_surface_in_another_unit_is_refused_with_the_unit_first() {
        let points: Vec<[f64; 3]> = (0..8)
            .map(|corner| [0, 1, 2].map(|axis| f64::from(190 * (corner >> axis & 1))))
            .collect();
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        let triangles: Vec<[u32; 3]> = sides.into_iter().flat_map(halves).collect();
        let fill = |unit_m, fill_m| {
            let options = MeshOptions {
                unit_m,
                filling: Some(Filling::even(fill_m)),
                ..MeshOptions::default()
            };
            from_surface("liver.stl", &points, triangles.clone(), &options)
        };
        let why = fill(1.0, 0.008).unwrap_err().to_string();
        let begin = "liver.stl: the body is 190 m large, its coordinates read as m; `unit_m` mm reads them as \
            mm; read as it is, about";
        assert!(why.starts_with(begin), "{why}");
        assert!(fill(0.001, 0.03).is_ok());
    }

    #[test]
    fn a_wrong_unit_is_said_and_a_hand_s_scale_is_not() {
        let said = |size_m: f64, unit_m| {
            let unlikely = UnlikelySize::of(&[[0.0; 3], [0.0, size_m, 0.0]], unit_m);
            unlikely.map(|unlikely| unlikely.with_unit("`unit_m`"))
        };
        assert_eq!(
            said(199.6, 1.0).unwrap(),
            "the body is 200 m large, its coordinates read as m; `unit_m` mm reads them as mm"
        );
        let small = said(0.000_19, 0.001).unwrap();
        assert!(
            small.starts_with("the body is 0.190 mm large, its coordinates read as mm; `unit_m` m")
        );
        assert_eq!((said(0.2, 1.0), said(0.2, 0.001)), (None, None));
        assert_eq!(UnlikelySize::of(&[], 1.0), None);
    }
}
