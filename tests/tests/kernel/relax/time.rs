//! Time: a branch relaxes as the analytic series does, whatever the sweeps do.

use std::f64::consts::TAU;

use chaincell_host::bake::ImageBytes;
use chaincell_host::bake::tissue::DEVICE_HZ;
use chaincell_kernel::{Network, Predict, ToolPart};

use super::{image, image_at, links, middle_m, network, upper};
use crate::bench::Bench;

/// Most error that time may make, as a share of the branch's peak.
const ERROR_MAX: f64 = 2e-3;
/// The same of links pressed by 1.3 %, which also turn on the way.
const LINK_ERROR_MAX: f64 = 1e-2;
/// Sweeps a tick that are compared, and those of a reference.
const FEW: [u16; 3] = [1, 2, 4];
const MANY: u16 = 24;
/// Times of the branches \[s\].
const TIMES_S: [f64; 6] = [0.005, 0.02, 0.1, 2.0, 12.0, 100.0];
/// Radius of the ball and depth of its press \[m\].
const RADIUS_M: f64 = 0.008;
const DEPTH_M: f64 = 0.002;
/// Ticks of the press, and ticks a second of its reference.
const BALL_TICKS: usize = 300;
const FINE_HZ: u32 = 4 * DEVICE_HZ;

/// Motions of a hand, 0 before its time begins.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// In one tick.
    Step,
    /// In 0.1 s.
    Ramp,
    /// At this frequency.
    Sine(f64),
}

impl Motion {
    fn at(self, time_s: f64) -> f64 {
        match self {
            Self::Step => (time_s / 1e-3).clamp(0.0, 1.0),
            Self::Ramp => (time_s / 0.1).clamp(0.0, 1.0),
            Self::Sine(hz) => (TAU * hz * time_s).sin(),
        }
    }

    /// The integral of exp(-(t - s) / tau) over the motion.
    fn remembered(self, tau_s: f64, time_s: f64) -> f64 {
        let ramp = |length_s: f64| {
            let done_s = time_s.min(length_s);
            let at = |s: f64| (-(time_s - s) / tau_s).exp();
            tau_s / length_s * (at(done_s) - at(0.0))
        };
        match self {
            Self::Step => ramp(1e-3),
            Self::Ramp => ramp(0.1),
            Self::Sine(hz) => {
                let (w, fade) = (TAU * hz, (-time_s / tau_s).exp());
                let (sin, cos) = (w * time_s).sin_cos();
                w * tau_s / (1.0 + (w * tau_s).powi(2)) * (cos + w * tau_s * sin - fade)
            }
        }
    }

    /// The part of its depth at which a ball is; it never leaves the surface by its own motion.
    fn down(self, time_s: f64) -> f64 {
        match self {
            Self::Step | Self::Ramp => self.at(time_s),
            Self::Sine(hz) => 0.5 * (1.0 - (TAU * hz * time_s).cos()),
        }
    }
}

const MOTIONS: [Motion; 5] =
    [Motion::Step, Motion::Ramp, Motion::Sine(1.0), Motion::Sine(3.0), Motion::Sine(10.0)];

/// A cube without lateral stress.
fn cube(branches: &[(f64, f64)]) -> ImageBytes {
    image("box:4x4x4x0.005", 15e3, 0.0, branches)
}

/// The same of links.
fn cube_of_links(branches: &[(f64, f64)]) -> ImageBytes {
    links("box:4x4x4x0.005", 0.0, branches)
}

/// Time at the end of a tick after the first one \[s\].
fn time_s(tick: usize) -> f64 {
    1e-3 * (tick + 1) as f64
}

/// Ticks of a press with a branch of this time.
fn ticks_of(tau_s: f64) -> usize {
    ((5e3 * tau_s) as usize).clamp(300, 1500)
}

/// Force of a cube, pressed by its upper face \[N\]: late in every third tick, or never.
fn pressed_n(network: Network<'_>, motion: Motion, ticks: usize, is_often_late: bool) -> Vec<f64> {
    pressed_by_n(1e-3, network, motion, ticks, is_often_late)
}

/// The same, pressed so deep \[m\].
fn pressed_by_n(
    depth_m: f64,
    network: Network<'_>,
    motion: Motion,
    ticks: usize,
    is_often_late: bool,
) -> Vec<f64> {
    let nodes = upper(network.model(), 1.0);
    let mut body = Bench::<Predict>::holding(network, &nodes);
    body.tick([0.0; 3]);
    let each = (0..ticks).map(|tick| {
        let place_m = [0.0, 0.0, (-depth_m * motion.at(time_s(tick))) as f32];
        if is_often_late && tick % 3 == 1 {
            body.late(place_m);
            return f64::NAN;
        }
        f64::from(body.tick(place_m).force_n.z)
    });
    each.collect()
}

