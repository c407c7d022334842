//! What a file is its content tells, whatever its name; line ends and numbers of other programs.

use chaincell_host::mesh::{Filling, MeshOptions, from_bytes};

use super::*;

/// Names of every format that is read, and of none.
const NAMES: [&str; 14] = [
    "a.msh", "a.vtk", "a.vtu", "a.inp", "a.node", "a.ele", "a.mesh", "a.avs", "a.stl", "a.ply",
    "a.obj", "a.txt", "a.MSH", "a",
];

/// Files whose content tells what they are.
const FILES: [&str; 11] = [
    "box.msh22.ascii.msh",
    "box.msh22.binary.msh",
    "box.msh41.binary.msh",
    "box.ascii.vtk",
    "box.binary.vtk",
    "box.meshio.ascii.vtu",
    "box.vtk.raw.vtu",
    "box.meshio.inp",
    "box.gmsh.inp",
    "box.meshio.mesh",
    "box.meshio.avs",
];

const SURFACES: [&str; 5] = [
    "mm.gmsh.stl",
    "mm.gmsh.binary.stl",
    "mm.gmsh.obj",
    "mm.meshio.ascii.ply",
    "mm.meshio.binary.ply",
];

fn bytes_of(name: &str) -> Vec<u8> {
    std::fs::read(data(name)).unwrap()
}

/// A box that Gmsh 4.15 meshed, as programs write it: the same body, with the groups that the format has.
#[test]
fn what_other_programs_write() {
    let gmsh = load("box.msh41.ascii.msh");
    assert_eq!((gmsh.nodes_m.len(), gmsh.tetrahedra.len()), (32, 70));
    assert_eq!(gmsh.groups["held below"].len(), 12);
    let of = |prefix: &str, names: &[&str], ending: &str| -> Vec<String> {
        names.iter().map(|name| format!("box.{prefix}{name}.{ending}")).collect()
    };
    let msh = of("msh", &["22.ascii", "22.binary", "41.binary", "41.parametric"], "msh");
    let vtk = of("vtk.", &["raw", "raw_zlib", "base64_zlib", "inline", "big"], "vtu");
    let meshio = of("meshio.", &["ascii", "zlib"], "vtu");
    let legacy = of("", &["ascii", "binary"], "vtk");
    let numbers = [("7", "held below"), ("1", "body")];
    let names = [("held below", "held below"), ("body", "body")];
    for (files, groups) in [
        ([msh, of("meshio", &[""], "inp")].concat(), &names[..]),
        (of("gmsh", &[""], "inp"), &[("held_below", "held below"), ("body", "body")]),
        ([vtk, meshio, legacy, of("meshio", &[""], "mesh")].concat(), &numbers),
        ([of("meshio", &[""], "node"), of("meshio", &[""], "ele")].concat(), &[("1", "body")]),
    ] {
        for file in files {
            let file = file.as_str();
            let read = load(file);
            assert_eq!(read.tetrahedra, gmsh.tetrahedra, "{file}");
            // Twelve digits are written of some texts.
            let is_short = ["box.meshio.ascii.vtu", "box.gmsh.inp"].contains(&file);
            let places = read.nodes_m.iter().flatten().zip(gmsh.nodes_m.iter().flatten());
            assert!({ places }.all(|(a, b)| a == b || is_short && (a - b).abs() < 1e-13), "{file}");
            for (name, of) in groups {
                assert_eq!(read.groups[*name], gmsh.groups[*of], "{file}");
            }
        }
    }
    for name in ["box51.ascii.vtk", "box51.binary.vtk"] {
        let read = load(name);
        assert_eq!((&read.nodes_m, &read.tetrahedra), (&gmsh.nodes_m, &gmsh.tetrahedra), "{name}");
        assert!(read.groups.is_empty());
    }
    let (mesh, inp) = (load("mm.gmsh.mesh"), load("mm.gmsh.inp"));
    assert_eq!((&mesh.nodes_m, &mesh.tetrahedra), (&inp.nodes_m, &inp.tetrahedra));
    assert!(mesh.groups.len() > 1);
}

#[test]
fn a_volume_is_read_under_every_name() {
    for file in FILES {
        let (wanted, bytes) = (load(file), bytes_of(file));
        for name in NAMES {
            assert_eq!(
                parse(Path::new(name), &bytes, 1.0).as_ref(),
                Ok(&wanted),
                "{file} as {name}"
            );
        }
    }
}

