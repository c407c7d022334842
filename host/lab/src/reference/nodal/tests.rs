use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::*;
use crate::reference::minimum;
use crate::reference::vectors::{fields, size};
use chaincell_host::bake::tissue::shape::element;
use chaincell_host::mesh::{Mesh, MeshOptions, load};

const POISSON: f64 = 0.4;

fn laws() -> [Law; 2] {
    [false, true].map(|band| Law { young_pa: 5000.0, poisson: POISSON, band })
}

/// A field with coordinates up to `size_m`.
fn random(nodes: usize, size_m: f64, seed: u64) -> Vec<[f64; 3]> {
    let mut source = Pcg64::seed_from_u64(seed);
    let coordinate = Uniform::new(-size_m, size_m).unwrap();
    (0..nodes).map(|_| std::array::from_fn(|_| coordinate.sample(&mut source))).collect()
}

/// A box of 4 x 3 x 3 nodes about 10 mm apart, every node shaken, so that no symmetry hides an
/// error.
pub(super) fn shaken() -> Mesh {
    let mut mesh = load("box:4x3x3x0.01", &MeshOptions::default()).unwrap();
    mesh.nodes_m = fields(&mesh.nodes_m, 1.0, &random(36, 0.0015, 1));
    mesh
}

pub(super) fn body(mesh: &Mesh, law: Law) -> Nodal {
    Nodal::new(&mesh.nodes_m, &mesh.tetrahedra, &mesh.default_fixed, law).unwrap()
}

fn moved(mesh: &Mesh, by: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
    mesh.nodes_m.iter().map(|x| by(*x)).collect()
}

/// Bent a little, pressed flat, turned inside out, scattered.
fn states(mesh: &Mesh) -> Vec<Vec<[f64; 3]>> {
    let nodes = mesh.nodes_m.len();
    let near = |by: fn([f64; 3]) -> [f64; 3], shake_m: f64, seed| {
        fields(&moved(mesh, by), 1.0, &random(nodes, shake_m, seed))
    };
    vec![
        near(|x| x, 0.001, 2),
        near(|[x, y, z]| [1.1 * x, y, 0.3 * z], 0.001, 3),
        near(|[x, y, z]| [x, 0.9 * y, -0.8 * z], 0.001, 4),
        near(|x| x, 0.03, 5),
    ]
}

fn residual(body: &Nodal, at: &[[f64; 3]]) -> (f64, Vec<[f64; 3]>) {
    let mut residual = vec![[0.0; 3]; at.len()];
    let energy = body.residual(at, &mut residual);
    (energy, residual)
}

fn inner(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum()
}

#[test]
fn the_residual_is_minus_the_gradient_and_the_curvature_its_slope() {
    let mesh = shaken();
    let inverted =
        |body: &Nodal, at: &[[f64; 3]]| body.stretches(at).iter().filter(|s| s[2] < 0.0).count();
    for law in laws() {
        let body = body(&mesh, law);
        let mut turned = 0;
        for (number, at) in states(&mesh).iter().enumerate() {
            turned += inverted(&body, at);
            let (_, here) = residual(&body, at);
            let curvature = body.curvature(at, &[]);
            for seed in 0..8 {
                let way = random(at.len(), 1.0, 100 + seed);
                let step = 1e-8;
                let [(e_plus, r_plus), (e_minus, r_minus)] =
                    [step, -step].map(|by| residual(&body, &fields(at, by, &way)));
                let slope = (e_minus - e_plus) / (2.0 * step);
                let exact = inner(&here, &way);
                let scale = size(&here) * size(&way);
                assert!((slope - exact).abs() < 1e-7 * scale, "{law:?} {number}: {slope} {exact}");
                let mut product = vec![[0.0; 3]; at.len()];
                body.times(&curvature, &way, &mut product);
                let change = fields(&r_minus, -1.0, &r_plus);
                let off = fields(&change, -2.0 * step, &product);
                assert!(
                    size(&off) < 1e-5 * size(&change),
                    "{law:?} {number}: {:e}",
                    size(&off) / size(&change)
                );
            }
        }
        assert!(turned > 36, "{turned}");
    }
}

#[test]
fn rest_is_exactly_zero() {
    let mesh = shaken();
    for law in laws() {
        let (energy, residual) = residual(&body(&mesh, law), &mesh.nodes_m);
        assert_eq!(energy, 0.0);
        assert!(residual.as_flattened().iter().all(|x| *x == 0.0), "{law:?}");
    }
}

