//! A generated slab on a held ground, fine in the middle of its top, as a probe on measured tissue
//! needs it: `slab:WIDTHxTHICKNESSxD`.

use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{self, Mesh, MeshOptions};

/// Ratio of the sizes of neighbouring elements, away from the middle of the top.
const GROWTH: f64 = 1.4;
/// Most elements from the middle to a side, or from the top to the ground.
const ELEMENTS_MAX: usize = 40;

/// A square slab: the middle of its top is the origin, its ground at minus the thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Length of a side \[m\].
    pub width_m: f64,
    /// Thickness \[m\].
    pub thickness_m: f64,
    /// Size of the elements in the middle of the top \[m\].
    pub element_m: f64,
    /// Elements from the middle to a side.
    half: usize,
    /// Elements from the top to the ground.
    layers: usize,
}

impl Slab {
    /// The slab of a spec, or none where the spec is another mesh's.
    pub fn parse(spec: &str) -> Result<Option<Self>> {
        let Some(size) = spec.strip_prefix("slab:") else { return Ok(None) };
        let refuse = |why: &str| Err(Error::input(format!("mesh {spec}: {why}")));
        let numbers: Option<Vec<f64>> = size.split('x').map(|word| word.parse().ok()).collect();
        let numbers: Option<[f64; 3]> = numbers.and_then(|numbers| numbers.try_into().ok());
        let Some([width_m, thickness_m, element_m]) = numbers else {
            return refuse("the form is slab:WIDTHxTHICKNESSxD, three numbers in metres");
        };
        let holds = |x: f64| (1e-6..=1e3).contains(&x);
        if ![width_m, thickness_m, element_m].into_iter().all(holds) {
            return refuse("width, thickness and D must be from 1e-6 to 1000 m");
        }
        if element_m > 0.25 * width_m || element_m > thickness_m {
            return refuse("D must be at most a quarter of the width, and at most the thickness");
        }
        let [half, layers] = [0.5 * width_m, thickness_m].map(|length_m| {
            // A geometric sum of so many elements reaches the length.
            let ratio: f64 = 1.0 + length_m * (GROWTH - 1.0) / element_m;
            (ratio.ln() / GROWTH.ln()).ceil() as usize
        });
        if half.max(layers) > ELEMENTS_MAX {
            return refuse("D is too small for this size; take a larger one");
        }
        Ok(Some(Self { width_m, thickness_m, element_m, half, layers: layers.max(2) }))
    }

    /// The mesh; its ground is held unless the user says otherwise.
    pub fn mesh(&self) -> Result<Mesh> {
        let across = 2 * self.half + 1;
        let spec = format!("box:{across}x{across}x{}x1", self.layers + 1);
        let mut mesh = mesh::load(&spec, &MeshOptions::default())?;
        self.place(&mut mesh);
        Ok(mesh)
    }

    /// The same mesh at another thickness: its links are the same, its layers thinner or thicker.
    pub fn at_thickness(&self, mesh: &Mesh, thickness_m: f64) -> Mesh {
        let mut mesh = mesh.clone();
        Self { thickness_m, ..*self }.place(&mut mesh);
        mesh
    }

    /// Puts the nodes of the box where they belong.
    fn place(&self, mesh: &mut Mesh) {
        let across = 2 * self.half + 1;
        let aside = graded(0.5 * self.width_m, self.element_m, self.half);
        let below = graded(self.thickness_m, self.element_m, self.layers);
        let x_m = |at: usize| {
            let places = at.abs_diff(self.half);
            if at < self.half { -aside[places] } else { aside[places] }
        };
        for (id, node) in mesh.nodes_m.iter_mut().enumerate() {
            let (layer, column) = (id % (self.layers + 1), id / (self.layers + 1));
            *node = [x_m(column / across), x_m(column % across), -below[self.layers - layer]];
        }
    }
}

/// `count` elements over a length, the first of `first_m` and each larger than the one before by
/// the same ratio; equal ones where the length is too short for that.
fn graded(length_m: f64, first_m: f64, count: usize) -> Vec<f64> {
    let sum = |ratio: f64| (0..count).map(|at| ratio.powi(at as i32)).sum::<f64>();
    let (mut low, mut high) = (1.0, 100.0);
    if sum(low) * first_m < length_m {
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if sum(middle) * first_m < length_m { low = middle } else { high = middle }
        }
    }
    let mut places = vec![0.0];
    let total = sum(low);
    let mut at = 0.0;
    for element in 0..count {
        at += low.powi(element as i32);
        places.push(length_m * at / total);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slab_is_fine_in_the_middle_and_as_large_as_asked() {
        let slab = Slab::parse("slab:0.06x0.02x0.001").unwrap().unwrap();
        let mesh = slab.mesh().unwrap();
        let along = |axis: usize| {
            let places = mesh.nodes_m.iter().map(move |node| node[axis]);
            (places.clone().fold(f64::MAX, f64::min), places.fold(f64::MIN, f64::max))
        };
        let is = |[low, high]: [f64; 2], (a, b): (f64, f64)| {
            assert!((a - low).abs() < 1e-9 && (b - high).abs() < 1e-9, "{a} {b}");
        };
        is([-0.03, 0.03], along(0));
        is([-0.03, 0.03], along(1));
        is([-0.02, 0.0], along(2));
        let near =
            |x: f64| mesh.nodes_m.iter().any(|n| (n[0] - x).abs() + n[1].abs() + n[2].abs() < 2e-6);
        assert!(near(0.0) && near(0.001) && near(-0.001));
        assert!(mesh.default_fixed.iter().all(|&node| mesh.nodes_m[node as usize][2] < -0.0199));
        let thin = slab.at_thickness(&mesh, 0.004);
        assert!(thin.nodes_m.iter().all(|node| node[2] >= -0.004 - 1e-12));
        assert_eq!(thin.links, mesh.links);
    }

    #[test]
    fn bad_slabs_are_named() {
        assert_eq!(Slab::parse("box:3x3x3x0.01").unwrap(), None);
        for (spec, part) in [
            ("slab:0.06x0.02", "the form is slab:WIDTHxTHICKNESSxD"),
            ("slab:0.06x-1x0.001", "from 1e-6 to 1000 m"),
            ("slab:0.06x0.02x0.03", "at most a quarter of the width"),
            ("slab:100x100x0.000001", "too small for this size"),
        ] {
            let error = Slab::parse(spec).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains(spec), "{error}");
        }
    }
}
