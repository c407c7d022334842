//! Abaqus input files, `.inp`.

use std::collections::BTreeMap;

use super::*;

const TEXT: &str = "** made by hand
*Heading
 any text, *no keyword
*Part, name=\"PART one\"
*NODE, nset=ALL
10, 0., 0., 0.
20, 1., 0, 0
30, 0, 1
40, 0, 0, 1.E0
 7, 1, 1, 1
*Element, Type=S3, elset=Skin
1, 10, 20, 40
*ELEMENT, type=c3d4,
 elset=Body
2, 10, 20,
 30, 40
5, 20, 30, 40, 7
*Nset, nset=Tip
7,
*nset, NSET=Row, generate
10, 40, 10
*Elset, elset=both, generate
2, 5, 3
*ELSET, ELSET=\"skin and more\"
Skin, 5
*Nset, nset=tip
part-1.10
*Nset, nset=of skin, elset=Skin
*Elset, elset=none
*Solid Section, elset=Body, material=M
,
*End Part
*Material, name=M
*Elastic
 5000., 0.45
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
fn nodes_elements_and_sets_are_read() {
    let body = read(TEXT).unwrap();
    assert_eq!(body.nodes_m[2], [0.0, 1.0, 0.0]);
    assert_eq!(body.tetrahedra, [[0, 1, 2, 3], [1, 2, 3, 4]]);
    let wanted = [
        ("ALL", vec![0, 1, 2, 3, 4]),
        ("Body", vec![0, 1, 2, 3, 4]),
        ("Row", vec![0, 1, 2, 3]),
        ("Skin", vec![0, 1, 3]),
        ("Tip", vec![0, 4]),
        ("both", vec![0, 1, 2, 3, 4]),
        ("none", vec![]),
        ("of skin", vec![0, 1, 3]),
        ("skin and more", vec![0, 1, 2, 3, 4]),
    ];
    assert_eq!(body.groups, wanted.map(|(name, nodes)| (name.to_owned(), nodes)).into());
    assert_eq!(read(&TEXT.replace('\n', "\r\n")).unwrap(), body);
    assert_eq!(read(&TEXT.replace("30, 0, 1\n", "\u{a0}\n30, 0, 1\n")).unwrap(), body);
    let mm = parse(Path::new("a.inp"), TEXT.as_bytes(), 0.001).unwrap();
    assert_eq!(mm.nodes_m[4], [0.001; 3]);
}

#[test]
fn what_is_not_read_names_line_and_remedy() {
    refused("** made by hand\n*Heading\n any", "any", &["a.inp:1:", "no Abaqus input file"]);
    refused("20, 1., 0, 0", "20, nan, 0, 0", &["a.inp:7: the x is NaN", "`unit_m`"]);
    refused("20, 1., 0, 0", "20, 1., zero, 0", &["a.inp:7: y is 'zero'"]);
    refused("20, 1., 0, 0", "10, 1., 0, 0", &["a.inp:7: node number 10 is given twice"]);
    refused("20, 1., 0, 0", ", 1., 0, 0", &["a.inp:7: the node number is ''"]);
    refused("5, 20, 30, 40, 7", "5, 20, 30, 40, 8", &["a.inp:17:", "node 8"]);
    refused("5, 20, 30, 40, 7", "2, 20, 30, 40, 7", &["a.inp:17: element number 2", "twice"]);
    refused("5, 20, 30, 40, 7", "5, 20, 30, 40", &["a.inp:17: element 5 has 3 nodes"]);
    refused("5, 20, 30, 40, 7", "5, 20, 30, 40, 40", &["a.inp:17:", "a node twice"]);
    refused("type=c3d4", "type=C3D10", &["a.inp:13:", "C3D10", "first-order", "C3D4"]);
    refused("type=c3d4", "type=C3D8R", &["a.inp:13:", "C3D8R", "tetrahedra"]);
    refused("type=c3d4", "type=COH3D6", &["a.inp:13:", "COH3D6"]);
    refused("type=c3d4,", "elset=A,", &["a.inp:13: *ELEMENT without TYPE="]);
    refused("type=c3d4,", "type=S3,", &["3 elements but none of type C3D4"]);
    refused("10, 40, 10\n", "10, 40, 0\n", &["a.inp:21:", "generates no set"]);
    refused("10, 40, 10\n", "40, 10, 1\n", &["a.inp:21:", "generates no set"]);
    refused("10, 40, 10\n", "10, 18446744073709551615\n", &["a.inp:21:", "node 11"]);
    refused("10, 40, 10\n", "a, 40, 10\n", &["a.inp:21:", "is 'a'"]);
    refused("7,\n", "8,\n", &["a.inp:19:", "node 8"]);
    refused("Skin, 5", "Skins, 5", &["a.inp:25: 'Skins'"]);
    refused("*End Part", "*Part, name=B", &["a.inp:32: a second part", "merge"]);
    refused("*End Part", "*Instance, name=A\n1, 0, 0", &["a.inp:33:", "moves its part"]);
    refused("*End Part", "*Instance, name=A\n*Instance, name=B", &["a.inp:33: a second instance"]);
    refused("*End Part", "*INCLUDE, INPUT=b.inp", &["a.inp:32: *INCLUDE", "in full"]);
    refused("*NODE, nset", "*NODE, SYSTEM=C, nset", &["a.inp:5:", "rectangular"]);
    refused("*NODE, nset", "*NODE, INPUT=n.txt, nset", &["a.inp:5: *NODE", "in full"]);
    assert_refused(read("*Heading\n"), &["a.inp: it has no *NODE"]);
    assert_refused(read("*NODE,"), &["a.inp:1: the file ends", "comma"]);
    let binary = [TEXT.as_bytes(), b"\xff\xfe\n"].concat();
    assert_refused(parse(Path::new("a.inp"), &binary, 1.0), &["a.inp:36: byte 1 of the line"]);
}

