//! C programs against the static library: they compile without a warning, and compute what the
//! kernel computes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use chaincell_kernel::{
    Budget, CutRoom, EDGE_BYTES, Model, Network, Predict, Settings, Tissue, TissueMut, ToolPart,
    ToolPose, TouchStore, Track, coarse_room, cut_words, elastic_room, include_model, term_states,
};
use nalgebra::Vector3;

static BOX: &[u8] = include_model!("../../../tests/data/box5.chaincell");
static PLANE: &[u8] = include_model!("../../../tests/data/plane9.chaincell");

/// A body of nodal shapes.
static TISSUE: &[u8] = include_model!("../../../tests/data/tissue6.chaincell");

/// One with a surface that tools meet.
static SURFACE: &[u8] = include_model!("../../../tests/data/touch6.chaincell");

/// One that a blade cuts.
static BLADE: &[u8] = include_model!("../../../tests/data/blade5.chaincell");

const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn data(name: &str) -> PathBuf {
    package().join("../../tests/data").join(name)
}

/// The static library as cargo builds it today; `cargo test` leaves none at a name that is known.
fn library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let mut cargo = Command::new(std::env::var_os("CARGO").expect("run by cargo test"));
        // The whole workspace selects the same features as its tests: nothing is built twice.
        cargo.args(["build", "--workspace", "--lib", "--locked", "--offline"]);
        cargo.args(["--message-format", "json-render-diagnostics"]).current_dir(package());
        if !cfg!(debug_assertions) {
            cargo.arg("--release");
        }
        let built = succeed(&mut cargo);
        let files = built.lines().flat_map(|line| {
            let message: serde_json::Value = serde_json::from_str(line).unwrap();
            let files = message["filenames"].as_array().cloned().unwrap_or_default();
            files.into_iter().filter_map(|file| file.as_str().map(PathBuf::from))
        });
        let named = |file: &PathBuf| file.ends_with("libchaincell_ffi.a");
        files.into_iter().find(named).expect("cargo builds libchaincell_ffi.a")
    })
}

/// Runs a command that must succeed without a word on standard error but cargo's; its output.
fn succeed(command: &mut Command) -> String {
    let Output { status, stdout, stderr } =
        command.output().unwrap_or_else(|why| panic!("{command:?}: {why}"));
    let stderr = String::from_utf8_lossy(&stderr);
    assert!(status.success(), "{command:?}: {status}\n{stderr}");
    String::from_utf8(stdout).unwrap()
}

fn compiler(name: &str, standard: &str) -> Command {
    let mut command = Command::new(name);
    command.args([standard, "-O1"]).args(WARNINGS);
    command.arg("-I").arg(package().join("include"));
    command
}

/// Compiles and links a C program.
fn program(source: &str, folder: &Path) -> PathBuf {
    let executable = folder.join("program");
    let mut cc = compiler("cc", "-std=c99");
    cc.arg(package().join(source)).arg(library()).args(["-lpthread", "-ldl", "-lm"]);
    succeed(cc.arg("-o").arg(&executable));
    executable
}

/// What `press.c` does, in Rust: the lines it prints.
fn pressed<const ROOM: usize, const STATES: usize>(
    image: &'static [u8],
    ids: &[u32],
) -> Vec<String> {
    let model = Model::from_bytes(image).unwrap();
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    let mut held: Vec<u16> = ids.iter().map(|&id| model.cell_of_input(id).unwrap()).collect();
    held.sort_unstable();
    let mut tissue = Tissue::<256, Track<ROOM>, 2, STATES>::new();
    tissue.reset(&network).unwrap();
    tissue.choose_contacts(&network, &held).unwrap();
    let mut lines = Vec::new();
    for tick in 0..250_u16 {
        let position_m = Vector3::new(0.0, 0.0, -0.0001 * f32::from(tick));
        let output =
            tissue.tick(&network, &[ToolPose::at(position_m, u32::from(tick < 200))], Budget::All);
        if tick % 25 == 24 {
            lines.push(format!("flags {}", output.flags.0));
        }
    }
    lines.push(format!("state hash {:016x}", tissue.view().state_hash(&model)));
    lines
}

