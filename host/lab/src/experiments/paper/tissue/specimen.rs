//! A testing machine: a block of tissue between two clamps, moved in the kernel's ticks.
//!
//! The block is filled with a lattice of tetrahedra. The direction of the load to the lattice matters to bands alone,
//! which act along links. Strain is measured between marks in the middle, since clamps hinder the ends.

use std::fmt::Write as _;

use chaincell_kernel::{Flags, Model, Settings, ToolPose};
use nalgebra::{Rotation3, Vector3};

use crate::bodies::Variant;
use chaincell_host::bake::tissue::{KnownTissue, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Contact, Engine, Scheme, rest_m};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::mesh::{Filling, MeshOptions, load};

/// Angles of a block that stands askew in the lattice \[rad\].
const ASKEW: [f64; 3] = [0.4, 0.7, 0.25];
/// Part of the length, about the middle, in which the marks are.
const MARKED: f64 = 0.3;
/// Largest distance of a clamped node from its end \[edges\].
const CLAMPED: f64 = 0.02;
/// Share of the error of the strain that the machine takes back in a tick.
const GAIN: f64 = 0.3;
/// Sweeps of a tick.
const SWEEPS: u16 = 8;
/// Most energy that the clamps may store \[J/m^3\].
const ENERGY_MAX: f64 = 1e5;

/// How a block stands in the lattice of its tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lattice {
    /// Along an axis of the lattice.
    Along,
    /// Askew, at angles to all directions of its links.
    Askew,
}

/// A block before its bake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Its lengths, the last one from clamp to clamp \[m\].
    pub size_m: [f64; 3],
    /// Mean edge of its tetrahedra \[m\].
    pub edge_m: f64,
    /// Its place in the lattice.
    pub lattice: Lattice,
}

/// A block with its clamped ends, of which the second one moves.
pub struct Specimen {
    image: ImageBytes,
    /// Cells of the moving clamp, ascending.
    held: Vec<u16>,
    /// The axes of the block, the last one from clamp to clamp.
    axes: [Vector3<f64>; 3],
    size_m: [f64; 3],
    /// Number of cells.
    pub cells: usize,
}

/// Strains between the marks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strain {
    /// Stretch from clamp to clamp.
    pub along: f64,
    /// Mean stretch across.
    pub across: f64,
}

impl Specimen {
    /// A block of a tissue, for `hz` ticks a second.
    ///
    /// # Errors
    /// As the filling and the bake.
    pub fn new(block: Block, of: &KnownTissue, hz: u32) -> Result<Self> {
        let Block { size_m, edge_m, lattice } = block;
        let axes = axes(lattice);
        let folder = tempfile::tempdir().map_err(Error::check)?;
        let path = folder.path().join("block.stl");
        std::fs::write(&path, surface(size_m, axes)).map_err(Error::check)?;
        let filling = Some(Filling { size_m: edge_m, finer: None });
        let mesh =
            load(&path.to_string_lossy(), &MeshOptions { filling, ..MeshOptions::default() })?;
        // The nodes of both ends.
        let height = |node: &[f64; 3]| axes[2].dot(&Vector3::from(*node));
        let near = |at_m: f64| -> Vec<u32> {
            let nodes = (0..).zip(&mesh.nodes_m);
            let is_near = nodes.filter(|(_, node)| (height(node) - at_m).abs() < CLAMPED * edge_m);
            is_near.map(|(node, _)| node).collect()
        };
        let [fixed, held] = [-0.5, 0.5].map(|end| near(end * size_m[2]));
        let options = BakeOptions {
            tissue: Some(tissue(of, hz)),
            energy_max_j: Some(ENERGY_MAX * size_m.iter().product::<f64>()),
            ..BakeOptions::default()
        };
        let image = bake(&mesh, &fixed, &options)?;
        let model = parse(&image)?;
        let mut held: Vec<u16> =
            held.iter().filter_map(|&node| model.cell_of_input(node)).collect();
        held.sort_unstable();
        let cells = model.cells();
        Ok(Self { image, held, axes, size_m, cells })
    }

    /// The machine with the specimen in it, at rest.
    ///
    /// # Errors
    /// None for a specimen that was made here.
    pub fn machine(&self) -> Result<Machine<'_>> {
        let model = parse(&self.image)?;
        let contact = Contact::Cells(self.held.clone());
        let change = |settings: Settings| Settings { max_force_n: 1e3, ..settings };
        let variant = Variant::single(Scheme::Predict, true);
        let engine = variant.unlimited(model, contact, SWEEPS, change)?;
        let marked_m = 0.5 * MARKED * self.size_m[2];
        let place = |cell: usize| self.in_axes(rest_m(engine.network().model(), cell));
        let marks = (0..model.cells()).map(|cell| (cell, place(cell)));
        let marks = marks.filter(|(_, rest)| rest[2].abs() < marked_m).collect();
        let mut machine = Machine { engine, specimen: self, marks, end_m: [0.0; 3], wanted: 1.0 };
        machine.tick()?;
        Ok(machine)
    }

    fn in_axes(&self, place: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| axis.dot(&Vector3::from(place)))
    }
}

