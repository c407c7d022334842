//! The probe as contact, on generated bodies and on random graphs.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, HatSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Model, Network, Settings, TickOutput, ToolSample, Unloading};
use nalgebra::Vector3;

fn body(spec: &str, hats: HatSpacing, alpha: f64) -> ImageBytes {
    let mesh = load(spec, &MeshOptions::default()).unwrap();
    let fixed = if spec.starts_with("box") {
        let bottom = |&node: &u32| mesh.nodes_m[node as usize][2] < 1e-9;
        (0..mesh.nodes_m.len() as u32).filter(bottom).collect()
    } else {
        mesh.default_fixed.clone()
    };
    let alpha = PerCell::Uniform(alpha);
    bake(&mesh, &fixed, &BakeOptions { alpha, hats, colours: true, ..BakeOptions::default() })
        .unwrap()
}

fn length(v: Vector3<f32>) -> f32 {
    v.dot(&v).sqrt()
}

#[test]
fn explore() {
    for (spec, radius, top) in
        [("plane:21x21x0.01", 0.035, 0.0), ("box:9x9x6x0.01", 0.025, 0.05), ("box:13x13x8x0.01", 0.035, 0.07)]
    {
        for hats in [HatSpacing::None, HatSpacing::Links(2.5)] {
            for alpha in [0.0, 0.05] {
                let image = body(spec, hats, alpha);
                let model = Model::from_bytes(image.as_bytes()).unwrap();
                for scheme in [Scheme::Track, Scheme::Euler, Scheme::GaussSeidel, Scheme::Rkl2] {
                    let sweeps = if scheme == Scheme::Rkl2 { 9 } else { 4 };
                    let network =
                        Network::new(model, scheme.settings(&model, sweeps)).unwrap();
                    let contact = Contact::Probe { radius_m: radius, capacity: 200 };
                    let mut engine =
                        Engine::with_contact(network, scheme, Arithmetic::F32, contact).unwrap();
                    let mut last: Option<TickOutput> = None;
                    let (mut jump, mut changes, mut at) = (0.0_f32, 0, 0);
                    let mut hash = 0;
                    let mut still = 0;
                    let mut report = String::new();
                    for tick in 0..1600 {
                        let depth = 0.015 * (tick.min(300) as f32 / 300.0);
                        let x = 0.02 * ((tick.clamp(600, 900) - 600) as f32 / 300.0);
                        let z = top + radius - depth;
                        let sample = ToolSample { position_m: Vector3::new(x + 0.0013, 0.0021, z), engaged: 1 };
                        let out = engine.tick(&sample);
                        if let Some(last) = last {
                            let j = length(out.force_n - last.force_n);
                            if j > jump { jump = j; at = tick; }
                            if out.contacts != last.contacts { changes += 1; still = tick; }
                        }
                        if engine.state_hash() != hash { hash = engine.state_hash(); }
                        last = Some(out);
                        if [300, 599, 900, 1599].contains(&tick) {
                            report += &format!(" | {tick}: F {:.5} n {} jump {jump:.1e}@{at} changes {changes} last@{still} fl {}", length(out.force_n), out.contacts, out.flags.0);
                            (jump, changes) = (0.0, 0);
                        }
                    }
                    println!("{spec} hats {} a{alpha} {scheme:?}{report}", model.hats());
                }
            }
        }
    }
}
