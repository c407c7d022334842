//! The energy of a tissue and of tools on a contact surface in double precision, over the samples of
//! all triangles: what the certified level is compared with.
//!
//! What friction and grips store is left out: it is 0 or more, so the level is no lower with it.

use chaincell_kernel::{COORDINATE_MAX, Model, ProxyPose, Rounding, ToolPart};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::energy::{Energy, energy, energy_of_shapes};
use crate::reference::{Links, Nodal, Stiffening};
use chaincell_host::engine::Arithmetic;

/// Spacing of single precision.
const EPS: f64 = f32::EPSILON as f64;
/// How far fixed point may move a length [mean link lengths].
const FIXED_RESOLUTION: f64 = 8.0 / 16_777_216.0;

/// The triangles as a part meets them: corners, parts of an edge, stiffness of all samples
/// [2 `k_ref`].
type Triangles = Vec<([usize; 3], u16, f64)>;

/// Energy of a state in double precision \[J\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stored {
    /// Of the tissue alone.
    pub tissue_j: f64,
    /// Of tissue and tools.
    pub energy_j: f64,
    /// How far rounding may move it.
    pub allowance_j: f64,
    /// How far rounding may move a force of the tissue [mean link lengths times 2 `k_ref`].
    pub force_allowance: f64,
}

/// What a tool meets by its contact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Met {
    /// Energy of the samples in it \[J\].
    pub energy_j: f64,
    /// Their stiffness [N/m].
    pub stiffness_n_per_m: f64,
}

/// What the energy is computed with; in internal units.
#[derive(Debug, Clone)]
pub struct ExactContact<'m> {
    model: Model<'m>,
    tissue: Tissue,
    /// How far the numbers may move a length, beyond rounding [mean link lengths].
    resolution: f64,
    /// Bounds of the cells.
    bounds: Vec<f64>,
    tools: Vec<Vec<(ToolPart, Triangles)>>,
}

/// The material of a body.
#[derive(Debug, Clone)]
enum Tissue {
    Shapes(Box<(Nodal, Stiffening)>),
    Links(Links),
    /// Shapes that the reference does not know, and bodies that can be cut or relax.
    Unknown,
}

impl Tissue {
    fn of(model: &Model<'_>) -> Self {
        if model.tetrahedra_to_cut() > 0 || model.relaxes() {
            return Self::Unknown;
        }
        if !model.is_nodal() {
            return Self::Links(Links::of_model(model));
        }
        match Nodal::of_model(model) {
            Ok(Some(shapes)) => Self::Shapes(Box::new((shapes, Stiffening::of_model(model)))),
            _ => Self::Unknown,
        }
    }
}

/// A part of a tool at a pose, in internal units.
struct Placed {
    centre: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    core: [[f64; 3]; 2],
    radius: f64,
}

impl Placed {
    fn distance(&self, point: Vector3<f64>) -> f64 {
        let own = self.turn.inverse_transform_vector(&(point - self.centre));
        let [low, high] = self.core;
        let of = |axis: usize| (low[axis] - own[axis]).max(own[axis] - high[axis]).max(0.0);
        Vector3::new(of(0), of(1), of(2)).norm()
    }

    /// Whether no point of a triangle can be in it.
    fn is_beyond(&self, corners: &[Vector3<f64>; 3]) -> bool {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let arm = corners.iter().map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        self.distance(middle) - arm > self.radius * (1.0 + EPS)
    }
}

