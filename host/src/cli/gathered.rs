//! Everything that a run gathers tick by tick, and the folder that it fills.

use std::path::Path;

use chaincell_kernel::trace::Record;
use chaincell_kernel::{TickOutput, ToolPose};

use super::picture;
use super::pins::add_pins;
use super::snapshots::Snapshots;
use crate::engine::course::{Course, ToolCourse};
use crate::engine::estimates::Estimates;
use crate::engine::motion::Pose;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::tools::Poses;
use crate::error::Result;
use crate::files::output::{
    Answer, ContactRows, Folder, PinCourse, PinRows, ToolRows, cells_csv, force_csv, vtu,
};
use crate::files::recording::{self, Recording, TraceFile};
use crate::files::whole::write_whole;
use crate::picture::{ForceCurve, Largest};

/// The tables of a run with a folder for its results.
pub struct Tables<'a> {
    folder: &'a Folder,
    trace: TraceFile,
    copy: Option<&'a Path>,
    snapshots: Snapshots<'a>,
    contacts: ContactRows,
    tools: ToolRows,
    curve: ForceCurve,
}

impl<'a> Tables<'a> {
    /// Begins the trace, with room for `records`; a `copy` of it goes elsewhere in the end. `force` replaces an
    /// earlier trace.
    ///
    /// # Errors
    /// A trace or a copy that cannot be written.
    pub fn begin(
        folder: &'a Folder,
        begun: Recording,
        records: usize,
        snapshots: Snapshots<'a>,
        copy: Option<&'a Path>,
        force: bool,
    ) -> Result<Self> {
        let (front, place) = (begun.bytes().to_vec(), folder.file(recording::TRACE));
        let trace = TraceFile::create("--out", &place, force, begun, records)?;
        let copy = copy.filter(|copy| !is_same(copy, &place));
        if let Some(path) = copy {
            // Report a place that cannot be written before the run, not after it.
            write_whole(path, &front)?;
        }
        let (contacts, tools) = (ContactRows::default(), ToolRows::default());
        let curve = ForceCurve::default();
        Ok(Self { folder, trace, copy, snapshots, contacts, tools, curve })
    }

    /// Adds a tick that has been made.
    fn after(
        &mut self,
        pose: &Pose,
        of_tools: &Poses,
        output: &TickOutput,
        is_adaptive: bool,
        tissue: &mut Staged<'_>,
    ) -> Result<()> {
        let sweeps = pose.sweeps.or(is_adaptive.then_some(output.sweeps));
        self.trace.add_tools(&Record { sweeps, ..record(pose, tissue) }, of_tools.each());
        for tool in 0..tissue.tools() {
            self.tools.add(pose.tick, tool, &tissue.felt(tool), output.flags.0);
        }
        self.contacts.after(pose.tick, tissue.engine_mut());
        self.curve.add(pose.tick, pose.position_m, output.force_n.into(), output.contacts > 0);
        self.snapshots.after(pose.tick, tissue.engine_mut())
    }

    /// Ends the trace, and writes tables, curves and the last positions; ticks came at a rate \[Hz\].
    fn finish(self, tissue: &mut Staged<'_>, answers: &[Answer], hz: u32) -> Result<()> {
        let folder = self.folder;
        self.trace.finish()?;
        if let Some(path) = self.copy {
            write_whole(path, &recording::read(&folder.file(recording::TRACE))?)?;
        }
        self.snapshots.finish()?;
        let nodes = tissue.engine_mut().nodes();
        folder.write("cells_final.csv", cells_csv(&nodes).as_bytes())?;
        folder.write("final.vtu", vtu(tissue.engine_mut(), &nodes).as_bytes())?;
        folder.write("force.csv", force_csv(answers).as_bytes())?;
        picture::write_curves(&self.curve, folder, hz)?;
        self.contacts.write(folder, tissue.engine())?;
        self.tools.write(folder, tissue.tools())
    }
}

/// Returns true if both are the same file.
fn is_same(one: &Path, other: &Path) -> bool {
    one.canonicalize().ok().zip(other.canonicalize().ok()).is_some_and(|(one, other)| one == other)
}

