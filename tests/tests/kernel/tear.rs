//! Tearing: a bar with a notch, pulled apart, tears at the notch, at a load that hardly depends on the mesh.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue as OfTissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{
    Budget, CutRoom, Cutting, Network, Predict, Settings, TearLimit, TickOutput, Tissue, TissueMut,
    ToolPart, ToolPose, TouchStore, cut_words, elastic_room, term_states,
};
use chaincell_tests::bodies::model;

use crate::bench::Bench;
use crate::cut_bar::{end, move_inner_nodes};
use crate::cutting::{centre, faces};

/// Length, width and height of the bar \[m\].
const SIZE_M: [f64; 3] = [0.040, 0.010, 0.020];
/// Height of the notch's front; the notch is open above it, at x = 0 \[m\].
const FRONT_M: f64 = 0.010;
/// Pull in a tick \[m\].
const STEP_M: f32 = 2.0e-5;

/// A bar of this many elements across its width, whose inner nodes are moved by up to a fifth of their distance.
fn mesh(across: usize, seed: u64) -> Mesh {
    let h = SIZE_M[1] / across as f64;
    let nodes = SIZE_M.map(|size| (size / h).round() as usize + 1);
    let spec = format!("box:{}x{}x{}x{h}", nodes[0], nodes[1], nodes[2]);
    let mut mesh = load(&spec, &MeshOptions::default()).unwrap();
    if seed > 0 {
        move_inner_nodes(&mut mesh, h, seed);
    }
    mesh
}

/// The nodes of an end of the bar.
fn end_of(mesh: &Mesh, sign: f64) -> Vec<u32> {
    end(mesh, 0.5 * sign * SIZE_M[0])
}

fn image(mesh: &Mesh, tear_limit: Option<TearLimit>, toughness_j_per_m2: f64) -> ImageBytes {
    let toughness_j_per_m2 = PerCell::Uniform(toughness_j_per_m2);
    image_of(mesh, &end_of(mesh, -1.0), &material(), tear_limit, toughness_j_per_m2)
}

/// Young's modulus of a bar \[Pa\].
const YOUNG_PA: f64 = 5000.0;

/// A body's material.
#[derive(Clone)]
enum Material {
    Tissue(OfTissue),
    /// The links of a bar's tetrahedra, as stiff as tissue.
    Links,
}

fn tissue() -> OfTissue {
    OfTissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(0.3))
}

fn material() -> Material {
    Material::Tissue(tissue())
}

/// Tissue whose links resist ten times as much when they are longer by a tenth.
fn stiffening() -> Material {
    let stiffening = vec!["long:0.1=50000".parse().unwrap()];
    Material::Tissue(OfTissue { stiffening, ..tissue() })
}

/// Stiffness of the links of a bar for which it is as stiff as tissue on the whole: E V = sum of k l^2 / 6.
fn stiffness_n_per_m(mesh: &Mesh) -> f64 {
    let squared = |[a, b]: &[u32; 2]| {
        let [a, b] = [a, b].map(|&node| mesh.nodes_m[node as usize]);
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
    };
    let sum_m2: f64 = mesh.links.iter().map(squared).sum();
    6.0 * YOUNG_PA * SIZE_M.iter().product::<f64>() / sum_m2
}

fn image_of(
    mesh: &Mesh,
    fixed: &[u32],
    material: &Material,
    tear_limit: Option<TearLimit>,
    toughness_j_per_m2: PerCell,
) -> ImageBytes {
    let cuttable =
        Some(Cuttable { spare_share: 1.0, toughness_j_per_m2, tear_limit, ..Cuttable::default() });
    let options =
        BakeOptions { cuttable, coarse_basis: BasisSpacing::Links(2.0), ..BakeOptions::default() };
    let options = match material {
        Material::Tissue(tissue) => BakeOptions { tissue: Some(tissue.clone()), ..options },
        Material::Links => {
            BakeOptions { stiffness_n_per_m: PerCell::Uniform(stiffness_n_per_m(mesh)), ..options }
        }
    };
    bake(mesh, fixed, &options).unwrap()
}