/// The machine with a specimen.
pub struct Machine<'s> {
    engine: Engine<'s>,
    specimen: &'s Specimen,
    /// Cells between which the strain is measured, with their places at rest along the axes.
    marks: Vec<(usize, [f64; 3])>,
    /// Displacement of the moving clamp along the axes \[m\].
    end_m: [f64; 3],
    /// Stretch that was wanted last.
    wanted: f64,
}

impl Machine<'_> {
    /// A tick with the clamp where it is; returns the force by area at rest that it takes, along the axes \[Pa\].
    fn tick(&mut self) -> Result<[f64; 3]> {
        interrupt::check()?;
        let Specimen { axes, size_m, .. } = self.specimen;
        let place: Vector3<f64> = axes.iter().zip(self.end_m).map(|(axis, by)| axis * by).sum();
        let output = self.engine.tick(&ToolPose::at(place.map(|x| x as f32), 1));
        if output.flags.contains(Flags::MOTION_CLAMPED) {
            return Err(Error::check("the clamp was stopped; allow the specimen more energy"));
        }
        let force = Vector3::from(output.force_n.map(f64::from));
        let area_m2 = size_m[0] * size_m[1];
        Ok(axes.map(|axis| -axis.dot(&force) / area_m2))
    }

    /// One tick towards a stretch between the marks; returns the nominal stress along, tension above 0 \[Pa\].
    ///
    /// # Errors
    /// An interruption.
    pub fn stretch(&mut self, wanted: f64) -> Result<f64> {
        let missing = self.wanted - self.strain().along;
        self.end_m[2] += self.specimen.size_m[2] * (wanted - self.wanted + GAIN * missing);
        self.wanted = wanted;
        Ok(self.tick()?[2])
    }

    /// One tick with the clamp moved sideways by a shear; returns the nominal shear stress \[Pa\].
    ///
    /// # Errors
    /// An interruption.
    pub fn shear(&mut self, shear: f64) -> Result<f64> {
        self.end_m[0] = shear * self.specimen.size_m[2];
        Ok(self.tick()?[0])
    }

    /// The strain between the marks: slopes of the places now over those at rest.
    pub fn strain(&mut self) -> Strain {
        let now = self.engine.positions_m();
        let slope = |axis: usize| {
            let pairs = self
                .marks
                .iter()
                .map(|&(cell, rest)| [rest[axis], self.specimen.in_axes(now[cell])[axis]]);
            let pairs: Vec<[f64; 2]> = pairs.collect();
            let mean = [0, 1]
                .map(|of| pairs.iter().map(|pair| pair[of]).sum::<f64>() / pairs.len() as f64);
            let sums = pairs.iter().fold([0.0; 2], |[product, square], pair| {
                let from = pair[0] - mean[0];
                [product + from * (pair[1] - mean[1]), square + from * from]
            });
            sums[0] / sums[1]
        };
        let [x, y, along] = [0, 1, 2].map(slope);
        Strain { along, across: 0.5 * (x + y) }
    }
}

/// The tissue of a row of the table, for `hz` ticks a second.
pub fn tissue(of: &KnownTissue, hz: u32) -> Tissue {
    let relaxation = (!of.branches.is_empty()).then(|| Relaxation {
        branches: of.branches.clone(),
        is_instant: of.is_instant,
        device_hz: hz,
    });
    Tissue {
        stiffening: of.stiffening.clone(),
        relaxation,
        ..Tissue::new(PerCell::Uniform(of.young_pa), PerCell::Uniform(of.poisson))
    }
}

fn axes(lattice: Lattice) -> [Vector3<f64>; 3] {
    let [x, y, z] = if lattice == Lattice::Askew { ASKEW } else { [0.0; 3] };
    let turn = Rotation3::from_euler_angles(x, y, z);
    [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| turn * axis)
}

pub fn parse(image: &ImageBytes) -> Result<Model<'_>> {
    Model::from_bytes(image.as_bytes()).map_err(Error::check)
}

/// The surface of a block about the origin, as an STL file.
pub fn surface(size_m: [f64; 3], axes: [Vector3<f64>; 3]) -> String {
    let corner = |at: usize| -> Vector3<f64> {
        let side = |axis: usize| if at >> axis & 1 == 1 { 0.5 } else { -0.5 };
        (0..3).map(|axis| axes[axis] * (side(axis) * size_m[axis])).sum()
    };
    // Two triangles a side, counter-clockwise from outside.
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid block\n");
    for [a, b, c, d] in sides {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for at in triangle.map(corner) {
                let _ = writeln!(text, "vertex {} {} {}", at.x, at.y, at.z);
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid block\n"
}
