//! A tissue between two ticks, of `Tissue` and of `run`.

use std::sync::Arc;

use chaincell_client::command::refusal_text;
use chaincell_client::surface::SurfaceRow;
use chaincell_host::cli::offline::Offline;
use chaincell_host::engine::cut::report::CutReport;
use chaincell_host::engine::staged::Staged;
use chaincell_host::engine::tissue::{Node, TissueEngine};
use chaincell_host::engine::tools::Felt;
use chaincell_host::files::snapshot::SessionSnapshot;
use chaincell_kernel::TOOLS_MAX;
use chaincell_kernel::trace::Command;
use pyo3::prelude::*;
use self_cell::self_cell;

use crate::errors::Class;
use crate::model::Body;
use crate::output::Output;
use crate::poses::Tick;
use crate::surface::Surface;

self_cell!(
    /// A tissue with the body that it reads.
    struct Cell {
        owner: Arc<Body>,
        #[not_covariant]
        dependent: Staged,
    }
);

/// A tissue between two ticks.
pub(crate) struct Live {
    cell: Cell,
    /// Ticks since the reset.
    pub(crate) ticks: u64,
    options: Offline,
}

impl Live {
    /// At rest, as `run` would begin.
    pub(crate) fn new(body: &Arc<Body>, options: &Offline) -> PyResult<Self> {
        let cell = Cell::try_new(Arc::clone(body), |body| options.staged(body.model()));
        let cell = cell.map_err(|why| Class::Argument.host(why))?;
        Ok(Self { cell, ticks: 0, options: options.clone() })
    }

    /// Calls `act` with the tissue.
    pub(crate) fn with<R>(&mut self, act: impl FnOnce(&mut Staged<'_>) -> R) -> R {
        self.cell.with_dependent_mut(|_, staged| act(staged))
    }

    /// Tools that were chosen by their parts.
    pub(crate) fn tools(&mut self) -> usize {
        self.with(|staged| staged.tools())
    }

    /// Refuses poses and sweeps that cannot be ticked.
    pub(crate) fn check(&mut self, tick: &Tick, sweeps: Option<u16>) -> PyResult<()> {
        let (given, tools) = (tick.poses.len(), self.tools());
        if given > tools.max(1) {
            let text = format!("poses of {given} tools: `tools` chose {}", tools.max(1));
            return Err(Class::Pose.error(text));
        }
        let (is_anytime, most) =
            self.with(|of| (of.is_anytime(), of.engine().network().settings().sweeps));
        match sweeps {
            Some(_) if !is_anytime => Err(Class::Argument.error(
                "`sweeps` of a tick: under this `scheme` the sweeps are the tissue's time; leave \
                 it out, or take `scheme` track",
            )),
            Some(sweeps) if sweeps > most => Err(Class::Argument.error(format!(
                "`sweeps` {sweeps} of a tick: the tissue makes at most {most}; give it more `sweeps`"
            ))),
            _ => Ok(()),
        }
    }

    /// One tick, as `run` makes it.
    pub(crate) fn tick(&mut self, tick: &Tick, sweeps: Option<u16>) -> Output {
        self.ticks += 1;
        let number = self.ticks;
        let budget = self.options.budget(sweeps);
        self.with(|staged| {
            let tools = staged.tools();
            let of = staged.tick_by(&tick.poses, budget);
            if tools == 0 {
                let (force_n, contacts) = (of.force_n.into(), of.contacts);
                let force_error_n = staged.force_error_n(0);
                let felt =
                    Felt { force_n, contacts, flags: of.flags, force_error_n, ..Felt::default() };
                return Output { of, felt: vec![felt], is_several: false, tick: number };
            }
            let felt = (0..tools).map(|tool| staged.felt(tool)).collect();
            let is_several = tools > 1 || tick.is_several;
            Output { of, felt, is_several, tick: number }
        })
    }

    /// The hash of the state, 16 hexadecimal digits.
    pub(crate) fn state_hash(&mut self) -> String {
        format!("{:016x}", self.with(|staged| staged.state_hash()))
    }

    /// Positions of the nodes \[m\], by ascending id.
    pub(crate) fn positions_m(&mut self) -> Vec<[f32; 3]> {
        self.with(|staged| {
            let mut nodes = vec![Node::default(); staged.engine().node_count()];
            staged.read_nodes(&mut nodes);
            nodes.iter().map(|node| node.position_m).collect()
        })
    }

    /// Relaxed energy \[J\]; `None` for a body that does not relax.
    pub(crate) fn relaxed_j(&mut self) -> Option<f32> {
        self.with(|staged| staged.relaxed_j())
    }

    /// The cut; `None` for a body that cannot be cut.
    pub(crate) fn cuts(&mut self) -> Option<CutReport> {
        self.with(|staged| staged.cut())
    }

    /// The surface as it is cut now; `None` for a body that cannot be cut.
    pub(crate) fn surface(&mut self) -> Option<Surface> {
        let tick = self.ticks;
        self.with(|staged| {
            let mut rows = vec![SurfaceRow::default(); staged.engine().surface_rows()?];
            let header = staged.read_surface(&mut rows);
            Some(Surface::new(header, &rows, tick))
        })
    }

    /// Carries out a command.
    pub(crate) fn command(&mut self, command: &Command) -> PyResult<()> {
        let done = self.with(|staged| staged.command(command));
        done.map_err(|why| Class::Refused.error(refusal_text(why as u32)))
    }

    /// The tissue as bytes; `begun` are its model and options.
    pub(crate) fn snapshot(&mut self, begun: &[u8]) -> PyResult<Vec<u8>> {
        let saved = self.with(|staged| staged.saved());
        let saved = saved.ok_or_else(|| Class::Base.error("this tissue cannot be saved"))?;
        let snapshot = SessionSnapshot {
            tick: self.ticks,
            publisher: 0,
            released: [false; TOOLS_MAX],
            is_paused: false,
            begun: begun.to_vec(),
            saved,
        };
        Ok(snapshot.to_bytes().0)
    }

    /// Goes on from such bytes.
    pub(crate) fn restore(&mut self, bytes: &[u8], begun: &[u8]) -> PyResult<()> {
        let (snapshot, _) = SessionSnapshot::of(bytes).map_err(|why| Class::Snapshot.error(why))?;
        if snapshot.begun != begun {
            return Err(Class::Snapshot.error(
                "it was taken of another model, with other options or by another release: take those",
            ));
        }
        let done = self.with(|staged| staged.restore(&snapshot.saved));
        done.map_err(|why| Class::Snapshot.host(why))?;
        self.ticks = snapshot.tick;
        Ok(())
    }
}
