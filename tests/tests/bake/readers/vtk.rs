use super::*;

/// Two tetrahedra over one face, a triangle and a vertex, with data behind.
pub(super) const TEXT: &str = "# vtk DataFile Version 3.0
a title of any kind: \u{fc}
ASCII
DATASET UNSTRUCTURED_GRID
FIELD FieldData 2
TIME 1 1 double
0.5
NOTE 2 3 int
1 2 3
4 5 6
POINTS 5 float
0 0 0 1 0 0 0 1 0
0 0 1
1 1 1
METADATA
INFORMATION 0

CELLS 4 16
1 0
3 0 1 3
4 0 1 2 3
4 1 2 3 4
CELL_TYPES 4
1 5 10 10
CELL_DATA 4
SCALARS anything float 1
";

const TETRAHEDRA: [[u32; 4]; 2] = [[0, 1, 2, 3], [1, 2, 3, 4]];

fn be_ints(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_be_bytes()).collect()
}

fn be_longs(numbers: &[i64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_be_bytes()).collect()
}

fn be_floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_be_bytes()).collect()
}

const POINTS: [f32; 15] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 1., 1., 1.];

fn head(version: &str) -> Vec<u8> {
    let head = format!(
        "# vtk DataFile Version {version}\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\n\
         FIELD FieldData 1\nTIME 1 1 float\n"
    );
    [head.as_bytes(), &be_floats(&[0.5]), b"\nPOINTS 5 float\n", &be_floats(&POINTS)].concat()
}

/// The same body, binary; without an end of line behind the numbers, which some writers leave out.
pub(super) fn lists() -> Vec<u8> {
    let cells = be_ints(&[1, 0, 3, 0, 1, 3, 4, 0, 1, 2, 3, 4, 1, 2, 3, 4]);
    let types = be_ints(&[1, 5, 10, 10]);
    [&head("3.0")[..], b"CELLS 4 16\n", &cells, b"\nCELL_TYPES 4\n", &types].concat()
}

/// The same with offsets and connectivity.
pub(super) fn offsets() -> Vec<u8> {
    let nodes = be_longs(&[0, 0, 1, 3, 0, 1, 2, 3, 1, 2, 3, 4]);
    [
        &head("5.1")[..],
        b"\nCELLS 5 12\nOFFSETS vtktypeint64\n",
        &be_longs(&[0, 1, 4, 8, 12]),
        b"\nCONNECTIVITY vtktypeint64\n",
        &nodes,
        b"\nCELL_TYPES 4\n",
        &be_ints(&[1, 5, 10, 10]),
        b"\n\nPOINT_DATA 5\n",
    ]
    .concat()
}

fn read(bytes: &[u8]) -> Result<RawMesh> {
    parse(Path::new("a.vtk"), bytes, 1.0)
}

#[track_caller]
fn refused(bytes: &[u8], parts: &[&str]) {
    assert_refused(read(bytes), parts);
}

#[track_caller]
fn with(from: &str, to: &str) -> Vec<u8> {
    assert!(TEXT.contains(from), "{from} is not in the text");
    TEXT.replacen(from, to, 1).into_bytes()
}

#[test]
fn all_codings_give_the_same_body() {
    let text = read(TEXT.as_bytes()).unwrap();
    assert_eq!((text.nodes_m.len(), &text.tetrahedra[..]), (5, &TETRAHEDRA[..]));
    assert_eq!(text.nodes_m[4], [1.0; 3]);
    assert!(text.groups.is_empty());
    assert_eq!(read(&lists()).unwrap(), text);
    assert_eq!(read(&offsets()).unwrap(), text);
    let mm = parse(Path::new("a.vtk"), &offsets(), 0.001).unwrap();
    assert_eq!(mm.nodes_m[4], [0.001; 3]);
}

