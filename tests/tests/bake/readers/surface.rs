//! Surface files, `.stl`, `.obj` and `.ply`: the same tetrahedron in each, whole, wrong and damaged.

use super::*;
use chaincell_host::mesh::{Filling, MeshOptions, from_bytes};

const PLACES: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
const TRIANGLES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn text_stl() -> Vec<u8> {
    let mut text = "solid a name\n".to_owned();
    for triangle in TRIANGLES {
        text += "facet normal nan 0 0\n outer loop\n";
        for [x, y, z] in triangle.map(|at| PLACES[at]) {
            text += &format!("  vertex {x} {y:e} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    (text + "endsolid a name\n").into_bytes()
}

/// Begins as a text does.
fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(4_u32.to_le_bytes());
    for triangle in TRIANGLES {
        bytes.extend([0; 12]);
        triangle
            .iter()
            .for_each(|at| PLACES[*at].iter().for_each(|x| bytes.extend(x.to_le_bytes())));
        bytes.extend([0; 2]);
    }
    bytes
}

const OBJ: &str = "# made by hand
mtllib a.mtl
o body
v 0 0 0
v 1 0 0 1.0
v 0 1 0 # third
v 0 0 1
vt 0.5 0.5
vn 0 0 1
f 1/1 3/1 2/1
f 1//1 2//1 4//1
f -4 -1 -2
f 2/1/1 3/1/1 4/1/1
";

fn ply_head(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nobj_info none\nelement vertex 4\n\
         property float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 4\n\
         property list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\n\
         property list uint8 float64 rest\nend_header\n"
    )
}

fn text_ply() -> Vec<u8> {
    let mut text = ply_head("ascii");
    PLACES.iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z} 255\n"));
    TRIANGLES.iter().for_each(|[a, b, c]| text += &format!("3 {a} {b} {c}\n"));
    (text + "7 2 0.5 0.5\n").into_bytes()
}

fn binary_ply(little: bool) -> Vec<u8> {
    let order = if little { "little" } else { "big" };
    let mut bytes = ply_head(&format!("binary_{order}_endian")).into_bytes();
    let mut put = |number: &[u8]| {
        let mut number = number.to_vec();
        if !little {
            number.reverse();
        }
        bytes.extend(number);
    };
    for place in PLACES {
        place.iter().for_each(|x| put(&x.to_le_bytes()));
        put(&[255]);
    }
    for triangle in TRIANGLES {
        put(&[3]);
        triangle.iter().for_each(|at| put(&(*at as i32).to_le_bytes()));
    }
    put(&7_i32.to_le_bytes());
    put(&[1]);
    put(&0.5_f64.to_le_bytes());
    bytes
}