#[test]
fn a_rigid_motion_has_no_energy() {
    let mesh = shaken();
    for angle in [0.1, 1.5, 3.1] {
        let turn = nalgebra::Rotation3::new(Vector3::new(0.5, -0.7, 0.4).normalize() * angle);
        let at = moved(&mesh, |x| {
            let [x, y, z]: [f64; 3] = (turn * Vector3::from(x)).into();
            [x + 0.3, y - 0.2, z + 0.1]
        });
        for law in laws() {
            let body = body(&mesh, law);
            let (energy, residual) = residual(&body, &at);
            let unit_n = body.force_n();
            assert!(energy.abs() < 1e-12 * unit_n * body.length_unit(), "{law:?}: {energy:e} J");
            assert!(size(&residual) < 1e-11 * unit_n, "{law:?}: {:e} N", size(&residual));
        }
    }
}

/// Under a uniform strain every node has exactly that gradient, and inside nothing pulls; so with
/// the surface held the body takes on the strain.
#[test]
fn a_uniform_strain_is_exact() {
    let mesh = shaken();
    let strain = Matrix3::new(0.06, 0.02, -0.03, 0.01, -0.2, 0.04, 0.02, 0.05, -0.4);
    let at = moved(&mesh, |x| {
        let u: [f64; 3] = (strain * Vector3::from(x)).into();
        plus(x, 1.0, u)
    });
    let surface: Vec<usize> = mesh.triangles.as_flattened().iter().map(|i| *i as usize).collect();
    let held: Vec<_> = surface.iter().map(|&i| (i, at[i])).collect();
    for law in laws() {
        let body = body(&mesh, law);
        let u = body.displacements(&at);
        for i in 0..u.len() {
            let off = (body.shape.slope(&u, i) - strain).norm();
            assert!(off < 1e-14, "node {i}: {off:e}");
        }
        let (_, residual) = residual(&body, &at);
        let inside: Vec<usize> = (0..u.len()).filter(|i| !surface.contains(i)).collect();
        assert_eq!(inside.len(), 2);
        for &i in &inside {
            assert!(norm(residual[i]) < 1e-13 * body.force_n(), "node {i}: {:?}", residual[i]);
        }
        let found = minimum(&body, &held, &mesh.nodes_m, 1e-12 * body.force_n());
        for &i in &inside {
            let off_m = norm(minus(found.positions[i], at[i]));
            assert!(off_m < 1e-12, "{law:?}, node {i}: {off_m:e} m");
        }
    }
}

/// A pattern that changes sign from node to node cancels in the mean gradients; the spread keeps it
/// from going free.
#[test]
fn no_pattern_goes_free() {
    let mesh = load("box:5x5x5x0.01", &MeshOptions::default()).unwrap();
    let parity = |[x, y, z]: [f64; 3]| ((x + y + z) / 0.01).round() as i64 & 1;
    let checkered: Vec<[f64; 3]> =
        mesh.nodes_m.iter().map(|x| [1e-8 * (1 - 2 * parity(*x)) as f64, 0.0, 0.0]).collect();
    let fields_m = (0..20).map(|seed| random(mesh.nodes_m.len(), 1e-8, 300 + seed));
    for law in laws() {
        let body = body(&mesh, Law { poisson: 0.0, ..law });
        for d in fields_m.clone().chain([checkered.clone()]) {
            let tetrahedron = |nodes: &[u32; 4]| {
                let (volume, slope) = gradient(&mesh, nodes, &d);
                volume * (0.5 * (slope + slope.transpose())).norm_squared()
            };
            let linear =
                mesh.tetrahedra.iter().map(tetrahedron).sum::<f64>() * body.moduli[0].mu_pa;
            let (energy, _) = residual(&body, &fields(&mesh.nodes_m, 1.0, &d));
            let share = energy / linear;
            assert!(share > 0.2 / 1.2 - 1e-5, "{law:?}: {share}");
        }
    }
}

/// Volume and gradient of a field in a tetrahedron.
fn gradient(mesh: &Mesh, nodes: &[u32; 4], d: &[[f64; 3]]) -> (f64, Matrix3<f64>) {
    let (volume, gradients) = element(&mesh.nodes_m, *nodes).unwrap();
    let mut slope = Matrix3::zeros();
    for (&i, g) in nodes.iter().zip(gradients) {
        slope += Vector3::from(d[i as usize]) * Vector3::from(g).transpose();
    }
    (volume, slope)
}

/// d'L d for L = 2 mu ((1 - beta) Ln + beta Lc) + 3 lambda Ln, with a band 8 mu Ln more.
fn bound(body: &Nodal, mesh: &Mesh, d: &[[f64; 3]]) -> f64 {
    let (mu, lambda) = (body.moduli[0].mu_pa, body.moduli[0].lambda_pa);
    let band = if body.moduli[0].band { 8.0 * mu } else { 0.0 };
    let nodal = 2.0 * mu * (1.0 - SPREAD) + 3.0 * lambda + band;
    let node = |i: usize| body.shape.volume_m3(i) * body.shape.slope(d, i).norm_squared();
    let tetrahedron = |nodes: &[u32; 4]| {
        let (volume, slope) = gradient(mesh, nodes, d);
        volume * slope.norm_squared()
    };
    let nodes = nodal * (0..d.len()).map(node).sum::<f64>();
    nodes + 2.0 * mu * SPREAD * mesh.tetrahedra.iter().map(tetrahedron).sum::<f64>()
}

