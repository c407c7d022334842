//! Sweeps after a deep cut.
#![allow(clippy::unwrap_used, dead_code, missing_docs)]
#[path = "../kernel/bench.rs"]
mod bench;
use bench::Bench;
use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BakeOptions, Cuttable, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::*;

fn centre(mesh: &Mesh, t: usize) -> [f64; 3] {
    let mut c = [0.0; 3];
    for &n in &mesh.tetrahedra[t] {
        for a in 0..3 {
            c[a] += mesh.nodes_m[n as usize][a] / 4.0;
        }
    }
    c
}

/// Faces between tetrahedra on two sides of the plane x = at, not deeper than depth beneath the top there.
fn cut(mesh: &Mesh, at_m: f64, down_to_m: f64) -> Vec<(usize, usize)> {
    use std::collections::HashMap;
    let mut of: HashMap<[u32; 3], (usize, usize)> = HashMap::new();
    let mut faces = vec![];
    for (t, corners) in mesh.tetrahedra.iter().enumerate() {
        for k in 0..4 {
            let mut key: Vec<u32> = (0..4).filter(|&c| c != k).map(|c| corners[c]).collect();
            key.sort();
            let key = [key[0], key[1], key[2]];
            if let Some(other) = of.insert(key, (t, k)) {
                let z = key.iter().map(|&n| mesh.nodes_m[n as usize][2]).sum::<f64>() / 3.0;
                if (centre(mesh, t)[0] < at_m) != (centre(mesh, other.0)[0] < at_m) && z > down_to_m {
                    faces.push((t, k));
                }
            }
        }
    }
    faces
}

#[test]
fn sweeps() {
    let mesh = load("organ:5762", &MeshOptions::default()).unwrap();
    let poisson: f64 = std::env::var("NU").ok().map_or(0.45, |x| x.parse().unwrap());
    let cuttable = Some(Cuttable { spare_share: 0.1, ..Cuttable::default() });
    let tissue = Some(Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(poisson)));
    let options = BakeOptions { tissue, cuttable, ..BakeOptions::default() };
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let model = Model::from_bytes(&image).unwrap();
    let (lo, hi) = (0..3).map(|a| (mesh.nodes_m.iter().map(|n| n[a]).fold(f64::MAX, f64::min), mesh.nodes_m.iter().map(|n| n[a]).fold(f64::MIN, f64::max))).unzip::<f64, f64, Vec<_>, Vec<_>>();
    println!("{} cells, {lo:?} {hi:?}, coarse {:?}", model.cells(), model.coarse_functions());
    // The top at x = at.
    let at_m = 0.0;
    let top = |x: f64, y: f64| mesh.nodes_m.iter().filter(|n| (n[0] - x).abs() < 0.008 && (n[1] - y).abs() < 0.008).map(|n| n[2]).fold(f64::MIN, f64::max);
    let y0 = 0.5 * (lo[1] + hi[1]);
    let top_m = top(at_m, y0);
    let near = [at_m + 0.012, y0, top(at_m + 0.012, y0)];
    let held: Vec<u32> = (0..mesh.nodes_m.len()).filter(|&n| mesh.nodes_m[n].iter().zip(near).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt() < 0.008).map(|n| n as u32).collect();
    println!("top {top_m} held {}", held.len());
    for depth_m in [0.0, 0.02, 0.04] {
        let mut settings = Settings::for_model(&model);
        settings.sweeps = 1;
        let network = Network::new(model, settings).unwrap();
        let mut body = Bench::<Predict>::holding(network, &held);
        body.tick([0.0; 3]);
        if depth_m > 0.0 {
            for face in cut(&mesh, at_m, top_m - depth_m) {
                body.open(face).unwrap();
            }
        }
        for _ in 0..600 {
            body.tick([0.0; 3]);
        }
        println!("depth {depth_m}: {:?}", body.cuts());
        for way in [[0.002, 0.0, 0.0], [0.0, 0.0, 0.002], [0.0, 0.002, 0.0]] {
            let before = body.tick([0.0; 3]).force_n;
            let _ = before;
            let mut forces = vec![];
            for _ in 0..400 {
                let out = body.tick(way);
                let f = out.force_n;
                forces.push((0..3).map(|a| f64::from(f[a]) * f64::from(way[a]) / 0.002).sum::<f64>());
            }
            let last = *forces.last().unwrap();
            let until = |share: f64| forces.iter().rposition(|f| (f - last).abs() > share * last.abs()).map_or(0, |x| x + 1);
            println!("  way {way:?} force {last:.4} first {:.3} {:.3} {:.3} sweeps to 5 % {} 1 % {} .2 % {}", forces[0] / last, forces[1] / last, forces[3] / last, until(0.05), until(0.01), until(0.002));
            for _ in 0..400 {
                body.tick([0.0; 3]);
            }
        }
    }
}
