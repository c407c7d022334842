//! Sweeps beside a deep cut: the coarse level has functions on either side of it.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BakeOptions, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::Predict;

use super::bench::Bench;
use super::cutting::{centre, faces, network};

/// Edges of 8 mm.
const SLAB: &str = "box:17x13x7x0.008";
/// Ticks within which the functions are there.
const RENEWAL: usize = 150;

fn slab() -> Mesh {
    load(SLAB, &MeshOptions::default()).unwrap()
}

fn image(mesh: &Mesh) -> ImageBytes {
    let cuttable = Some(Cuttable { spare_share: 0.2, ..Cuttable::default() });
    let tissue = Some(Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45)));
    let options = BakeOptions { tissue, cuttable, ..BakeOptions::default() };
    // Held at its left end, so that a cut across it leaves a flap.
    let left = mesh.nodes_m.iter().map(|node| node[0]).fold(f64::MAX, f64::min);
    let held = (0..).zip(&mesh.nodes_m).filter(|(_, node)| node[0] < left + 1e-6);
    bake(mesh, &held.map(|(node, _)| node).collect::<Vec<u32>>(), &options).unwrap()
}

/// The faces of a cut across the slab, from above through two thirds of its height.
fn cut(mesh: &Mesh) -> Vec<(usize, usize)> {
    let low = mesh.nodes_m.iter().map(|node| node[2]).fold(f64::MAX, f64::min);
    let is_parted = |[one, other]: &[(usize, usize); 2]| {
        let [one, other] = [one.0, other.0].map(|at| centre(mesh, at));
        (one[0] < 0.001) != (other[0] < 0.001) && one[2].min(other[2]) > low + 0.016
    };
    faces(mesh).into_iter().filter(is_parted).map(|[one, _]| one).collect()
}

/// Nodes of the top around a place beyond the cut.
fn beside(mesh: &Mesh) -> Vec<u32> {
    let top = mesh.nodes_m.iter().map(|node| node[2]).fold(f64::MIN, f64::max);
    let is_there = |node: &[f64; 3]| {
        node[2] > top - 1e-6 && (node[0] - 0.024).hypot(node[1]) < 0.009
    };
    (0..).zip(&mesh.nodes_m).filter(|(_, node)| is_there(node)).map(|(node, _)| node).collect()
}

/// The slab with its cut, at rest.
fn parted<'a>(image: &'a ImageBytes, sweeps: u16, ticks: usize) -> Bench<'a, Predict> {
    let mesh = slab();
    let mut body = Bench::<Predict>::holding(network(image, sweeps), &beside(&mesh));
    body.tick([0.0; 3]);
    for face in cut(&mesh) {
        body.open(face).unwrap();
    }
    (0..ticks).for_each(|_| drop(body.tick([0.0; 3])));
    body
}

/// Pulled along each axis and let go within 0.4 s, one sweep a tick is near 24 of them: without functions on either
/// side of the cut the median is 10 % of the peak across it and 5 % along it.
#[test]
fn one_sweep_beside_a_deep_cut_is_near_many() {
    let image = image(&slab());
    for (axis, most) in [(0, 3.0), (1, 2.0), (2, 2.0)] {
        let (mut one, mut many) = (parted(&image, 1, 600), parted(&image, 24, 600));
        assert!(one.cuts().copies > 50 && one.cuts().waiting == 0, "{:?}", one.cuts());
        let (mut errors, mut peak_n) = (Vec::new(), 0.0_f32);
        for tick in 0..400 {
            let mut way_m = [0.0; 3];
            way_m[axis] = 0.002 * (1.0 - (tick as f32 - 200.0).abs() / 200.0);
            let [one, many] = [one.tick(way_m), many.tick(way_m)].map(|output| output.force_n[axis]);
            errors.push((one - many).abs());
            peak_n = peak_n.max(many.abs());
        }
        errors.sort_by(f32::total_cmp);
        let share = |of: f32| 100.0 * errors[(399.0 * of) as usize] / peak_n;
        let [median, most_of, largest] = [0.5, 0.9, 1.0].map(share);
        println!("axis {axis}: {median:.2} % median, {most_of:.2} 90th percentile, {largest:.2} largest");
        assert!(median < most, "axis {axis}: {median} %");
    }
}

/// Hashes of a body that is pulled.
fn pulled(body: &mut Bench<'_, Predict>, ticks: usize) -> Vec<u64> {
    let pull = |tick: usize| 1e-5 * tick as f32;
    (0..ticks).map(|tick| (drop(body.tick([pull(tick), 0.0, 0.0])), body.hash()).1).collect()
}

/// Saved in every step of a renewal, and with other bits in memory.
#[test]
fn a_body_restored_in_mid_renewal_goes_on_with_the_same_bits() {
    let image = image(&slab());
    for ticks in [3, 9, 14, 20, 40, RENEWAL] {
        let mut body = parted(&image, 1, ticks);
        let network = body.network;
        let mut bytes = vec![0; body.view().snapshot_bytes(&network).unwrap()];
        body.view().save(&network, &mut bytes).unwrap();
        let mut other = parted(&image, 1, 90);
        other.view().restore(&network, &bytes).unwrap();
        assert_eq!(pulled(&mut body, 200), pulled(&mut other, 200), "{ticks} ticks");
        // A word that no renewal leaves behind is refused, and changes nothing.
        let before = other.hash();
        let damaged = bytes.iter().rposition(|&byte| byte != 0).unwrap();
        bytes[damaged] = 0xFF;
        assert!(other.view().restore(&network, &bytes).is_err());
        assert_eq!(before, other.hash());
    }
}

#[test]
fn a_renewal_has_the_same_bits_with_and_without_vector_units() {
    let image = image(&slab());
    let [scalar, vector] = [true, false].map(|is_scalar| {
        let mut body = parted(&image, 1, 0);
        if is_scalar {
            body.view().go_scalar();
        }
        pulled(&mut body, RENEWAL + 50)
    });
    assert_eq!(scalar, vector);
}