/// A bar whose far end a tool holds.
struct Bar<'a> {
    bench: Bench<'a, Predict>,
    mesh: &'a Mesh,
    /// Ticks of the pull.
    ticks: u32,
}

impl<'a> Bar<'a> {
    fn new(image: &'a ImageBytes, mesh: &'a Mesh, sweeps: u16) -> Self {
        let model = model(image);
        let settings = Settings { sweeps, max_force_n: 100.0, ..Settings::for_model(&model) };
        let network = Network::new(model, settings).unwrap();
        Self { bench: Bench::holding(network, &end_of(mesh, 1.0)), mesh, ticks: 0 }
    }

    fn tick_at(&mut self, pull_m: f32) -> TickOutput {
        self.bench.tick([pull_m, 0.0, 0.0])
    }

    /// Pulls a step further.
    fn pull(&mut self) -> TickOutput {
        self.ticks += 1;
        self.tick_at(STEP_M * self.ticks as f32)
    }

    /// Stands still.
    fn hold(&mut self) -> TickOutput {
        self.tick_at(STEP_M * self.ticks as f32)
    }

    /// Opens the notch, and lets the body come to rest.
    fn notch(&mut self) {
        for [one, other] in faces(self.mesh) {
            let [a, b] = [one.0, other.0].map(|at| centre(self.mesh, at));
            if (a[0] < 0.0) != (b[0] < 0.0) && (a[2] + b[2]) / 2.0 > FRONT_M {
                self.bench.open(one).unwrap();
            }
        }
        for _ in 0..200 {
            self.tick_at(0.0);
        }
        let cuts = self.bench.cuts();
        assert_eq!((cuts.waiting, cuts.refused), (0, 0));
    }

    /// The cells of all tetrahedra.
    fn corners(&mut self) -> Vec<[u16; 4]> {
        let (network, count) = (self.bench.network, self.mesh.tetrahedra.len());
        let mut of = |at, corner| self.bench.view().cell_of_corner(&network, at, corner).unwrap();
        (0..count).map(|at| [0, 1, 2, 3].map(|corner| of(at, corner))).collect()
    }

    /// Rest places of the nodes that have split since the tetrahedra had these cells.
    fn split_places(&mut self, before: &[[u16; 4]]) -> Vec<[f64; 3]> {
        let now = self.corners();
        let nodes =
            before.iter().zip(&now).zip(&self.mesh.tetrahedra).flat_map(|(cells, nodes)| {
                (0..4).filter(move |&k| cells.0[k] != cells.1[k]).map(move |k| nodes[k])
            });
        nodes.map(|node| self.mesh.nodes_m[node as usize]).collect()
    }
}

/// The first tear of a bar.
struct First {
    force_n: f64,
    /// Distance of the torn cell from the line of the notch's front, in mean edges.
    off: f64,
}

/// Pulls a bar of this material until it tears.
fn first(material: &Material, across: usize, seed: u64, limit: TearLimit) -> First {
    let mesh = mesh(across, seed);
    let image = image_of(&mesh, &end_of(&mesh, -1.0), material, Some(limit), PerCell::Uniform(2.0));
    let mut bar = Bar::new(&image, &mesh, 8);
    bar.notch();
    let corners = bar.corners();
    let mut force_n = 0.0;
    while bar.bench.cuts().torn == 0 {
        force_n = f64::from(bar.pull().force_n.x).abs();
        assert!(bar.ticks < 3000, "{limit:?} h {across} seed {seed}: no tear");
    }
    let torn = bar.split_places(&corners);
    let edge_m = f64::from(bar.bench.network.model().unit_m());
    let off = torn.iter().map(|place| place[0].hypot(place[2] - FRONT_M) / edge_m);
    First { force_n, off: off.fold(0.0, f64::max) }
}

