//! `--cells` seen from outside: fewer cells than nodes, and every node in the results.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_host::bake::{BakeOptions, ImageBytes, bake as bake_mesh};
use chaincell_host::engine::contact::held;
use chaincell_host::mesh::{Mesh, load};
use chaincell_kernel::image::kind as section;
use chaincell_kernel::{
    Budget, Model, ModelError, Network, Settings, Tissue, ToolPose, Track, coarse_room,
};
use chaincell_tests::files::{Table, bake, play, scratch, summary, text, write_path};
use chaincell_tests::{forge, run};

/// Nodes of the box, its top ones have ids 5, 11, ..
const NODES: usize = 9 * 7 * 6;

fn body() -> (Mesh, ImageBytes) {
    let mesh = load("box:9x7x6x0.01", &Default::default()).unwrap();
    let options = BakeOptions { cells: Some(60), ..BakeOptions::default() };
    let image = bake_mesh(&mesh, &mesh.default_fixed, &options).unwrap();
    (mesh, image)
}

fn info(model: &Path) -> serde_json::Value {
    let shown = run(["info", text(model), "--json"]).with(0);
    serde_json::from_str(&shown.out).unwrap()
}

#[test]
fn a_run_lists_every_node() {
    let folder = scratch();
    let model = bake(folder.path(), "box:9x7x6x0.01", &["--cells", "60"]);
    let figures = info(&model);
    assert_eq!((figures["cells"].as_u64(), figures["nodes"].as_u64()), (Some(60), Some(378)));
    let path = folder.path().join("press.csv");
    let rows = (0..40_u16).map(|tick| (tick.into(), [0.0, 0.0, -0.0005 * f32::from(tick)], 1));
    write_path(&path, rows);
    let out = folder.path().join("out");
    let contact = "cells:box:-0.021,0.021,-0.021,0.021,0.049,0.051";
    let options = ["--contact", contact, "--snapshot-ticks", "0,39"];
    play(&model, &path, &out, &options).with(0);
    let rest = load("box:9x7x6x0.01", &Default::default()).unwrap();
    let first = Table::read(&out.join("cells_0.csv"));
    assert!(first.whole("node").into_iter().eq(0..NODES as u64));
    for (at, node) in first.vectors("x_m").iter().zip(&rest.nodes_m) {
        assert!((0..3).all(|axis| (at[axis] - node[axis]).abs() < 1e-8), "{at:?} {node:?}");
    }
    let last = Table::read(&out.join("cells_final.csv"));
    assert_eq!(last, Table::read(&out.join("cells_39.csv")));
    let sunk = |node: usize| rest.nodes_m[node][2] - last.vectors("x_m")[node][2];
    // The middle of the top goes with the tool, the bottom stays.
    assert!((sunk(4 * 42 + 3 * 6 + 5) - 0.0195).abs() < 0.004, "{}", sunk(4 * 42 + 3 * 6 + 5));
    assert!(rest.default_fixed.iter().all(|&node| sunk(node as usize).abs() < 1e-8));
    let vtu = std::fs::read_to_string(out.join("final.vtu")).unwrap();
    let piece = format!("NumberOfPoints=\"{NODES}\" NumberOfCells=\"{}\"", rest.tetrahedra.len());
    assert!(vtu.contains(&piece), "{piece}");
    let summary = summary(&out);
    assert_eq!((summary["cells"].as_u64(), summary["nodes"].as_u64()), (Some(60), Some(378)));
    for id in summary["contact_nodes"].as_array().unwrap() {
        assert!((rest.nodes_m[id.as_u64().unwrap() as usize][2] - 0.05).abs() < 1e-12);
    }
}

#[test]
fn bad_numbers_are_refused() {
    let folder = scratch();
    let model = folder.path().join("model.chaincell");
    for (number, part) in [
        ("0", "--cells 0: must be from 2 to 378"),
        ("1", "--cells 1: must be from 2 to 378"),
        ("379", "--cells 379: must be from 2 to 378"),
        ("NaN", "'--cells <N>'"),
        ("-3", "'--cells <N>'"),
        ("1.5", "'--cells <N>'"),
    ] {
        let ended = run(["bake", "box:9x7x6x0.01", "-o", text(&model), "--cells", number]).with(2);
        assert!(ended.err.contains(part), "{number}: {}", ended.err);
        assert!(!model.exists());
    }
    let large = run(["bake", "box:51x51x51x0.01", "-o", text(&model)]).with(2);
    assert!(large.err.contains("--cells N"), "{}", large.err);
}

#[test]
fn a_mesh_of_more_nodes_than_cells_there_can_be() {
    let folder = scratch();
    let model = bake(folder.path(), "box:51x51x26x0.002", &["--cells", "500", "--lean"]);
    assert_eq!(info(&model)["cells"], 500);
    let model = bake(folder.path(), "box:51x51x26x0.002", &["--cells", "500"]);
    assert_eq!(info(&model)["nodes"], 51 * 51 * 26);
}

