//! Files cut and damaged everywhere: a sound body or an error that names the file.

use std::sync::OnceLock;

use proptest::prelude::*;

use super::*;

/// Files of other programs, one of every format and coding.
const FILES: [&str; 11] = [
    "box.meshio.ascii.vtu",
    "box.meshio.zlib.vtu",
    "box.vtk.raw.vtu",
    "box.vtk.base64_zlib.vtu",
    "box.vtk.inline.vtu",
    "box.meshio.inp",
    "box.gmsh.inp",
    "box.meshio.mesh",
    "box.meshio.node",
    "box.meshio.ele",
    "box.meshio.avs",
];

/// A file, how many of its bytes it needs, and a step between the cuts that are tried.
struct Sample {
    name: &'static str,
    bytes: Vec<u8>,
    needed: usize,
    step: usize,
}

/// These files, and those that the tests of each format make.
fn samples() -> &'static [Sample] {
    static SAMPLES: OnceLock<Vec<Sample>> = OnceLock::new();
    SAMPLES.get_or_init(|| {
        let of_programs = FILES.map(|name| {
            let bytes = std::fs::read(data(name)).unwrap();
            // An .inp has neither counts nor an end.
            let needed = if name.ends_with(".inp") { 0 } else { bytes.len() - 40 };
            Sample { name, bytes, needed, step: 7 }
        });
        let own = |name, bytes: Vec<u8>, needed| Sample { name, bytes, needed, step: 1 };
        let until = |bytes: Vec<u8>, text: &str, more: usize| {
            let needed = behind(&bytes, text) + more;
            (bytes, needed)
        };
        let mut all = Vec::from(of_programs);
        for text in [gmsh::OLD, gmsh::NEW] {
            let (bytes, needed) = until(text.into(), "\n$EndElements", 0);
            all.push(own("a.msh", bytes, needed - "$EndElements".len()));
        }
        for of in [gmsh_binary::old, gmsh_binary::new, gmsh_binary::parametric] {
            for little in [true, false] {
                let (bytes, needed) = until(of(little), "$EndElements", 0);
                all.push(own("a.msh", bytes, needed));
            }
        }
        for (bytes, needed) in [
            until(vtk::TEXT.into(), "1 5 10 1", 0),
            until(vtk::lists(), "CELL_TYPES 4\n", 16),
            until(vtk::offsets(), "CELL_TYPES 4\n", 16),
        ] {
            all.push(own("a.vtk", bytes, needed));
        }
        for (name, bytes) in surface::files() {
            // Not needed are the name after endsolid, the last references of an .obj and the edge after the
            // faces of a .ply.
            let needed = bytes.len() - if name == "a.stl" { 8 } else { 20 };
            all.push(own(name, bytes, needed));
        }
        all
    })
}

/// Reads the bytes as that file; of TetGen's files the other one stays sound, surfaces are filled.
fn read(name: &str, bytes: &[u8]) -> Result<RawMesh> {
    if !["a.stl", "a.obj", "a.ply"].contains(&name) {
        return parse(&data(name), bytes, 1.0);
    }
    let Mesh { nodes_m, tetrahedra, groups, .. } = surface::fill(name, bytes)?;
    Ok(RawMesh { nodes_m, tetrahedra, groups })
}

#[test]
fn every_cut_is_refused_with_the_file_or_gives_a_sound_body() {
    for Sample { name, bytes, needed, step } in samples() {
        assert!(read(name, bytes).is_ok(), "{name}");
        for end in (0..bytes.len()).step_by(*step) {
            let read = read(name, &bytes[..end]);
            assert!(is_sound(&read, name), "{name} cut at {end}: {read:?}");
            assert!(read.is_err() || end >= *needed, "{name} cut at {end}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn mutated_bytes_never_panic(
        which in 0..samples().len(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        digits in any::<bool>(),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let sample = &samples()[which];
        let mut bytes = sample.bytes.clone();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            // Digits reach deeper than bytes of every kind.
            bytes[at] = if digits { b"0123456789-./, \n"[value as usize % 16] } else { value };
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        // An error of a pair may name either file.
        let name = sample.name.rsplit_once('.').unwrap().0;
        prop_assert!(is_sound(&read(sample.name, &bytes), name));
    }
}