/// The record of a tick that has been made.
fn record(pose: &Pose, tissue: &mut Staged<'_>) -> Record {
    let state_hash = Some(tissue.state_hash());
    Record { state_hash, ..Record::of(pose.tick, ToolPose::from(*pose)) }
}

/// All that is gathered.
pub struct Gathered<'a> {
    /// `None` for a run without a folder.
    tables: Option<Tables<'a>>,
    /// One for each tool; of held cells one.
    courses: Vec<Course>,
    /// True if a picture is wanted.
    draws: bool,
    /// True if ticks end when their force is exact enough: the trace then holds their sweeps.
    is_adaptive: bool,
    /// Estimated errors of the forces.
    pub estimates: Estimates,
    largest: Largest,
    pins: PinRows,
    /// Energy that tools on a surface gave the body \[J\].
    pub given_j: f64,
    /// Of scissors, the largest so far.
    pub opening_torque_n_m: Option<f32>,
}

impl<'a> Gathered<'a> {
    /// Nothing yet. `draws` is true if a picture is wanted, `is_adaptive` if ticks end when their force is exact
    /// enough.
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(tables: Option<Tables<'a>>, draws: bool, is_adaptive: bool) -> Result<Self> {
        let (courses, largest, estimates) = (Vec::new(), Largest::default(), Estimates::new()?);
        let (pins, opening_torque_n_m) = (PinRows::default(), None);
        Ok(Self {
            tables,
            courses,
            draws,
            is_adaptive,
            estimates,
            largest,
            pins,
            given_j: 0.0,
            opening_torque_n_m,
        })
    }

    /// Adds a tick that has been made.
    ///
    /// # Errors
    /// A snapshot that cannot be written.
    pub fn after(
        &mut self,
        pose: &Pose,
        of_tools: &Poses,
        output: &TickOutput,
        tissue: &mut Staged<'_>,
    ) -> Result<()> {
        let force_n = output.force_n.into();
        self.given_j += f64::from(tissue.engine_mut().given_j());
        self.courses.resize(tissue.tools().max(1), Course::default());
        if let ([only], 0) = (&mut self.courses[..], tissue.tools()) {
            only.add(force_n, output.contacts, None);
            self.estimates.add(force_n, output.contacts, tissue.force_error_n(0));
        }
        for tool in 0..tissue.tools() {
            let felt = tissue.felt(tool);
            self.courses[tool].add(felt.force_n, felt.contacts, tissue.places_m(tool));
            let error_n = tissue.force_error_n(tool);
            self.estimates.add(felt.force_n, felt.contacts, error_n);
            let torque_n_m = tissue.engine_mut().opening_torque_n_m(tool).map(|x| x + 0.0);
            self.opening_torque_n_m = larger(self.opening_torque_n_m, torque_n_m);
        }
        add_pins(&mut self.pins, pose.tick, tissue.engine_mut());
        if self.draws {
            self.largest.after(tissue.engine_mut(), pose.tick, of_tools.each(), force_n);
        }
        let Some(tables) = &mut self.tables else { return Ok(()) };
        tables.after(pose, of_tools, output, self.is_adaptive, tissue)
    }

    /// Writes the tables; ticks came at a rate \[Hz\].
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(&mut self, tissue: &mut Staged<'_>, answers: &[Answer], hz: u32) -> Result<()> {
        let Some(tables) = self.tables.take() else { return Ok(()) };
        self.pins.write(tables.folder)?;
        tables.finish(tissue, answers, hz)
    }

    /// The course of each pin.
    pub fn pin_courses(&self) -> Vec<PinCourse> {
        self.pins.courses().to_vec()
    }

    /// The course of each tool.
    pub fn courses(&self) -> Vec<ToolCourse> {
        self.courses.iter().map(Course::result).collect()
    }

    /// Draws the tick of the largest force where a picture is wanted, and says so.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn picture(&self, out: Option<&Path>, tissue: &Staged<'_>) -> Result<Option<String>> {
        let Some(out) = out else { return Ok(None) };
        picture::of_run(&self.largest, tissue.engine(), out)
    }
}

/// The larger of two numbers, of which there may be none.
fn larger(one: Option<f32>, other: Option<f32>) -> Option<f32> {
    let both = one.zip(other).map(|(one, other)| one.max(other));
    both.or(one).or(other)
}
