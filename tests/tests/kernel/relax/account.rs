//! The account of energy: a hand pays for all that a body holds, relaxes or loses in its sweeps, whatever it does.

use chaincell_kernel::{Dynamics, Flags, Network, Predict, Track};
use nalgebra::Vector3;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::{blocks, hand_m, network, upper};
use crate::bench::Bench;

type V = Vector3<f64>;

/// Most rounding of a sum of works, as a share of their magnitudes.
const ROUNDING: f64 = 1e-6;
/// Farthest place of a hand along each axis \[m\].
const REACH_M: f64 = 2.5e-3;
/// Ticks of the way back to the beginning.
const BACK: usize = 20;
/// Motions of each hand.
const SEEDS: u64 = 4;

/// The hand's exact work is held, relaxed or taken by the sweeps; a still hand's energy falls; a closed motion pays.
fn account<D: Dynamics<Number = f32>>(sweeps: u16) {
    for (name, image) in &blocks(&[(1.0, 0.03), (2.0, 0.4)]) {
        account_of::<D>(name, network(image, sweeps));
    }
}

fn account_of<D: Dynamics<Number = f32>>(name: &str, network: Network<'_>) {
    let nodes = upper(network.model(), 8e-3);
    let mut body = Bench::<D>::holding(network, &nodes);
    let (mut work_j, mut last_j, mut relaxed_j) = (0.0_f64, 0.0, 0.0);
    for tick in 0..900 {
        let is_late = tick % 7 == 3;
        let still = tick > 500;
        let place = if still { [0.0; 3] } else { hand_m(tick) };
        let output = if is_late { body.late(place) } else { body.tick(place) };
        work_j += f64::from(output.work_j);
        let energy_j = f64::from(output.energy_j);
        let now_j = f64::from(body.view().relaxed_j(&network));
        assert!(now_j >= relaxed_j - 1e-9, "{name}, {tick}: {now_j} after {relaxed_j}");
        // The sweeps only take.
        let lost_j = work_j - energy_j - now_j;
        assert!(
            lost_j >= -1e-6 * (work_j + energy_j),
            "{name}, {tick}: {work_j} {energy_j} {now_j}"
        );
        if tick > 502 {
            assert!(energy_j <= last_j, "{name}, {tick}: {energy_j} after {last_j}");
        }
        (last_j, relaxed_j) = (energy_j, now_j);
    }
    assert!(
        work_j > 0.0 && relaxed_j > 0.01 * work_j && last_j < 0.05 * work_j,
        "{name}: {work_j} {last_j} {relaxed_j}"
    );
}

#[test]
fn the_account_of_energy_closes() {
    account::<Predict>(1);
    account::<Track>(1);
    account::<Predict>(4);
}

/// Random numbers of a motion.
struct Draw(Pcg64);

impl Draw {
    /// A number from 0 to 1.
    fn share(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// A vector in a cube of this half edge.
    fn vector(&mut self, half: f64) -> V {
        V::from_fn(|_, _| half * (2.0 * self.share() - 1.0))
    }
}

/// A hand that tries to get energy out of a body.
#[derive(Debug, Clone, Copy)]
enum Hand {
    /// It walks at random.
    Walk,
    /// It jumps to another place every 5 ms.
    Zigzag,
    /// It jumps around squares of random size.
    Square,
    /// It presses for 20 ms, then flees with the force as long.
    Flee,
}

impl Hand {
    const ALL: [Self; 4] = [Self::Walk, Self::Zigzag, Self::Square, Self::Flee];