#[test]
fn the_example_presses_as_the_kernel_does() {
    let folder = tempfile::tempdir().unwrap();
    let press = program("examples/press.c", folder.path());
    let cases = [
        ("box5.chaincell", vec![69, 64], pressed::<{ coarse_room(27, 2) }, 0>(BOX, &[64, 69])),
        ("plane9.chaincell", vec![40], pressed::<0, 0>(PLANE, &[40])),
        (
            "tissue6.chaincell",
            vec![41, 89],
            pressed::<{ elastic_room(64) }, { term_states(256) }>(TISSUE, &[41, 89]),
        ),
    ];
    for (image, ids, wanted) in cases {
        let ids = ids.iter().map(u32::to_string);
        let said = succeed(Command::new(&press).arg(data(image)).args(ids));
        let lines: Vec<&str> = said.lines().collect();
        assert_eq!(lines.len(), wanted.len() + 1, "{said}");
        for (line, end) in lines[1..].iter().zip(&wanted) {
            assert!(line.ends_with(end.as_str()), "{image}: `{end}` is not in\n{said}");
        }
        // Pressed it pushes back, let go it does not.
        let force = |line: &str| line.split_whitespace().nth(5).unwrap().parse::<f32>().unwrap();
        assert!(force(lines[8]) > 0.0 && force(lines[10]) == 0.0, "{said}");
    }
}

#[test]
fn the_example_says_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let press = program("examples/press.c", folder.path());
    let broken = folder.path().join("broken.chaincell");
    let mut image = std::fs::read(data("plane9.chaincell")).unwrap();
    image[400] ^= 1;
    std::fs::write(&broken, image).unwrap();
    let cases = [
        (data("no such file"), "40", "cannot read"),
        (broken, "40", "checksum does not match: copy or bake it again (-24;"),
        (package().join("Cargo.toml"), "40", "not a chaincell model"),
        (data("plane9.chaincell"), "0", "a contact cell is fixed and cannot be held"),
        (data("plane9.chaincell"), "81", "take one of the input mesh's nodes (-7;"),
        (data("plane9.chaincell"), "4x", "4x: an input id is a whole number"),
    ];
    for (image, id, wanted) in cases {
        let output = Command::new(&press).arg(image).arg(id).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && said.contains(wanted), "{wanted}: {said}");
    }
}

/// Where `grasp.c` puts its tools.
fn placed(tick: u16) -> [ToolPose; 2] {
    let share = |from: u16, to: u16| match tick {
        _ if tick < from => 0.0,
        _ if tick < to => f32::from(tick - from) / f32::from(to - from),
        _ => 1.0,
    };
    let down_m = 0.005 * share(0, 100);
    let aside_m = 0.012 - 0.002 * share(100, 180);
    let [ball, jaw] = [0.005_f32, 0.009].map(|reach_m| 0.03 + reach_m - down_m);
    let at = |x_m, z_m| ToolPose::at(Vector3::new(x_m, 0.001, z_m), 1);
    [at(-aside_m, ball), at(aside_m, jaw + 0.006 * share(180, 240))]
}

/// What `grasp.c` does, in Rust: the words of its lines that are no small numbers.
fn grasped() -> Vec<String> {
    let model = Model::from_bytes(SURFACE).unwrap();
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    let mut tissue = Tissue::<144, Predict<{ elastic_room(24) }>, 0, { term_states(144) }>::new();
    let mut store = TouchStore::<144, 256, 512, 2>::new();
    let mut body = tissue.touching(store.room());
    body.reset(&network).unwrap();
    let capsule = ToolPart::capsule(0.004, 0.005);
    let beside = |y_m| ToolPart { centre_m: [0.0, y_m, 0.0], ..capsule };
    let tools: [&[ToolPart]; 2] = [&[ToolPart::sphere(0.005)], &[beside(-0.004), beside(0.004)]];
    body.choose_tools(&network, &tools, 0.3).unwrap();
    let (mut lines, mut work_j) = (Vec::new(), 0.0);
    for tick in 0..270_u16 {
        if tick == 180 {
            body.grip(&network, 1);
        }
        if tick == 240 {
            body.let_go(1, 20);
        }
        body.tick(&network, &placed(tick), Budget::All);
        work_j +=
            (0..2).map(|tool| f64::from(body.tool_output(&network, tool).work_j)).sum::<f64>();
        if tick % 60 == 59 {
            for tool in 0..2 {
                let contacts = body.tool_output(&network, tool).contacts;
                let held = body.gripped(&network, tool);
                lines.push(format!("{contacts} contacts, {held} samples gripped"));
            }
            body.contact_forces(&network, |of| {
                lines.push(format!(
                    "triangle {:3}, tool {}, part {}:",
                    of.triangle, of.tool, of.part
                ));
            });
        }
    }
    assert!(work_j > 0.0);
    lines.push(format!("state hash {:016x}", body.state_hash(&model)));
    lines
}

