//! The output stage in closed loop with a modelled handle and hand: no energy is made.
//!
//! What is counted is the continuous motion in double precision: the work of the device's force on
//! the handle less what the handle's own damping takes. From rest on, that sum is what hand and
//! handle have got out of nothing. It may not rise above 0 by more than a coupling at rest takes to
//! be shifted by two counts of the encoder. Counted anew in each cycle, so that what an earlier one
//! took pays for nothing, it may not rise above what tissue and coupling stored at the cycle's
//! beginning by more than 0.05 mJ: the encoder's counts hide that much. In the holds the force is
//! there, and the handle is slower than a soft hand's own swing.
//!
//! 1,000,000 ticks in all; with `CHAINCELL_SLOW=1` as many for each case.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, HatSpacing, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::stage::{Device, Stage, StageSettings};
use chaincell_kernel::{Model, Network, Settings, Tissue, ToolSample, Track, Unloading};
use chaincell_tests::handle::{Hand, Handle, Moving};
use nalgebra::Vector3;

/// Ticks of all cases together, and of each in the slow suite.
const TICKS: u32 = 1_000_000;
/// A press, a hold, taps, a drag along the surface, a hold, the hand off and on again.
const CYCLE: u32 = 5_000;
/// Most energy made in a cycle by itself [J].
const CYCLE_J: f64 = 5.0e-5;
/// Links of the soft and of the stiff body [N/m].
const TISSUES: [f32; 2] = [100.0, 5000.0];
/// Stiffness [N/m] and damping [N s/m] of a soft and of a stiff grip.
const GRIPS: [(f64, f64); 2] = [(50.0, 0.5), (1000.0, 5.0)];
/// Handles: mass [kg] and step of the encoder [m].
const DEVICES: [(Device, f64, f64); 5] = [
    (Device::Touch, 0.05, 55.0e-6),
    (Device::Premium, 0.1, 30.0e-6),
    (Device::Falcon, 0.2, 60.0e-6),
    (Device::Omega, 0.2, 10.0e-6),
    (Device::Sigma, 0.3, 2.0e-6),
];
/// Damping of every handle [N s/m], what the stage counts on.
const DAMPING: f64 = 0.5;

/// A column of 12 cells of 1 cm, its bottom fixed.
fn column(stiffness_n_per_m: f32) -> ImageBytes {
    let mesh = load("box:2x2x3x0.01", &MeshOptions::default()).unwrap();
    let options = BakeOptions {
        stiffness_n_per_m: PerCell::Uniform(stiffness_n_per_m.into()),
        hats: HatSpacing::None,
        ..BakeOptions::default()
    };
    bake(&mesh, &[0, 3, 6, 9], &options).unwrap()
}

/// Where the hand wants to be, from where the contact cell rests [m], and whether it holds.
fn wish(tick: u32, depth: f64) -> (Vector3<f64>, bool) {
    let at = tick % CYCLE;
    let t = f64::from(at);
    let ramp = |from: f64, ticks: f64| ((t - from) / ticks).clamp(0.0, 1.0);
    let down =
        ramp(200.0, 600.0) - ramp(1_400.0, 300.0) + ramp(2_400.0, 100.0) - ramp(4_600.0, 100.0);
    let tap = if (1_800..2_300).contains(&at) { (t * 0.03).sin().max(0.0) } else { 0.0 };
    let drag = ramp(2_700.0, 400.0) - ramp(4_700.0, 200.0);
    let place = Vector3::new(0.3 * drag, 0.1 * drag, -down - tap) * depth;
    (place, !(3_800..4_200).contains(&at))
}

/// What came of a loop.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    /// Most that hand and handle got out of nothing, in the run and in a cycle by itself [J].
    made_j: f64,
    cycle_j: f64,
    /// Least force in the holds [N].
    hold_n: f64,
    /// Fastest motion in the holds, when all should be at rest [m/s].
    rest_m_per_s: f64,
    /// Largest energy of motion [J], largest force and step of the force [N].
    kinetic_j: f64,
    force_n: f64,
    step_n: f64,
    ticks: u32,
}

