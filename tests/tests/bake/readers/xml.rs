//! VTK XML files, `.vtu`.

use super::*;

/// Two tetrahedra over one face and a triangle, with groups.
const TEXT: &str = r#"<?xml version="1.0"?>
<!-- a comment -->
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid>
<Piece NumberOfPoints="5" NumberOfCells="3">
<Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0
0 0 1
1 1 1
</DataArray>
</Points>
<Cells>
<DataArray type="Int32" Name="connectivity" format="ascii">0 1 3 0 1 2 3 1 2 3 4</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">3 7 11</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">5 10 10</DataArray>
</Cells>
<CellData>
<DataArray type="Float64" Name="heat" format="ascii">1 2 3</DataArray>
<DataArray type="Int32" Name="material" format="ascii">4 0 2</DataArray>
</CellData>
</Piece>
</UnstructuredGrid>
</VTKFile>
"#;

fn read(text: &str) -> Result<RawMesh> {
    parse(Path::new("a.vtu"), text.as_bytes(), 1.0)
}

#[track_caller]
fn with(from: &str, to: &str) -> String {
    assert!(TEXT.contains(from), "{from} is not in the text");
    TEXT.replacen(from, to, 1)
}

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    assert_refused(read(text), parts);
}

#[test]
fn a_text_is_read_with_its_groups() {
    let body = read(TEXT).unwrap();
    assert_eq!(body.nodes_m[4], [1.0; 3]);
    assert_eq!(body.tetrahedra, [[0, 1, 2, 3], [1, 2, 3, 4]]);
    let wanted = [("2", vec![1, 2, 3, 4]), ("4", vec![0, 1, 3])];
    assert_eq!(body.groups, wanted.map(|(name, nodes)| (name.to_owned(), nodes)).into());
    assert_eq!(read(&TEXT.replace('\n', "\r\n")).unwrap(), body);
    assert_eq!(read(&with("material", "Material")).unwrap(), body);
    assert!(read(&with("material", "other")).unwrap().groups.is_empty());
    let mm = parse(Path::new("a"), TEXT.as_bytes(), 0.001).unwrap();
    assert_eq!(mm.nodes_m[4], [0.001; 3]);
}

/// Whole numbers of either sign and any type; an array with a fraction holds none.
#[test]
fn groups_of_any_number() {
    let groups = |from: &str, to: &str| {
        let groups = read(&with(from, to)).unwrap().groups;
        groups.into_iter().collect::<Vec<(String, Vec<u32>)>>()
    };
    let wanted = |first: &str, second: &str| {
        [(first.to_owned(), vec![0, 1, 3]), (second.to_owned(), vec![1, 2, 3, 4])]
    };
    let array = "Int32\" Name=\"material\" format=\"ascii\">4 0 2";
    assert_eq!(groups("4 0 2", "-1 0 -7"), wanted("-1", "-7"));
    let real = "Float64\" Name=\"material\" format=\"ascii\">4.0 0 8e0";
    assert_eq!(groups(array, real), wanted("4", "8"));
    let gmsh = "Int32\" Name=\"CellEntityIds\" format=\"ascii\">4 -1 8";
    assert_eq!(groups(array, gmsh), wanted("4", "8"));
    let fraction = "Float64\" Name=\"material\" format=\"ascii\">4.5 0 2";
    assert!(groups(array, fraction).is_empty());
    let next = format!("{fraction}</DataArray>\n<DataArray type=\"Int8\" Name=\"region\">4 0 8");
    assert_eq!(groups(array, &next), wanted("4", "8"));
    // Of each signed type -3, in base64 behind the number of bytes.
    for (kind, text) in [
        ("Int8", "AwAAAAQA/Q=="),
        ("Int16", "BgAAAAQAAAD9/w=="),
        ("Int32", "DAAAAAQAAAAAAAAA/f///w=="),
        ("Int64", "GAAAAAQAAAAAAAAAAAAAAAAAAAD9/////////w=="),
    ] {
        let binary = format!("{kind}\" Name=\"material\" format=\"binary\">{text}");
        let found = read(&with(array, &binary)).unwrap().groups;
        assert_eq!((&found["4"], &found["-3"]), (&vec![0, 1, 3], &vec![1, 2, 3, 4]), "{kind}");
    }
    // Above those of an i64 there is no group.
    let huge =
        "UInt64\" Name=\"material\" format=\"binary\">GAAAAP//////////BAAAAAAAAAAEAAAAAAAAAA==";
    assert!(groups(array, huge).is_empty());
}

