//! The methods behind one face: a tick moves the contact node, positions are in input order.

use chaincell_kernel::{Model, ToolPose};
use nalgebra::Vector3;
use serde::{Serialize, Serializer};

use super::body::Body;
use crate::baseline::chainmail::{Chain, Graph, Lattice, Limits};
use crate::baseline::{Baseline, MassSpring, Xpbd};
use crate::bodies::Variant;
use crate::reference::profile::in_input_order;
use crate::reference::vectors::norm;
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme, to_m};
use chaincell_host::error::{Error, Result};

/// Link passes a tick of the methods that sweep.
pub const SWEEPS: u16 = 4;

/// A method of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The network with the paper's own step.
    Euler,
    /// The network with `track`.
    Track,
    /// Traditional `ChainMail` with its six lists.
    Lattice,
    /// Generalised `ChainMail` on the body's links, with relaxation.
    Graph,
    /// Explicit mass-spring dynamics.
    MassSpring,
    /// Position-based dynamics.
    PositionBased,
}

impl Kind {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 6] = [
        Self::Euler,
        Self::Track,
        Self::Lattice,
        Self::Graph,
        Self::MassSpring,
        Self::PositionBased,
    ];

    /// Name in tables and pictures.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Euler => "network, euler",
            Self::Track => "network, track",
            Self::Lattice => "ChainMail, lattice",
            Self::Graph => "generalised ChainMail, relaxed",
            Self::MassSpring => MassSpring::NAME,
            Self::PositionBased => Xpbd::NAME,
        }
    }

    /// What speaks for the same bits on every target.
    #[must_use]
    pub fn portable(self) -> &'static str {
        match self {
            Self::Euler | Self::Track => "yes, tested",
            // Additions, products, quotients, roots and comparisons in a fixed order.
            Self::Lattice | Self::Graph | Self::PositionBased => "by construction, not tested",
            // The bound of its step starts from the platform's sine.
            Self::MassSpring => "no",
        }
    }

    /// The method on a body at rest.
    ///
    /// # Errors
    /// As the engine and the chains.
    pub fn start(self, body: &Body) -> Result<Box<dyn Method + '_>> {
        let limits = || Limits::of_alpha(body.alpha);
        let (nodes_m, fixed) = (&body.mesh.nodes_m, &body.mesh.default_fixed);
        Ok(match self {
            Self::Euler => Box::new(Cells::new(body, Scheme::Euler)?),
            Self::Track => Box::new(Cells::new(body, Scheme::Track)?),
            Self::Lattice => {
                let chain = Lattice::new(body.nodes, nodes_m, fixed, limits()?)?;
                Box::new(Linked { body, chain, sweeps: 0, last: None })
            }
            Self::Graph => {
                let chain = Graph::new(nodes_m, &body.mesh.links, fixed, limits()?)?;
                Box::new(Linked { body, chain, sweeps: SWEEPS, last: None })
            }
            Self::MassSpring => Box::new(Plain::<MassSpring>::new(body)?),
            Self::PositionBased => Box::new(Plain::<Xpbd>::new(body)?),
        })
    }
}

impl Serialize for Kind {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// A body under a method.
pub trait Method {
    /// One tick with the contact node `way_m` from its place at rest; returns how many times an
    /// element was looked at.
    ///
    /// # Errors
    /// What the method refuses.
    fn tick(&mut self, way_m: [f64; 3]) -> Result<usize>;

    /// Positions in input order \[m\].
    fn positions_m(&mut self) -> Vec<[f64; 3]>;

    /// Force on the contact node \[N\]; none where the method knows no force.
    fn force_n(&mut self) -> Option<f64>;
}

/// The network.
struct Cells<'b> {
    engine: Engine<'b>,
    force_n: f64,
}

impl<'b> Cells<'b> {
    fn new(body: &'b Body, scheme: Scheme) -> Result<Self> {
        let model = body.model()?;
        let contact = contact_cell(&model, body)? as u16;
        let (variant, contact) =
            (Variant::plain(scheme, Arithmetic::F32), Contact::Cells(vec![contact]));
        let mut engine = variant.unlimited(model, contact, SWEEPS, |settings| settings)?;
        // The tool takes hold at rest.
        engine.tick(&ToolPose::at(Vector3::zeros(), 1));
        Ok(Self { engine, force_n: 0.0 })
    }
}

impl Method for Cells<'_> {
    fn tick(&mut self, way_m: [f64; 3]) -> Result<usize> {
        let position_m = Vector3::from(way_m.map(|x| x as f32));
        let answer = self.engine.tick(&ToolPose::at(position_m, 1));
        self.force_n = norm(answer.force_n.map(f64::from).into());
        Ok(usize::from(SWEEPS) * self.engine.network().model().cells())
    }

    fn positions_m(&mut self) -> Vec<[f64; 3]> {
        let cells = self.engine.positions_m();
        in_input_order(self.engine.network().model(), &cells)
    }

    fn force_n(&mut self) -> Option<f64> {
        Some(self.force_n)
    }
}

/// A chain.
struct Linked<'b, C> {
    body: &'b Body,
    chain: C,
    sweeps: u16,
    /// Where the contact node was put last: a node at rest starts no front.
    last: Option<[f64; 3]>,
}

impl<C: Chain> Method for Linked<'_, C> {
    fn tick(&mut self, way_m: [f64; 3]) -> Result<usize> {
        let to = self.body.contact_m(way_m);
        let mut visited = 0;
        if self.last.replace(to) != Some(to) {
            visited = self.chain.move_to(&[(self.body.contact, to)])?.visited;
        }
        for _ in 0..self.sweeps {
            visited += self.chain.relax(&Limits::RIGID).visited;
        }
        Ok(visited)
    }

    fn positions_m(&mut self) -> Vec<[f64; 3]> {
        self.chain.elements().positions_m().to_vec()
    }

    fn force_n(&mut self) -> Option<f64> {
        None
    }
}

/// A method of others on the model's links.
struct Plain<'b, B> {
    body: &'b Body,
    model: Model<'b>,
    state: B,
    cell: usize,
}

impl<'b, B: Baseline> Plain<'b, B> {
    fn new(body: &'b Body) -> Result<Self> {
        let model = body.model()?;
        let (state, cell) = (B::new(&model), contact_cell(&model, body)?);
        Ok(Self { body, model, state, cell })
    }
}

impl<B: Baseline> Method for Plain<'_, B> {
    fn tick(&mut self, way_m: [f64; 3]) -> Result<usize> {
        let (rest, unit_m) = (self.model.rest_position(self.cell), self.model.unit_m());
        let to = std::array::from_fn(|axis| rest[axis] + way_m[axis] as f32 / unit_m);
        self.state.hold(self.cell, to);
        for _ in 0..SWEEPS {
            self.state.step();
        }
        Ok(usize::from(SWEEPS) * self.model.cells())
    }

    fn positions_m(&mut self) -> Vec<[f64; 3]> {
        let cells = self.state.positions().iter();
        let cells: Vec<[f64; 3]> = cells.map(|p| to_m(&self.model, p.map(f64::from))).collect();
        in_input_order(&self.model, &cells)
    }

    fn force_n(&mut self) -> Option<f64> {
        let positions_m = self.positions_m();
        Some(self.body.force_n(&positions_m))
    }
}

fn contact_cell(model: &Model<'_>, body: &Body) -> Result<usize> {
    let cell = model.cell_of_input(body.contact as u32).map(usize::from);
    cell.ok_or_else(|| Error::check(format!("the {} has no node {}", body.name, body.contact)))
}
