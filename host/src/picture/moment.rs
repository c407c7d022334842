//! A tick of a tissue, kept so that it can be drawn after further ticks.

use chaincell_kernel::ToolPose;

use super::body::{Body, Paint};
use super::camera::View;
use super::raster::{Pixels, raster};
use super::skin::Skin;
use super::tool::Placed;
use super::{eye, legend, tool};
use crate::engine::{Contact, CutCells, Engine, Nodes};

/// Width and height of a picture, and of the part of it that shows the body \[px\].
const SIZE_PX: (u32, u32) = (1280, 800);
const BODY_PX: (u32, u32) = (SIZE_PX.0 - legend::WIDTH_PX, SIZE_PX.1);
/// Air around the bodies: the texts above and below lie in it \[px\].
const AIR_PX: f64 = 56.0;
/// Fine pixels along an edge of a pixel, and the width of a line in them.
const FINE: u32 = 2;
const WIRE_PX: f32 = 1.0;
/// Most triangles whose edges are drawn: more would be all dark.
const WIRED_MAX: usize = 6000;
/// Least end of the colours \[mm\].
const RANGE_MIN_MM: f64 = 1e-3;
/// Radius of a held cell's ball, and half the width of a link, in mean link lengths.
const HELD_LINKS: f64 = 0.2;
const LINK_LINKS: f64 = 0.05;
/// Half the edge of a half space's plate, as a part of the body's extent.
const PLATE: f64 = 0.75;

/// Positions, tools and force of a tick.
#[derive(Debug, Clone)]
pub struct Moment {
    /// Number of the tick.
    pub tick: u64,
    /// Force on the first tool \[N\].
    pub force_n: [f32; 3],
    /// With the copies of split cells.
    nodes: Nodes,
    cut: Option<CutCells>,
    tools: Vec<Placed>,
}

impl Moment {
    /// The state after a tick. `poses` are those of the tools; `force_n` is that on the first \[N\].
    pub fn of(engine: &mut Engine<'_>, tick: u64, poses: &[ToolPose], force_n: [f32; 3]) -> Self {
        let tools = poses.iter().enumerate();
        let tools = tools.map(|(tool, pose)| Placed::new(pose, engine.proxy_pose(tool))).collect();
        let cut = engine.cut_cells();
        let mut nodes = engine.nodes();
        if let Some(cut) = &cut {
            nodes = engine.with_copies(&nodes, cut);
        }
        Self { tick, force_n, nodes, cut, tools }
    }

    /// The largest displacement of a node \[m\].
    #[must_use]
    pub fn displacement_m(&self, engine: &Engine<'_>) -> f64 {
        let skin = self.skin(engine);
        1e-3 * largest(&self.ways_mm(&skin))
    }

    /// Draws the body, coloured by displacement with a legend, and the tools. `engine` is the one of
    /// [`Self::of`]. Some tenths of a second and 130 MB.
    #[must_use]
    pub fn draw(&self, engine: &Engine<'_>) -> Pixels {
        let skin = self.skin(engine);
        let ways_mm = self.ways_mm(&skin);
        let range = [0.0, largest(&ways_mm).max(RANGE_MIN_MM)];
        // The eye, by the contact.
        let (contact_m, outward) = self.contact(engine);
        let (towards, up) = eye::towards(&skin.rest_m, contact_m, outward);
        // The body, then the tools.
        let mut bodies = vec![self.body(engine, &skin, ways_mm, towards)];
        bodies.extend(self.tools(engine, &skin));
        // The body in both states and the tools fill the picture, so that it is the same scale over a press.
        let points = bodies.iter().flat_map(|body| &body.points_m).chain(&skin.rest_m);
        let view = View::fit(points, towards, up, BODY_PX, AIR_PX);
        let mut pixels = Pixels::white(SIZE_PX);
        pixels.paste((0, 0), &raster(&bodies, view, range, FINE, WIRE_PX));
        legend::write(&mut pixels, &self.title(), range, view.pixels_per_m);
        pixels
    }

    fn skin(&self, engine: &Engine<'_>) -> Skin {
        let model = engine.network().model();
        match &self.cut {
            Some(cut) => Skin::of_cut(model, &self.nodes, cut),
            None => Skin::of(model, &self.nodes),
        }
    }

    /// Tick and force in words.
    fn title(&self) -> String {
        format!("tick {}, force {:.4} N", self.tick, norm(self.force_n.map(f64::from)))
    }

    fn ways_mm(&self, skin: &Skin) -> Vec<f64> {
        let pairs = self.nodes.positions_m.iter().zip(&skin.rest_m);
        pairs.map(|(at, rest)| 1e3 * norm(std::array::from_fn(|x| at[x] - rest[x]))).collect()
    }

