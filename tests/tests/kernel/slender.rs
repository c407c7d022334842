//! Slender bodies and nearly incompressible ones, held by a whole face: the force is that of the
//! equilibrium soon after a move, and the coarse level is no worse than none.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Choice, Flags, Model, Network, ToolPose};
use nalgebra::Vector3;

/// Between two nodes of a bar \[m\].
const APART_M: f64 = 0.005;
const YOUNG_PA: f64 = 5000.0;
/// Ticks of a move, and of the rest behind it.
const MOVES: usize = 60;
const RESTS: usize = 60;
/// From here on the force is to be that of the equilibrium.
const SETTLED: usize = MOVES + 10;

/// A bar of given numbers of nodes along it and across, fixed at one end and held at the other.
struct Bar {
    image: ImageBytes,
    held: Vec<u32>,
    length_m: f64,
    width_m: f64,
}

impl Bar {
    fn new([along, across]: [usize; 2], poisson: f64, coarse_basis: BasisSpacing) -> Self {
        let spec = format!("box:{along}x{across}x{across}x{APART_M}");
        let mesh = load(&spec, &MeshOptions::default()).unwrap();
        let [length_m, width_m] = [along, across].map(|nodes| (nodes - 1) as f64 * APART_M);
        let at_end = |side: f64| -> Vec<u32> {
            let near = |x: &[f64; 3]| (x[0] - side * 0.5 * length_m).abs() < 1e-6;
            (0..).zip(&mesh.nodes_m).filter(|(_, x)| near(x)).map(|(node, _)| node).collect()
        };
        let tissue = Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(poisson));
        let options = BakeOptions { tissue: Some(tissue), coarse_basis, ..BakeOptions::default() };
        let image = bake(&mesh, &at_end(-1.0), &options).unwrap();
        Self { image, held: at_end(1.0), length_m, width_m }
    }

    /// The forces of a move by `way_m` and of the rest behind it, and how many ticks had a pass that
    /// was discarded.
    fn forces(&self, scheme: Scheme, sweeps: u16, way_m: [f64; 3]) -> (Vec<Vector3<f64>>, usize) {
        let model = Model::from_bytes(self.image.as_bytes()).unwrap();
        let mut held: Vec<u16> =
            self.held.iter().map(|&node| model.cell_of_input(node).unwrap()).collect();
        held.sort_unstable();
        let network = Network::new(model, scheme.settings(&model, sweeps)).unwrap();
        let mut engine = Engine::new(network, scheme, &held).unwrap();
        let mut discarded = 0;
        let forces = (0..MOVES + RESTS).map(|tick| {
            let share = tick.min(MOVES) as f64 / MOVES as f64;
            let position_m = Vector3::from(way_m.map(|x| (share * x) as f32));
            let output = engine.tick(&ToolPose::at(position_m, 1));
            discarded += usize::from(output.flags.contains(Flags::ROLLED_BACK));
            output.force_n.map(f64::from)
        });
        (forces.collect(), discarded)
    }

    /// Where the body comes to rest with many sweeps \[N\]: the middle one of the last forces.
    fn settled_n(&self, way_m: [f64; 3]) -> f64 {
        let (forces, _) = self.forces(Scheme::Predict, 40, way_m);
        let mut last: Vec<f64> = forces[SETTLED..].iter().map(|force| force.norm()).collect();
        last.sort_by(f64::total_cmp);
        last[last.len() / 2]
    }
}

/// The largest distance from a settled force once the move is over, and the largest force.
fn worst(forces: &[Vector3<f64>], settled_n: f64) -> [f64; 2] {
    let off = forces[SETTLED..].iter().map(|force| (force.norm() / settled_n - 1.0).abs());
    let most = forces.iter().map(|force| force.norm() / settled_n);
    [off.fold(0.0, f64::max), most.fold(0.0, f64::max)]
}

/// Pulled by 2 % of its length a bar resists with E A eps, and a little more at ends that cannot
/// narrow: at any ratio of length to width, and near to no change of volume.
#[test]
fn a_pulled_bar_resists_as_its_equilibrium_does() {
    let bars = [[9, 9], [21, 5], [21, 3], [61, 3], [31, 2]];
    for (size, poisson) in bars
        .into_iter()
        .flat_map(|size| [0.45, 0.495].map(|poisson| (size, poisson)))
        .chain([([21, 5], 0.3), ([21, 5], 0.48), ([61, 3], 0.48)])
    {
        let bar = Bar::new(size, poisson, BasisSpacing::BySize);
        let way_m = [0.02 * bar.length_m, 0.0, 0.0];
        let hookes_n = YOUNG_PA * bar.width_m * bar.width_m * 0.02;
        let settled_n = bar.settled_n(way_m);
        let stout = if size[0] == size[1] { 1.35 } else { 1.1 };
        let is_hookes = settled_n > 0.97 * hookes_n && settled_n < stout * hookes_n;
        assert!(is_hookes, "{size:?}, {poisson}: {settled_n} N, E A eps {hookes_n} N");
        let (forces, discarded) = bar.forces(Scheme::Predict, 4, way_m);
        let [off, most] = worst(&forces, settled_n);
        assert!(off < 0.05 && most < 1.1, "{size:?}, {poisson}: off by {off}, most {most}");
        assert!(discarded < 10, "{size:?}, {poisson}: {discarded} ticks");
    }
}

/// Bent by a tenth of its length.
#[test]
fn a_bent_bar_resists_as_its_equilibrium_does() {
    for (size, poisson, sure) in
        [([21, 5], 0.45, 0.05), ([21, 5], 0.495, 0.05), ([41, 3], 0.45, 0.05), ([41, 3], 0.48, 0.1)]
    {
        let bar = Bar::new(size, poisson, BasisSpacing::BySize);
        let way_m = [0.0, 0.0, 0.1 * bar.length_m];
        let (forces, _) = bar.forces(Scheme::Predict, 4, way_m);
        let [off, most] = worst(&forces, bar.settled_n(way_m));
        assert!(off < sure && most < 1.2, "{size:?}, {poisson}: off by {off}, most {most}");
    }
}

/// With the coarse level the force is never farther off than without, but for 5 %.
#[test]
fn a_coarse_level_is_no_worse_than_none() {
    for (size, poisson, scheme) in [
        ([9, 9], 0.495, Scheme::Predict),
        ([9, 9], 0.495, Scheme::Track),
        ([21, 5], 0.48, Scheme::Track),
        ([31, 3], 0.495, Scheme::Track),
        ([31, 3], 0.495, Scheme::Predict),
    ] {
        let with = Bar::new(size, poisson, BasisSpacing::BySize);
        let without = Bar::new(size, poisson, BasisSpacing::None);
        for way in [[0.02, 0.0, 0.0], [0.0, 0.0, 0.05]] {
            let way_m = way.map(|x| x * with.length_m);
            let settled_n = with.settled_n(way_m);
            let [with, without] =
                [&with, &without].map(|bar| worst(&bar.forces(scheme, 4, way_m).0, settled_n));
            for (with, without) in with.into_iter().zip(without) {
                let name = scheme.name();
                assert!(
                    with < without + 0.05,
                    "{size:?}, {poisson}, {name}, {way:?}: {with} instead of {without}"
                );
            }
        }
    }
}