#[test]
fn a_surface_is_one_under_every_name() {
    let options = MeshOptions {
        filling: Some(Filling::even(0.008)),
        unit_m: 0.001,
        ..MeshOptions::default()
    };
    let first = from_bytes(SURFACES[0], &bytes_of(SURFACES[0]), &options).unwrap();
    for file in SURFACES {
        let bytes = bytes_of(file);
        let wanted = from_bytes(file, &bytes, &options).unwrap();
        assert_eq!(wanted.tetrahedra, first.tetrahedra, "{file}");
        for name in NAMES {
            let read = parse(Path::new(name), &bytes, 1.0);
            assert_refused(read, &[name, "a surface", "`fill_m` SIZE"]);
            assert_eq!(
                from_bytes(name, &bytes, &options).as_ref(),
                Ok(&wanted),
                "{file} as {name}"
            );
        }
    }
    for file in FILES {
        let why = from_bytes(file, &bytes_of(file), &options).unwrap_err().to_string();
        assert!(why.contains("leave it out where a file has tetrahedra"), "{file}: {why}");
    }
}

#[test]
fn what_is_not_read_is_named_with_the_remedy() {
    for (bytes, what, remedy) in [
        (&b"\xff\xfe*\0N\0"[..], "UTF-16", "UTF-8"),
        (b"BZh91AY&SY\0", "bzip2", "bunzip2"),
        (b"PK\x03\x04\x14\0", "ZIP", "unpack"),
        (b"\x89HDF\r\n\x1a\n", "HDF5", "meshio convert"),
        (b"CDF\x01\0\0", "NetCDF", "meshio convert"),
        (b"OFF\n3 1 0\n", "OFF", ".stl"),
        (b"    -1\n  2411\n", "I-DEAS", "gmsh -save"),
        (b"# by hand\nmesh3d\n", "Netgen", "meshio convert"),
        (b"(0 \"by hand\")\n", "Fluent", "meshio convert"),
        (b"*KEYWORD\n*NODE\n", "LS-DYNA", ".inp"),
        (b"$ by hand\nGRID,1,,0.,0.,0.\n", "Nastran", ".inp"),
        (b"TITLE = \"by hand\"\n", "Tecplot", "meshio convert"),
        (b"<!DOCTYPE X3D><X3D/>", "XML", ".vtu"),
        (b"\x01\0\0\0\x02\0\0\0", ".meshb", "meshio convert"),
    ] {
        for name in NAMES {
            let read = parse(Path::new(name), bytes, 1.0);
            assert_refused(read, &[name, what, remedy]);
        }
    }
    assert_refused(
        parse(Path::new("a.vtk"), b"nothing known\n", 1.0),
        &["a.vtk:1: no legacy VTK file"],
    );
    assert_refused(parse(Path::new("a.txt"), b"nothing known\n", 1.0), &["unknown format", "UCD"]);
}

/// With a carriage return alone, or with a line feed behind it, at the end of each line.
#[test]
fn lines_end_as_programs_end_them() {
    let texts = FILES.into_iter().filter(|name| !name.contains("binary") && !name.contains("raw"));
    for file in texts {
        let (wanted, text) = (load(file), String::from_utf8(bytes_of(file)).unwrap());
        for end in ["\r", "\r\n"] {
            let read = parse(&data(file), text.replace('\n', end).as_bytes(), 1.0);
            assert_eq!(read.as_ref(), Ok(&wanted), "{file} {end:?}");
        }
    }
    let options = MeshOptions {
        filling: Some(Filling::even(0.008)),
        unit_m: 0.001,
        ..MeshOptions::default()
    };
    for file in SURFACES.into_iter().filter(|name| !name.contains("binary")) {
        let (bytes, text) = (bytes_of(file), String::from_utf8(bytes_of(file)).unwrap());
        let wanted = from_bytes(file, &bytes, &options);
        for end in ["\r", "\r\n"] {
            assert_eq!(
                from_bytes(file, text.replace('\n', end).as_bytes(), &options),
                wanted,
                "{file}"
            );
        }
    }
    // Errors count these lines.
    for end in ["\n", "\r", "\r\n"] {
        let text = ["*NODE", "1, 0, 0, 0", "2, 1, x, 0", ""].join(end);
        assert_refused(parse(Path::new("a.inp"), text.as_bytes(), 1.0), &["a.inp:3: y is 'x'"]);
        let text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "x", ""].join(end);
        assert_refused(parse(Path::new("a.msh"), text.as_bytes(), 1.0), &["a.msh:5:", "'x'"]);
    }
}

/// In front of decimals a point alone is read; exponents may be those of Fortran.
#[test]
fn numbers_of_other_programs() {
    let read = |text: &str| parse(Path::new("a.vtk"), text.as_bytes(), 1.0);
    let wanted = read(vtk::TEXT).unwrap();
    for digits in ["1.0D+00", "1d0", "1.E0", "+1"] {
        assert_eq!(
            read(&vtk::TEXT.replacen("0 0 1\n", &format!("0 0 {digits}\n"), 1)).unwrap(),
            wanted
        );
    }
    let comma = vtk::TEXT.replacen("0 0 1\n", "0 0 1,0\n", 1);
    assert_refused(
        read(&comma),
        &["a.vtk:13: z is '1,0'", "a point in front of decimals, not a comma"],
    );
    assert_refused(read(&vtk::TEXT.replacen("0 0 1\n", "0 0 D\n", 1)), &["a.vtk:13: z is 'D'"]);
}
