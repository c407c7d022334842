//! Cutting: cells split where faces between tetrahedra open, and the body is then the one that its pieces make.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::ops::Range;

use chaincell_host::bake::tissue::{Band, Tissue as Material};
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::snapshot::SnapshotError;
use chaincell_kernel::{
    CutError, CutOutput, Dynamics, Head, Network, Predict, Settings, TickOutput, Track,
};
use chaincell_tests::bodies::model;

use crate::bench::Bench;
use crate::snapshot::check;

/// A bar of tissue on a fixed ground.
const BAR: &str = "box:7x5x4x0.006";

fn options(spare_share: Option<f64>, coarse_basis: BasisSpacing) -> BakeOptions {
    let cuttable = spare_share.map(|spare_share| Cuttable { spare_share, ..Cuttable::default() });
    let tissue = Some(Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3)));
    BakeOptions { tissue, cuttable, coarse_basis, ..BakeOptions::default() }
}

fn mesh() -> Mesh {
    load(BAR, &MeshOptions::default()).unwrap()
}

fn image(mesh: &Mesh, spare_share: Option<f64>) -> ImageBytes {
    let options = options(spare_share, BasisSpacing::Links(2.0));
    bake(mesh, &mesh.default_fixed, &options).unwrap()
}

/// The body of shapes that stiffen when they are strained.
fn banded(mesh: &Mesh, spare_share: Option<f64>) -> ImageBytes {
    let mut options = options(spare_share, BasisSpacing::Links(2.0));
    options.tissue.as_mut().unwrap().stiffening = stiffening();
    bake(mesh, &mesh.default_fixed, &options).unwrap()
}

/// Bands far stiffer than the tissue, one of them on one side.
pub fn stiffening() -> Vec<Band> {
    ["0.02=10000", "long:0.1=20000"].map(|band| band.parse().unwrap()).to_vec()
}

/// The body made of links with bands in place of shapes.
fn linked(mesh: &Mesh) -> ImageBytes {
    let (tissue, alpha) = (None, PerCell::Uniform(0.02));
    let shapes = options(Some(0.5), BasisSpacing::Links(2.0));
    bake(mesh, &mesh.default_fixed, &BakeOptions { tissue, alpha, ..shapes }).unwrap()
}

/// The body of shapes, that with stiffening bands, and that of links.
fn all() -> [ImageBytes; 3] {
    let mesh = mesh();
    [image(&mesh, Some(0.5)), banded(&mesh, Some(0.5)), linked(&mesh)]
}

pub fn network<'a>(image: &'a ImageBytes, sweeps: u16) -> Network<'a> {
    let model = model(image);
    let settings = Settings { sweeps, ..Settings::for_model(&model) };
    Network::new(model, settings).unwrap()
}

/// Inner faces: the tetrahedra on both sides, each with the opposite corner.
pub fn faces(mesh: &Mesh) -> Vec<[(usize, usize); 2]> {
    let mut sides: BTreeMap<Vec<u32>, Vec<(usize, usize)>> = BTreeMap::new();
    for (tetrahedron, nodes) in mesh.tetrahedra.iter().enumerate() {
        for corner in 0..4 {
            let mut face: Vec<u32> =
                (0..4).filter(|&at| at != corner).map(|at| nodes[at]).collect();
            face.sort_unstable();
            sides.entry(face).or_default().push((tetrahedron, corner));
        }
    }
    sides.into_values().filter_map(|sides| sides.try_into().ok()).collect()
}

/// Mean of a tetrahedron's corners \[m\].
pub fn centre(mesh: &Mesh, tetrahedron: usize) -> [f64; 3] {
    let corners = mesh.tetrahedra[tetrahedron].map(|node| mesh.nodes_m[node as usize]);
    [0, 1, 2].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 4.0)
}

/// The faces that a cut from the top down to this height parts, across the bar.
pub fn cut(mesh: &Mesh, down_to_m: f64) -> Vec<(usize, usize)> {
    let crossing = |side: (usize, usize)| centre(mesh, side.0)[0] < 0.0012;
    let is_deep = |side: (usize, usize)| centre(mesh, side.0)[2] > down_to_m;
    let of = |[one, other]: &[(usize, usize); 2]| {
        crossing(*one) != crossing(*other) && is_deep(*one) && is_deep(*other)
    };
    faces(mesh).iter().filter(|sides| of(sides)).map(|sides| sides[0]).collect()
}

