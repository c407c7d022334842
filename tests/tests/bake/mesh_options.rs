//! Meshes by their options, and the reference liver in every format.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_host::mesh::{MeshOptions, load, select};

fn refusal(spec: &str, options: &MeshOptions) -> String {
    load(spec, options).unwrap_err().to_string()
}

#[test]
fn options_are_checked() {
    let bad = MeshOptions { unit_m: f64::NAN, ..MeshOptions::default() };
    assert!(refusal("plane:3x3x0.01", &bad).contains("`unit_m`"));
    let diagonals = MeshOptions { diagonals: true, ..MeshOptions::default() };
    assert!(refusal("box:3x3x3x0.01", &diagonals).contains("`diagonals`"));
}

#[test]
fn units_do_not_scale_generators() {
    let mm = MeshOptions { unit_m: 0.001, ..MeshOptions::default() };
    assert_eq!(
        load("plane:3x3x0.01", &mm).unwrap(),
        load("plane:3x3x0.01", &MeshOptions::default()).unwrap()
    );
}

/// The reference liver, the same from all formats.
#[test]
fn reference_liver() {
    let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE") else {
        println!("SKIPPED reference_liver: CHAINCELL_REFERENCE is not set");
        return;
    };
    let read = |name: &str, unit_m: f64| {
        let path = Path::new(&folder).join("meshes").join(name);
        let options = MeshOptions { unit_m, ..MeshOptions::default() };
        load(path.to_str().unwrap(), &options).unwrap()
    };
    let old = read("liver_5762.msh22.msh", 1.0);
    assert_eq!(old, read("liver_5762.msh41.msh", 1.0));
    let vtk = read("liver_5762.vtk", 1.0);
    assert_eq!(vtk.tetrahedra, old.tetrahedra);
    // The text of the .msh files has 16 digits, that of the .vtk up to 17.
    let pairs = vtk.nodes_m.iter().flatten().zip(old.nodes_m.iter().flatten());
    assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-15 * a.abs()));
    assert_eq!((&vtk.links, &vtk.triangles), (&old.links, &old.triangles));
    assert_eq!((old.nodes_m.len(), old.tetrahedra.len()), (5_773, 20_268));
    assert_eq!((old.links.len(), old.triangles.len()), (30_358, 8_636));
    assert_eq!((old.unused.len(), old.flat_tetrahedra), (0, 0));
    assert_eq!(old.groups["surface"].len(), 4_320);
    assert_eq!(old.groups["volume"].len(), 5_773);
    let mm = read("liver_5762.msh22.msh", 0.001);
    assert_eq!(mm.nodes_m[7][2], old.nodes_m[7][2] * 0.001);
    let sets = Path::new(&folder).join("meshes/liver_5762.sets.json");
    let text = format!("file:{}#fixed", sets.display());
    let fixed = select(&text, &old.nodes_m, &old.groups, &old.border, "`fix`").unwrap();
    assert_eq!(fixed.len(), 697);
}