    /// The place after this tick \[m\], from the last one and the force of the tissue there.
    fn next(self, tick: usize, place_m: V, force_n: V, draw: &mut Draw) -> V {
        let next_m = match self {
            Self::Walk => place_m + draw.vector(4e-4),
            Self::Zigzag if tick.is_multiple_of(5) => draw.vector(1e-3),
            Self::Square if tick.is_multiple_of(20) => {
                let (corner, edge_m) = (tick / 20 % 4, 2e-3 * draw.share());
                let x_m = if corner == 1 || corner == 2 { edge_m } else { 0.0 };
                let z_m = if corner >= 2 { -edge_m } else { 0.0 };
                V::new(x_m, 0.0, z_m)
            }
            Self::Zigzag | Self::Square => place_m,
            Self::Flee if (tick / 20).is_multiple_of(2) => {
                place_m + draw.vector(2e-4) - V::new(0.0, 0.0, 1e-4)
            }
            Self::Flee => place_m + force_n * (3e-4 / force_n.norm().max(1e-6)),
        };
        next_m.map(|x| x.clamp(-REACH_M, REACH_M))
    }
}

/// Work of a hand that goes from rest at random for 200 to 400 ticks, then back to its beginning: the exact sum, and
/// the trapezoid sum of the published forces \[J\].
fn closed_j<D: Dynamics<Number = f32>>(
    network: Network<'_>,
    nodes: &[u32],
    hand: Hand,
    seed: u64,
) -> [f64; 2] {
    let mut draw = Draw(Pcg64::seed_from_u64(seed));
    let mut body = Bench::<D>::holding(network, nodes);
    body.tick([0.0; 3]);
    let (mut place_m, mut end_m, mut force_n) = (V::zeros(), V::zeros(), V::zeros());
    let (mut exact_j, mut trapezoid_j, mut moved_j) = (0.0_f64, 0.0_f64, 0.0_f64);
    let ticks = 200 + (200.0 * draw.share()) as usize;
    for tick in 0..ticks + BACK {
        // The next place, at random or on the way back.
        let wished_m = if tick < ticks {
            end_m = hand.next(tick, place_m, force_n, &mut draw);
            end_m
        } else {
            end_m * (1.0 - (tick + 1 - ticks) as f64 / BACK as f64)
        };
        let sent_m = wished_m.map(|x| x as f32);
        let output = body.tick(sent_m.into());
        // A shortened motion has another trapezoid.
        assert!(!output.flags.contains(Flags::MOTION_CLAMPED), "{hand:?} {seed}, {tick}");
        let (next_m, next_n) = (sent_m.map(f64::from), output.force_n.map(f64::from));
        let work_j = f64::from(output.work_j);
        (exact_j, moved_j) = (exact_j + work_j, moved_j + work_j.abs());
        trapezoid_j -= 0.5 * (force_n + next_n).dot(&(next_m - place_m));
        // The body has held nothing at the beginning: it gives nothing out at any time.
        assert!(
            exact_j >= -ROUNDING * moved_j,
            "{hand:?} {seed}, {tick}: {exact_j} of {moved_j} J"
        );
        (place_m, force_n) = (next_m, next_n);
    }
    assert!(moved_j > 0.0 && place_m == V::zeros(), "{hand:?} {seed}: {moved_j} J");
    [exact_j, trapezoid_j]
}

/// Checks closed motions of all hands with this number of sweeps.
fn closed<D: Dynamics<Number = f32>>(name: &str, sweeps: u16) {
    for (body, image) in &blocks(&[(1.0, 0.03), (2.0, 0.4)]) {
        closed_of::<D>(&format!("{body}, {name}"), network(image, sweeps));
    }
}

fn closed_of<D: Dynamics<Number = f32>>(name: &str, network: Network<'_>) {
    let sweeps = network.settings().sweeps;
    let nodes = upper(network.model(), 8e-3);
    for hand in Hand::ALL {
        let mut least_j = [f64::INFINITY; 2];
        for seed in 0..SEEDS {
            let works_j = closed_j::<D>(network, &nodes, hand, seed);
            least_j = [0, 1].map(|sum| f64::min(least_j[sum], works_j[sum]));
        }
        let [exact_j, trapezoid_j] = least_j;
        println!(
            "{name}, {sweeps} sweeps, {hand:?}: exact work at least {exact_j:.1e} J, trapezoid \
             {trapezoid_j:.1e} J"
        );
        assert!(exact_j > 0.0 && trapezoid_j > 0.0, "{name} {sweeps} {hand:?}: {least_j:?}");
    }
}

#[test]
fn closed_motions_give_a_hand_nothing() {
    closed::<Predict>("predict", 1);
    closed::<Predict>("predict", 2);
    closed::<Predict>("predict", 4);
    closed::<Track>("track", 1);
}
