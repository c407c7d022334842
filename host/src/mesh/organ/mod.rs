//! `organ[:SIZE]`: a generated liver-shaped body of about SIZE nodes.
//!
//! The same bits on every machine: only + - * / and square roots, in a fixed order.

mod cut;
mod shape;
mod smooth;
mod stuffing;

use std::collections::BTreeMap;

use super::Mesh;
use super::geometry::distance;
use crate::error::{Error, Result};
use stuffing::Body;

/// Nodes unless a size is given.
const SIZE: usize = 5_762;
/// Fewest nodes: below, the thin lobe has no inside.
const SIZE_MIN: usize = 150;
/// Most nodes.
const SIZE_MAX: usize = 60_000;

/// A size that is met this closely ends the search: 1 in 200, of 1 in 50 allowed.
const CLOSE: usize = 200;
/// A size that is not met this closely is refused.
const ALLOWED: usize = 50;

/// The held patch is around this point of the back, in metres.
const BACK_M: [f64; 3] = [-0.03, 0.08, 0.012];

/// One in so many surface nodes is held.
const SURFACE_PER_FIXED: usize = 10;

/// A body 0.20 x 0.15 x 0.09 m with nodes within 2 % of `size` (150 to 60,000; default 5,762),
/// held at a patch of its back, a tenth of the surface nodes.
pub(super) fn generate(size: Option<&str>) -> Result<Mesh> {
    let size = match size.map(str::parse::<usize>) {
        None => SIZE,
        Some(Ok(size)) if (SIZE_MIN..=SIZE_MAX).contains(&size) => size,
        _ => {
            return Err(Error::input(format!(
                "mesh organ:{}: SIZE must be a whole number of nodes from {SIZE_MIN} to {SIZE_MAX}",
                size.unwrap_or("")
            )));
        }
    };
    let mut body = sized(size)?;
    smooth::smooth(&mut body);
    let mesh = Mesh::from_tetrahedra(body.nodes_m, &body.tetrahedra, BTreeMap::new());
    Ok(Mesh { default_fixed: back(&mesh), ..mesh })
}

/// The body whose number of nodes is close to `size`.
fn sized(size: usize) -> Result<Body> {
    let off = |body: &Body| body.nodes_m.len().abs_diff(size);
    let mut spacing_m = 0.02;
    let mut best = stuffing::fill(spacing_m);
    let mut latest = best.nodes_m.len();
    // Newton's steps find the spacing roughly: nodes go with its inverse cube ..
    for _ in 0..12 {
        spacing_m *= (1.0 + (latest as f64 / size as f64 - 1.0) / 3.0).clamp(0.7, 1.3);
        let body = stuffing::fill(spacing_m);
        latest = body.nodes_m.len();
        if off(&body) < off(&best) {
            best = body;
        }
        if off(&best) * CLOSE <= size {
            return Ok(best);
        }
    }
    // .. and small steps around it the numbers that small bodies jump over.
    for step in 1..=200 {
        for sign in [-1.0, 1.0] {
            let body = stuffing::fill(spacing_m * (1.0 + sign * 0.0005 * f64::from(step)));
            if off(&body) < off(&best) {
                best = body;
            }
        }
        if off(&best) * CLOSE <= size {
            return Ok(best);
        }
    }
    if off(&best) * ALLOWED <= size {
        return Ok(best);
    }
    Err(Error::input(format!("mesh organ:{size}: no lattice comes near; take another SIZE")))
}

/// The surface nodes nearest to the middle of the back, sorted.
fn back(mesh: &Mesh) -> Vec<u32> {
    let mut surface: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    surface.sort_unstable();
    surface.dedup();
    let count = surface.len() / SURFACE_PER_FIXED;
    let away = |id: &u32| distance(mesh.nodes_m[*id as usize], BACK_M);
    surface.sort_by(|a, b| away(a).total_cmp(&away(b)));
    surface.truncate(count);
    surface.sort_unstable();
    surface
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survey() {
        for size in
            ["150", "151", "163", "200", "300", "500", "1000", "2000", "5762", "20000", "60000"]
        {
            let start = std::time::Instant::now();
            let mesh = match generate(Some(size)) {
                Ok(m) => m,
                Err(e) => {
                    println!("{e}");
                    continue;
                }
            };
            let t = start.elapsed();
            let mut low = [f64::MAX; 3];
            let mut high = [f64::MIN; 3];
            for p in &mesh.nodes_m {
                for a in 0..3 {
                    low[a] = low[a].min(p[a]);
                    high[a] = high[a].max(p[a]);
                }
            }
            let lens: Vec<f64> = mesh
                .links
                .iter()
                .map(|l| distance(mesh.nodes_m[l[0] as usize], mesh.nodes_m[l[1] as usize]))
                .collect();
            let mean = lens.iter().sum::<f64>() / lens.len() as f64;
            let min = lens.iter().copied().fold(f64::MAX, f64::min);
            let max = lens.iter().copied().fold(0.0, f64::max);
            let mut val = vec![0; mesh.nodes_m.len()];
            for l in &mesh.links {
                val[l[0] as usize] += 1;
                val[l[1] as usize] += 1;
            }
            let mut q: Vec<f64> = mesh
                .tetrahedra
                .iter()
                .map(|t| smooth::roundness(super::super::geometry::corners(&mesh.nodes_m, *t)))
                .collect();
            q.sort_by(f64::total_cmp);
            let vol: f64 = mesh
                .tetrahedra
                .iter()
                .map(|t| {
                    super::super::geometry::volume6(super::super::geometry::corners(
                        &mesh.nodes_m,
                        *t,
                    )) / 6.0
                })
                .sum();
            let mut s: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
            s.sort();
            s.dedup();
            println!(
                "{size}: n {} t {} l {} surf {} val {}..{} min/mean {:.3} max/mean {:.3} q {:.3} {:.3} {:.3} vol {vol:.6} ext {:?} euler {} {t:?}",
                mesh.nodes_m.len(),
                mesh.tetrahedra.len(),
                mesh.links.len(),
                s.len(),
                val.iter().min().unwrap(),
                val.iter().max().unwrap(),
                min / mean,
                max / mean,
                q[0],
                q[q.len() / 100],
                q[q.len() / 2],
                [high[0] - low[0], high[1] - low[1], high[2] - low[2]],
                s.len() as i64 - mesh.triangles.len() as i64 / 2
            );
            println!("{low:?} {high:?}");
            super::super::check::check("organ", &mesh, &crate::mesh::MeshOptions::default())
                .unwrap();
        }
    }
}
