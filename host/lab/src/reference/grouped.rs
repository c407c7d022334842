//! How stiff a body of few cells is beside its mesh.

use chaincell_host::bake::{BakeOptions, BasisSpacing, bake};
use chaincell_host::engine::contact::held;
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::Model;

use super::{Links, minimum};

/// Force of the top, held and moved by `move_m`, on whatever moves it \[N\].
fn plate(mesh: &Mesh, cells: Option<usize>, move_m: [f64; 3]) -> [f64; 3] {
    let options = BakeOptions { cells, coarse_basis: BasisSpacing::None, ..BakeOptions::default() };
    let image = bake(mesh, &mesh.default_fixed, &options).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let height = mesh.nodes_m.iter().map(|p| p[2]).fold(0.0, f64::max);
    let on_top = |node: &u32| mesh.nodes_m[*node as usize][2] > height - 1e-9;
    let nodes: Vec<u32> = (0..mesh.nodes_m.len() as u32).filter(on_top).collect();
    let of: Vec<usize> = held(&model, &nodes).unwrap().into_iter().map(usize::from).collect();
    let links = Links::of_model(&model);
    let unit_m = f64::from(model.unit_m());
    let place =
        |&cell: &usize| (cell, std::array::from_fn(|x| links.rest()[cell][x] + move_m[x] / unit_m));
    let places: Vec<(usize, [f64; 3])> = of.iter().map(place).collect();
    let found = minimum(&links, &places, links.rest(), 1e-9);
    links.force(&found.positions, &of).map(|f| f * f64::from(model.force_unit_n()))
}

#[test]
fn a_pressed_box_is_about_as_stiff_as_its_mesh() {
    let mesh = load("box:21x21x11x0.005", &MeshOptions::default()).unwrap();
    for (axis, move_m) in [(2, [0.0, 0.0, -0.001]), (0, [0.001, 0.0, 0.0])] {
        let fine = plate(&mesh, None, move_m)[axis];
        for (cells, within) in [(1000, 0.07), (300, 0.15)] {
            let off = plate(&mesh, Some(cells), move_m)[axis] / fine - 1.0;
            println!("{cells} cells, top moved by {move_m:?} m: force off by {:.1} %", 100.0 * off);
            assert!(off.abs() < within, "{cells} cells: {off}");
        }
    }
}