pub(super) fn files() -> [(&'static str, Vec<u8>); 6] {
    [
        ("a.stl", text_stl()),
        ("a.stl", binary_stl()),
        ("a.obj", OBJ.into()),
        ("a.ply", text_ply()),
        ("a.ply", binary_ply(true)),
        ("a.ply", binary_ply(false)),
    ]
}

pub(super) fn fill(name: &str, bytes: &[u8]) -> Result<Mesh> {
    let options = MeshOptions {
        filling: Some(Filling::even(0.08)),
        nodes_max: 2_000,
        ..MeshOptions::default()
    };
    from_bytes(name, bytes, &options)
}

#[track_caller]
fn refused(name: &str, bytes: &[u8], parts: &[&str]) {
    assert_refused(fill(name, bytes).map(|_| RawMesh::default()), parts);
}

#[track_caller]
fn with(text: &[u8], from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(text.to_vec()).unwrap();
    assert!(text.contains(from), "{from} is not in the text");
    text.replacen(from, to, 1).into_bytes()
}

#[test]
fn all_formats_give_the_same_body() {
    let wanted = fill("a.stl", &text_stl()).unwrap();
    let filled = wanted.filled.as_ref().unwrap();
    assert!((filled.volume_m3 - 1.0 / 6.0).abs() < 1e-15 && filled.triangles == 4);
    for (name, bytes) in files() {
        let body = fill(name, &bytes).unwrap();
        assert_eq!(body.tetrahedra, wanted.tetrahedra, "{name}");
        let same = body.nodes_m.iter().flatten().zip(wanted.nodes_m.iter().flatten());
        assert!({ same }.all(|(a, b)| (a - b).abs() < 1e-9), "{name}");
    }
    // What a file is its content tells, whatever its name says.
    let plain = [b"a\0\0\0\0\0", &binary_stl()[6..]].concat();
    for (name, bytes) in [("a.obj", plain.clone()), ("a", plain), ("a.stl", text_ply())] {
        assert_eq!(fill(name, &bytes).unwrap().tetrahedra, wanted.tetrahedra, "{name}");
    }
    let wide = with(&text_ply(), "uchar red", "uint64 red");
    assert_eq!(fill("a.ply", &wide).unwrap().tetrahedra, wanted.tetrahedra);
    let crlf = String::from_utf8(text_stl()).unwrap().replace('\n', "\r\n");
    assert_eq!(fill("a.stl", crlf.as_bytes()).unwrap().tetrahedra, wanted.tetrahedra);
}

#[test]
fn what_is_not_read_names_the_place_and_the_remedy() {
    let stl = |from: &str, to: &str, parts: &[&str]| {
        refused("a.stl", &with(&text_stl(), from, to), parts)
    };
    stl("facet", "faces", &["a.stl:2: 'faces' where facet or endsolid should be"]);
    stl("outer", "inner", &["a.stl:3: 'inner' where outer should be"]);
    stl("vertex 0 0e0 0", "vertex 0 inf 0", &["a.stl:4: the y is inf", "`unit_m`"]);
    stl("vertex 0 0e0 0", "vertex 0 zero 0", &["a.stl:4: y is 'zero'"]);
    stl("endsolid a name", "", &["a.stl:31: the file ends", "cut off"]);
    refused("a.stl", b"solid\nendsolid\n", &["a.stl: it has no triangles"]);
    refused("a.stl", b"a text\n", &["a.stl: a text that does not begin with 'solid'", ".obj"]);
    // A binary file of another length than it says, which begins as a text does.
    let longer = [&binary_stl()[..], b"xx"].concat();
    refused("a.stl", &longer, &["2 bytes behind the last of 4 triangles"]);
    refused("a.stl", &[0; 20], &["a.stl: byte 20: the file ends", "cut off"]);
    let mut many = binary_stl();
    many[80..84].fill(0xff);
    refused("a.stl", &with_zero(many), &["a.stl: byte 80: 4294967295 triangles", "bytes are left"]);
    let longer = [&[0; 1], &binary_stl()[1..], b"xx"].concat();
    refused("a.stl", &longer, &["2 bytes behind the last of 4 triangles"]);
    let obj = |from: &str, to: &str, parts: &[&str]| {
        refused("a.obj", &with(OBJ.as_bytes(), from, to), parts)
    };
    obj("f 1//1 2//1 4//1", "f 1 2 5", &["a.obj:11: '5'", "1 to 4"]);
    obj("f 1//1 2//1 4//1", "f 0 2 4", &["a.obj:11: '0'"]);
    obj("f -4 -1 -2", "f -5 -1 -2", &["a.obj:12: '-5'"]);
    obj("f -4 -1 -2", "f 1 2", &["a.obj:12: a face of 2 corners"]);
    obj("f -4 -1 -2", "f 1 2 \\", &["a.obj:12: a line that goes on"]);
    obj("v 0 0 1", "v 0 0", &["a.obj:7: z is ''"]);
    obj("v 0 0 1", "v 0 0 nan", &["a.obj:7: the z is NaN"]);
    refused("a.obj", b"v 0 0 \xff\n", &["a.obj:1: byte 7 of the line is no UTF-8"]);
    let ply = |from: &str, to: &str, parts: &[&str]| {
        refused("a.ply", &with(&text_ply(), from, to), parts)
    };
    ply("ply", "PLY", &["a.ply:1: its first line is not 'ply'"]);
    ply("ascii 1.0", "ascii 2.0", &["a.ply:2: 'format ascii 2.0'"]);
    ply("property float x", "property half x", &["a.ply:6: 'property half x'"]);
    ply("property float x", "property float u", &["a.ply:16:", "without x, y or z"]);
    ply("element vertex 4", "element vertex -4", &["a.ply:5:", "'-4'"]);
    ply("element vertex 4", "element vertex 18446744073709551615", &["bytes are left"]);
    ply("element vertex 4", "element vertex 3", &["a.ply:19:"]);
    ply("3 0 2 1", "3 0 2 4", &["a.ply:20: vertex 4 of a face", "0 to 3"]);
    ply("3 0 2 1", "3 0 2 1.5", &["a.ply:20:", "'1.5'"]);
    ply("3 0 2 1", "4000000000 0 2 1", &["a.ply:20: 4000000000 numbers of a list"]);
    ply("0 0 1 255", "0 0 nan 255", &["a.ply:19: the z is NaN", "`unit_m`"]);
    ply("element edge 1", "element tristrips 1", &["strips of triangles"]);
    let at = ply_head("binary_little_endian").len();
    let mut bytes = binary_ply(true);
    bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    refused("a.ply", &bytes, &[&format!("a.ply: byte {at}: the x is NaN")]);
    for (name, _) in files() {
        refused(name, b"", &[name, "empty"]);
        refused(name, b"\x1f\x8b\x08\0", &[name, "gunzip"]);
    }
}

/// Not beginning as a text does.
fn with_zero(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes[0] = 0;
    bytes
}

/// As programs write them that follow the format loosely.
#[test]
fn loose_texts_give_the_same_body() {
    let wanted = fill("a.stl", &text_stl()).unwrap();
    let text = String::from_utf8(text_stl()).unwrap();
    let changes: [&[(&str, &str)]; 8] = [
        &[("endsolid", "end solid")],
        &[("endfacet", "end facet"), ("endloop", "END LOOP")],
        &[("facet normal nan 0 0", "facet")],
        &[("facet normal nan 0 0", "facet normal")],
        &[("solid a name", "solid")],
        &[("solid a name", "  SOLID\t\"a name\"\n")],
        &[("\n", "\r")],
        &[("  vertex", "\t\tVertex"), ("normal nan 0 0\n", "normal -nan(ind) 1.#QNAN 0 ")],
    ];
    for change in changes {
        let loose = change.iter().fold(text.clone(), |text, (from, to)| text.replace(from, to));
        assert_ne!(loose, text);
        let body = fill("a.stl", loose.as_bytes()).unwrap();
        assert_eq!(body.tetrahedra, wanted.tetrahedra, "{change:?}");
    }
    let loose = text.replace("endfacet", "end face");
    refused("a.stl", loose.as_bytes(), &["a.stl:8: 'end' where endfacet should be"]);
    let short = text.replacen("  vertex 0 1e0 0\n", "", 1);
    refused("a.stl", short.as_bytes(), &["'endloop' where vertex should be"]);
    // Names of objects and materials in any encoding.
    let named = [b"o K\xf6rper\nusemtl \xff\n".as_slice(), OBJ.as_bytes()].concat();
    let obj = fill("a.obj", OBJ.as_bytes()).unwrap();
    assert_eq!(fill("a.obj", &named).unwrap().tetrahedra, obj.tetrahedra);
}

/// A box whose upper face is drawn as one polygon, which runs through itself as its normal sees it.
#[test]
fn a_face_that_is_not_flat_is_cut() {
    let options = MeshOptions { filling: Some(Filling::even(0.006)), ..MeshOptions::default() };
    let read = |text: &str| from_bytes("a.obj", text.as_bytes(), &options);
    let whole = read(&format!("{TWISTED}f 9 10 11 12\n")).unwrap();
    let cut = read(&format!("{TWISTED}f 9 10 11\nf 9 11 12\n")).unwrap();
    let volumes = [whole, cut].map(|mesh| mesh.filled.unwrap().volume_m3);
    assert!((volumes[0] / volumes[1] - 1.0).abs() < 0.01, "{volumes:?}");
    // What has no area, or crosses in its own plane, later checks refuse with its place.
    for face in ["f 9 10 9 12\n", "f 9 11 10 12\n"] {
        let why = read(&format!("{TWISTED}{face}")).unwrap_err().to_string();
        assert!(why.contains("a.obj: ") && why.contains('('), "{why}");
    }
}

const TWISTED: &str = "v 0 0 0\nv 0.04 0 0\nv 0.04 0.04 0\nv 0 0.04 0\nv 0 0 0.04\nv 0.04 0 0.04\n\
    v 0.04 0.04 0.04\nv 0 0.04 0.04\nv 0 0.02 0.037079\nv 0.04 0.02 0.0420248\n\
    v 0.04 0.0212621 0.0385561\nv 0 0.0202958 0.042921\nf 1 3 2\nf 1 4 3\nf 5 6 10\nf 5 10 9\n\
    f 12 11 7\nf 12 7 8\nf 1 2 6\nf 1 6 5\nf 3 4 8\nf 3 8 7\nf 2 3 7\nf 2 7 11\nf 2 11 10\n\
    f 2 10 6\nf 4 1 5\nf 4 5 9\nf 4 9 12\nf 4 12 8\n";
