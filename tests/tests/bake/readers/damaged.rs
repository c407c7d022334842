//! Files of other programs, cut and damaged everywhere: a sound body or an error that names the file.

use proptest::prelude::*;

use super::*;

/// One file of every format and coding.
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

fn bytes_of(name: &str) -> Vec<u8> {
    std::fs::read(data(name)).unwrap()
}

/// Reads the bytes as that file; of TetGen's files the other one stays sound.
fn read(name: &str, bytes: &[u8]) -> Result<RawMesh> {
    parse(&data(name), bytes, 1.0)
}

#[test]
fn every_cut_is_refused_with_the_file_or_gives_a_sound_body() {
    for name in FILES {
        let bytes = bytes_of(name);
        assert!(read(name, &bytes).is_ok(), "{name}");
        for end in (0..bytes.len()).step_by(7) {
            let read = read(name, &bytes[..end]);
            assert!(is_sound(&read, name), "{name} cut at {end}: {read:?}");
            // An .inp has neither counts nor an end.
            let may_end = name.ends_with(".inp") || end > bytes.len() - 40;
            assert!(read.is_err() || may_end, "{name} cut at {end}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn mutated_bytes_never_panic(
        which in 0..FILES.len(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        digits in any::<bool>(),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let name = FILES[which];
        let mut bytes = bytes_of(name);
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = if digits { b"0123456789-., \n"[value as usize % 15] } else { value };
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        // An error of a pair may name either file.
        let name = name.rsplit_once('.').unwrap().0;
        prop_assert!(is_sound(&read(FILES[which], &bytes), name));
    }
}
