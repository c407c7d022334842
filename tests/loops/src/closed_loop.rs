//! A tissue behind an output stage, a modelled device and a hand: the loop of the passivity tests.

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::stage::{Device, Stage, StageSettings};
use chaincell_kernel::{
    Budget, Flags, Model, Network, Settings, TickOutput, Tissue, ToolPose, Track, Unloading,
};
use nalgebra::{Rotation3, Vector3};

use crate::handle::{Hand, Handle, Moving};

/// Links of the soft and of the stiff body [N/m].
pub const TISSUES: [f32; 2] = [100.0, 5000.0];
/// Stiffness [N/m] and damping [N s/m] of a soft and of a stiff grip.
pub const GRIPS: [(f64, f64); 2] = [(50.0, 0.5), (1000.0, 5.0)];
/// Handles: mass \[kg\] and step of the encoder \[m\].
pub const DEVICES: [(Device, f64, f64); 5] = [
    (Device::Touch, 0.05, 55.0e-6),
    (Device::Premium, 0.1, 30.0e-6),
    (Device::Falcon, 0.2, 60.0e-6),
    (Device::Omega, 0.2, 10.0e-6),
    (Device::Sigma, 0.3, 2.0e-6),
];
/// Damping of every handle [N s/m], what the stage counts on.
const DAMPING: f64 = 0.5;

/// A column of 12 cells of 1 cm, its bottom fixed.
#[must_use]
pub fn column(stiffness_n_per_m: f32) -> ImageBytes {
    let mesh = load("box:2x2x3x0.01", &MeshOptions::default()).unwrap();
    let options = BakeOptions {
        stiffness_n_per_m: PerCell::Uniform(stiffness_n_per_m.into()),
        coarse_basis: BasisSpacing::None,
        ..BakeOptions::default()
    };
    bake(&mesh, &[0, 3, 6, 9], &options).unwrap()
}

/// The handle of a device, `axes` turning the axes of space to those of its encoders.
#[must_use]
pub fn handle(device: usize, axes: Rotation3<f64>) -> Handle {
    let (_, mass_kg, count_m) = DEVICES[device];
    Handle { mass_kg, damping_n_s_per_m: DAMPING, count_m, axes, delay_ticks: 1 }
}

/// A lossless wall below z = 0, its ledger exact.
#[derive(Debug, Clone, Copy)]
pub struct Wall {
    stiffness_n_per_m: f32,
    stored_j: f32,
}

impl Wall {
    /// Untouched.
    #[must_use]
    pub fn new(stiffness_n_per_m: f32) -> Self {
        Self { stiffness_n_per_m, stored_j: 0.0 }
    }

    /// What it answers to a tool.
    pub fn tick(&mut self, tool: &ToolPose) -> TickOutput {
        let depth = (-tool.position_m.z).max(0.0);
        let before = self.stored_j;
        self.stored_j = 0.5 * self.stiffness_n_per_m * depth * depth;
        TickOutput {
            force_n: Vector3::new(0.0, 0.0, self.stiffness_n_per_m * depth),
            energy_j: self.stored_j,
            work_j: self.stored_j - before,
            stiffness_n_per_m: if depth > 0.0 { self.stiffness_n_per_m } else { 0.0 },
            ..TickOutput::NONE
        }
    }
}

/// Time of a cycle of [`busy`] \[ms\].
pub const CYCLE_MS: f64 = 5000.0;

/// Where a busy hand wants to be, from where it begins, in parts of its depth: a press, a hold, taps at
/// 5 Hz, a press and a drag, a hold.
#[must_use]
pub fn busy(time_ms: f64) -> Vector3<f64> {
    let t = time_ms % CYCLE_MS;
    let ramp = |from: f64, ticks: f64| ((t - from) / ticks).clamp(0.0, 1.0);
    let down =
        ramp(200.0, 600.0) - ramp(1_400.0, 300.0) + ramp(2_400.0, 100.0) - ramp(4_600.0, 100.0);
    let tap = if (1_800.0..2_300.0).contains(&t) { (t * 0.03).sin().max(0.0) } else { 0.0 };
    let drag = ramp(2_700.0, 400.0) - ramp(4_700.0, 200.0);
    Vector3::new(0.3 * drag, 0.1 * drag, -down - tap)
}