fn turn(orientation: [f32; 4]) -> UnitQuaternion<f64> {
    let [x, y, z, w] = orientation.map(f64::from);
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// The weights of the corners for the centres of `parts`^2 equal parts of a triangle.
fn each_sample(parts: u16, mut visit: impl FnMut([f64; 3])) {
    let n = f64::from(parts);
    for i in 0..parts {
        for j in 0..parts - i {
            for third in [1.0 / 3.0, 2.0 / 3.0] {
                let [u, v] = [i, j].map(|at| (f64::from(at) + third) / n);
                if u + v < 1.0 {
                    visit([1.0 - u - v, u, v]);
                }
            }
        }
    }
}

impl<'m> ExactContact<'m> {
    /// Of a model under these tools, which need its contact surface, or under none.
    #[must_use]
    pub fn new(model: Model<'m>, tools: &[Vec<ToolPart>], numbers: Arithmetic) -> Self {
        let corners: Vec<[usize; 3]> =
            model.triangles().iter().map(|corners| corners.map(usize::from)).collect();
        let of = |part: &ToolPart| {
            let sampled_m =
                if part.is_half_space() { COORDINATE_MAX * model.unit_m() } else { part.radius_m };
            let (mut numbers, mut triangles) = (corners.iter(), Triangles::new());
            model.each_contact_triangle(sampled_m, |parts, stiffness_n_per_m| {
                let weight = f64::from(stiffness_n_per_m / (2.0 * model.stiffness_n_per_m()));
                triangles.extend(numbers.next().map(|corners| (*corners, parts, weight)));
            });
            (*part, triangles)
        };
        let tools = tools.iter().map(|parts| parts.iter().map(of).collect()).collect();
        let bounds = (0..model.cells()).map(|cell| f64::from(model.cell_bound(cell))).collect();
        let resolution = if numbers == Arithmetic::Fixed { FIXED_RESOLUTION } else { 0.0 };
        Self { model, tissue: Tissue::of(&model), resolution, bounds, tools }
    }

    /// Returns true if the energy of the tissue is known.
    #[must_use]
    pub fn is_known(&self) -> bool {
        !matches!(self.tissue, Tissue::Unknown)
    }

    /// Number of tools.
    #[must_use]
    pub fn tools(&self) -> usize {
        self.tools.len()
    }

    /// Smallest radius of a part [mean link lengths].
    #[must_use]
    pub fn radius_min(&self) -> f64 {
        let parts = self.tools.iter().flatten();
        let radius = parts.map(|(part, _)| f64::from(part.radius_m)).fold(f64::MAX, f64::min);
        radius / f64::from(self.model.unit_m())
    }

    /// A part of a tool where its proxy is.
    fn placed(&self, part: &ToolPart, proxy: &ProxyPose) -> Placed {
        let unit_m = f64::from(self.model.unit_m());
        let own = |x: f32| f64::from(x) / unit_m;
        let way = |axis: usize| {
            (f64::from(proxy.position_m[axis]) - f64::from(self.model.centre_m()[axis])) / unit_m
        };
        let pivot = Vector3::new(way(0), way(1), way(2));
        let of_tool = turn(proxy.orientation);
        let half = part.half_m.map(own);
        let radius = own(part.radius_m);
        let core = match part.is_half_space() {
            true => [[f64::NEG_INFINITY; 3], [f64::INFINITY, f64::INFINITY, -radius]],
            false => [half.map(|x| -x), half],
        };
        let centre = pivot + of_tool * Vector3::from(part.centre_m.map(own));
        let share = f64::from(proxy.share.min(1.0));
        Placed { centre, turn: of_tool * turn(part.orientation), core, radius: share * radius }
    }

    fn tissue_energy(&self, positions: &[[f64; 3]], closed: bool) -> Energy {
        match &self.tissue {
            Tissue::Shapes(of) => energy_of_shapes(&of.0, &of.1, positions, &self.bounds),
            Tissue::Links(links) => energy(links, positions, closed, |_| 0.5 * self.resolution),
            Tissue::Unknown => Energy::default(),
        }
    }

    /// Energy of tissue and tools at these positions [mean link lengths from the centre], the least of
    /// all rotations and shapes that the kernel may keep; with the links' bands as they are or `closed`.
    #[must_use]
    pub fn stored(
        &self,
        positions: &[[f64; 3]],
        proxies: &[Option<ProxyPose>],
        closed: bool,
    ) -> Stored {
        // The samples that the tools press.
        let mut pressed = Pressed::new(positions.len());
        for (tool, proxy) in proxies.iter().enumerate() {
            self.press(&mut pressed, tool, proxy.as_ref(), positions);
        }
        // The rounding of their energy.
        let tissue = self.tissue_energy(positions, closed);
        let mut allowance = tissue.allowance;
        if !self.tools.is_empty() {
            let mut rounding = Rounding::default();
            for (cell, at) in positions.iter().enumerate() {
                let bound = self.bounds[cell] + pressed.bounds[cell];
                let mobility = if bound > 0.0 { (1.0 / bound) as f32 } else { 0.0 };
                let stored = (8.0 * pressed.stored[cell]) as f32;
                rounding.add_cell(Rounding::of_cell(at.map(|x| x as f32), mobility, stored));
            }
            allowance += f64::from(rounding.allowance(pressed.energy as f32)) + pressed.slack;
        }
        let unit_j = f64::from(self.model.energy_unit_j());
        Stored {
            tissue_j: unit_j * tissue.energy,
            energy_j: unit_j * (tissue.energy + pressed.energy),
            allowance_j: unit_j * allowance,
            force_allowance: tissue.force_allowance,
        }
    }

    /// What a tool meets at these positions.
    #[must_use]
    pub fn met(&self, tool: usize, proxy: Option<&ProxyPose>, positions: &[[f64; 3]]) -> Met {
        let mut pressed = Pressed::new(positions.len());
        self.press(&mut pressed, tool, proxy, positions);
        Met {
            energy_j: f64::from(self.model.energy_unit_j()) * pressed.energy,
            stiffness_n_per_m: 2.0 * f64::from(self.model.stiffness_n_per_m()) * pressed.stiffness,
        }
    }

    /// Adds what a tool does to the samples.
    fn press(
        &self,
        pressed: &mut Pressed,
        tool: usize,
        proxy: Option<&ProxyPose>,
        positions: &[[f64; 3]],
    ) {
        let Some((parts, proxy)) = self.tools.get(tool).zip(proxy) else { return };
        for (part, triangles) in parts {
            pressed.add(&self.placed(part, proxy), triangles, positions);
        }
    }
}

/// What tools do to the samples; in internal units.
struct Pressed {
    /// The tools' part in the bounds of the cells, and what is stored at them.
    bounds: Vec<f64>,
    stored: Vec<f64>,
    energy: f64,
    /// How far the rounding of published poses may move it.
    slack: f64,
    /// Stiffness of the samples in the tools.
    stiffness: f64,
}

impl Pressed {
    fn new(cells: usize) -> Self {
        let (bounds, stored) = (vec![0.0; cells], vec![0.0; cells]);
        Self { bounds, stored, energy: 0.0, slack: 0.0, stiffness: 0.0 }
    }

    /// A part of a tool.
    fn add(&mut self, placed: &Placed, triangles: &Triangles, positions: &[[f64; 3]]) {
        for (corners, parts, weight) in triangles {
            let stiffness = weight / f64::from(u32::from(*parts) * u32::from(*parts));
            let at = corners.map(|cell| Vector3::from(positions[cell]));
            if placed.is_beyond(&at) {
                continue;
            }
            each_sample(*parts, |weights| {
                let point = at[0] * weights[0] + at[1] * weights[1] + at[2] * weights[2];
                let depth = placed.radius - placed.distance(point);
                if depth <= 0.0 {
                    return;
                }
                let own = 0.5 * stiffness * depth * depth;
                // A pose is published in single precision.
                let off = 4.0 * EPS * (point.norm() + placed.centre.norm() + placed.radius + 1.0);
                self.energy += own;
                self.slack += stiffness * off * (depth + off);
                self.stiffness += stiffness;
                for (cell, weight) in corners.iter().zip(weights) {
                    self.stored[*cell] += weight * own;
                    self.bounds[*cell] += weight * stiffness;
                }
            });
        }
    }
}
