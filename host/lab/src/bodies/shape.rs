//! Bodies before the bake: a mesh with its fixed nodes and those that a tool holds.

use chaincell_kernel::Model;

use chaincell_host::bake::{BakeOptions, ImageBytes, bake};
use chaincell_host::error::Result;
use chaincell_host::mesh::{Mesh, MeshOptions, load};

/// A mesh that is to be baked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shape {
    /// Nodes, links and elements.
    pub mesh: Mesh,
    /// Fixed nodes, ascending.
    pub fixed: Vec<u32>,
    /// Nodes that the tool holds, none fixed.
    pub held: Vec<u32>,
}

/// A box of n^3 nodes 10 mm apart, its bottom fixed; the tool holds the middle of its top.
///
/// # Errors
/// None for n from 2 on.
pub fn cuboid(n: u32) -> Result<Shape> {
    let middle = n / 2;
    let shape = Shape::generated(&format!("box:{n}x{n}x{n}x0.01"))?;
    Ok(shape.holding(&[(middle * n + middle) * n + n - 1]))
}

impl Shape {
    /// A generated body, fixed where its generator says; the tool holds nothing.
    ///
    /// # Errors
    /// As the generator.
    pub fn generated(spec: &str) -> Result<Self> {
        Self::generated_with(spec, &MeshOptions::default())
    }

    /// The same with options of the generator.
    ///
    /// # Errors
    /// As the generator.
    pub fn generated_with(spec: &str, options: &MeshOptions) -> Result<Self> {
        let mesh = load(spec, options)?;
        Ok(Self { fixed: mesh.default_fixed.clone(), mesh, held: Vec::new() })
    }

    /// The same with these nodes held by the tool.
    #[must_use]
    pub fn holding(self, nodes: &[u32]) -> Self {
        Self { held: nodes.to_vec(), ..self }
    }

    /// The image of the shape.
    ///
    /// # Errors
    /// As the bake.
    pub fn bake(&self, options: &BakeOptions) -> Result<ImageBytes> {
        bake(&self.mesh, &self.fixed, options)
    }

    /// Cells of the nodes that the tool holds, ascending.
    #[must_use]
    pub fn cells(&self, model: &Model<'_>) -> Vec<u16> {
        let cells = self.held.iter().filter_map(|&node| model.cell_of_input(node));
        let mut cells: Vec<u16> = cells.collect();
        cells.sort_unstable();
        cells
    }

    /// The same, stretched along the axes.
    #[must_use]
    pub fn stretched(mut self, by: [f64; 3]) -> Self {
        for node in &mut self.mesh.nodes_m {
            *node = std::array::from_fn(|axis| by[axis] * node[axis]);
        }
        self
    }

    /// The same with nothing fixed.
    #[must_use]
    pub fn floating(self) -> Self {
        Self { fixed: Vec::new(), ..self }
    }

    /// The same beside a copy of it that nothing fixes, ten of its widths away.
    #[must_use]
    pub fn twice(mut self) -> Self {
        let count = self.mesh.nodes_m.len() as u32;
        let xs = self.mesh.nodes_m.iter().map(|node| node[0]);
        let apart = 10.0 * xs.clone().fold(0.0, f64::max).max(-xs.fold(0.0, f64::min));
        let copies: Vec<_> = self.mesh.nodes_m.iter().map(|&[x, y, z]| [x + apart, y, z]).collect();
        self.mesh.nodes_m.extend(copies);
        let shifted: Vec<_> =
            self.mesh.links.iter().map(|ends| ends.map(|id| id + count)).collect();
        self.mesh.links.extend(shifted);
        let shifted: Vec<_> =
            self.mesh.triangles.iter().map(|ids| ids.map(|id| id + count)).collect();
        self.mesh.triangles.extend(shifted);
        let shifted: Vec<_> =
            self.mesh.tetrahedra.iter().map(|ids| ids.map(|id| id + count)).collect();
        self.mesh.tetrahedra.extend(shifted);
        self
    }

    /// The same with everything fixed and nothing to hold.
    #[must_use]
    pub fn all_fixed(self) -> Self {
        let fixed = (0..self.mesh.nodes_m.len() as u32).collect();
        Self { fixed, held: Vec::new(), ..self }
    }
}

/// A hub with `spokes` links to nodes on a sphere around it, each linked to the next; the first of
/// them is fixed, the tool holds the hub.
#[must_use]
pub fn hub(spokes: u32) -> Shape {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let around = |at: u32| {
        let z = 1.0 - (2.0 * f64::from(at) + 1.0) / f64::from(spokes);
        let (across, turn) = ((1.0 - z * z).sqrt(), golden * f64::from(at));
        [across * libm::cos(turn), across * libm::sin(turn), z].map(|x| 0.01 * x)
    };
    let nodes_m = (0..spokes).map(around).chain([[0.0; 3]]).collect();
    let ring = (1..spokes).map(|at| [at - 1, at]);
    let mut links: Vec<[u32; 2]> = ring.chain((0..spokes).map(|at| [at, spokes])).collect();
    links.sort_unstable();
    let mesh = Mesh { nodes_m, links, ..Mesh::default() };
    Shape { mesh, fixed: vec![0], held: vec![spokes] }
}

/// Two spiral arms from a common middle, the rest lengths of whose links grow by six decades; the
/// ends are fixed, the tool holds the middle.
#[must_use]
pub fn spiral() -> Shape {
    const ARM: u32 = 24;
    let radius = |at: u32| libm::exp10(-6.0 + 6.0 * f64::from(at) / f64::from(ARM - 1));
    let arm = |side: f64| {
        (0..ARM).map(move |at| {
            let (r, turn) = (side * radius(at), 0.8 * f64::from(at));
            [r * libm::cos(turn), r * libm::sin(turn), 0.3 * r * libm::cos(3.0 * turn)]
        })
    };
    let nodes_m: Vec<_> = [[0.0; 3]].into_iter().chain(arm(1.0)).chain(arm(-1.0)).collect();
    let along = |first: u32| {
        let near = [[0, first], [0, first + 1]];
        let next = (1..ARM).map(move |at| [first + at - 1, first + at]);
        near.into_iter().chain(next).chain((2..ARM).map(move |at| [first + at - 2, first + at]))
    };
    let mut links: Vec<[u32; 2]> = along(1).chain(along(1 + ARM)).collect();
    links.sort_unstable();
    let mesh = Mesh { nodes_m, links, ..Mesh::default() };
    Shape { mesh, fixed: vec![ARM, 2 * ARM], held: vec![0] }
}