/// The energy is never above a parabola with that second derivative, from any state and however
/// far; without a band a small swelling of the body at rest reaches it.
#[test]
fn a_constant_laplacian_bounds_the_curvature() {
    let mesh = shaken();
    for law in laws() {
        let body = body(&mesh, law);
        let share = |at: &[[f64; 3]], d: &[[f64; 3]]| {
            let (before, force) = residual(&body, at);
            let (after, _) = residual(&body, &fields(at, 1.0, d));
            2.0 * (after - before + inner(&force, d)) / bound(&body, &mesh, d)
        };
        for at in states(&mesh) {
            let curvature = body.curvature(&at, &[]);
            for seed in 0..40 {
                let size_m = [1e-5, 1e-3, 0.01, 0.1][seed as usize % 4];
                let d = random(at.len(), size_m, 200 + seed);
                let far = share(&at, &d);
                assert!(far < 1.0 + 1e-9, "{law:?}, {size_m} m: {far}");
                let mut product = vec![[0.0; 3]; at.len()];
                body.times(&curvature, &d, &mut product);
                let near = inner(&d, &product) / bound(&body, &mesh, &d);
                assert!(near < 1.0 + 1e-12, "{law:?}: {near}");
            }
        }
        let swelling = moved(&mesh, |x| x.map(|x| 1e-6 * x));
        let reached = share(&mesh.nodes_m, &swelling);
        let least = if law.band { 0.5 } else { 1.0 - 1e-5 };
        assert!((least..1.0 + 1e-6).contains(&reached), "{law:?}: {reached}");
    }
}

/// What a box of 0.1 x 0.1 x 0.05 m, 5 kPa, gives under a square of 25 mm pressed by 1 mm and held
/// on all sides, by quadratic elements of linear elasticity on the same tetrahedra (scikit-fem
/// 12.0): force \[N\], displacement \[mm\] of a node below the square, one beside its edge and
/// one deep beside it. Linear elements give 1.27 and 1.38 times the force.
struct Quadratic {
    poisson: f64,
    force_n: f64,
    nodes: [(usize, [f64; 3]); 3],
}

const QUADRATIC: [Quadratic; 2] = [
    Quadratic {
        poisson: 0.3,
        force_n: 0.238_678_4,
        nodes: [
            (202, [0.0, 0.0, -0.353_601]),
            (294, [-0.064_698, 0.0, -0.289_834]),
            (337, [0.101_533, 0.0, -0.087_455]),
        ],
    },
    Quadratic {
        poisson: 0.45,
        force_n: 0.274_829_9,
        nodes: [
            (202, [0.0, 0.0, -0.382_215]),
            (294, [0.014_779, 0.0, -0.272_285]),
            (337, [0.174_981, 0.0, -0.069_899]),
        ],
    },
];

#[test]
fn a_pressed_box_is_near_quadratic_elements() {
    let mesh = load("box:9x9x5x0.0125", &MeshOptions::default()).unwrap();
    let pressed = |x: [f64; 3]| x[2] > 0.0499 && x[0].abs() < 0.0126 && x[1].abs() < 0.0126;
    let nodes = 0..mesh.nodes_m.len();
    let pressed: Vec<usize> = nodes.filter(|i| pressed(mesh.nodes_m[*i])).collect();
    assert_eq!(pressed.len(), 9);
    let down = |&i: &usize| (i, plus(mesh.nodes_m[i], -0.001, [0.0, 0.0, 1.0]));
    let held: Vec<_> = pressed.iter().map(down).collect();
    for (law, exact) in laws().into_iter().flat_map(|law| QUADRATIC.map(|exact| (law, exact))) {
        let body = body(&mesh, Law { poisson: exact.poisson, ..law });
        let found = minimum(&body, &held, &mesh.nodes_m, 1e-10 * body.force_n());
        let force = body.force(&found.positions, &pressed)[2] / exact.force_n;
        assert!((force - 1.0).abs() < 0.03, "{law:?}: force {force} of the elements'");
        for ((node, u_mm), off_mm) in exact.nodes.into_iter().zip([0.005, 0.11, 0.02]) {
            let u = minus(found.positions[node], mesh.nodes_m[node]).map(|u| 1e3 * u);
            let off = norm(minus(u, u_mm));
            assert!(off < off_mm, "{law:?}, node {node}: {u:?} instead of {u_mm:?} mm");
        }
    }
}
