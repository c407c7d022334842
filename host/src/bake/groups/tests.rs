use super::*;
use crate::mesh::{MeshOptions, load};

/// A body with its groups and their links, all links of the mesh equally stiff.
struct Body {
    mesh: Mesh,
    groups: Groups,
    coarse: CoarseLinks,
}

fn body(spec: &str, cells: usize) -> Body {
    let mesh = load(spec, &MeshOptions::default()).unwrap();
    let groups = partition(&mesh, &mesh.default_fixed, cells).unwrap();
    let of_links = |value: f64| vec![value; mesh.links.len()];
    let coarse = couple(&mesh, &groups, &of_links(20.0), &of_links(0.0));
    Body { mesh, groups, coarse }
}

/// Rows of a homogeneous deformation.
type Rows = [[f64; 3]; 3];

fn moved(rows: &Rows, at: [f64; 3]) -> [f64; 3] {
    rows.map(|row| (0..3).map(|axis| row[axis] * at[axis]).sum())
}

/// Uniform stretches, compressions and shears by `by`, along the axes and askew.
fn deformations(by: f64) -> Vec<(&'static str, Rows)> {
    let one = |i: usize, j: usize, e: f64| {
        let mut rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        rows[i][j] += e;
        rows
    };
    let askew = |e: f64| {
        let n = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| f64::from(u8::from(i == j)) + e * n[i] * n[j])
        })
    };
    vec![
        ("stretch x", one(0, 0, by)),
        ("stretch y", one(1, 1, by)),
        ("compression z", one(2, 2, -by)),
        ("compression x", one(0, 0, -by)),
        ("shear xy", one(0, 1, by)),
        ("shear yz", one(1, 2, by)),
        ("shear zx", one(2, 0, by)),
        ("stretch askew", askew(by)),
        ("compression askew", askew(-by)),
    ]
}

/// Energy of links between `nodes` under a homogeneous deformation.
fn energy(nodes: &[[f64; 3]], links: &[[u32; 2]], stiffness: &[f64], rows: &Rows) -> f64 {
    let length = |[i, j]: [u32; 2], rows: &Rows| {
        let (a, b) = (nodes[i as usize], nodes[j as usize]);
        let d: [f64; 3] = std::array::from_fn(|axis| b[axis] - a[axis]);
        squared(moved(rows, d), [0.0; 3]).sqrt()
    };
    let rest = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let of = |(link, k): (&[u32; 2], &f64)| {
        0.5 * k * (length(*link, rows) - length(*link, &rest)).powi(2)
    };
    links.iter().zip(stiffness).map(of).sum()
}

/// Force of the held top against a move of it, of a model of the mesh.
fn plate(mesh: &Mesh, cells: Option<usize>, move_m: [f64; 3]) -> [f64; 3] {
    use crate::reference::{Links, minimum};
    let options = crate::bake::BakeOptions {
        cells,
        hats: crate::bake::HatSpacing::None,
        ..Default::default()
    };
    let image = crate::bake::bake(mesh, &mesh.default_fixed, &options).unwrap();
    let model = chaincell_kernel::Model::from_bytes(image.as_bytes()).unwrap();
    let top = mesh.nodes_m.iter().map(|p| p[2]).fold(0.0, f64::max);
    let nodes: Vec<u32> = (0..mesh.nodes_m.len() as u32)
        .filter(|&n| mesh.nodes_m[n as usize][2] > top - 1e-9)
        .collect();
    let held = crate::contact::held(&model, &nodes).unwrap();
    let links = Links::of_model(&model);
    let at = |cell: u16| {
        let r = links.rest()[usize::from(cell)];
        std::array::from_fn(|x| r[x] + move_m[x] / f64::from(model.unit_m()))
    };
    let places: Vec<(usize, [f64; 3])> = held.iter().map(|&c| (c.into(), at(c))).collect();
    let found = minimum(&links, &places, &links.rest().to_vec(), 1e-9);
    let of: Vec<usize> = held.iter().map(|&c| c.into()).collect();
    links.force(&found.positions, &of).map(|f| f * f64::from(model.force_unit_n()))
}

#[test]
fn probe_plate() {
    for (spec, cells) in [
        ("box:21x21x11x0.005", vec![1000, 500, 300, 100]),
        ("box:13x13x13x0.005", vec![700, 300, 100]),
    ] {
        let mesh = load(spec, &MeshOptions::default()).unwrap();
        for move_m in [[0.0, 0.0, -0.001], [0.001, 0.0, 0.0], [0.0, 0.0, 0.002]] {
            let fine = plate(&mesh, None, move_m);
            let axis = if move_m[0] != 0.0 { 0 } else { 2 };
            print!("{spec} {move_m:?} fine {:.3} N:", fine[axis]);
            for &cells in &cells {
                let c = plate(&mesh, Some(cells), move_m);
                print!(" {cells}: {:.4}", c[axis] / fine[axis]);
            }
            println!();
        }
    }
}

#[test]
fn probe() {
    for (spec, cells) in [
        ("box:21x21x11x0.005", 1000),
        ("box:21x21x11x0.005", 300),
        ("box:21x21x11x0.005", 100),
        ("organ:5762", 2000),
        ("organ:5762", 500),
        ("organ:5762", 200),
        ("organ:20000", 1000),
        ("organ:20000", 200),
        ("plane:31x31x0.01", 100),
    ] {
        let t = std::time::Instant::now();
        let Body { mesh, groups, coarse } = body(spec, cells);
        let t1 = t.elapsed();
        let reps: Vec<[f64; 3]> = groups.node.iter().map(|&n| mesh.nodes_m[n as usize]).collect();
        let carried = carry(&mesh, &groups, &coarse.links);
        let t2 = t.elapsed();
        let neg = carried.weights.iter().filter(|w| w.iter().any(|x| *x < 0.0)).count();
        let big = carried.weights.iter().flatten().fold(0.0f32, |a, x| a.max(x.abs()));
        let kmin = coarse.stiffness_n_per_m.iter().copied().fold(f64::MAX, f64::min);
        let kmax = coarse.stiffness_n_per_m.iter().copied().fold(0.0, f64::max);
        let surf: std::collections::BTreeSet<u32> =
            mesh.triangles.iter().flatten().copied().collect();
        let on = groups.node.iter().filter(|n| surf.contains(n)).count();
        let mut size = vec![0; groups.node.len()];
        for &g in &groups.of {
            size[g as usize] += 1;
        }
        println!(
            "{spec} {cells}: {} cells ({on} surface of {} nodes) {} links, k {kmin:.3}..{kmax:.3}, rough {} neg {neg} big {big:.2}, size {:?}..{:?} t {t1:?} {t2:?}",
            groups.node.len(),
            surf.len(),
            coarse.links.len(),
            carried.rough,
            size.iter().min(),
            size.iter().max()
        );
        let fine_k = vec![20.0; mesh.links.len()];
        for (name, rows) in deformations(0.05) {
            let fine = energy(&mesh.nodes_m, &mesh.links, &fine_k, &rows);
            let c = energy(&reps, &coarse.links, &coarse.stiffness_n_per_m, &rows);
            print!("  {name} {:.4}", c / fine);
        }
        println!();
    }
}
