//! The kernel's tissue beside the exact one.

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, PerCell, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_kernel::{Flags, Model, Network, Settings, ToolPose};

use super::tests::{body, shaken};
use super::*;
use crate::reference::minimum;
use crate::reference::vectors::{distance, fields, size};
use chaincell_host::mesh::{Mesh, MeshOptions, load};

/// A press: the nodes held, how far they go and in how many ticks.
struct Press {
    nodes: Vec<usize>,
    by_m: [f64; 3],
    ticks: u32,
}

/// Where the nodes end, the force on the tool \[N\], the energy \[J\] and the share of ticks that
/// were rolled back.
struct End {
    positions_m: Vec<[f64; 3]>,
    force_n: [f64; 3],
    energy_j: f64,
    rolled_back: f64,
}

fn played(mesh: &Mesh, law: Law, coarse_basis: BasisSpacing, press: &Press) -> End {
    let of = |value| PerCell::Uniform(value);
    let stretch_min = law.band.then_some(BAND_FROM);
    let tissue = Tissue::new(of(law.young_pa), of(law.poisson));
    let tissue = Some(Tissue { stretch_min, ..tissue });
    let options = BakeOptions { tissue, coarse_basis, ..BakeOptions::default() };
    let image = bake(mesh, &mesh.default_fixed, &options).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let settings = Settings { sweeps: 4, ..Settings::for_model(&model) };
    let network = Network::new(model, settings).unwrap();
    let mut held: Vec<u16> =
        press.nodes.iter().map(|&node| model.cell_of_input(node as u32).unwrap()).collect();
    held.sort_unstable();
    let mut engine = Engine::new(network, Scheme::Track, &held).unwrap();
    let at = |engine: &mut Engine<'_>, share: f64| {
        let position_m = press.by_m.map(|x| (share * x) as f32).into();
        engine.tick(&ToolPose::at(position_m, 1))
    };
    let (mut output, mut rolled_back) = (at(&mut engine, 0.0), 0);
    for tick in 0..press.ticks + 400 {
        let share = f64::from(tick.min(press.ticks)) / f64::from(press.ticks);
        output = at(&mut engine, share);
        rolled_back += u32::from(output.flags.contains(Flags::ROLLED_BACK));
    }
    let ids = model.input_id().to_vec();
    let mut positions_m = vec![[0.0; 3]; mesh.nodes_m.len()];
    for (id, at) in ids.into_iter().zip(engine.positions_m()) {
        positions_m[id as usize] = at;
    }
    let force_n = <[f32; 3]>::from(output.force_n).map(f64::from);
    let rolled_back = f64::from(rolled_back) / f64::from(press.ticks + 400);
    End { positions_m, force_n, energy_j: output.energy_j.into(), rolled_back }
}

/// Presses that end in the exact equilibrium: field, force, energy.
// REQ-FOR-07
#[test]
fn a_press_ends_in_the_equilibrium() {
    let even = load("box:9x9x5x0.0125", &MeshOptions::default()).unwrap();
    let on_top = |x: [f64; 3]| x[2] > 0.0499 && x[0].abs() < 0.0126 && x[1].abs() < 0.0126;
    let nodes = (0..even.nodes_m.len()).filter(|&i| on_top(even.nodes_m[i])).collect();
    let down = Press { nodes, by_m: [0.002, 0.0, -0.006], ticks: 200 };
    let aside = Press { nodes: vec![35], by_m: [0.004, 0.003, -0.002], ticks: 100 };
    for (mesh, press) in [(&even, &down), (&shaken(), &aside)] {
        for (poisson, band) in [(0.0, true), (0.3, false), (0.45, true)] {
            let law = Law { young_pa: 5000.0, poisson, band };
            let exact = body(mesh, law);
            let to = |&i: &usize| (i, plus(mesh.nodes_m[i], 1.0, press.by_m));
            let held: Vec<_> = press.nodes.iter().map(to).collect();
            let found = minimum(&exact, &held, &mesh.nodes_m, 1e-10 * exact.force_n());
            let force = exact.force(&found.positions, &press.nodes);
            for coarse_functions in [BasisSpacing::None, BasisSpacing::Links(2.5)] {
                let end = played(mesh, law, coarse_functions, press);
                let moved = size(&fields(&found.positions, -1.0, &mesh.nodes_m));
                let field = distance(&end.positions_m, &found.positions) / moved;
                let off = norm(minus(end.force_n, force)) / norm(force);
                let energy = end.energy_j / found.energy - 1.0;
                println!(
                    "nu {poisson}, band {band}, {coarse_functions:?}: field {field:.1e}, force {off:.1e}, energy {energy:.1e}, \
                     rolled back {:.0} %",
                    100.0 * end.rolled_back
                );
                assert!(field < 5e-3 && off < 1e-3 && energy.abs() < 1e-5);
            }
        }
    }
}