/// On regular meshes the load is that of the finest one; on those of moved nodes it scatters. Four of these, ten
/// with `CHAINCELL_SLOW=1`.
#[test]
fn a_notched_bar_tears_at_the_notch_at_a_load_that_hardly_depends_on_the_mesh() {
    hardly_depends_on_the_mesh(&material(), &[TearLimit::Toughness, TearLimit::Stretch(1.3)], 0.1);
}

/// So does one of tissue that stiffens, with the energy of its bands in its load.
#[test]
fn so_does_a_bar_that_stiffens() {
    hardly_depends_on_the_mesh(&stiffening(), &[TearLimit::Toughness], 0.1);
}

/// And one of links. These are stiffer at the surface than inside, the more the coarser the mesh, so that at a stretch
/// the load depends on it a little more.
#[test]
fn so_does_a_bar_of_links() {
    hardly_depends_on_the_mesh(&Material::Links, &[TearLimit::Toughness], 0.1);
    let [links_n, tissue_n] = [Material::Links, material()]
        .map(|material| first(&material, 4, 0, TearLimit::Toughness).force_n);
    assert!((links_n / tissue_n - 1.0).abs() < 0.15, "{links_n} {tissue_n}");
    hardly_depends_on_the_mesh(&Material::Links, &[TearLimit::Stretch(1.15)], 0.12);
}

fn hardly_depends_on_the_mesh(material: &Material, limits: &[TearLimit], within: f64) {
    let seeds: u64 = if std::env::var_os("CHAINCELL_SLOW").is_some() { 10 } else { 4 };
    for &limit in limits {
        let (mut regular, mut means, mut at_front) = (Vec::new(), Vec::new(), 0);
        for across in [2, 3, 4] {
            let all: Vec<First> =
                (0..=seeds).map(|seed| first(material, across, seed, limit)).collect();
            let forces: Vec<f64> = all[1..].iter().map(|first| first.force_n).collect();
            let mean = forces.iter().sum::<f64>() / seeds as f64;
            let scatter = forces.iter().map(|x| (x / mean - 1.0).powi(2)).sum::<f64>();
            let scatter = (scatter / seeds as f64).sqrt();
            let count = all[1..].iter().filter(|first| first.off < 1.0).count();
            println!(
                "{limit:?}, {:.2} mm between nodes: {:.4} N, nodes moved {mean:.4} N +- {:.1} %, at the front \
                 in {count} of {seeds}, farthest {:.2} edges",
                1e3 * SIZE_M[1] / across as f64,
                all[0].force_n,
                100.0 * scatter,
                all.iter().map(|first| first.off).fold(0.0, f64::max)
            );
            assert!(all[0].off < 0.5, "{limit:?} {across}: {}", all[0].off);
            regular.push(all[0].force_n);
            means.push(mean);
            at_front += count;
        }
        for (regular_n, mean_n) in regular.iter().zip(&means) {
            let ratios = [regular_n / regular[2], mean_n / means[2]];
            println!(
                "{limit:?}: {:.3} of the finest mesh, nodes moved {:.3}",
                ratios[0], ratios[1]
            );
            assert!((ratios[0] - 1.0).abs() < within, "{limit:?}: {ratios:?}");
        }
        let of = 3 * seeds as usize;
        assert!(10 * at_front >= 9 * of, "{limit:?}: {at_front} of {of}");
    }
}