/// Whole numbers of a known name are groups, behind whatever else is attached.
#[test]
fn numbers_of_the_cells_are_groups() {
    let attached = |data: &str| {
        let text = with("CELL_DATA 4\nSCALARS anything float 1\n", data);
        read(&text).map(|body| body.groups)
    };
    let wanted = [("1", vec![0, 1, 3]), ("2", vec![1, 2, 3, 4])];
    let wanted = wanted.map(|(name, nodes)| (name.to_owned(), nodes)).into();
    for data in [
        "CELL_DATA 4\nSCALARS CellEntityIds int 1\nLOOKUP_TABLE default\n0 1 0 2\n",
        "CELL_DATA 4\nSCALARS material long\nLOOKUP_TABLE default\n0 1 0 2\n",
        "POINT_DATA 5\nSCALARS heat float\nLOOKUP_TABLE default\n1 2 3 4 5\nCELL_DATA 4\n\
         FIELD FieldData 2\nmaterial 2 4 int\n1 2 3 4 5 6 7 8\ngmsh:physical 1 4 int\n0 1 0 2\n",
        // Real numbers that are whole ones, and an array in front with one that is not.
        "CELL_DATA 4\nSCALARS material float 1\nLOOKUP_TABLE default\n0 1 -0.0 2e0\n",
        "CELL_DATA 4\nFIELD f 2\nmaterial 1 4 double\n0 1.5 0 2\ntetgen:ref 1 4 char\n0 1 0 2\n",
        "CELL_DATA 4\nSCALARS region double\nLOOKUP_TABLE default\n0 nan 0 2\n\
         SCALARS group unsigned_char\nLOOKUP_TABLE default\n0 1 0 2\n",
        // Gmsh's cells without a group.
        "CELL_DATA 4\nSCALARS CellEntityIds int 1\nLOOKUP_TABLE default\n-1 1 -1 2\n",
        // What VTK writes in front of a field where it is active.
        "CELL_DATA 4\nVECTORS v double\n0 0 0 1 1 1 2 2 2 3 3 3\nTENSORS t float\n\
         0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n\
         GLOBAL_IDS i vtkIdType\n0 1 2 3\nLOOKUP_TABLE own 1\n0 0 0 1\n\
         FIELD FieldData 1\nMaterialIds 1 4 short\n0 1 0 2\n",
    ] {
        assert_eq!(attached(data).unwrap(), wanted, "{data}");
    }
    for data in [
        "CELL_DATA 3\nSCALARS material int 1\nLOOKUP_TABLE default\n0 1 0\n",
        "CELL_DATA 4\nSCALARS material float 1\nLOOKUP_TABLE default\n0 1.5 0 2\n",
        "CELL_DATA 4\nSCALARS material double 1\nLOOKUP_TABLE default\n0 1e300 0 2\n",
        "CELL_DATA 4\nVECTORS material int\n0 1 0 2\n",
        "POINT_DATA 5\nSCALARS material int 1\nLOOKUP_TABLE default\n0 1 0 2 3\n",
    ] {
        assert_eq!(attached(data).unwrap(), [].into(), "{data}");
    }
    let negative = attached("CELL_DATA 4\nFIELD f 1\nmedit:ref 1 4 int\n0 -1 0 -7\n").unwrap();
    assert_eq!((&negative["-1"], &negative["-7"]), (&vec![0, 1, 3], &vec![1, 2, 3, 4]));
    let half = attached("CELL_DATA 4\nSCALARS material int 1\nLOOKUP_TABLE default\n0 1\n");
    assert!(half.unwrap_err().to_string().contains("the groups of the cells"));
    let words = attached("CELL_DATA 4\nFIELD f 1\ngroup 1 4 int\n0 a 1 2\n");
    assert!(words.unwrap_err().to_string().contains("'a'"));
    let parts = attached("CELL_DATA 4\nFIELD f 1\ngroup 1 4 int\n0 1.5 1 2\n");
    assert!(parts.unwrap_err().to_string().contains("a.vtk:28: the group of a cell is '1.5'"));
}

/// Numbers of every type in binary, as programs choose the smallest that holds their groups.
#[test]
fn binary_groups_of_every_type() {
    let body = |kind: &str, numbers: &[u8]| {
        let head = format!("\nCELL_DATA 4\nFIELD f 1\nregion 1 4 {kind}\n");
        read(&[&lists()[..], head.as_bytes(), numbers].concat()).map(|body| body.groups)
    };
    let signed = [("-3", vec![1, 2, 3, 4]), ("1", vec![0, 1, 3])];
    let signed = signed.map(|(name, nodes)| (name.to_owned(), nodes)).into();
    let wide = |of: fn(i16) -> Vec<u8>| [0, 1, 0, -3].into_iter().flat_map(of).collect::<Vec<u8>>();
    for (kind, numbers) in [
        ("char", wide(|n| (n as i8).to_be_bytes().into())),
        ("short", wide(|n| n.to_be_bytes().into())),
        ("int", wide(|n| i32::from(n).to_be_bytes().into())),
        ("vtktypeint64", wide(|n| i64::from(n).to_be_bytes().into())),
        ("float", wide(|n| f32::from(n).to_be_bytes().into())),
        ("double", wide(|n| f64::from(n).to_be_bytes().into())),
    ] {
        assert_eq!(body(kind, &numbers).unwrap(), signed, "{kind}");
    }
    for (kind, name, numbers) in [
        ("unsigned_char", "253", wide(|n| (n as u8).to_be_bytes().into())),
        ("unsigned_short", "65533", wide(|n| (n as u16).to_be_bytes().into())),
        ("unsigned_int", "65533", wide(|n| u32::from(n as u16).to_be_bytes().into())),
        ("unsigned_long", "65533", wide(|n| u64::from(n as u16).to_be_bytes().into())),
    ] {
        assert_eq!(body(kind, &numbers).unwrap()[name], [1, 2, 3, 4], "{kind}");
    }
    let huge = body("unsigned_long", &[0xff; 32]).unwrap_err().to_string();
    assert!(huge.contains("is '18446744073709551615'"), "{huge}");
}