#[test]
fn the_example_grasps_as_the_kernel_does() {
    let folder = tempfile::tempdir().unwrap();
    let grasp = program("examples/grasp.c", folder.path());
    let run =
        |image: &str, top: &str| Command::new(&grasp).arg(data(image)).arg(top).output().unwrap();
    let said = succeed(Command::new(&grasp).arg(data("touch6.chaincell")).arg("0.03"));
    // Storage first, the work before the hash.
    let lines: Vec<&str> = said.lines().skip(1).filter(|line| !line.starts_with("work")).collect();
    let wanted = grasped();
    assert!(wanted.iter().any(|line| line.ends_with("30 samples gripped")), "{wanted:?}");
    assert_eq!(lines.len(), wanted.len(), "{said}");
    for (line, wanted) in lines.iter().zip(wanted) {
        assert!(line.contains(&wanted), "{wanted} in {line}");
    }
    for (image, top, wanted) in [
        ("tissue6.chaincell", "0.03", "no contact surface: bake --contact-surface yes (-91)"),
        ("touch6.chaincell", "nan", "usage"),
        ("plane9.chaincell", "0.03", "no contact surface"),
    ] {
        let output = run(image, top);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && said.contains(wanted), "{wanted}: {said}");
    }
}

/// What `cut.c` does, in Rust: the ends of its lines.
fn cut() -> Vec<String> {
    let model = Model::from_bytes(BLADE).unwrap();
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    let mut tissue = Tissue::<130, Track<{ elastic_room(8) }>, 0, { term_states(130) }>::new();
    let mut store = TouchStore::<130, 64>::new();
    let mut words = vec![0; cut_words(&model)];
    let cut = CutRoom::new(&mut words);
    let mut body = TissueMut { cut, ..tissue.touching(store.room()) };
    body.reset(&network).unwrap();
    body.choose_tools(&network, &[&[ToolPart::edge(0.016)]], 0.0).unwrap();
    let mut lines = Vec::new();
    for tick in 0..240_u16 {
        if tick == 200 {
            assert_eq!(body.open_face(&network, 0, 0), Ok(true));
        }
        let height_m = 0.03 + 0.0005 - 0.0001 * f32::from(tick.min(200));
        let pose = ToolPose::at(Vector3::new(0.001, -0.001, height_m), 1);
        body.tick(&network, &[pose], Budget::All);
        if tick % 40 == 39 {
            let cuts = body.cut_output(&network);
            let [faces, copies, refused] = [cuts.opened_faces, cuts.copies, cuts.refused];
            lines.push(format!("{faces} faces open, {copies} copies, {refused} refused"));
        }
    }
    let cuts = body.cut_output(&network);
    assert!(cuts.opened_faces > 10 && cuts.copies > 3, "{cuts:?}");
    lines.push(format!("state hash {:016x}", body.state_hash(&model)));
    lines
}

#[test]
fn the_example_cuts_as_the_kernel_does() {
    let folder = tempfile::tempdir().unwrap();
    let program = program("examples/cut.c", folder.path());
    let run = |image: &str| Command::new(&program).arg(data(image)).arg("0.03").output().unwrap();
    let said = succeed(Command::new(&program).arg(data("blade5.chaincell")).arg("0.03"));
    let (lines, wanted): (Vec<&str>, _) = (said.lines().skip(1).collect(), cut());
    assert_eq!(lines.len(), wanted.len(), "{said}");
    for (line, wanted) in lines.iter().zip(wanted) {
        assert!(line.ends_with(&wanted), "{wanted} in {line}");
    }
    for (image, wanted) in [
        ("touch6.chaincell", "the body cannot be cut: bake it with --cuttable (-160)"),
        ("plane9.chaincell", "the body cannot be cut"),
    ] {
        let output = run(image);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && said.contains(wanted), "{wanted}: {said}");
    }
}