/// The mesh with the nodes of opened faces doubled.
fn parted(mesh: &Mesh, open: &[(usize, usize)]) -> Mesh {
    let mut closed = faces(mesh);
    closed.retain(|sides| !open.contains(&sides[0]));
    let mut tetrahedra = mesh.tetrahedra.clone();
    let mut nodes_m = mesh.nodes_m.clone();
    for node in 0..mesh.nodes_m.len() as u32 {
        // Join the tetrahedra at the node over closed faces with it.
        let star: Vec<usize> =
            (0..tetrahedra.len()).filter(|&at| mesh.tetrahedra[at].contains(&node)).collect();
        let mut label: BTreeMap<usize, usize> = star.iter().map(|&at| (at, at)).collect();
        loop {
            let before = label.clone();
            for [(one, corner), (other, _)] in &closed {
                if let (Some(&a), Some(&b)) = (label.get(one), label.get(other))
                    && mesh.tetrahedra[*one][*corner] != node
                {
                    label.insert(*one, a.min(b));
                    label.insert(*other, a.min(b));
                }
            }
            if before == label {
                break;
            }
        }
        let mut pieces: Vec<usize> = label.values().copied().collect();
        pieces.sort_unstable();
        pieces.dedup();
        for &piece in pieces.iter().skip(1) {
            let copy = nodes_m.len() as u32;
            nodes_m.push(mesh.nodes_m[node as usize]);
            for (&at, _) in label.iter().filter(|(_, of)| **of == piece) {
                for id in tetrahedra[at].iter_mut().filter(|id| **id == node) {
                    *id = copy;
                }
            }
        }
    }
    let mut links: Vec<[u32; 2]> = tetrahedra
        .iter()
        .flat_map(|nodes| (0..4).flat_map(move |a| (0..a).map(move |b| [nodes[a], nodes[b]])))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    links.sort_unstable();
    links.dedup();
    Mesh { nodes_m, tetrahedra, links, triangles: Vec::new(), ..mesh.clone() }
}

/// Nodes of the top at the bar's far end.
fn end(mesh: &Mesh) -> Vec<u32> {
    let top = mesh.nodes_m.iter().map(|place| place[2]).fold(f64::MIN, f64::max);
    let far = mesh.nodes_m.iter().map(|place| place[0]).fold(f64::MIN, f64::max);
    let is_there = |place: &[f64; 3]| place[2] > top - 1e-6 && place[0] > far - 0.007;
    (0..).zip(&mesh.nodes_m).filter(|(_, place)| is_there(place)).map(|(node, _)| node).collect()
}

/// The force on a tool that pulled the end away from the cut.
fn settled<D: Dynamics<Number = f32>>(body: &mut Bench<'_, D>) -> [f64; 3] {
    let output = (0..3000).map(|_| body.tick([0.003, 0.0, 0.0])).last().unwrap();
    [0, 1, 2].map(|axis| output.force_n[axis].into())
}

/// Opens the faces one after another while the tool pulls: the body is then that of the mesh with doubled
/// nodes. It is stiffer with bands.
#[test]
fn a_body_cut_face_by_face_is_that_baked_in_pieces() {
    let [plain_n, banded_n] = [image, banded].map(|baked| cut_face_by_face(&baked));
    println!("{plain_n} N, with bands {banded_n} N");
    assert!(banded_n > 1.5 * plain_n, "{plain_n} {banded_n}");
}