#[test]
fn heads_that_are_not_read() {
    refused("no XML at all", &["a.vtu", "no sound XML"]);
    refused(&with("</Piece>", ""), &["a.vtu", "no sound XML", "save or copy"]);
    refused(&with("type=\"UnstructuredGrid\"", "type=\"PolyData\""), &["PolyData", "volume mesh"]);
    refused(&with("VTKFile type", "VTKFile byte type"), &["no sound XML"]);
    refused(&with("LittleEndian", "Middle"), &["a.vtu:3:", "byte_order 'Middle'"]);
    refused(&with(" byte_order", " header_type=\"UInt8\" byte_order"), &["header_type 'UInt8'"]);
    refused(
        &with(" byte_order", " compressor=\"vtkLZ4DataCompressor\" byte_order"),
        &["a.vtu:3:", "vtkLZ4DataCompressor", "vtkZLibDataCompressor and none", "one of these"],
    );
    refused(&with("<Piece N", "<Piece/><Piece N"), &["a.vtu:5: NumberOfPoints is ''"]);
    refused("<!DOCTYPE X3D><X3D/>", &["a.vtu: it is no sound XML of VTK", "as .vtu or .vtk"]);
    refused(&with("NumberOfPoints=\"5\"", ""), &["a.vtu:5: NumberOfPoints is ''"]);
    refused(&with("<Cells>", "<Cell>").replace("</Cells>", "</Cell>"), &["'offsets' in Cells"]);
    let nested = "<VTKFile>".repeat(1_000_000);
    refused(&nested, &["a.vtu:1: elements nested 33 deep"]);
    // What a comment or plain text has is nested in nothing.
    for (begin, end) in [("<!--", "-->"), ("<Name><![CDATA[", "]]></Name>")] {
        let text = with("<Points>", &format!("{begin}{}{end}<Points>", "<a>".repeat(100)));
        assert_eq!(read(&text).unwrap(), read(TEXT).unwrap());
    }
    let open = format!("<VTKFile><!--{}", "<a>".repeat(100));
    refused(&open, &["a.vtu: it is no sound XML"]);
    let behind = format!("<VTKFile><!-- <a> -->{}", "<a>".repeat(100));
    refused(&behind, &["a.vtu:1: elements nested 33 deep"]);
    let bytes = [TEXT.as_bytes(), b"\xff"].concat();
    assert_refused(parse(Path::new("a.vtu"), &bytes, 1.0), &["a.vtu:25: no UTF-8"]);
}

#[test]
fn pieces_are_put_one_behind_the_other() {
    let one = read(TEXT).unwrap();
    let piece = &TEXT[TEXT.find("<Piece").unwrap()..TEXT.find("</UnstructuredGrid").unwrap()];
    let empty = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"></Piece>";
    let two = read(&TEXT.replacen(piece, &format!("{piece}{empty}{piece}"), 1)).unwrap();
    let shifted = one.tetrahedra.iter().map(|ids| ids.map(|id| id + 5));
    assert_eq!(two.nodes_m, [one.nodes_m.clone(), one.nodes_m.clone()].concat());
    assert_eq!(two.tetrahedra, one.tetrahedra.iter().copied().chain(shifted).collect::<Vec<_>>());
    let (name, ids) = one.groups.first_key_value().unwrap();
    let both: Vec<u32> = ids.iter().copied().chain(ids.iter().map(|id| id + 5)).collect();
    assert_eq!(two.groups[name], both);
    // A fault in the second has its own line.
    let wrong = piece.replace("NumberOfPoints=\"5\"", "NumberOfPoints=\"-5\"");
    let text = TEXT.replacen(piece, &format!("{piece}{wrong}"), 1);
    assert_refused(read(&text), &["a.vtu:23: NumberOfPoints is '-5'"]);
    assert_refused(read(&TEXT.replacen(piece, empty, 1)), &["a.vtu: it has no Piece with points"]);
}

/// Pieces that all point at the same data take no more than the file may unpack to.
#[test]
fn pieces_that_share_data_are_bounded() {
    let piece = "<Piece NumberOfPoints=\"100000\" NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" \
                 NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points><Cells><DataArray \
                 type=\"Int32\" Name=\"connectivity\">0 1 2 3</DataArray><DataArray type=\"Int32\" \
                 Name=\"offsets\">4</DataArray><DataArray type=\"UInt8\" Name=\"types\">10</DataArray></Cells>\
                 </Piece>";
    let mut bytes = format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{}</UnstructuredGrid>\
         <AppendedData encoding=\"raw\">_",
        piece.repeat(2_000)
    )
    .into_bytes();
    bytes.extend(2_400_000_u32.to_le_bytes());
    bytes.extend(vec![0; 2_400_000]);
    bytes.extend(b"</AppendedData></VTKFile>");
    assert_refused(parse(Path::new("a.vtu"), &bytes, 1.0), &["a.vtu", "has room for"]);
}

