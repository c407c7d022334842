use super::gmsh::{NEW, OLD};
use super::*;

/// Puts numbers into a file in either byte order.
struct Writer {
    bytes: Vec<u8>,
    little: bool,
}

impl Writer {
    fn new(version: &str, little: bool) -> Self {
        let mut file = Self { bytes: Vec::new(), little };
        file.text(&format!("$MeshFormat\n{version} 1 8\n"));
        file.ints(&[1]);
        file.text("\n$EndMeshFormat\n");
        file.text("$PhysicalNames\n2\n2 7 \"the skin\"\n3 1 \"body\"\n$EndPhysicalNames\n");
        file
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }

    fn number<const N: usize>(&mut self, mut number: [u8; N]) {
        if !self.little {
            number.reverse();
        }
        self.bytes.extend(number);
    }

    fn ints(&mut self, numbers: &[i32]) {
        numbers.iter().for_each(|number| self.number(number.to_le_bytes()));
    }

    fn longs(&mut self, numbers: &[u64]) {
        numbers.iter().for_each(|number| self.number(number.to_le_bytes()));
    }

    fn reals(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.number(number.to_le_bytes()));
    }
}

/// The body of `OLD`; its widest tag does not fit 32 bits.
pub(super) fn old(little: bool) -> Vec<u8> {
    let mut file = Writer::new("2.2", little);
    file.text("$Nodes\n5\n");
    for (tag, position) in [
        (900, [0.0, 0.0, 0.0]),
        (7, [1.0, 0.0, 0.0]),
        (i32::MAX, [0.0, 1.0, 0.0]),
        (3, [0.0, 0.0, 1.0]),
        (12, [1.0, 1.0, 1.0]),
    ] {
        file.ints(&[tag]);
        file.reals(&position);
    }
    file.text("\n$EndNodes\n$Elements\n6\n");
    file.ints(&[15, 1, 2, 1, 4, 1, 900]);
    file.ints(&[2, 1, 2, 2, 7, 1, 900, 7, 3]);
    file.ints(&[4, 2, 2, 3, 1, 1, 900, 7, i32::MAX, 3, 4, 1, 1, 7, i32::MAX, 3, 12]);
    file.ints(&[4, 1, 2, 5, 9, 1, 7, i32::MAX, 3, 12]);
    file.ints(&[1, 1, 2, 6, 0, 1, 900, 7]);
    file.text("\n$EndElements\n$NodeData\n");
    file.bytes.extend([0xff, b'$', 0, 0x0a, 0xfe]);
    file.text("\n$EndNodeData\n");
    file.bytes
}

/// The body of `NEW`.
pub(super) fn new(little: bool) -> Vec<u8> {
    let mut file = Writer::new("4.1", little);
    file.text("$Entities\n");
    file.longs(&[1, 1, 1, 2]);
    file.ints(&[1]);
    file.reals(&[0.0; 3]);
    file.longs(&[1]);
    file.ints(&[4]);
    for (tag, groups, bounding) in
        [(1, &[][..], &[1, -1][..]), (1, &[-7], &[1]), (1, &[1], &[]), (2, &[1, 9], &[])]
    {
        file.ints(&[tag]);
        file.reals(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        for list in [groups, bounding] {
            file.longs(&[list.len() as u64]);
            file.ints(list);
        }
    }
    file.text("\n$EndEntities\n$Nodes\n");
    file.longs(&[2, 5, 3, 900]);
    file.ints(&[0, 1, 0]);
    file.longs(&[1, 900]);
    file.reals(&[0.0; 3]);
    file.ints(&[3, 1, 1]);
    file.longs(&[4, 7, u64::MAX, 3, 12]);
    file.reals(&[1.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.0, 1.0, 0.0, 0.5, 0.5, 0.5]);
    file.reals(&[0.0, 0.0, 1.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5]);
    file.text("\n$EndNodes\n$Elements\n");
    file.longs(&[5, 5, 1, 6]);
    for (head, rows) in [
        ([0, 1, 15], &[1, 900][..]),
        ([2, 1, 2], &[2, 900, 7, 3]),
        ([3, 1, 4], &[3, 900, 7, u64::MAX, 3]),
        ([3, 2, 4], &[4, 7, u64::MAX, 3, 12]),
        ([1, 1, 1], &[6, 900, 7]),
    ] {
        file.ints(&head);
        file.longs(&[1]);
        file.longs(rows);
    }
    file.text("\n$EndElements\n");
    file.bytes
}

/// The body of `OLD` as Gmsh writes it with `Mesh.SaveParametric`: behind a node its entity, and the place
/// on a curve or a surface.
pub(super) fn parametric(little: bool) -> Vec<u8> {
    let whole = old(little);
    let mut file = Writer::new("2.2", little);
    file.text("$ParametricNodes\n5\n");
    for (tag, position, dimension) in [
        (900, [0.0, 0.0, 0.0], 0),
        (7, [1.0, 0.0, 0.0], 1),
        (i32::MAX, [0.0, 1.0, 0.0], 2),
        (3, [0.0, 0.0, 1.0], 3),
        (12, [1.0, 1.0, 1.0], 0),
    ] {
        file.ints(&[tag]);
        file.reals(&position);
        file.ints(&[dimension, 1]);
        file.reals(&[0.5, 0.25][..if dimension < 3 { dimension as usize } else { 0 }]);
    }
    file.text("\n$EndParametricNodes");
    file.bytes.extend(&whole[behind(&whole, "$EndNodes")..]);
    file.bytes
}

#[test]
fn parametric_nodes_and_views_behind_are_read() {
    for little in [true, false] {
        let wanted = read(&old(little)).unwrap();
        assert_eq!(read(&parametric(little)).unwrap(), wanted);
        for (version, whole) in [("2.2", old(little)), ("4.1", new(little))] {
            let mut view = Writer::new(version, little);
            view.text("$NodeData\n1\n\"u\"\n0\n3\n0\n1\n1\n");
            view.ints(&[900]);
            view.reals(&[0.5]);
            view.text("\n$EndNodeData\n");
            let appended = [whole.clone(), view.bytes].concat();
            assert_eq!(read(&appended).unwrap(), read(&whole).unwrap());
            let twice = read(&[whole.clone(), whole].concat());
            assert_refused(twice, &["a.msh: byte", "a second $MeshFormat with a mesh of its own"]);
        }
    }
}

fn read(bytes: &[u8]) -> Result<RawMesh> {
    parse(Path::new("a.msh"), bytes, 1.0)
}

#[track_caller]
fn refused(bytes: &[u8], parts: &[&str]) {
    assert_refused(read(bytes), parts);
}

/// `bytes` with others from `at` on.
fn with(bytes: &[u8], at: usize, other: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + other.len()].copy_from_slice(other);
    bytes
}

