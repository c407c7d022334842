//! Mesh files in every format; what is accepted and small is baked.

use chaincell_host::bake::{BakeOptions, bake};
use chaincell_host::error::Error;
use chaincell_host::mesh::{Filling, Mesh, MeshOptions, from_bytes};
use chaincell_kernel::Model;

/// Most nodes of a mesh that is baked.
const BAKED_NODES_MAX: usize = 100;

/// A Gmsh file, 2.2 or 4.1, text or binary.
pub fn gmsh(data: &[u8]) {
    mesh("fuzz.msh", data);
}

/// A legacy VTK file, text or binary.
pub fn vtk(data: &[u8]) {
    mesh("fuzz.vtk", data);
}

/// A VTK XML, an Abaqus or a Medit file; the first byte says which.
pub fn meshes(data: &[u8]) {
    let [which, data @ ..] = data else { return };
    mesh(["fuzz.vtu", "fuzz.inp", "fuzz.mesh"][usize::from(which % 3)], data);
}

/// A closed surface in STL, OBJ or PLY, filled coarsely; the first byte says which.
pub fn surface(data: &[u8]) {
    let [which, data @ ..] = data else { return };
    let name = ["fuzz.stl", "fuzz.obj", "fuzz.ply"][usize::from(which % 3)];
    let options = MeshOptions {
        filling: Some(Filling::even(0.08)),
        nodes_max: 2_000,
        ..MeshOptions::default()
    };
    match from_bytes(name, data, &options) {
        Ok(mesh) => sound(&mesh),
        Err(why) => assert!(why.exit_code() == 2 && why.to_string().contains(name), "{why}"),
    }
}

fn mesh(name: &str, data: &[u8]) {
    let strict = from_bytes(name, data, &MeshOptions::default());
    let lenient = MeshOptions { drop_unused: true, allow_parts: true, ..MeshOptions::default() };
    let mesh = from_bytes(name, data, &lenient);
    if let Ok(strict) = strict {
        assert!(mesh.as_ref() == Ok(&strict), "what is sound is sound for lenient readers too");
    }
    match mesh {
        Ok(mesh) => sound(&mesh),
        Err(why) => assert!(why.exit_code() == 2 && why.to_string().contains(name), "{why}"),
    }
}

/// Every index of an accepted mesh is in range, and it bakes or is refused with a reason.
fn sound(mesh: &Mesh) {
    let nodes = mesh.nodes_m.len();
    let known = |id: &u32| (*id as usize) < nodes;
    assert!(mesh.nodes_m.as_flattened().iter().all(|x| x.is_finite()));
    assert!(mesh.links.iter().all(|[i, j]| i < j) && mesh.links.is_sorted());
    assert!(mesh.links.as_flattened().iter().all(known));
    assert!(mesh.triangles.as_flattened().iter().all(known));
    assert!(mesh.tetrahedra.as_flattened().iter().all(known));
    assert!(mesh.groups.values().flatten().all(known));
    if nodes > BAKED_NODES_MAX {
        return;
    }
    match bake(mesh, &[], &BakeOptions::default()) {
        Ok(image) => assert!(Model::from_bytes(image.as_bytes()).is_ok()),
        Err(Error::Input(_)) => {}
        Err(why) => panic!("an accepted mesh is refused by the bake's own check: {why}"),
    }
}