/// Force of a branch as stiff as the rest, from that of the elastic body \[N\]; `None` where the motion is near 0.
fn branch_n(stiff_n: f64, motion: Motion, tau_s: f64, time_s: f64) -> Option<f64> {
    let place = motion.at(time_s);
    (place.abs() >= 0.05).then(|| 0.5 * stiff_n / place * motion.remembered(tau_s, time_s))
}

/// Largest error of the force in shares of the branch's largest force.
fn time_error(tau_s: f64, motion: Motion, is_often_late: bool) -> f64 {
    let [stiff_n, force_n] = [&cube(&[]), &cube(&[(1.0, tau_s)])]
        .map(|image| pressed_n(network(image, 12), motion, ticks_of(tau_s), is_often_late));
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for (tick, (stiff_n, force_n)) in stiff_n.iter().zip(&force_n).enumerate() {
        let branch_n = branch_n(*stiff_n, motion, tau_s, time_s(tick));
        let Some(branch_n) = branch_n.filter(|force_n| !force_n.is_nan()) else { continue };
        largest = largest.max(branch_n.abs());
        error = error.max((force_n - (0.5 * stiff_n + branch_n)).abs());
    }
    error / largest
}

/// Checks the largest error of branches of these times \[s\] under all motions, in shares of the branch's peak.
fn check_times(times_s: &[f64], is_often_late: bool, most: f64) {
    for &tau_s in times_s {
        for motion in MOTIONS {
            let error = time_error(tau_s, motion, is_often_late);
            println!("tau {tau_s} s, {motion:?}: {:.3} % of the branch's peak", 100.0 * error);
            assert!(error < most, "{tau_s} {motion:?}: {error}");
        }
    }
}

#[test]
fn branches_are_exact_in_time() {
    check_times(&TIMES_S, false, ERROR_MAX);
}

/// Links relax by Fung's law: the force of a branch is that of the elastic body, whose changes fade one by one. It is
/// no line in the depth, so the sum goes over the elastic body's own forces.
#[test]
fn tensions_of_links_fade_in_proportion() {
    for tau_s in TIMES_S {
        for motion in MOTIONS {
            let [elastic, relaxing] = [cube_of_links(&[]), cube_of_links(&[(1.0, tau_s)])];
            let [stiff_n, force_n] = [&elastic, &relaxing].map(|image| {
                pressed_by_n(2e-4, network(image, 12), motion, ticks_of(tau_s), false)
            });
            let left = (-1e-3 / tau_s).exp();
            let in_a_tick = (1.0 - left) * tau_s / 1e-3;
            let (mut error, mut largest, mut branch_n, mut last_n) = (0.0_f64, 0.0_f64, 0.0, 0.0);
            for (stiff_n, force_n) in stiff_n.iter().zip(&force_n) {
                branch_n = left * branch_n + in_a_tick * (0.5 * stiff_n - last_n);
                last_n = 0.5 * stiff_n;
                largest = largest.max(f64::abs(branch_n));
                error = error.max((force_n - (0.5 * stiff_n + branch_n)).abs());
            }
            println!(
                "links, tau {tau_s} s, {motion:?}: {:.3} % of the peak",
                100.0 * error / largest
            );
            assert!(error < LINK_ERROR_MAX * largest, "{tau_s} {motion:?}: {error} {largest}");
        }
    }
}

#[test]
fn late_ticks_take_their_time() {
    check_times(&[0.005, 0.02], true, 5e-3);
}

/// The part of the twin's own error that a body that relaxes may have: its peak under a ball is that of another force.
const TWIN: f64 = 1.05;

/// Errors of a body that relaxes and of its elastic twin with as many sweeps \[N\], a tick each.
#[derive(Debug, Default)]
struct Errors {
    relaxing_n: Vec<f64>,
    elastic_n: Vec<f64>,
    /// Peaks of the branch's force and of the elastic one.
    peak_n: f64,
    force_n: f64,
}

impl Errors {
    fn note(&mut self, relaxing_n: f64, elastic_n: f64, [branch_n, force_n]: [f64; 2]) {
        self.force_n = self.force_n.max(force_n.abs());
        self.relaxing_n.push(relaxing_n.abs());
        self.elastic_n.push(elastic_n.abs());
        self.peak_n = self.peak_n.max(branch_n.abs());
    }

    /// Prints the errors in shares of the branch's peak, and adds them to the faults if in 98 of 100 ticks more is left
    /// than the twin's own error and a share of both peaks. In the others a pass may have been discarded, of the twin
    /// in other ticks.
    fn check(self, name: String, faults: &mut Vec<String>) {
        let [relaxing, elastic] = [self.relaxing_n, self.elastic_n].map(|mut errors_n| {
            errors_n.sort_by(f64::total_cmp);
            [errors_n[errors_n.len() * 98 / 100], errors_n[errors_n.len() - 1]]
                .map(|error_n| error_n / self.peak_n)
        });
        let percent =
            |[most, largest]: [f64; 2]| format!("{:.3} ({:.3})", 100.0 * most, 100.0 * largest);
        let text = format!(
            "{name}: 98 % of the ticks within {} % of the branch's peak (largest), the elastic twin {} %",
            percent(relaxing),
            percent(elastic)
        );
        println!("{text}");
        let is_fine =
            relaxing[0] <= TWIN * elastic[0] + ERROR_MAX * (1.0 + self.force_n / self.peak_n);
        if !is_fine {
            faults.push(text);
        }
    }
}