#[test]
fn a_patch_holds_the_cells_it_covers() {
    let (mesh, image) = body();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let of = |cell: u16| -> Vec<u32> {
        (0..NODES as u32).filter(|&node| model.cell_of_input(node) == Some(cell)).collect()
    };
    let free = |cell: &u16| !model.is_fixed(*cell) && of(*cell).len() > 3;
    let cell = (0..60).find(free).unwrap();
    let group = of(cell);
    // One node, or half the group: its cell. A neighbour's single node adds nothing to it.
    assert_eq!(held(&model, &group[..1]).unwrap(), [cell]);
    let beside = model.neighbours(cell.into()).map(|(_, other)| other as u16).find(free).unwrap();
    let mut both = group;
    both.push(of(beside)[0]);
    assert_eq!(held(&model, &both).unwrap(), [cell]);
    both.extend(&of(beside)[1..]);
    let mut pair = [cell, beside];
    pair.sort_unstable();
    assert_eq!(held(&model, &both).unwrap(), pair);
    let fixed = mesh.default_fixed[3];
    let why = held(&model, &[group_free_node(&model), fixed]).unwrap_err().to_string();
    assert!(why.contains(&format!("node {fixed} is fixed")), "{why}");
    assert!(held(&model, &[NODES as u32]).unwrap_err().to_string().contains("no cell"));
}

fn group_free_node(model: &Model<'_>) -> u32 {
    let cell = (0..60).find(|&cell| !model.is_fixed(cell)).unwrap();
    model.input_id()[usize::from(cell)]
}

#[test]
fn the_kernel_carries_nodes_without_a_heap() {
    let (_, image) = body();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    let mut tissue: Tissue<60, Track<{ coarse_room(48, 2) }>, 2> = Tissue::new();
    tissue.reset(&network).unwrap();
    let id = group_free_node(&model);
    let cell = model.cell_of_input(id).unwrap();
    tissue.choose_contacts(&network, &[cell]).unwrap();
    for tick in 0..30_u8 {
        let position_m = [0.0, 0.0, -0.0005 * f32::from(tick)].into();
        tissue.tick(&network, &[ToolPose::at(position_m, 1)], Budget::All);
    }
    let view = tissue.view();
    // A cell and the node it stands at are one.
    let node = view.fine_position_m(&model, id as usize).unwrap();
    let there = view.position_m(&model, cell.into()).unwrap();
    assert!((node - there).norm() < 1e-7, "{node} {there}");
    assert_eq!(view.fine_position_m(&model, NODES), None);
}

#[test]
fn lean_images_and_old_ones_have_no_fine_nodes() {
    let mesh = load("box:9x7x6x0.01", &Default::default()).unwrap();
    for (cells, lean) in [(Some(60), true), (None, false)] {
        let options = BakeOptions { cells, lean, ..BakeOptions::default() };
        let image = bake_mesh(&mesh, &mesh.default_fixed, &options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        assert_eq!(model.fine_nodes(), 0);
        assert_eq!(model.fine_position(0, |_| Some([0.0; 3])), None);
        let cell = usize::from(model.cell_of_input(model.input_id()[7]).unwrap());
        assert_eq!(cell, 7);
    }
}

// REQ-MOD-02
#[test]
fn damaged_sections_are_refused() {
    let (_, image) = body();
    let bytes = image.as_bytes();
    let error = |kind: u32, offset: usize, value: &[u8]| {
        let mut changed = bytes.to_vec();
        let at = forge::section(bytes, kind).start + offset;
        changed[at..at + value.len()].copy_from_slice(value);
        Model::from_bytes(forge::resealed(changed).as_bytes()).unwrap_err()
    };
    let nan = f32::NAN.to_le_bytes();
    assert_eq!(
        error(section::FINE_CELLS, 2 * 16, &60_u16.to_le_bytes()),
        ModelError::Index(section::FINE_CELLS, 2)
    );
    assert_eq!(error(section::FINE_WEIGHTS, 0, &nan), ModelError::Value(section::FINE_WEIGHTS, 0));
    assert_eq!(
        error(section::FINE_WEIGHTS, 3 * 32, &3.0_f32.to_le_bytes()),
        ModelError::Value(section::FINE_WEIGHTS, 3)
    );
    assert_eq!(error(section::FINE_REST, 12, &nan), ModelError::Value(section::FINE_REST, 1));
    let beyond = (NODES as u32).to_le_bytes();
    let first = |kind| ModelError::Index(kind, 0);
    assert_eq!(error(section::FINE_TRIANGLES, 0, &beyond), first(section::FINE_TRIANGLES));
    assert_eq!(error(section::FINE_TETRAHEDRA, 0, &beyond), first(section::FINE_TETRAHEDRA));
    // A cell that stands at a node of another group.
    let model = Model::from_bytes(bytes).unwrap();
    let other = model.input_id()[1].to_le_bytes();
    assert_eq!(error(section::INPUT_ID, 0, &other), first(section::INPUT_ID));
}