/// The force that cutting a bar face by face leaves, beside that of the bar baked in pieces \[N\].
fn cut_face_by_face(image: &dyn Fn(&Mesh, Option<f64>) -> ImageBytes) -> f64 {
    let mesh = mesh();
    let (whole, held, open) = (image(&mesh, Some(0.5)), end(&mesh), cut(&mesh, 0.005));
    let doubled = parted(&mesh, &open);
    let baked = image(&doubled, None);
    let mut body = Bench::<Track>::holding(network(&whole, 4), &held);
    body.tick([0.0; 3]);
    let uncut = settled(&mut body);
    for face in &open {
        assert_eq!(body.open(*face), Ok(true));
        body.tick([0.003, 0.0, 0.0]);
    }
    let force = settled(&mut body);
    let cuts = body.cuts();
    assert_eq!(cuts.opened_faces as usize, open.len());
    assert_eq!((cuts.waiting, cuts.refused), (0, 0));
    assert_eq!(cuts.copies as usize, doubled.nodes_m.len() - mesh.nodes_m.len());
    let mut reference = Bench::<Track>::holding(network(&baked, 4), &held);
    reference.tick([0.0; 3]);
    let expected = settled(&mut reference);
    let size = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
    let off = force.iter().zip(expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    println!("uncut {uncut:?}, cut {force:?}, baked in pieces {expected:?}: {:.2e}", off / size);
    assert!(off < 1e-3 * size, "{force:?} {expected:?}");
    // So are the stresses at the nodes of the mesh.
    let [now, baked] = [&mut body, &mut reference].map(|body| mises_pa(body, &mesh));
    let largest = baked.iter().fold(0.0_f32, |a, b| a.max(*b));
    let off = now.iter().zip(&baked).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("stresses up to {largest} Pa, at most {off} Pa off");
    assert!(largest > 100.0 && off < 0.01 * largest, "{off} of {largest} Pa");
    let lost = uncut.iter().zip(expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    assert!(lost > 0.05 * size, "{uncut:?} {expected:?}");
    size
}

/// The stress after von Mises at each node \[Pa\].
fn mises_pa<D: Dynamics<Number = f32>>(body: &mut Bench<'_, D>, mesh: &Mesh) -> Vec<f32> {
    let model = body.model();
    let cells = (0..mesh.nodes_m.len() as u32).map(|node| model.cell_of_input(node).unwrap());
    cells.map(|cell| body.view().stress(&model, cell.into()).unwrap().von_mises_pa()).collect()
}

/// The tool pulls while the cut goes on: three faces in each of the first ticks.
fn while_cut<D: Dynamics<Number = f32>>(
    body: &mut Bench<'_, D>,
    open: &[(usize, usize)],
    ticks: Range<usize>,
    mut each: impl FnMut(&mut Bench<'_, D>, TickOutput),
) {
    for tick in ticks {
        for face in open.chunks(3).nth(tick).into_iter().flatten() {
            body.open(*face).unwrap();
        }
        let share = 1e-5 * tick.min(300) as f32;
        let output = body.tick([share, 0.3 * share, 0.0]);
        each(body, output);
    }
}

#[test]
fn a_cut_has_the_same_bits_with_and_without_vector_units() {
    fn hashes<D: Dynamics<Number = f32>>(image: &ImageBytes, is_scalar: bool) -> Vec<u64> {
        let (mesh, mut hashes) = (mesh(), Vec::new());
        let mut body = Bench::<D>::holding(network(image, 3), &end(&mesh));
        if is_scalar {
            body.view().go_scalar();
        }
        while_cut(&mut body, &cut(&mesh, 0.005), 0..60, |body, output| {
            hashes.push(body.hash());
            hashes.extend(output.force_n.iter().map(|x| u64::from(x.to_bits())));
        });
        assert!(body.cuts().copies > 5);
        hashes
    }
    for image in all() {
        assert_eq!(hashes::<Track>(&image, true), hashes::<Track>(&image, false));
        assert_eq!(hashes::<Predict>(&image, true), hashes::<Predict>(&image, false));
    }
}

#[test]
fn a_restored_cut_goes_on_with_the_same_bits() {
    all().iter().for_each(goes_on);
}

fn goes_on(image: &ImageBytes) {
    let (mesh, held) = (mesh(), end(&mesh()));
    let open = cut(&mesh, 0.003);
    let network = network(image, 3);
    let mut body = Bench::<Predict>::holding(network, &held);
    while_cut(&mut body, &open, 0..4, |_, _| ());
    for face in open.iter().skip(12) {
        assert_eq!(body.open(*face), Ok(true));
    }
    assert!(body.cuts().waiting > 0 && body.cuts().copies > 0, "{:?}", body.cuts());
    let mut bytes = vec![0; body.view().snapshot_bytes(&network).unwrap()];
    body.view().save(&network, &mut bytes).unwrap();
    // Another tissue goes on from it, and so does one that was cut elsewhere.
    let mut hashes = Vec::new();
    while_cut(&mut body, &open, 12..60, |body, _| hashes.push(body.hash()));
    for is_cut in [false, true] {
        let mut other = Bench::<Predict>::holding(network, &held);
        if is_cut {
            while_cut(&mut other, &cut(&mesh, 0.012), 0..40, |_, _| ());
        }
        other.view().restore(&network, &bytes).unwrap();
        let mut again = Vec::new();
        while_cut(&mut other, &open, 12..60, |body, _| again.push(body.hash()));
        assert_eq!(hashes, again);
    }
    // One without memory for cuts refuses it, and stays as it was.
    let mut without = Bench::<Predict>::holding(network, &held);
    without.words.clear();
    let before = without.hash();
    assert!(without.view().restore(&network, &bytes).is_err());
    assert_eq!(before, without.hash());
}

/// Counts of open faces and of waiting cells that do not match the body are refused.
#[test]
fn a_snapshot_with_other_counts_is_refused() {
    all().iter().for_each(refuses_other_counts);
}

fn refuses_other_counts(image: &ImageBytes) {
    let (mesh, held) = (mesh(), end(&mesh()));
    let open = cut(&mesh, 0.003);
    let network = network(image, 3);
    let mut body = Bench::<Predict>::holding(network, &held);
    for face in &open {
        assert_eq!(body.open(*face), Ok(true));
    }
    let cuts = body.cuts();
    let mut bytes = vec![0; body.view().snapshot_bytes(&network).unwrap()];
    body.view().save(&network, &mut bytes).unwrap();
    // The counts stand together: copies, faces, refused splits, waiting cells.
    let wanted = [0, cuts.opened_faces, 0, cuts.waiting].map(u32::to_le_bytes).concat();
    let mut places = (0..bytes.len() - 20).filter(|&at| bytes[at..].starts_with(&wanted));
    let (place, another) = (places.next().unwrap(), places.next());
    assert_eq!(another, None);
    for at in [place + 4, place + 12] {
        for forged in [0, 1, 255] {
            let mut other = bytes.clone();
            other[at] = forged;
            check(&mut other);
            let why = body.view().restore(&network, &other);
            assert!(matches!(why, Err(SnapshotError::Value(_))), "{at} {forged}: {why:?}");
        }
    }
    assert_eq!(body.view().restore(&network, &bytes), Ok(()));
}

#[test]
fn a_reset_closes_all_cuts() {
    all().iter().for_each(is_closed_by_a_reset);
}

fn is_closed_by_a_reset(image: &ImageBytes) {
    let (mesh, held) = (mesh(), end(&mesh()));
    let network = network(image, 3);
    let mut fresh = Bench::<Track>::holding(network, &held);
    let mut body = Bench::<Track>::holding(network, &held);
    while_cut(&mut body, &cut(&mesh, 0.005), 0..40, |_, _| ());
    assert!(body.cuts().copies > 0);
    body.tick([0.0; 3]);
    body.head.clone_from(&Head::NEW);
    body.view().reset(&network).unwrap();
    let cells: Vec<u16> = {
        let mut cells: Vec<u16> =
            held.iter().map(|&node| network.model().cell_of_input(node).unwrap()).collect();
        cells.sort_unstable();
        cells
    };
    body.view().choose_contacts(&network, &cells).unwrap();
    assert_eq!(body.cuts(), CutOutput::default());
    for tick in 0..50 {
        let way = [1e-5 * tick as f32, 0.0, 0.0];
        assert_eq!(fresh.tick(way), body.tick(way));
        assert_eq!(fresh.hash(), body.hash());
    }
}

/// Without spare cells a split is refused and counted, and the body stays as it is there.
#[test]
fn without_spare_cells_splits_are_refused() {
    let mesh = mesh();
    let image = image(&mesh, Some(0.0));
    let mut body = Bench::<Track>::holding(network(&image, 3), &end(&mesh));
    let spare = body.model().spare_cells();
    while_cut(&mut body, &cut(&mesh, -1.0), 0..120, |body, output| {
        assert!(output.force_n.iter().all(|x| x.is_finite()) && body.is_finite());
    });
    let cuts = body.cuts();
    assert!(cuts.copies as usize <= spare && cuts.refused > 0, "{cuts:?}");
    assert_eq!(cuts.waiting, 0);
}

/// At most eight cells split in a tick, the others wait; a late tick splits none.
#[test]
fn splits_wait_for_their_tick() {
    let mesh = mesh();
    let image = image(&mesh, Some(0.5));
    let mut body = Bench::<Track>::holding(network(&image, 3), &end(&mesh));
    body.tick([0.0; 3]);
    for face in cut(&mesh, -1.0) {
        body.open(face).unwrap();
    }
    let marked = body.cuts().waiting;
    assert!(marked > 16, "{marked}");
    for _ in 0..3 {
        body.late([0.0; 3]);
        assert_eq!((body.cuts().waiting, body.cuts().copies), (marked, 0));
    }
    let (mut before, mut ticks) = (0, 0);
    while body.cuts().waiting > 0 {
        body.tick([0.0; 3]);
        let copies = body.cuts().copies;
        assert!((1..=8).contains(&(copies - before)) || body.cuts().waiting == 0, "{copies}");
        (before, ticks) = (copies, ticks + 1);
    }
    assert!(ticks >= 3 && before > 16, "{ticks} {before}");
}

/// A tetrahedron of which all faces open hangs on nothing; its copies stay where they are left.
#[test]
fn a_tetrahedron_can_be_cut_free() {
    let mesh = mesh();
    let image = image(&mesh, Some(0.5));
    let surface: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    let inner = |at: usize| mesh.tetrahedra[at].iter().all(|node| !surface.contains(node));
    let free = (0..mesh.tetrahedra.len()).find(|&at| inner(at)).unwrap();
    let mut body = Bench::<Track>::holding(network(&image, 3), &end(&mesh));
    let network = body.network;
    (0..4).for_each(|corner| assert_eq!(body.open((free, corner)), Ok(true)));
    (0..4).for_each(|corner| assert_eq!(body.open((free, corner)), Ok(false)));
    assert_eq!(body.cuts().opened_faces, 4);
    let most = mesh.tetrahedra.len();
    assert_eq!(body.open((most, 0)), Err(CutError::Unknown(most, 0)));
    assert_eq!(body.open((0, 4)), Err(CutError::Unknown(0, 4)));
    for tick in 0..300 {
        let output = body.tick([1e-5 * tick as f32, 0.0, 0.0]);
        assert!(output.force_n.norm().is_finite() && body.is_finite());
    }
    assert_eq!(body.cuts().copies, 4);
    // No other tetrahedron has a corner of it, and it kept its shape.
    let corners: Vec<u16> =
        (0..4).map(|at| body.view().cell_of_corner(&network, free, at).unwrap()).collect();
    for other in (0..most).filter(|&at| at != free) {
        for at in 0..4 {
            let cell = body.view().cell_of_corner(&network, other, at).unwrap();
            assert!(!corners.contains(&cell));
        }
    }
    let length = |a: [f32; 3], b: [f32; 3]| {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
    };
    let nodes = mesh.tetrahedra[free];
    let rest = |at: usize| {
        body.model().rest_position(body.model().cell_of_input(nodes[at]).unwrap().into())
    };
    for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        let now = length(
            body.state[usize::from(corners[a])].xyz(),
            body.state[usize::from(corners[b])].xyz(),
        );
        let before = length(rest(a), rest(b));
        assert!((now / before - 1.0).abs() < 0.02, "{a} {b}: {now} {before}");
    }
}

/// A copy of a fixed cell is fixed.
#[test]
fn copies_of_fixed_cells_stay() {
    let mesh = mesh();
    let image = image(&mesh, Some(0.5));
    let mut body = Bench::<Track>::holding(network(&image, 3), &end(&mesh));
    while_cut(&mut body, &cut(&mesh, -1.0), 0..200, |_, _| ());
    let (model, cells) = (body.model(), body.model().cells());
    assert!(body.cuts().refused == 0 && body.cuts().copies > 0);
    let first = cells - model.spare_cells();
    let rest: Vec<[f32; 3]> =
        model.fixed().iter().map(|&cell| model.rest_position(cell.into())).collect();
    let fixed = (first..first + body.cuts().copies as usize)
        .filter(|&cell| rest.contains(&body.state[cell].xyz()))
        .count();
    // A row of the ground, five nodes across.
    assert_eq!(fixed, 5);
}
