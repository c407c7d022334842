//! What `bake` notes and refuses of bodies that are read well: with number, place, and ids of nodes.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::{scratch, text};
use chaincell_tests::{Ended, run};

use super::readers::data;

#[track_caller]
fn baked(mesh: &str, options: &[&str]) -> Ended {
    let folder = scratch();
    let model = folder.path().join("model.chaincell");
    run([&["bake", mesh, "-o", text(&model)], options].concat())
}

#[track_caller]
fn refused(mesh: &str, options: &[&str], parts: &[&str]) {
    let err = baked(mesh, options).with(2).err;
    for part in parts {
        assert!(err.contains(part), "{options:?}: `{part}` is missing: {err}");
    }
}

#[test]
fn tetrahedra_that_overlap_are_noted_with_number_and_place() {
    let folded = data("folded.vtk");
    let err = baked(text(&folded), &[]).with(0).err;
    let wanted = "note: 32 tetrahedra overlap, the first two around (0.007500, 0.007500, 0.013500): the mesh is";
    assert!(err.contains(wanted), "{err}");
    let json = baked(text(&folded), &["--json"]).with(0).json();
    assert_eq!(json["overlapping_tetrahedra"], 32);
    // The place is in the unit of the file.
    let err = baked(text(&folded), &["--units", "mm"]).with(0).err;
    assert!(err.contains("(0.007500, 0.007500, 0.013500)"), "{err}");
    let sound = data("box.msh41.ascii.msh");
    assert!(!baked(text(&sound), &[]).with(0).err.contains("overlap"));
    assert_eq!(baked(text(&sound), &["--json"]).with(0).json().get("overlapping_tetrahedra"), None);
}

#[test]
fn two_pieces_of_a_file_are_parts() {
    let piece = |x: &str| {
        format!(
            "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" \
             NumberOfComponents=\"3\">{x}0 0 0 {x}1 0 0 {x}0 1 0 {x}0 0 1</DataArray></Points><Cells>\
             <DataArray type=\"Int32\" Name=\"connectivity\">0 1 2 3</DataArray><DataArray type=\"Int32\" \
             Name=\"offsets\">4</DataArray><DataArray type=\"UInt8\" Name=\"types\">10</DataArray></Cells>\
             </Piece>"
        )
    };
    let folder = scratch();
    let file = folder.path().join("two.vtu");
    let (from, to) =
        ("<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>", "</UnstructuredGrid></VTKFile>");
    std::fs::write(&file, format!("{from}{}{}{to}", piece("1"), piece("2"))).unwrap();
    refused(text(&file), &[], &["2 unconnected parts", "--allow-parts"]);
    let ended = baked(text(&file), &["--allow-parts", "--json"]).with(0).json();
    assert_eq!((ended["cells"].as_u64(), ended["parts"].as_u64()), (Some(8), Some(2)));
}

#[test]
fn a_modulus_out_of_range_is_named_as_itself() {
    for young in ["1e30", "1e-30", "1e38", "2e-38"] {
        refused(
            "box:3x3x3x0.01",
            &["--young-pa", young],
            &["--young-pa", young, "soft tissue has"],
        );
    }
    let folder = scratch();
    let values = folder.path().join("values");
    std::fs::write(&values, "5000 ".repeat(26) + "1e30").unwrap();
    let values = format!("file:{}", values.display());
    refused("box:3x3x3x0.01", &["--young-pa", &values], &["--young-pa 1e30"]);
    refused("box:3x3x3x0.01", &["--stiffness-n-per-m", "1e30"], &["--stiffness-n-per-m"]);
}

/// Cells are numbered anew, and a node in front has no link.
#[test]
fn refusals_name_nodes_by_their_ids() {
    let folder = scratch();
    let file = folder.path().join("flat.inp");
    let mut inp = String::from("*NODE\n1, 9, 9, 9\n");
    for (number, place) in
        [(2, "3, 1, 0"), (3, "0, 0, 0"), (4, "1, 0, 0"), (5, "0, 1, 0"), (6, "0, 0, 1")]
    {
        inp += &format!("{number}, {place}\n");
    }
    inp += "*ELEMENT, TYPE=C3D4\n1, 3, 4, 5, 6\n2, 3, 4, 5, 2\n";
    std::fs::write(&file, inp).unwrap();
    let options = ["--drop-unused", "--young-pa", "5000"];
    let parts =
        ["--young-pa: the tetrahedron of nodes [2, 3, 4, 1], at (0.000000, 0.000000, 0.000000) m"];
    refused(text(&file), &options, &parts);
}
