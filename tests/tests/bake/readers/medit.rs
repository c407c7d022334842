//! Medit meshes, `.mesh`.

use super::*;

const TEXT: &str = "MeshVersionFormatted 2 # version
# a comment
Dimension 3
Corners
2
1 5
Vertices
5
0 0 0 0
1 0 0 3
0 1 0 0
0 0 1 0
1 1 1 -2
Triangles
1
1 2 4 7
Tetrahedra
2
1 2 3 4 0
2 3 4 5 9
Normals 1
0 0 1
End
";

fn read(text: &str) -> Result<RawMesh> {
    parse(Path::new("a.mesh"), text.as_bytes(), 1.0)
}

#[track_caller]
fn refused(from: &str, to: &str, parts: &[&str]) {
    assert!(TEXT.contains(from), "{from} is not in the text");
    assert_refused(read(&TEXT.replacen(from, to, 1)), parts);
}

#[test]
fn references_are_groups_and_other_sections_are_passed_over() {
    let body = read(TEXT).unwrap();
    assert_eq!(body.nodes_m[4], [1.0; 3]);
    assert_eq!(body.tetrahedra, [[0, 1, 2, 3], [1, 2, 3, 4]]);
    let wanted = [
        ("7", vec![0, 1, 3]),
        ("9", vec![1, 2, 3, 4]),
        ("points:-2", vec![4]),
        ("points:3", vec![1]),
    ];
    assert_eq!(body.groups, wanted.map(|(name, nodes)| (name.to_owned(), nodes)).into());
    assert_eq!(read(&TEXT.replace('\n', "\r\n \r\n")).unwrap(), body);
    assert_eq!(parse(Path::new("a"), TEXT.as_bytes(), 1.0).unwrap(), body);
    assert_eq!(read(TEXT.strip_suffix("End\n").unwrap()).unwrap(), body);
}

#[test]
fn what_is_not_read_names_line_and_remedy() {
    refused("MeshVersionFormatted", "MeshVersion", &["a.mesh:1: 'MeshVersion'", "no Medit file"]);
    refused("Formatted 2", "Formatted 9", &["a.mesh:1: version 9"]);
    refused("Dimension 3", "Dimension 2", &["a.mesh:7: vertices of dimension 2", "Dimension 3"]);
    refused("1 0 0 3", "1 0 nan 3", &["a.mesh:10: the z is NaN", "`unit_m`"]);
    refused("1 0 0 3", "1 x 0 3", &["a.mesh:10: y is 'x'"]);
    refused("1 0 0 3", "1 0 0 3.5", &["a.mesh:10: the reference number is '3.5'"]);
    refused("2 3 4 5 9", "2 3 4 6 9", &["a.mesh:20: vertex 6", "1 to 5"]);
    refused("2 3 4 5 9", "2 3 4 0 9", &["a.mesh:20: vertex 0"]);
    refused("2 3 4 5 9", "2 3 3 5 9", &["a.mesh:20:", "twice"]);
    refused("Vertices\n5", "Vertices\n4", &["a.mesh:13: '1' where a section should begin"]);
    refused("Vertices\n5", "Vertices\n6", &["a.mesh:14: x is 'Triangles'"]);
    refused("Vertices\n5", "Vertices\n99999999999999", &["a.mesh:8:", "bytes are left"]);
    refused("Tetrahedra\n2", "Tetrahedra\n18446744073709551615", &["a.mesh:18:", "bytes are left"]);
    refused("Tetrahedra\n2", "Tetrahedra\n-2", &["a.mesh:18:", "'-2'"]);
    refused("Triangles\n1\n1 2 4 7", "Hexahedra\n1\n1 2 3 4 5 1 2 3 0", &["a.mesh:15:", "split"]);
    refused("Normals 1", "TetrahedraP2 1", &["a.mesh:21:", "linear elements"]);
    let text = TEXT.split("Tetrahedra").next().unwrap();
    assert_refused(read(text), &["a.mesh", "1 triangles and edges but no Tetrahedra", "volume"]);
    assert_refused(read("MeshVersionFormatted 2\nDimension 3\nEnd"), &["no Vertices"]);
    for bytes in [[1, 0, 0, 0], [0, 0, 0, 1]] {
        let read = parse(Path::new("a.meshb"), &bytes, 1.0);
        assert_refused(read, &["a.meshb", "binary", "meshio convert"]);
    }
    assert_refused(parse(Path::new("a.mesh"), b"Mesh\xff\xfe", 1.0), &["a.mesh:1:"]);
}
