use super::*;

/// Two tetrahedra over one face, tags sparse and out of order, a tetrahedron in two groups.
pub(super) const OLD: &str = "$Comments
made by hand
$EndComments
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 \"the skin\"
3 1 \"body\"
$EndPhysicalNames
$Nodes
5
900 0 0 0
7 1 0 0
18446744073709551615 0 1 0
3 0 0 1
12 1 1 1e0
$EndNodes
$Elements
6
1 15 2 4 1 900
2 2 2 7 1 900 7 3
3 4 2 1 1 900 7 18446744073709551615 3
4 4 2 1 1 7 18446744073709551615 3 12
5 4 2 9 1 7 18446744073709551615 3 12
6 1 2 0 1 900 7
$EndElements
$NodeData
ignored
$EndNodeData
";

/// The same body.
pub(super) const NEW: &str = "$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 \"the skin\"
3 1 \"body\"
$EndPhysicalNames
$Entities
1 1 1 2
1 0 0 0 1 4
1 0 0 0 1 0 0 0 2 1 -1
1 0 0 0 1 1 1 1 -7 1 1
1 0 0 0 1 1 1 1 1 0
2 0 0 0 1 1 1 2 1 9 0
$EndEntities
$Nodes
2 5 3 900
0 1 0 1
900
0 0 0
3 1 1 4
7
18446744073709551615
3
12
1 0 0 .5 .5 .5
0 1 0
0 0 1

1 1 1
$EndNodes
$Elements
5 5 1 6
0 1 15 1
1 900
2 1 2 1
2 900 7 3
3 1 4 1
3 900 7 18446744073709551615 3
3 2 4 1
4 7 18446744073709551615 3 12
1 1 1 1
6 900 7
$EndElements
";

fn read(text: &str) -> Result<RawMesh> {
    parse(Path::new("a.msh"), text.as_bytes(), 1.0)
}

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    assert_refused(read(text), parts);
}

/// `text` with `from`, which it must have, replaced.
#[track_caller]
fn with(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from} is not in the text");
    text.replacen(from, to, 1)
}

#[test]
fn what_follows_a_quoted_name_is_a_remark() {
    for text in [OLD, NEW] {
        let named = with(text, "\"the skin\"", "\"the skin\"  lower \"block\" 2");
        assert_eq!(read(&named).unwrap(), read(text).unwrap());
        refused(&with(text, "\"body\"", "body"), &["the group name is 'body'", "double quotes"]);
        refused(&with(text, "\"body\"", "\"body"), &["double quotes"]);
    }
}

/// With the dimension, the entity and the place in it behind each node, as Gmsh writes them.
#[test]
fn parametric_nodes_are_read() {
    let mut text = with(OLD, "$Nodes", "$ParametricNodes");
    text = with(&text, "$EndNodes", "$EndParametricNodes");
    for (from, to) in [
        ("900 0 0 0\n", "900 0 0 0 0 4\n"),
        ("7 1 0 0\n", "7 1 0 0 1 2 0.5\n"),
        ("3 0 0 1\n", "3 0 0 1 2 1 0.25 -3e-5\n"),
        ("12 1 1 1e0\n", "12 1 1 1e0 3 1\n"),
    ] {
        text = with(&text, from, to);
    }
    assert_eq!(read(&text).unwrap(), read(OLD).unwrap());
    refused(&with(&text, "7 1 0 0 1", "7 1 x 0 1"), &["a.msh:", "y is 'x'"]);
}

#[test]
fn views_behind_a_mesh_are_passed_over() {
    let view = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$NodeData\n1\n\"u\"\n1\n0.0\n3\n0\n1\n1\n900 0\n\
                $EndNodeData\n";
    for text in [OLD, NEW] {
        assert_eq!(read(&format!("{text}{view}{view}")).unwrap(), read(text).unwrap());
        let second = ["a.msh:", "a second $MeshFormat with a mesh of its own", "keep one"];
        refused(&format!("{text}{text}"), &second);
    }
    refused(&format!("{view}{NEW}"), &["a second $MeshFormat with a mesh of its own"]);
}