/// With cutting off nothing tears; with it on again the same bar does.
#[test]
fn with_cutting_off_nothing_tears() {
    let mesh = mesh(3, 1);
    let image = image(&mesh, Some(TearLimit::Stretch(1.3)), 2.0);
    let mut bar = Bar::new(&image, &mesh, 4);
    bar.notch();
    let (on, cuts) = (bar.bench.network, bar.bench.cuts());
    let settings = Settings { cut: Cutting::Off, ..*on.settings() };
    bar.bench.network = Network::new(bar.bench.model(), settings).unwrap();
    (0..600).for_each(|_| assert!(bar.pull().force_n.x.is_finite()));
    assert_eq!((bar.bench.cuts().torn, bar.bench.cuts().opened_faces), (0, cuts.opened_faces));
    bar.bench.network = on;
    (0..40).for_each(|_| assert!(bar.hold().force_n.x.is_finite()));
    assert!(bar.bench.cuts().torn > 0, "{:?}", bar.bench.cuts());
}

/// The crack runs through the bar; the body never has more energy than the tool gave it.
#[test]
fn a_crack_runs_on_from_the_notch_and_gains_no_energy() {
    for (material, limit) in [
        (material(), TearLimit::Toughness),
        (material(), TearLimit::Stretch(1.3)),
        (stiffening(), TearLimit::Toughness),
        (Material::Links, TearLimit::Toughness),
        (Material::Links, TearLimit::Stretch(1.3)),
    ] {
        let mesh = mesh(3, 1);
        let image =
            image_of(&mesh, &end_of(&mesh, -1.0), &material, Some(limit), PerCell::Uniform(2.0));
        let mut bar = Bar::new(&image, &mesh, 4);
        bar.notch();
        let corners = bar.corners();
        let (mut work_j, mut most_n, mut last, mut worst) = (0.0, 0.0_f64, 0.0, f64::MIN);
        for _ in 0..1200 {
            let output = if bar.ticks < 800 { bar.pull() } else { bar.hold() };
            last = f64::from(output.force_n.x).abs();
            most_n = most_n.max(last);
            work_j += f64::from(output.work_j);
            worst = worst.max(f64::from(output.energy_j) - work_j);
        }
        let lowest_m =
            bar.split_places(&corners).iter().map(|place| place[2]).fold(FRONT_M, f64::min);
        println!(
            "{limit:?}: most {most_n:.4} N, at the end {last:.4} N, crack down to {:.1} mm, {:?}, work {work_j:.3e} \
             J, level above it at most {worst:.1e}",
            1e3 * lowest_m,
            bar.bench.cuts()
        );
        assert!(lowest_m < 1e-6, "{limit:?}: {lowest_m}");
        assert!(last < 0.1 * most_n, "{limit:?}: {last} of {most_n}");
        assert!(worst < 1e-6 * work_j, "{limit:?}: {worst} {work_j}");
    }
}

/// A torn body whose tool stands still comes to the force of one that is cut at the same faces.
#[test]
fn a_torn_body_at_rest_is_the_one_cut_at_the_same_faces() {
    let mesh = mesh(3, 1);
    let torn = image(&mesh, Some(TearLimit::Stretch(1.3)), 2.0);
    let mut bar = Bar::new(&torn, &mesh, 4);
    bar.notch();
    while bar.bench.cuts().torn < 4 {
        bar.pull();
    }
    // Half of the pull tears no further.
    bar.ticks /= 2;
    let mut output = TickOutput::NONE;
    for _ in 0..4000 {
        output = bar.hold();
    }
    let corners = bar.corners();
    // Open the faces whose corners have other cells on the other side, in a body that does not tear.
    let cut = image(&mesh, None, 2.0);
    let mut other = Bar::new(&cut, &mesh, 4);
    let network = other.bench.network;
    for [one, there] in faces(&mesh) {
        let names = |at: usize| mesh.tetrahedra[at].into_iter().zip(corners[at]);
        let mut here = names(one.0);
        if here.any(|(node, cell)| names(there.0).any(|(same, name)| node == same && cell != name))
        {
            other.bench.view().open_face(&network, one.0, one.1).unwrap();
        }
    }
    for _ in 0..200 {
        other.tick_at(0.0);
    }
    other.ticks = bar.ticks;
    let mut expected = TickOutput::NONE;
    for _ in 0..4000 {
        expected = other.hold();
    }
    let (force_n, expected_n) = (output.force_n.x, expected.force_n.x);
    println!(
        "torn {force_n} N, cut {expected_n} N; level {} J, {} J; {:?} {:?}",
        output.energy_j,
        expected.energy_j,
        bar.bench.cuts(),
        other.bench.cuts()
    );
    assert_eq!(bar.bench.cuts().copies, other.bench.cuts().copies);
    assert!(force_n.abs() > 0.01 && (force_n / expected_n - 1.0).abs() < 0.01);
    assert!(output.energy_j > 0.999 * expected.energy_j);
}

