//! TetGen's pair of files.

use super::*;

const NODE: &str = "# points\n\n5 3 1 1 # counts\n1 0 0 0 0.5 0\n2 1 0 0 0.5 4\n3 0 1 0 0 0\n\
    4 0 0 1 0 -1\n5 1 1 1 0 4 # the last\n";
const ELE: &str = "2 4 1\n1 1 2 3 4 7\n2 2 3 4 5 0.5\n# generated\n";

/// Reads a pair from a folder by the name that ends in `ending`.
fn read(node: &str, ele: &str, ending: &str) -> Result<RawMesh> {
    let folder = chaincell_tests::files::scratch();
    let path = |ending: &str| folder.path().join(format!("a.{ending}"));
    std::fs::write(path("node"), node).unwrap();
    std::fs::write(path("ele"), ele).unwrap();
    parse(&path(ending), &std::fs::read(path(ending)).unwrap(), 1.0)
}

#[track_caller]
fn refused(from: &str, to: &str, parts: &[&str]) {
    assert!(NODE.contains(from) || ELE.contains(from), "{from} is in neither text");
    let (node, ele) = (NODE.replacen(from, to, 1), ELE.replacen(from, to, 1));
    let (node, ele) = if NODE.contains(from) { (&node[..], ELE) } else { (NODE, &ele[..]) };
    assert_refused(read(node, ele, "ele"), parts);
}

#[test]
fn either_name_gives_the_pair_with_its_groups() {
    let body = read(NODE, ELE, "node").unwrap();
    assert_eq!(body.nodes_m[4], [1.0; 3]);
    assert_eq!(body.tetrahedra, [[0, 1, 2, 3], [1, 2, 3, 4]]);
    let wanted = [("7", vec![0, 1, 2, 3]), ("points:-1", vec![3]), ("points:4", vec![1, 4])];
    assert_eq!(body.groups, wanted.map(|(name, nodes)| (name.to_owned(), nodes)).into());
    assert_eq!(read(NODE, ELE, "ele").unwrap(), body);
    let zero = "5 3\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 1 1 1\n";
    let body_0 = read(zero, "2 4\n0 0 1 2 3\n1 1 2 3 4\n", "ele").unwrap();
    assert_eq!((body_0.nodes_m, body_0.tetrahedra), (body.nodes_m, body.tetrahedra));
}

#[test]
fn what_is_not_read_names_line_and_remedy() {
    refused("5 3 1 1", "5 2 1 1", &["a.node:3: points of dimension 2"]);
    refused("5 3 1 1", "6 3 1 1", &["a.node:9: the file ends", "cut off"]);
    refused("5 3 1 1", "4 3 1 1", &["a.node:8: a line more"]);
    refused("5 3 1 1", "5 3 2 1", &["a.node:4: the line ends before the boundary marker"]);
    refused("5 3 1 1", "5 3 0 1", &["a.node:4: the line goes on with '0'"]);
    refused("5 3 1 1", "888888888888 3 1 1", &["a.node:3:", "bytes are left"]);
    refused("3 0 1 0 0 0", "7 0 1 0 0 0", &["a.node:6: point number 7 in place 2"]);
    refused("1 0 0 0 0.5", "2 0 0 0 0.5", &["a.node:4: point number 2 in place 0"]);
    refused("3 0 1 0 0 0", "3 0 inf 0 0 0", &["a.node:6: the y is inf", "`unit_m`"]);
    refused("3 0 1 0 0 0", "3 0 one 0 0 0", &["a.node:6: y is 'one'"]);
    refused("2 4 1\n", "2 10 1\n", &["a.ele:1: elements of 10 nodes", "-o2"]);
    refused("2 4 1\n", "18446744073709551615 4 1\n", &["a.ele:1:", "bytes are left"]);
    refused("2 4 1\n", "1 4 1\n", &["a.ele:3: a line more"]);
    refused("2 4 1\n", "0 4 1\n", &["a.ele: it has no tetrahedra"]);
    refused("1 1 2 3 4 7", "1 0 2 3 4 7", &["a.ele:2: point 0; the points are 1 to 5"]);
    refused("1 1 2 3 4 7", "1 1 2 3 6 7", &["a.ele:2: point 6"]);
    refused("1 1 2 3 4 7", "1 1 2 3 3 7", &["a.ele:2:", "twice"]);
    refused("1 1 2 3 4 7", "1 1 2 3 4 seven", &["a.ele:2: the attribute is 'seven'"]);
    assert_refused(read("", ELE, "ele"), &["a.node", "empty"]);
    assert_refused(read("# no more\n", ELE, "ele"), &["a.node:2: the file ends in the points"]);
    assert_refused(read("0 3\n", ELE, "ele"), &["a.node: it has no points"]);
    let folder = chaincell_tests::files::scratch();
    let missing = parse(&folder.path().join("b.ele"), ELE.as_bytes(), 1.0);
    assert_refused(missing, &["b.node", "b.ele needs it", "the points of the mesh", "one folder"]);
    let text = parse(&folder.path().join("c.node"), b"5 3 \xff", 1.0);
    assert_refused(text, &["c.ele", "c.node needs it", "the tetrahedra of the mesh"]);
}