#[test]
fn both_formats_give_the_same_body() {
    let old = read(OLD).unwrap();
    assert_eq!(old.nodes_m[2], [0.0, 1.0, 0.0]);
    assert_eq!(old.tetrahedra, [[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 3, 4]]);
    assert_eq!(old.groups["the skin"], [0, 1, 3]);
    assert_eq!(old.groups["body"], [0, 1, 2, 3, 4]);
    assert_eq!((&old.groups["9"], &old.groups["4"]), (&vec![1, 2, 3, 4], &vec![0]));
    assert_eq!(old.groups.len(), 4);
    let new = read(NEW).unwrap();
    assert_eq!(new.nodes_m, old.nodes_m);
    assert_eq!(new.tetrahedra, old.tetrahedra[..2]);
    assert_eq!(new.groups, old.groups);
}

#[test]
fn layout_of_the_text_is_free() {
    let crlf = OLD.replace('\n', "\r\n\r\n");
    assert_eq!(read(&crlf).unwrap(), read(OLD).unwrap());
    let unended = NEW.trim_end();
    assert_eq!(read(unended).unwrap(), read(NEW).unwrap());
    let plain = with(NEW, "$Entities", "$Unknown").replace("$EndEntities", "$EndUnknown");
    assert_eq!(read(&plain).unwrap().groups.len(), 0);
}

#[test]
fn coordinates_are_scaled_and_bounded() {
    let mm = parse(Path::new("a.msh"), OLD.as_bytes(), 0.001).unwrap();
    assert_eq!(mm.nodes_m[4], [0.001; 3]);
    for (bad, shown) in [("nan", "NaN"), ("inf", "inf"), ("1e400", "inf"), ("-1e39", "-1e39")] {
        let remedy = format!("a.msh:17: the z is {shown}");
        refused(&with(OLD, "3 0 0 1\n", &format!("3 0 0 {bad}\n")), &[&remedy, "`unit_m`"]);
    }
    for (bad, remedy) in [("0x1", "again"), ("1,5", "not a comma")] {
        let place = format!("a.msh:17: z is '{bad}'");
        refused(&with(OLD, "3 0 0 1\n", &format!("3 0 0 {bad}\n")), &[&place, remedy]);
    }
    refused(&with(NEW, "1 0 0 .5 .5 .5", "1 0"), &["a.msh:27: the line ends before z"]);
}

#[test]
fn element_types_that_are_not_read() {
    let ten = with(OLD, "3 4 2 1 1", "3 11 2 1 1");
    refused(&ten, &["a.msh:24: element 3 is a 10-node tetrahedron (type 11)", "ElementOrder = 1"]);
    refused(&with(NEW, "3 1 4 1", "3 1 11 1"), &["a.msh:39: each element", "(type 11)"]);
    for (kind, name) in [(3, "quadrangle"), (5, "hexahedron"), (6, "prism"), (7, "pyramid")] {
        let text = with(OLD, "4 4 2 1 1", &format!("4 {kind} 2 1 1"));
        refused(&text, &["a.msh:25: element 4", name, "RecombineAll"]);
    }
    refused(&with(OLD, "1 15 2", "1 99 2"), &["a.msh:22:", "type 99"]);
}

#[test]
fn bodies_without_volume() {
    let skin = "$Elements\n1\n1 2 2 7 1 900 7 3\n$EndElements\n";
    let head = &OLD[..OLD.find("$Elements").unwrap()];
    refused(&format!("{head}{skin}"), &["1 elements but no tetrahedra", "gmsh -3"]);
    refused(&format!("{head}$Elements\n0\n$EndElements\n"), &["no elements", "gmsh -3"]);
    refused(head, &["no elements"]);
    refused("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", &["a.msh: it has no nodes"]);
    refused("nothing\n", &["there is no $MeshFormat"]);
}