/// With few sweeps the error of the force is that of the elastic twin with as many, plus what time may make.
#[test]
fn branches_are_exact_in_time_with_few_sweeps() {
    let elastic = cube(&[]);
    let bodies = TIMES_S.map(|tau_s| (tau_s, cube(&[(1.0, tau_s)])));
    let mut faults = Vec::new();
    for motion in MOTIONS {
        let twin = |sweeps| pressed_n(network(&elastic, sweeps), motion, 1500, false);
        let exact_n = twin(MANY);
        for sweeps in FEW {
            let twin_n = twin(sweeps);
            for (tau_s, relaxing) in &bodies {
                let network = network(relaxing, sweeps);
                let forces_n = pressed_n(network, motion, ticks_of(*tau_s), false);
                let mut errors = Errors::default();
                for (tick, force_n) in forces_n.iter().enumerate() {
                    let exact_n = exact_n[tick];
                    let branch_n = branch_n(exact_n, motion, *tau_s, time_s(tick));
                    let Some(branch_n) = branch_n else { continue };
                    let error_n = force_n - (0.5 * exact_n + branch_n);
                    errors.note(error_n, twin_n[tick] - exact_n, [branch_n, exact_n]);
                }
                let name = format!("held cells, {sweeps} sweeps, tau {tau_s} s, {motion:?}");
                errors.check(name, &mut faults);
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Force of a slab under a ball at every millisecond \[N\], with this number of sweeps and of ticks a second.
fn under_ball_n(image: &ImageBytes, motion: Motion, sweeps: u16, device_hz: u32) -> Vec<f64> {
    let network = network(image, sweeps);
    let [x_m, y_m, top_m] = middle_m(network.model());
    let ball = [ToolPart::sphere(RADIUS_M as f32)];
    let mut body = Bench::<Predict>::under(network, &[&ball], 0.0);
    let step = (device_hz / DEVICE_HZ) as usize;
    let each = (0..=BALL_TICKS * step).map(|tick| {
        let depth_m = DEPTH_M * motion.down(tick as f64 / f64::from(device_hz));
        let place_m = [x_m, y_m, top_m + RADIUS_M - depth_m].map(|x| x as f32);
        f64::from(body.tick(place_m).force_n.z)
    });
    let all_n: Vec<f64> = each.collect();
    all_n.into_iter().step_by(step).collect()
}

/// A ball as probe, whose force is no line in its depth: the reference is the same body at four times the rate with
/// many sweeps. A jump is left out, since the force is no straight line within that tick.
#[test]
fn a_ball_feels_branches_that_are_exact_in_time() {
    let slab = |device_hz, branches: &[(f64, f64)]| {
        image_at(device_hz, "box:7x7x4x0.005", (15e3, 0.0), branches)
    };
    let elastic = slab(DEVICE_HZ, &[]);
    let bodies = [0.1, 2.0, 100.0].map(|tau_s| {
        (tau_s, [DEVICE_HZ, FINE_HZ].map(|device_hz| slab(device_hz, &[(1.0, tau_s)])))
    });
    let mut faults = Vec::new();
    for motion in &MOTIONS[1..] {
        let stiff_n = under_ball_n(&elastic, *motion, MANY, FINE_HZ);
        let twins_n = FEW.map(|sweeps| under_ball_n(&elastic, *motion, sweeps, DEVICE_HZ));
        for (tau_s, [relaxing, fine]) in &bodies {
            let exact_n = under_ball_n(fine, *motion, MANY, FINE_HZ);
            for (sweeps, twin_n) in FEW.into_iter().zip(&twins_n) {
                let forces_n = under_ball_n(relaxing, *motion, sweeps, DEVICE_HZ);
                let mut errors = Errors::default();
                for (tick, force_n) in forces_n.iter().enumerate() {
                    let (exact_n, stiff_n) = (exact_n[tick], stiff_n[tick]);
                    let elastic_n = twin_n[tick] - stiff_n;
                    let branch_n = exact_n - 0.5 * stiff_n;
                    errors.note(force_n - exact_n, elastic_n, [branch_n, stiff_n]);
                }
                assert!(errors.peak_n > 1e-3, "{tau_s} s, {motion:?}: {}", errors.peak_n);
                let name = format!("ball, {sweeps} sweeps, tau {tau_s} s, {motion:?}");
                errors.check(name, &mut faults);
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