#[test]
fn a_restored_tear_goes_on_with_the_same_bits() {
    [material(), stiffening(), Material::Links].iter().for_each(goes_on_when_restored);
}

fn goes_on_when_restored(material: &Material) {
    let mesh = mesh(3, 2);
    let image = image_of(
        &mesh,
        &end_of(&mesh, -1.0),
        material,
        Some(TearLimit::Toughness),
        PerCell::Uniform(2.0),
    );
    let mut bar = Bar::new(&image, &mesh, 2);
    bar.notch();
    while bar.bench.cuts().torn < 3 {
        bar.pull();
    }
    let (network, ticks) = (bar.bench.network, bar.ticks);
    let mut bytes = vec![0; bar.bench.view().snapshot_bytes(&network).unwrap()];
    bar.bench.view().save(&network, &mut bytes).unwrap();
    let go_on = |bar: &mut Bar<'_>| {
        bar.ticks = ticks;
        let run = |bar: &mut Bar<'_>| (bar.pull().force_n.x.to_bits(), bar.bench.hash());
        (0..200).map(|_| run(bar)).collect::<Vec<_>>()
    };
    let expected = go_on(&mut bar);
    assert!(bar.bench.cuts().torn > 5, "{:?}", bar.bench.cuts());
    let mut other = Bar::new(&image, &mesh, 2);
    other.bench.view().restore(&network, &bytes).unwrap();
    assert_eq!(go_on(&mut other), expected);
}

/// A bar without a notch tears first on the side where its cells are weak.
#[test]
fn a_tear_begins_in_the_weak_group() {
    let mesh = mesh(2, 0);
    for side in [-1.0, 1.0] {
        let is_weak = |place: &[f64; 3]| (0.0049..0.0151).contains(&(side * place[0]));
        let toughness = |place| if is_weak(place) { 2.0 } else { 8.0 };
        let toughness = PerCell::Each(mesh.nodes_m.iter().map(toughness).collect());
        let limit = Some(TearLimit::Toughness);
        let image = image_of(&mesh, &end_of(&mesh, -1.0), &material(), limit, toughness);
        let mut bar = Bar::new(&image, &mesh, 8);
        let corners = bar.corners();
        while bar.bench.cuts().torn == 0 {
            bar.pull();
            assert!(bar.ticks < 1000, "{side}: no tear");
        }
        let torn = bar.split_places(&corners);
        println!("{side}: {} ticks, {torn:?}", bar.ticks);
        assert!(!torn.is_empty() && torn.iter().all(is_weak), "{side}: {torn:?}");
    }
}

/// Below the limit the body has the bits of one that does not tear.
#[test]
fn below_the_limit_nothing_changes() {
    let mesh = mesh(2, 1);
    let plain = image(&mesh, None, 2.0);
    for limit in [TearLimit::Toughness, TearLimit::Stretch(10.0)] {
        let image = image(&mesh, Some(limit), 1e5);
        let mut bars = [Bar::new(&plain, &mesh, 2), Bar::new(&image, &mesh, 2)];
        for _ in 0..300 {
            let [one, other] = bars.each_mut().map(|bar| (bar.pull(), bar.bench.hash()));
            assert_eq!(one, other, "{limit:?}");
        }
        assert_eq!(bars[1].bench.cuts().torn, 0);
    }
}