#[test]
fn formats_that_are_not_read() {
    refused(&with(NEW, "4.1 0 8", "4.1 1 8"), &["a.msh: byte 20: the bytes", "byte order"]);
    refused(&with(NEW, "4.1 0 8", "4.1 1 4"), &["a.msh:2: numbers of 4 bytes"]);
    refused(&with(NEW, "4.1 0 8", "4.1 2 8"), &["a.msh:2: file type 2"]);
    refused(&with(NEW, "4.1 0 8", "4 0 8"), &["a.msh:2: Gmsh format 4;", "msh41"]);
    refused(&with(OLD, "$MeshFormat", "$Other"), &["cut off"]);
    refused("$NOD\n1\n1 0 0 0\n$ENDNOD\n", &["a.msh:1: Gmsh format 1;", "msh41"]);
    let bytes = b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 \xff 0 0\n";
    let read = parse(Path::new("a.msh"), bytes, 1.0);
    assert_refused(read, &["a.msh:6: byte 3", "save the mesh again"]);
}

/// Names and comments in the encoding of older programs.
#[test]
fn names_in_latin_1_are_read() {
    for text in [OLD, NEW] {
        let text = with(text, "the skin", "die H\u{fc}lle").replace("made by", "f\u{fc}r");
        let latin: Vec<u8> = text.chars().map(|letter| letter as u32 as u8).collect();
        let wanted = read(&text).unwrap();
        assert_eq!(wanted.groups["die H\u{fc}lle"], [0, 1, 3]);
        assert_eq!(parse(Path::new("a.msh"), &latin, 1.0).unwrap(), wanted);
    }
}

#[test]
fn references_and_tags() {
    let unknown = with(OLD, "900 7 18446744073709551615 3\n", "900 8 12 3\n");
    refused(&unknown, &["a.msh:24: element 3 refers to node tag 8"]);
    refused(&with(OLD, "7 1 0 0", "900 1 0 0"), &["a.msh:15: node tag 900 is given twice"]);
    refused(&with(NEW, "12\n1 0 0", "3\n1 0 0"), &["a.msh:26: node tag 3 is given twice"]);
    refused(&with(NEW, "3 900 7 1", "3 900 3 1"), &["a.msh:40: element 3", "a node twice"]);
    refused(&with(OLD, "7 1 0 0", "-7 1 0 0"), &["a.msh:15: the node tag is '-7'"]);
}

#[test]
fn counts_that_lie() {
    let huge = "18446744073709551615";
    for (text, count, line) in
        [(OLD, "$Nodes\n5", 19), (OLD, "$Elements\n6", 28), (OLD, "$PhysicalNames\n2", 11)]
    {
        let name = count.split('\n').next().unwrap();
        let more = with(text, count, &format!("{name}\n{huge}"));
        refused(&more, &[&format!("a.msh:{line}: "), "fewer lines than it says"]);
        let fewer = with(text, count, &format!("{name}\n1"));
        refused(&fewer, &["has more than it says"]);
        let negative = with(text, count, &format!("{name}\n-5"));
        refused(&negative, &["is '-5'", "whole number"]);
    }
    refused(&with(NEW, "2 5 3 900", "2 6 3 900"), &["says 6 nodes, its blocks have 5"]);
    refused(&with(NEW, "2 5 3 900", &format!("{huge} 5 3 900")), &["fewer lines"]);
    refused(&with(NEW, "3 1 1 4", &format!("3 1 1 {huge}")), &["the line goes on with '0'"]);
    refused(&with(NEW, "5 5 1 6", "5 7 1 6"), &["says 7 elements"]);
    refused(
        &with(OLD, "2 2 2 7 1 900", &format!("2 2 {huge} 7 1 900")),
        &["a.msh:23: the line ends"],
    );
}

#[test]
fn what_is_cut_off_says_in_which_section() {
    for text in [OLD, NEW] {
        let middle = text.find("900 7 18446").unwrap();
        refused(&text[..middle], &["$Elements", "cut off"]);
        let between = text.find("\n900 0 0 0\n").or(text.find("\n0 0 0\n")).unwrap();
        refused(&text[..between], &["the file ends in $Nodes before", "cut off"]);
    }
}