/// As Abaqus/CAE writes a model: a part, its instance in the assembly, reference points and sets there.
const CAE: &str = "*Heading
** Job name: Job-1 Model name: Model-1
*Preprint, echo=NO, model=NO, history=NO, contact=NO
** PARTS
*Part, name=Liver
*Node
      1,           0.,           0.,           0.
      2,           1.,           0.,           0.
      3,           0.,           1.,           0.
      4,           0.,           0.,           1.
      5,           1.,           1.,           1.
*Element, type=C3D4
1, 1, 2, 3, 4
2, 2, 3, 4, 5
*Nset, nset=Set-1, generate
 1,  5,  1
*Elset, elset=Set-1, generate
 1,  2,  1
*Elset, elset=Inner
 2,
*Solid Section, elset=Set-1, material=Material-1
,
*End Part
** ASSEMBLY
*Assembly, name=Assembly
*Instance, name=Liver-1, part=Liver
*End Instance
*Node
      1,          0.5,          0.5,           2.
*Element, type=MASS, elset=Weight
1, 1
*Element, type=CONN3D2
2, Liver-1.5, 1
*Mass, elset=Weight
0.1,
*Nset, nset=RP, internal
 1,
*Nset, nset=Set-1, instance=Liver-1
 1, 2
*Nset, nset=Both, instance=Liver-1, generate
 3,  4,  1
*Nset, nset=Both
 1,
*Nset, nset=All of it
 Liver-1.Set-1, Liver-1.1, Set-1
*Elset, elset=_Surf-1_S2, internal, instance=Liver-1
 1,
*Surface, type=ELEMENT, name=Surf-1
_Surf-1_S2, S2
*Transform, nset=Set-1
 1., 0., 0., 0., 1., 0.
*End Assembly
*Material, name=Material-1
*Step, name=Step-1
*Boundary
Set-1, 1, 1
*End Step
";

#[test]
fn an_assembly_of_one_instance_has_sets_of_its_own() {
    let body = read(CAE).unwrap();
    assert_eq!((body.nodes_m.len(), &body.tetrahedra[..]), (5, &[[0, 1, 2, 3], [1, 2, 3, 4]][..]));
    let wanted = [
        ("All of it", vec![0, 1, 2, 3, 4]),
        ("Both", vec![2, 3]),
        ("Inner", vec![1, 2, 3, 4]),
        // Of both sets of one name the part's is told by its instance.
        ("Liver-1.Set-1", vec![0, 1, 2, 3, 4]),
        ("Set-1", vec![0, 1]),
        ("_Surf-1_S2", vec![0, 1, 2, 3]),
    ];
    let wanted: BTreeMap<_, _> = wanted.map(|(name, nodes)| (name.to_owned(), nodes)).into();
    assert_eq!(body.groups, wanted);
    // A mesh of the instance itself, as of one that is independent.
    let (front, rest) = CAE.split_once("*Node\n").unwrap();
    let (mesh, rest) = rest.split_once("*End Part\n").unwrap();
    let of_instance = rest.replacen("*End Instance", &format!("*Node\n{mesh}*End Instance"), 1);
    let independent = read(&format!("{front}*End Part\n{of_instance}")).unwrap();
    assert_eq!(independent, body);
    // Numbers that only the part has are the part's.
    let bare = read(&CAE.replacen("*Nset, nset=Both\n 1,", "*Nset, nset=Both\n 5,", 1)).unwrap();
    assert_eq!(bare.groups["Both"], [2, 3, 4]);
}

#[test]
fn what_an_assembly_may_not_have_names_line_and_remedy() {
    let refused = |from: &str, to: &str, parts: &[&str]| {
        assert!(CAE.contains(from), "{from} is not in the text");
        assert_refused(read(&CAE.replacen(from, to, 1)), parts);
    };
    let second = "** ASSEMBLY\n*Part, name=Tool";
    refused("** ASSEMBLY", second, &["a.inp:25: a second part", "delete the others", "merge"]);
    let second = "*End Instance\n*Instance, name=B, part=Liver";
    refused("*End Instance", second, &["a.inp:28: a second instance", "merge"]);
    refused("*End Instance", "1., 0., 0.\n*End Instance", &["a.inp:27:", "moves its part"]);
    refused("type=MASS", "type=C3D4", &["a.inp:31: element 1", "outside of the part", "put all"]);
    refused("*Nset, nset=Both\n 1,", "*Nset, nset=Both\n 9,", &["a.inp:43:", "node 9"]);
    refused(" Liver-1.Set-1, Liver-1.1", " Liver-1.Set-9", &["a.inp:45: 'Liver-1.Set-9'"]);
}

/// Names in the encoding of older programs.
#[test]
fn names_in_latin_1_are_read() {
    let latin = |text: &str| text.chars().map(|letter| letter as u32 as u8).collect::<Vec<u8>>();
    let text = TEXT.replace("Skin", "H\u{fc}lle").replace(" any text", "\u{e4}");
    assert!(parse(Path::new("a.inp"), &latin(&text), 1.0).is_err(), "data that is no text");
    let text = TEXT.replace("Skin", "H\u{fc}lle").replace("made by", "f\u{fc}r");
    let wanted = read(&text).unwrap();
    assert_eq!(wanted.groups["H\u{fc}lle"], [0, 1, 3]);
    assert_eq!(parse(Path::new("a.inp"), &latin(&text), 1.0).unwrap(), wanted);
}