fn run(
    image: &ImageBytes,
    settings: StageSettings,
    device: usize,
    grip: usize,
    ticks: u32,
) -> Seen {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let settings_of = Settings { unloading: Unloading::Off, ..Settings::for_model(&model) };
    let network = Network::new(model, settings_of).unwrap();
    let mut tissue = Tissue::<16, Track, 1>::new();
    tissue.reset(&network).unwrap();
    let cell = network.model().cell_of_input(2).unwrap();
    tissue.choose_contacts(&network, &[cell]).unwrap();
    let start = tissue.view().position_m(network.model(), cell.into()).unwrap().map(f64::from);
    let mut stage = Stage::new(settings).unwrap();
    let (_, mass_kg, count_m) = DEVICES[device];
    let handle = Handle { mass_kg, damping_n_s_per_m: DAMPING, count_m, delay_ticks: 1 };
    let mut moving = Moving::new(handle, start);
    let (stiffness_n_per_m, damping_n_s_per_m) = GRIPS[grip];
    let mut hand = Hand { stiffness_n_per_m, damping_n_s_per_m, holds: true, at: start };
    let mut seen = Seen { hold_n: f64::INFINITY, ..Seen::default() };
    let spring_n_per_m = settings.coupling.map_or(0.0, |of| f64::from(of.stiffness_n_per_m));
    let mut from_j = 0.0;
    let mut last = Vector3::zeros();
    for tick in 0..ticks {
        let (way, holds) = wish(tick, 0.01);
        (hand.at, hand.holds) = (start + way, holds);
        let device = moving.sample(true);
        let tool = stage.sample(&device);
        let answer = tissue.tick(&network, &tool);
        let force = stage.output(&answer).force_n;
        seen.step_n = seen.step_n.max((force - last).map(f64::from).norm());
        seen.force_n = seen.force_n.max(force.map(f64::from).norm());
        last = force;
        moving.tick(force, &hand);
        seen.ticks = tick + 1;
        let got_j = moving.port_j - moving.lost_j;
        if tick % CYCLE == 0 {
            let apart_m = tool.position_m.map(f64::from) - device.position_m.map(f64::from);
            let coupling_j = 0.5 * spring_n_per_m * apart_m.norm_squared();
            from_j = got_j + f64::from(answer.energy_j) + coupling_j;
        }
        seen.made_j = seen.made_j.max(got_j);
        seen.cycle_j = seen.cycle_j.max(got_j - from_j);
        seen.kinetic_j = seen.kinetic_j.max(moving.kinetic_j());
        if (1_200..1_400).contains(&(tick % CYCLE)) {
            seen.rest_m_per_s = seen.rest_m_per_s.max(moving.velocity.norm());
            seen.hold_n = seen.hold_n.min(force.map(f64::from).norm());
        }
        if seen.kinetic_j > 100.0 {
            break;
        }
    }
    seen
}

fn print(name: &str, device: usize, tissue: f32, grip: usize, seen: &Seen) {
    let Seen { made_j, cycle_j, hold_n, rest_m_per_s, kinetic_j, force_n, step_n, ticks } = seen;
    println!(
        "{name} {:?}, links {tissue} N/m, hand {} N/m: made {made_j:.1e} J in {ticks} ticks, {cycle_j:.1e} J in a cycle, at rest \
         {rest_m_per_s:.1e} m/s and {hold_n:.2} N, motion at most {kinetic_j:.1e} J, force {force_n:.2} N, step {step_n:.2} N",
        DEVICES[device].0, GRIPS[grip].0
    );
}

/// What a coupling takes to be shifted by two counts, and as much again for sums in single precision.
fn allowed_j(settings: &StageSettings, device: usize) -> f64 {
    let stiffness = settings.coupling.map_or(0.0, |of| f64::from(of.stiffness_n_per_m));
    let shift = 2.0 * DEVICES[device].2;
    stiffness * shift * shift
}

