//! Rest: a body that relaxes changes no bit any more, some time after a press and after its release.

use chaincell_kernel::{Budget, Dynamics, Network, Predict, ToolPose, Track};

use super::{blocks, image, network, upper};
use crate::bench::Bench;

/// Times of the slowest branch after which all rests; 1 + G times as many of a body that is let go.
const REST: f64 = 15.0;

/// In the rest shape a body remembers nothing, 15 (1 + G) tau after its release.
#[test]
fn a_released_body_forgets() {
    let image = image("box:5x5x4x0.005", 15e3, 0.45, &[(1.0, 0.02), (1.0, 0.1)]);
    let network = network(&image, 2);
    let nodes = upper(network.model(), 8e-3);
    let mut body = Bench::<Predict>::holding(network, &nodes);
    for tick in 0..300 {
        body.tick([0.0, 0.0, -1e-3 * (tick as f32 / 50.0).min(1.0)]);
    }
    let free = [ToolPose::at([0.0, 0.0, 0.0].into(), 0)];
    for _ in 0..6000 {
        body.view().tick(&network, &free, Budget::All);
    }
    // The clock and what has relaxed are left.
    let rows = &body.words[18..];
    assert!(rows.iter().all(|&word| word == 0), "{:?}", rows.iter().find(|&&word| word != 0));
    assert!(body.view().relaxed_j(&network) > 0.0);
}

/// Returns the number of values after which all are equal.
fn rests_after<T: PartialEq>(values: &[T]) -> usize {
    let last = values.last();
    values.len() - values.iter().rev().take_while(|value| Some(*value) == last).count()
}

/// A body is pressed, held and released: from some time on the force stays, and the memory of the body that was let go
/// does bit for bit. A branch of 10,000 ticks and more counts the 16 ticks between two updates: its count goes on.
fn rest<D: Dynamics<Number = f32>>(name: &str, sweeps: u16) {
    let (first, slow) = ((1.0, 0.02), (0.5, 0.06));
    for (body, image) in &blocks(&[first, slow]) {
        // Slack links creep back to their bands for longer, as those of an elastic body do.
        let forgets = *body != "slack links";
        let name = format!("{body}, {name}");
        rest_of::<D>(&name, network(image, sweeps), [first, slow], forgets);
    }
}

fn rest_of<D: Dynamics<Number = f32>>(
    name: &str,
    network: Network<'_>,
    [first, slow]: [(f64, f64); 2],
    forgets: bool,
) {
    let sweeps = network.settings().sweeps;
    let nodes = upper(network.model(), 8e-3);
    let mut body = Bench::<D>::holding(network, &nodes);
    for tick in 0..=50 {
        body.tick([0.0, 0.0, -1e-3 * tick as f32 / 50.0]);
    }
    let tau_ticks = 1e3 * slow.1;
    let let_go = 1.0 + first.0 + slow.0;
    let held = ToolPose::at([0.0, 0.0, -1e-3].into(), 1);
    let free = ToolPose::at([0.0, 0.0, 0.0].into(), 0);
    for (state, pose, factor) in [("held", held, 1.0), ("released", free, let_go)] {
        let most_ticks = REST * factor * tau_ticks;
        let ticks = 2 * most_ticks as usize;
        let each = (0..ticks).map(|_| {
            let output = body.view().tick(&network, &[pose], Budget::All);
            (output.force_n.z, body.words.clone())
        });
        let (forces_n, memories): (Vec<f32>, Vec<_>) = each.unzip();
        let force_n = forces_n[ticks - 1];
        assert!((force_n > 0.0) == (pose.engaged == 1), "{name}, {state}: {force_n}");
        // Positions go on in their last bits, as those of an elastic body do.
        let later_n =
            forces_n[most_ticks as usize..].iter().map(|later_n| (later_n - force_n).abs());
        let off = later_n.fold(0.0, f32::max) / force_n.max(1.0);
        let of_memory = rests_after(&memories) as f64 / (factor * tau_ticks);
        println!(
            "{name}, {sweeps} sweeps, {state}: force within {off:.1e} after {REST}, memory at rest after {of_memory:.1} \
             times {:.0} ticks",
            factor * tau_ticks
        );
        assert!(off < 1e-4, "{name}, {state}: {off}");
        assert!(pose.engaged == 1 || !forgets || of_memory <= REST, "{name}, {state}: {of_memory}");
    }
}

#[test]
fn the_force_rests_and_the_memory_of_a_body_let_go() {
    rest::<Predict>("predict", 2);
    rest::<Track>("track", 4);
}
