//! AVS UCD files, `.inp` and `.avs`.

use super::*;

const TEXT: &str = "# made by hand
5 3 1 0 0
10 0 0 0
20 1 0 0
30 0 1.D0 0
40 0 0 1
7 1 1 1
1 3 tri 10 20 40
2 0 tet 10 20 30 40
3 9  tet  20 30 40 7
1 1
u, m
10 0.5
";

fn read(text: &str) -> Result<RawMesh> {
    parse(Path::new("a.inp"), text.as_bytes(), 1.0)
}

#[track_caller]
fn refused(from: &str, to: &str, parts: &[&str]) {
    assert!(TEXT.contains(from), "{from} is not in the text");
    assert_refused(read(&TEXT.replacen(from, to, 1)), parts);
}

#[test]
fn nodes_tetrahedra_and_materials_are_read() {
    let body = read(TEXT).unwrap();
    assert_eq!((body.nodes_m[2], body.nodes_m[4]), ([0.0, 1.0, 0.0], [1.0; 3]));
    assert_eq!(body.tetrahedra, [[0, 1, 2, 3], [1, 2, 3, 4]]);
    let wanted = [("3", vec![0, 1, 3]), ("9", vec![1, 2, 3, 4])];
    assert_eq!(body.groups, wanted.map(|(name, nodes)| (name.to_owned(), nodes)).into());
    assert_eq!(parse(Path::new("a.avs"), TEXT.as_bytes(), 1.0).unwrap(), body);
    // Tetrahedra turn the other way in UCD.
    let [medit, meshio] = ["box.meshio.mesh", "box.meshio.avs"].map(|name| Mesh::from(load(name)));
    assert_eq!((&meshio.nodes_m, &meshio.tetrahedra), (&medit.nodes_m, &medit.tetrahedra));
    assert_eq!(
        (&meshio.groups["1"], &meshio.groups["7"]),
        (&medit.groups["1"], &medit.groups["7"])
    );
}

#[test]
fn what_is_not_read_names_line_and_remedy() {
    refused("5 3 1 0 0", "6 3 1 0 0", &["a.inp:8: y is 'tri'"]);
    refused("5 3 1 0 0", "99999999999 3 1 0 0", &["a.inp:2:", "bytes are left"]);
    refused("5 3 1 0 0", "5 99999999999 1 0 0", &["a.inp:7:", "bytes are left"]);
    refused("20 1 0 0", "10 1 0 0", &["a.inp:4: node number 10 is given twice"]);
    refused("20 1 0 0", "20 1 0 nan", &["a.inp:4: the z is NaN", "`unit_m`"]);
    refused("20 1 0 0", "20 1 0,5 0", &["a.inp:4: y is '0,5'", "a point in front of decimals"]);
    refused("2 0 tet", "2 0 hex", &["a.inp:9: element 2 is of type 'hex'", "split"]);
    refused("10 20 30 40\n", "10 20 30 30\n", &["a.inp:9:", "twice"]);
    refused("10 20 30 40\n", "10 20 30 50\n", &["a.inp:9: element 2 refers to node 50"]);
    refused("10 20 30 40\n", "10 20 30\n", &["a.inp:9: the line ends"]);
    let text = TEXT.replace("tet ", "quad ");
    assert_refused(read(&text), &["a.inp: it has 5 nodes and 3 elements but no tetrahedra"]);
}