/// A body tears neither in late ticks nor after the tool has let go.
#[test]
fn nothing_tears_in_late_ticks_or_without_a_tool() {
    let mesh = mesh(2, 1);
    let image = image(&mesh, Some(TearLimit::Stretch(1.3)), 2.0);
    let mut bar = Bar::new(&image, &mesh, 2);
    bar.notch();
    let network = bar.bench.network;
    let tick = |bar: &mut Bar<'_>, pull_m: f32, engaged: u32, budget: Budget<'_>| {
        let pose = ToolPose::at([pull_m, 0.0, 0.0].into(), engaged);
        bar.bench.view().tick(&network, &[pose], budget)
    };
    for step in 0..800 {
        tick(&mut bar, STEP_M * step as f32, 1, Budget::LATE);
    }
    assert_eq!(bar.bench.cuts().torn, 0);
    // The tick in which the tool lets go still sees the body that it held.
    tick(&mut bar, 0.016, 0, Budget::All);
    let torn = bar.bench.cuts().torn;
    for _ in 0..20 {
        tick(&mut bar, 0.016, 0, Budget::All);
    }
    assert_eq!(bar.bench.cuts().torn, torn);
}

/// A ball that grips the top of a block and is drawn away tears it.
#[test]
fn a_grip_tears_what_it_pulls_at() {
    const CELLS: usize = 490;
    type Scheme = Predict<{ elastic_room(160) }>;
    let mesh = load("box:7x7x5x0.005", &MeshOptions::default()).unwrap();
    let limit = Some(TearLimit::Stretch(1.5));
    let image = image_of(&mesh, &mesh.default_fixed, &material(), limit, PerCell::Uniform(2.0));
    let model = model(&image);
    let settings = Settings { sweeps: 4, max_force_n: 100.0, ..Settings::for_model(&model) };
    let network = Network::new(model, settings).unwrap();
    let mut tissue: Box<Tissue<CELLS, Scheme, 4, { term_states(CELLS) }>> = Box::default();
    let mut touch: Box<TouchStore<CELLS, 256, 256>> = Box::default();
    let mut words = vec![0; cut_words(&model)];
    let mut run = |run: &mut dyn FnMut(&mut TissueMut<'_, Scheme>)| {
        let cut = CutRoom::new(&mut words);
        run(&mut TissueMut { cut, ..tissue.touching(touch.room()) });
    };
    run(&mut |view| {
        view.reset(&network).unwrap();
        view.choose_tools(&network, &[&[ToolPart::sphere(0.006)]], 0.5).unwrap();
    });
    let at = |height_m: f32| [ToolPose::at([0.0, 0.0, height_m].into(), 1)];
    // Press, grip, and draw away.
    for step in 0..100 {
        run(&mut |view| {
            view.tick(&network, &at(0.027 - 4e-5 * step as f32), Budget::All);
        });
    }
    run(&mut |view| assert!(view.grip(&network, 0) > 0));
    let (mut torn, mut held, mut last) = (0, 0, TickOutput::NONE);
    let (mut most_n, mut drag_n) = (0.0_f32, 0.0_f32);
    // The ball carries the piece away and stands still.
    for step in 0..720_u16 {
        let way_m = 5e-5 * f32::from(step.min(600));
        run(&mut |view| {
            last = view.tick(&network, &at(0.023 + way_m), Budget::All);
            drag_n = if step == 600 { -last.force_n.z } else { drag_n };
            most_n = most_n.max(-last.force_n.z);
            (torn, held) = (view.cut_output(&network).torn, view.gripped(&network, 0));
        });
    }
    println!(
        "{torn} torn, most {most_n} N, {drag_n} N as it is carried, at the end {} N and {} J",
        last.force_n.z, last.energy_j
    );
    assert!(held > 0 && last.force_n.z.abs() < 0.01 * most_n, "{held} {}", last.force_n);
    assert!(torn > 0);
}