#[test]
fn counts_and_values_that_are_wrong() {
    for (from, to, parts) in [
        ("NumberOfPoints=\"5\"", "NumberOfPoints=\"6\"", ["a.vtu:7:", "15 numbers where 18"]),
        ("NumberOfPoints=\"5\"", "NumberOfPoints=\"-5\"", ["a.vtu:5:", "is '-5'"]),
        ("Points=\"5\"", "Points=\"18446744073709551615\"", ["a.vtu:7:", "15 numbers where"]),
        ("Cells=\"3\"", "Cells=\"18446744073709551615\"", ["a.vtu:15:", "3 numbers where"]),
        ("3 7 11", "3 7 12", ["a.vtu:14:", "11 numbers where 12"]),
        ("3 7 11", "3 8 7", ["a.vtu:15:", "the offset 7 behind 8"]),
        ("3 7 11", "3 7 18446744073709551615", ["a.vtu:14:", "numbers where"]),
        ("0 1 2 3 1", "0 1 2 x 1", ["a.vtu:14:", "is 'x'"]),
        ("0 1 2 3 1", "0 1 2 -3 1", ["a.vtu:14:", "is '-3'"]),
        ("0 1 2 3 1", "0 1 2 9 1", ["cell 1 refers to point 9", "save"]),
        ("1 1 1\n", "1 1 NaN\n", ["a.vtu:7: the z is NaN", "`unit_m`"]),
        ("1 1 1\n", "1 1 1e39\n", ["a.vtu:7: the z is 1e39", "`unit_m`"]),
        ("5 10 10", "5 24 10", ["10-node tetrahedron", "first-order"]),
        ("5 10 10", "5 12 10", ["hexahedron", "split"]),
        ("Components=\"3\"", "Components=\"2\"", ["a.vtu:7:", "2 components"]),
        ("type=\"Float64\" Num", "type=\"String\" Num", ["a.vtu:7:", "'String'"]),
        ("\"Int32\" Name=\"off", "\"Float32\" Name=\"off", ["a.vtu:15:", "whole"]),
        ("4 0 2", "4 -1.5 2", ["a.vtu:20:", "'-1.5'"]),
        ("types\" format=\"ascii\"", "types\" format=\"hex\"", ["a.vtu:16:", "format 'hex'"]),
        ("types\" format=\"ascii\"", "types\" format=\"appended\"", ["a.vtu:16:", "AppendedData"]),
        (
            "types\" format=\"ascii\">5",
            "types\" format=\"binary\">AA@AAAA=",
            ["a.vtu:16:", "base64"],
        ),
        ("types\" format=\"ascii\"", "types\" format=\"binary\"", ["a.vtu:16:", "cut off"]),
    ] {
        refused(&with(from, to), &parts);
    }
}

/// Lengths of binary data that lie are refused before anything is made of them.
#[test]
fn lengths_of_binary_data_that_lie() {
    let path = data("box.vtk.raw.vtu");
    let file = std::fs::read(&path).unwrap();
    let start = behind(&file, "<AppendedData encoding=\"raw\">");
    let data_at = start + file[start..].iter().position(|byte| *byte == b'_').unwrap() + 1;
    for (at, value) in [(0, 0xff), (3, 0x7f), (7, 0x7f)] {
        let mut file = file.clone();
        file[data_at + 344 + at] = value;
        assert_refused(parse(&path, &file, 1.0), &["box.vtk.raw.vtu:", "'Points'", "bytes where"]);
    }
    assert_refused(parse(&path, &file[..data_at + 400], 1.0), &["'Points'", "cut off"]);
    let path = data("box.vtk.raw_zlib.vtu");
    let file = std::fs::read(&path).unwrap();
    let start = behind(&file, "<AppendedData encoding=\"raw\">");
    let data_at = start + file[start..].iter().position(|byte| *byte == b'_').unwrap() + 1;
    let mut sizes = file.clone();
    sizes[data_at..data_at + 4].fill(0xff);
    // The groups come first.
    assert_refused(parse(&path, &sizes, 1.0), &["'CellEntityIds'", "cut off"]);
    let mut zlib = file.clone();
    zlib[data_at + 17] ^= 0x55;
    assert_refused(parse(&path, &zlib, 1.0), &["'CellEntityIds'", "zlib", "damaged"]);
}

/// A small file whose counts ask for more than it can hold is refused before it is unpacked.
#[test]
fn what_unpacks_to_too_much_is_refused() {
    // Points in blocks of 24 MiB that 24 KiB are said to pack.
    let file = |blocks: u32, last: u32, points: u64| {
        let head = format!(
            "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid>\
             <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" \
             NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points></Piece>\
             </UnstructuredGrid><AppendedData encoding=\"raw\">_"
        );
        let sizes = [blocks, 24 << 20, last].into_iter();
        let sizes: Vec<u8> =
            sizes.chain((0..blocks).map(|_| 24 << 10)).flat_map(u32::to_le_bytes).collect();
        [head.as_bytes(), &sizes, &vec![0; (24 << 10) * blocks as usize]].concat()
    };
    let read = |bytes: &[u8]| parse(Path::new("a.vtu"), bytes, 1.0);
    let parts = ["a.vtu:1: array 'Points': it unpacks to", "has room for", "without compression"];
    assert_refused(read(&file(6, 0, 6 << 20)), &parts);
    // Whatever the length, not more than a plain file may have.
    assert_refused(read(&file(300, 24 << 20, 300 << 20)), &["has room for 536870912"]);
    // Counts that do not agree are refused before that.
    assert_refused(read(&file(6, 0, 5)), &["its blocks have 150994944 bytes where 120 are needed"]);
    // What has room is unpacked.
    assert_refused(read(&file(1, 120, 5)), &["zlib", "damaged"]);
}