/// `CHAINCELL_SHAPE_BYTES`, `CHAINCELL_TOUCH_BYTES` and `CHAINCELL_CUT_BYTES` are enough, and waste little.
#[test]
fn the_headers_macros_bound_the_sizes() {
    let folder = tempfile::tempdir().unwrap();
    let sizes = program("tests/c/sizes.c", folder.path());
    let said = succeed(Command::new(sizes).arg("shapes"));
    assert_eq!(said.lines().count(), 3);
    // That of nodal shapes, beside what the example says that its body takes.
    let press = program("examples/press.c", folder.path());
    let pressed = succeed(Command::new(press).arg(data("tissue6.chaincell")).arg("41").arg("89"));
    let (body, bytes) = pressed.lines().next().unwrap().rsplit_once(": ").unwrap();
    assert_eq!(body, "144 cells, 628 links, 18 coarse functions");
    let size: usize = bytes.trim_end_matches(" bytes").parse().unwrap();
    let bound: usize = said.lines().next().unwrap().parse().unwrap();
    assert!((size..size + 1024).contains(&bound), "{bound}, {size}");
    // And with room for tools.
    let grasp = program("examples/grasp.c", folder.path());
    let grasped = succeed(Command::new(grasp).arg(data("touch6.chaincell")).arg("0.03"));
    let bytes = grasped.lines().next().unwrap().trim_end_matches(" bytes");
    let size: usize = bytes.parse().unwrap();
    // Of two tools, each with an edge where the kernel of these tests is one that cuts.
    let bound = said.lines().nth(1).unwrap().parse::<usize>().unwrap() + 2 * EDGE_BYTES;
    assert!((size..size + 1536).contains(&bound), "{bound}, {size}");
    // And with memory for cuts.
    let cut = program("examples/cut.c", folder.path());
    let said_of_cut = succeed(Command::new(cut).arg(data("blade5.chaincell")).arg("0.03"));
    let bytes = said_of_cut.lines().next().unwrap().trim_end_matches(" bytes");
    let size: usize = bytes.parse().unwrap();
    let bound: usize = said.lines().nth(2).unwrap().parse().unwrap();
    assert!((size..size + 1536).contains(&bound), "{bound}, {size}");
}

/// One struct goes from the kernel's header to the client's and back, whichever is included first.
#[test]
fn a_tool_is_the_same_in_both_headers() {
    let folder = tempfile::tempdir().unwrap();
    let executable = folder.path().join("program");
    for first in ["-DKERNEL_FIRST", "-DCLIENT_FIRST"] {
        let mut cc = compiler("cc", "-std=c99");
        cc.arg("-I").arg(package().join("../../host/client/ffi/include")).arg(first);
        cc.arg(package().join("tests/c/one_pose.c")).arg("-o").arg(&executable);
        succeed(&mut cc);
        let said = succeed(&mut Command::new(&executable));
        assert_eq!(said, "0 0 1 0, 1, 9, 3 N, 0.5 N m, 7, 256\n");
    }
}

#[test]
fn the_header_stands_alone_in_every_language() {
    let folder = tempfile::tempdir().unwrap();
    let object = folder.path().join("object");
    if Command::new("c++").arg("--version").output().is_err() {
        println!("SKIPPED the header as C++: no c++");
    } else {
        for standard in ["-std=c++11", "-std=c++20"] {
            let mut command = compiler("c++", standard);
            command.arg("-c").arg(package().join("tests/c/header.cpp"));
            succeed(command.arg("-o").arg(&object));
        }
    }
    for standard in ["-std=c99", "-std=c11", "-std=c17"] {
        let mut command = compiler("cc", standard);
        command.arg("-c").arg(package().join("tests/c/sizes.c"));
        succeed(command.arg("-o").arg(&object));
    }
}