#[test]
fn no_energy_is_made() {
    let slow = std::env::var_os("CHAINCELL_SLOW").is_some();
    let cases = (DEVICES.len() * TISSUES.len() * GRIPS.len()) as u32;
    let ticks = if slow { TICKS } else { TICKS / cases };
    if !slow {
        println!("SKIPPED {TICKS} ticks for each case: CHAINCELL_SLOW is not set");
    }
    for stiffness in TISSUES {
        let image = column(stiffness);
        for (device, &(profile, ..)) in DEVICES.iter().enumerate() {
            for grip in 0..GRIPS.len() {
                let settings = StageSettings::for_device(profile);
                let seen = run(&image, settings, device, grip, ticks);
                print("with", device, stiffness, grip, &seen);
                let bound = allowed_j(&settings, device);
                assert!(seen.made_j <= bound, "{profile:?}: {} J, allowed {bound}", seen.made_j);
                assert!(seen.cycle_j <= CYCLE_J, "{profile:?}: {} J in a cycle", seen.cycle_j);
                let step = 1.000_01 * f64::from(settings.max_slew_n_per_s * settings.tick_s);
                assert!(seen.step_n <= step && seen.force_n <= f64::from(settings.max_force_n));
                assert!(seen.hold_n > 0.02, "{profile:?}: {} N", seen.hold_n);
                assert!(seen.rest_m_per_s < 0.03, "{profile:?}: {} m/s", seen.rest_m_per_s);
                // What the hand itself puts into its taps.
                assert!(seen.kinetic_j < 0.1, "{profile:?}: {}", seen.kinetic_j);
            }
        }
    }
}

#[test]
fn without_the_stage_the_same_loop_oscillates() {
    let image = column(TISSUES[1]);
    for (device, (profile, ..)) in DEVICES.iter().enumerate() {
        for grip in 0..GRIPS.len() {
            let seen = run(&image, StageSettings::NONE, device, grip, 20_000);
            print("without", device, TISSUES[1], grip, &seen);
            assert!(seen.made_j > 0.05, "{profile:?}: {} J", seen.made_j);
        }
    }
}

/// A slow press and a hold on a given path, measured without counts: what passivity control does to
/// the force.
#[test]
fn a_slow_press_feels_the_same() {
    for stiffness in TISSUES {
        let image = column(stiffness);
        let settings = StageSettings::for_device(Device::Omega);
        let forces = |settings: StageSettings| {
            let model = Model::from_bytes(image.as_bytes()).unwrap();
            let network = Network::new(model, Settings::for_model(&model)).unwrap();
            let mut tissue = Tissue::<16, Track, 1>::new();
            tissue.reset(&network).unwrap();
            tissue.choose_contacts(&network, &[model.cell_of_input(2).unwrap()]).unwrap();
            let mut stage = Stage::new(settings).unwrap();
            let tick = |tick: u16| {
                // 10 mm/s for 200 ms, then still.
                let depth = 1.0e-5 * f32::from(tick.min(300).saturating_sub(100));
                let position_m = Vector3::new(0.0, 0.0, -depth);
                let tool = stage.sample(&ToolSample { position_m, engaged: 1 });
                f64::from(stage.output(&tissue.tick(&network, &tool)).force_n.z)
            };
            (0..600).map(tick).collect::<Vec<f64>>()
        };
        let (with, without) =
            (forces(settings), forces(StageSettings { passivity: None, ..settings }));
        let apart = with.iter().zip(&without).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let (end, at_rest) = (without[599], (with[599] - without[599]).abs());
        println!(
            "links {stiffness} N/m: {end:.3} N, in the press {apart:.1e} N off, at rest {at_rest:.1e} N"
        );
        assert!(apart <= 0.03 && at_rest <= 1.0e-4 * end, "{apart} {at_rest} of {end}");
    }
}