#[test]
fn both_byte_orders_give_the_body_of_the_text() {
    let text_22 = read(OLD.replace("18446744073709551615", "2147483647").as_bytes()).unwrap();
    let text_41 = read(NEW.as_bytes()).unwrap();
    for little in [true, false] {
        assert_eq!(read(&old(little)).unwrap(), text_22);
        assert_eq!(read(&new(little)).unwrap(), text_41);
    }
    let mm = parse(Path::new("a.msh"), &old(true), 0.001).unwrap();
    assert_eq!(mm.nodes_m[4], [0.001; 3]);
}

#[test]
fn the_probe_of_the_byte_order() {
    let at = behind(&new(true), "4.1 1 8\n");
    refused(&with(&new(true), at, &[1, 0, 0, 1]), &["a.msh: byte 20", "text mode"]);
    refused(&with(&new(true), at + 4, b"x"), &["where $EndMeshFormat should be"]);
}

#[test]
fn counts_that_lie_are_refused_before_anything_is_read() {
    let at = behind(&old(true), "$Nodes\n");
    refused(&with(&old(true), at, b"9"), &["a.msh: byte 262: the y is 1.42", "finite"]);
    let huge = [&old(true)[..at], b"99999999999999999999\n"].concat();
    refused(&huge, &["number of nodes is '99999999999999999999", "whole number"]);
    let huge = [&old(true)[..at], b"4000000000000", &old(true)[at + 1..]].concat();
    refused(&huge, &["4000000000000 nodes of at least 28 bytes", "bytes are left"]);
    let at = behind(&old(true), "$Elements\n6\n");
    refused(&with(&old(true), at + 4, &[0, 0, 0, 0]), &["a block of 0 elements"]);
    refused(&with(&old(true), at + 4, &[9, 0, 0, 0]), &["a block of 9 elements where 6 are left"]);
    refused(&with(&old(true), at + 8, &[255; 4]), &["the number of tags is '-1'"]);
    refused(&with(&old(true), at - 2, b"5"), &["where $EndElements should be"]);
    for (section, words) in [("$Entities\n", 0..4), ("$Nodes\n", 0..1), ("$Elements\n", 0..1)] {
        let at = behind(&new(true), section);
        for word in words {
            refused(&with(&new(true), at + 8 * word, &[255; 8]), &["bytes are left"]);
            refused(&with(&new(true), at + 8 * word + 4, &[0, 0, 0, 8]), &["bytes are left"]);
        }
    }
    let at = behind(&new(true), "$Nodes\n");
    refused(&with(&new(true), at + 8, &[6]), &["says 6 nodes, its blocks have 5"]);
    refused(&with(&new(true), at + 32 + 12, &[255; 8]), &["bytes are left"]);
    let at = behind(&new(true), "$Elements\n");
    refused(&with(&new(true), at + 32 + 12, &[255; 8]), &["bytes are left"]);
}

#[test]
fn types_coordinates_and_references() {
    let at = behind(&old(true), "$Elements\n6\n");
    refused(&with(&old(true), at, &[11]), &["10-node tetrahedron", "ElementOrder = 1"]);
    refused(&with(&old(true), at, &[5]), &["8-node hexahedron", "RecombineAll"]);
    refused(&with(&old(true), at + 24, &[8, 0]), &["element 1 refers to node tag 8"]);
    let at = behind(&old(true), "$Nodes\n5\n");
    for bad in [f64::NAN, f64::INFINITY, -1e39] {
        let bytes = with(&old(true), at + 20, &bad.to_le_bytes());
        refused(&bytes, &[&format!("a.msh: byte {}: the z is {bad:?}", at + 20), "`unit_m`"]);
    }
    refused(&with(&old(true), at + 28, &900_i32.to_le_bytes()), &["tag 900 is given twice"]);
    refused(&with(&old(true), at + 28, &[255; 4]), &["the node tag is '-1'"]);
    let at = behind(&new(true), "$Nodes\n");
    refused(&with(&new(true), at + 32, &[4]), &["the entity dimension is 4"]);
}