#[test]
fn headers_that_are_not_read() {
    refused(&with("# vtk", "# VTK"), &["a.vtk:1:", "its first line"]);
    refused(&with("Version 3.0", "Version 6.0"), &["version '6.0'"]);
    refused(&with("ASCII", "ASCI"), &["a.vtk:3: 'ASCI'"]);
    refused(&with("UNSTRUCTURED_GRID", "POLYDATA"), &["a.vtk:4:", "UNSTRUCTURED_GRID"]);
    refused(&with("POINTS 5 float", "POINTS 5 int"), &["a.vtk:11: points of type 'int'"]);
    refused(&with("TIME 1 1 double", "TIME 1 1 string"), &["a.vtk:6:", "'string'"]);
}

#[test]
fn cells_that_are_not_read() {
    for (number, name) in [("12", "hexahedron"), ("24", "10-node tetrahedron"), ("99", "another")] {
        refused(&with("1 5 10 10", &format!("1 5 {number} 10")), &["cell 2 is a", name]);
    }
    refused(&with("1 5 10 10", "1 9 10 10"), &["cell 1 of type 9 has 3 nodes"]);
    refused(&with("1 5 10 10", "1 7 7 7"), &["4 cells but no tetrahedra"]);
    refused(&with("4 0 1 2 3", "4 0 1 2 5"), &["cell 2 refers to point 5"]);
    refused(&with("4 0 1 2 3", "4 0 1 1 3"), &["cell 2", "a node twice"]);
    refused(&with("4 0 1 2 3", "4 0 1 -2 3"), &["a.vtk:21:", "is '-2'"]);
    refused(&with("CELL_TYPES 4\n1 5 10 10", "CELL_TYPES 2\n10 10"), &["4 CELLS and 2"]);
    for bad in ["nan", "inf", "1e39"] {
        refused(&with("0 0 1\n", &format!("0 0 {bad}\n")), &["a.vtk:13: the z is", "`unit_m`"]);
    }
    refused(&with("0 0 1\n", "0 0 x\n"), &["a.vtk:13: z is 'x'; it must be a number"]);
}

#[test]
fn counts_that_lie_are_refused_before_anything_is_read() {
    for name in ["POINTS 5", "CELLS 4 16", "CELL_TYPES 4", "NOTE 2 3"] {
        let (front, _) = name.rsplit_once(' ').unwrap();
        for count in ["4000000000000", "18446744073709551615"] {
            let text = with(name, &format!("{front} {count}"));
            refused(&text, &["bytes are left"]);
        }
        refused(&with(name, &format!("{front} -1")), &["is '-1'", "whole number"]);
    }
    refused(&with("CELLS 4 16", "CELLS 4 15"), &["size is 15, too little for cell 3"]);
    refused(&with("CELLS 4 16", "CELLS 4000000000000 16"), &["too little for cell 4"]);
    refused(&with("CELLS 4 16", "CELLS 3 16"), &["5 more than the 3 cells have"]);
    refused(&with("POINTS 5", "POINTS 4"), &["'1' where a section should begin"]);
    let mut file = offsets();
    let at = behind(&file, "OFFSETS vtktypeint64\n");
    file[at + 15] = 9;
    refused(&file, &["the offset 4 behind 9"]);
    file[at + 15] = 1;
    file[at + 39] = 11;
    refused(&file, &["do not run from 0 to 12"]);
    let point = behind(&lists(), "POINTS 5 float\n");
    refused(&lists()[..point + 9], &["5 points", "bytes are left", "cut off"]);
    let mut file = lists();
    file[point..point + 4].copy_from_slice(&f32::NAN.to_be_bytes());
    refused(&file, &[&format!("a.vtk: byte {point}: the x is NaN"), "`unit_m`"]);
}