/// What of a loop is chosen.
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    /// The output stage.
    pub settings: StageSettings,
    /// Place in [`DEVICES`].
    pub device: usize,
    /// Place in [`GRIPS`].
    pub grip: usize,
    /// From the axes of space to those of the encoders.
    pub axes: Rotation3<f64>,
}

impl Choice {
    /// A device behind its own profile, its encoders along the axes of space.
    #[must_use]
    pub fn of(device: usize, grip: usize) -> Self {
        let settings = StageSettings::for_device(DEVICES[device].0);
        Self { settings, device, grip, axes: Rotation3::identity() }
    }

    /// Every device behind its own profile, in both grips.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..DEVICES.len())
            .flat_map(|device| (0..GRIPS.len()).map(move |grip| Self::of(device, grip)))
    }

    /// How far apart the forces of a hold may be: two counts of the coupling's spring, and 0.03 N.
    #[must_use]
    pub fn swing_n(&self) -> f64 {
        2.0 * self.coupling_n_per_m() * DEVICES[self.device].2 + 0.03
    }

    /// Stiffness of the coupling, 0 without one [N/m].
    #[must_use]
    pub fn coupling_n_per_m(&self) -> f64 {
        self.settings.coupling.map_or(0.0, |of| of.stiffness_n_per_m.into())
    }
}

/// The loop.
pub struct Loop<'m> {
    choice: Choice,
    network: Network<'m>,
    tissue: Tissue<400, Track, 64>,
    stage: Stage,
    /// Device and hand.
    pub moving: Moving,
    start: Vector3<f64>,
    /// What the device was given last \[N\].
    pub force_n: Vector3<f64>,
    /// Whether the stage says that it withholds force.
    pub is_withheld: bool,
    /// Upper bound of what tissue and coupling store \[J\].
    pub stored_j: f64,
}

impl<'m> Loop<'m> {
    /// At rest, the tool engaged at one of the column's upper corners.
    #[must_use]
    pub fn new(image: &'m ImageBytes, choice: Choice) -> Self {
        let mut the = Self::begin(image, choice);
        let model = *the.network.model();
        let cell = model.cell_of_input(2).unwrap();
        the.tissue.choose_contacts(&the.network, &[cell]).unwrap();
        let start = the.tissue.view().position_m(&model, cell.into()).unwrap().map(f64::from);
        the.stand(start);
        the
    }

    fn begin(image: &'m ImageBytes, choice: Choice) -> Self {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let settings = Settings { unloading: Unloading::Off, ..Settings::for_model(&model) };
        let network = Network::new(model, settings).unwrap();
        let mut tissue = Tissue::new();
        tissue.reset(&network).unwrap();
        let handle = handle(choice.device, choice.axes);
        Self {
            choice,
            network,
            tissue,
            stage: Stage::new(choice.settings).unwrap(),
            moving: Moving::new(handle, Vector3::zeros()),
            start: Vector3::zeros(),
            force_n: Vector3::zeros(),
            is_withheld: false,
            stored_j: 0.0,
        }
    }

    fn stand(&mut self, start: Vector3<f64>) {
        (self.start, self.moving.position) = (start, start);
    }

    /// A tick, the hand, while it `holds`, wanting to be `way` off the start \[m\].
    pub fn tick(&mut self, way: Vector3<f64>, holds: bool) {
        let device = self.moving.sample(true);
        let tool = self.stage.sample(&device);
        let answer = self.tissue.tick(&self.network, &[tool], Budget::All);
        let output = self.stage.output(&answer);
        let force_n = output.force_n;
        self.is_withheld = output.flags.contains(Flags::FORCE_WITHHELD);
        let apart_m = (tool.position_m - device.position_m).map(f64::from);
        self.stored_j = f64::from(answer.energy_j)
            + 0.5 * self.choice.coupling_n_per_m() * apart_m.norm_squared();
        self.force_n = force_n.map(f64::from);
        let (stiffness_n_per_m, damping_n_s_per_m) = GRIPS[self.choice.grip];
        let at = self.start + way;
        self.moving.tick(force_n, &Hand { stiffness_n_per_m, damping_n_s_per_m, holds, at });
    }

    /// What hand and handle have got out of nothing so far, or rather put in \[J\].
    #[must_use]
    pub fn got_j(&self) -> f64 {
        self.moving.got_j()
    }
}