    /// The place of the contact, and the direction out of the body there: that of the force on the tool.
    fn contact(&self, engine: &Engine<'_>) -> ([f64; 3], [f64; 3]) {
        let force = self.force_n.map(f64::from);
        let middle = mean(&self.nodes.positions_m);
        let place = match (self.tools.first(), engine.contact()) {
            (Some(tool), Contact::Tools { .. }) => tool.position_m.map(f64::from),
            _ => mean(&self.held_m(engine)),
        };
        let out = std::array::from_fn(|x| place[x] - middle[x]);
        (place, if norm(force) > 0.0 { force } else { out })
    }

    /// Positions of the held cells \[m\].
    fn held_m(&self, engine: &Engine<'_>) -> Vec<[f64; 3]> {
        let ids = engine.network().model().input_id();
        let of_cell = |&cell: &u16| {
            let id = ids.get(usize::from(cell))?;
            let at = self.nodes.ids.iter().position(|node| node == id)?;
            self.nodes.positions_m.get(at).copied()
        };
        engine.contacts().iter().filter_map(of_cell).collect()
    }

    fn body(&self, engine: &Engine<'_>, skin: &Skin, ways_mm: Vec<f64>, towards: [f64; 3]) -> Body {
        if skin.triangles.is_empty() {
            let half_m = LINK_LINKS * f64::from(engine.network().model().unit_m());
            return ribbons(&self.nodes.positions_m, &skin.links, &ways_mm, half_m, towards);
        }
        let edges = skin.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let is_few = skin.triangles.len() <= WIRED_MAX;
        Body {
            points_m: self.nodes.positions_m.clone(),
            triangles: skin.triangles.clone(),
            paint: Paint::Values(ways_mm),
            wires: if is_few { edges.filter(|[a, b]| a < b).collect() } else { Vec::new() },
            unlit: false,
        }
    }

    /// Tools where the tissue meets them, or balls on the cells that one holds.
    fn tools(&self, engine: &Engine<'_>, skin: &Skin) -> Vec<Body> {
        let Contact::Tools { tools, .. } = engine.contact() else {
            let radius_m = HELD_LINKS * f64::from(engine.network().model().unit_m());
            return self.held_m(engine).into_iter().map(|at| tool::ball(at, radius_m)).collect();
        };
        let plate_m = PLATE * extent(&skin.rest_m);
        let placed = self.tools.iter().zip(tools);
        let bodies =
            placed.flat_map(|(at, parts)| parts.iter().map(|part| tool::body(part, at, plate_m)));
        bodies.collect()
    }
}

/// The moment of the largest force so far; of equals the later one.
#[derive(Debug, Default)]
pub struct Largest {
    moment: Option<Moment>,
}

impl Largest {
    /// Looks at a tick.
    pub fn after(
        &mut self,
        engine: &mut Engine<'_>,
        tick: u64,
        poses: &[ToolPose],
        force_n: [f32; 3],
    ) {
        let size = |force_n: [f32; 3]| norm(force_n.map(f64::from));
        if self.moment.as_ref().is_none_or(|moment| size(force_n) >= size(moment.force_n)) {
            self.moment = Some(Moment::of(engine, tick, poses, force_n));
        }
    }

    /// The moment; none without a tick.
    #[must_use]
    pub fn moment(&self) -> Option<&Moment> {
        self.moment.as_ref()
    }
}

/// Links as strips that face the eye.
fn ribbons(
    points_m: &[[f64; 3]],
    links: &[[u32; 2]],
    values: &[f64],
    half_m: f64,
    towards: [f64; 3],
) -> Body {
    let (mut corners, mut triangles, mut painted) = (Vec::new(), Vec::new(), Vec::new());
    for ends in links {
        let [a, b] = ends.map(|id| nalgebra::Vector3::from(points_m[id as usize]));
        let side = (b - a).cross(&nalgebra::Vector3::from(towards));
        let side = side.try_normalize(1e-12).unwrap_or_default() * half_m;
        let first = corners.len() as u32;
        corners.extend([a - side, a + side, b - side, b + side].map(<[f64; 3]>::from));
        let [from, to] = ends.map(|id| values[id as usize]);
        painted.extend([from, from, to, to]);
        triangles.extend([[first, first + 1, first + 3], [first, first + 3, first + 2]]);
    }
    let paint = Paint::Values(painted);
    Body { points_m: corners, triangles, paint, wires: Vec::new(), unlit: true }
}

fn norm(vector: [f64; 3]) -> f64 {
    nalgebra::Vector3::from(vector).norm()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn mean(points_m: &[[f64; 3]]) -> [f64; 3] {
    let count = points_m.len().max(1) as f64;
    std::array::from_fn(|x| points_m.iter().map(|point| point[x]).sum::<f64>() / count)
}

/// The longest edge of the box around some points.
fn extent(points_m: &[[f64; 3]]) -> f64 {
    let edge = |x: usize| {
        let of = points_m.iter().map(|point| point[x]);
        of.clone().fold(f64::NEG_INFINITY, f64::max) - of.fold(f64::INFINITY, f64::min)
    };
    (0..3).map(edge).fold(0.0, f64::max)
}
