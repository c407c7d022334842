//! Many chain elements to one neural cell, the paper's first open problem: one press of one body as
//! a network of all its nodes, and as networks of ever fewer cells that carry the nodes along.

use std::time::Instant;

use chaincell_kernel::{Model, Network, Settings, ToolSample, Unloading};
use nalgebra::Vector3;
use serde::Serialize;

use super::section::{Context, Figure, Numbers, Section};
use crate::bake::{BakeOptions, ImageBytes, bake};
use crate::cli::{automatic, inward};
use crate::contact::held;
use crate::cosim::histogram::Latencies;
use crate::engine::{Engine, Scheme};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::mesh::{self, Mesh, MeshOptions};
use crate::plot::{Axis, Chart, Style};
use crate::report::tables::{Table, csv, percent, us};

/// Depth of the press in mean link lengths of the organ of 5,762 nodes.
const DEPTH_LINKS: f64 = 3.0;
/// Radius of the patch that is pressed \[m\].
const PATCH_M: f64 = 0.015;
/// Nodes of the surface up to so many radii from its middle make up the profile.
const PROFILE_RADII: f64 = 3.0;
/// Ticks of the press.
const PRESS_TICKS: usize = 100;
/// Sweeps a tick.
const SWEEPS: u16 = 4;
/// Ticks between two looks at how far the body still moves.
const LOOK_TICKS: usize = 25;
/// Looks at most.
const LOOKS_MAX: usize = 16;
/// The body has settled when it moved less than this share of its displacement between two looks.
const SETTLED: f64 = 1e-4;

/// One network.
#[derive(Debug, Clone, Serialize)]
struct Row {
    cells: usize,
    links: usize,
    held_cells: usize,
    force_n: f64,
    /// Against the full network, signed.
    force_error: f64,
    field_error: f64,
    profile_error: f64,
    patch_error: f64,
    tick_median_ns: u64,
    tick_share: f64,
    settle_sweeps: usize,
    unsettled: f64,
    image_bytes: usize,
    ram_bytes: usize,
}

/// What is pressed, and how.
struct Press {
    mesh: Mesh,
    /// Nodes that the tool holds.
    patch: Vec<u32>,
    /// Nodes of the surface around them.
    profile: Vec<u32>,
    way_m: [f64; 3],
    depth_m: f64,
}

/// A network at the end of the press.
struct Settled {
    row: Row,
    /// Displacement of every node \[m\].
    field_m: Vec<[f64; 3]>,
    force_n: [f64; 3],
}

/// The press over numbers of cells.
///
/// # Errors
/// As the generator, the bake and the engine; a drawing that fails; the user's wish to stop.
pub fn section(context: &Context) -> Result<Section> {
    let (size, numbers): (usize, &[usize]) = if context.quick {
        (2000, &[500, 200, 100])
    } else {
        (20_000, &[5000, 2000, 1000, 500, 200])
    };
    let (press, image) = prepare(size)?;
    let full = settle(&press, &image)?;
    let mut rows = vec![full.row.clone()];
    for &cells in numbers {
        let options = BakeOptions { cells: Some(cells), ..BakeOptions::default() };
        let image = bake(&press.mesh, &press.mesh.default_fixed, &options)?;
        let coarse = settle(&press, &image)?;
        rows.push(compared(&press, &full, coarse));
    }
    Ok(Section {
        key: "scaling",
        title: "Many chain elements to one cell".to_owned(),
        text: text(&press, &rows),
        figures: figures(&rows)?,
        tables: vec![(caption(&press), table(&rows))],
        numbers: vec![Numbers { name: "scaling".to_owned(), csv: csv(&rows) }],
        json: serde_json::json!({
            "nodes": press.mesh.nodes_m.len(),
            "depth_m": press.depth_m,
            "patch_radius_m": PATCH_M,
            "patch_nodes": press.patch.len(),
            "sweeps_per_tick": SWEEPS,
            "networks": rows,
        }),
    })
}

/// The organ with its patch, and the model in which every node is a cell.
fn prepare(size: usize) -> Result<(Press, ImageBytes)> {
    let depth_m = DEPTH_LINKS * mean_link_m(&mesh::load("organ", &MeshOptions::default())?);
    let mesh = mesh::load(&format!("organ:{size}"), &MeshOptions::default())?;
    let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default())?;
    let model = parse(&image)?;
    let around = automatic(&model)?;
    let normal = inward(&model, &around);
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let centre =
        around.iter().map(|&cell| mesh.nodes_m[model.input_id()[usize::from(cell)] as usize]);
    let centre = centre.fold([0.0; 3], |sum: [f64; 3], p| std::array::from_fn(|x| sum[x] + p[x]));
    let centre = centre.map(|x| x / around.len() as f64);
    let mut surface: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    surface.sort_unstable();
    surface.dedup();
    surface.retain(|node| mesh.default_fixed.binary_search(node).is_err());
    let within = |radius: f64| -> Vec<u32> {
        let near = |node: &&u32| norm(&[minus(mesh.nodes_m[**node as usize], centre)]) <= radius;
        surface.iter().filter(near).copied().collect()
    };
    let (patch, profile) = (within(PATCH_M), within(PROFILE_RADII * PATCH_M));
    let way_m = normal.map(|x| depth_m * x / length);
    Ok((Press { patch, profile, mesh, way_m, depth_m }, image))
}

/// Presses a network and waits until it has settled.
fn settle(press: &Press, image: &ImageBytes) -> Result<Settled> {
    let model = parse(image)?;
    let contacts = held(&model, &press.patch)?;
    let settings = Settings {
        max_tool_step_m: 1e3 * model.unit_m(),
        unloading: Unloading::Off,
        ..Scheme::Track.settings(&model, SWEEPS)
    };
    let network = Network::new(model, settings).map_err(Error::check)?;
    let mut engine = Engine::new(network, Scheme::Track, &contacts)?;
    let mut times = Latencies::new()?;
    let mut force_n = [0.0; 3];
    for tick in 0..=PRESS_TICKS {
        let sample = sample(press, tick as f64 / PRESS_TICKS as f64);
        let start = Instant::now();
        force_n = engine.tick(&sample).force_n.into();
        times.record(start.elapsed().as_nanos() as u64);
    }
    let (mut field_m, mut unsettled, mut ticks) = (field(press, &mut engine), f64::INFINITY, 0);
    while unsettled > SETTLED && ticks < LOOKS_MAX * LOOK_TICKS {
        for _ in 0..LOOK_TICKS {
            force_n = engine.tick(&sample(press, 1.0)).force_n.into();
        }
        if interrupt::asked() {
            return Err(Error::Interrupted);
        }
        ticks += LOOK_TICKS;
        let now = field(press, &mut engine);
        unsettled = distance(&now, &field_m) / norm(&now);
        field_m = now;
    }
    let force_n = force_n.map(f64::from);
    let row = Row {
        cells: model.cells(),
        links: model.links(),
        held_cells: contacts.len(),
        force_n: norm(&[force_n]),
        force_error: 0.0,
        field_error: 0.0,
        profile_error: 0.0,
        patch_error: 0.0,
        tick_median_ns: times.summary().p50,
        tick_share: 1.0,
        settle_sweeps: ticks * usize::from(SWEEPS),
        unsettled,
        image_bytes: image.as_bytes().len(),
        ram_bytes: engine.ram_bytes(),
    };
    Ok(Settled { row, field_m, force_n })
}

/// A network's row, with its errors against the full one.
fn compared(press: &Press, full: &Settled, coarse: Settled) -> Row {
    let of = |field: &[[f64; 3]], nodes: &[u32]| -> Vec<[f64; 3]> {
        nodes.iter().map(|&node| field[node as usize]).collect()
    };
    // Root mean square over some nodes, as a share of the depth.
    let off = |nodes: &[u32], wanted: &[[f64; 3]]| {
        let mean = distance(&of(&coarse.field_m, nodes), wanted) / (nodes.len() as f64).sqrt();
        mean / press.depth_m
    };
    let along = |force: [f64; 3]| (0..3).map(|x| force[x] * full.force_n[x]).sum::<f64>();
    Row {
        force_error: along(coarse.force_n) / along(full.force_n) - 1.0,
        field_error: distance(&coarse.field_m, &full.field_m) / norm(&full.field_m),
        profile_error: off(&press.profile, &of(&full.field_m, &press.profile)),
        patch_error: off(&press.patch, &vec![press.way_m; press.patch.len()]),
        tick_share: coarse.row.tick_median_ns as f64 / full.row.tick_median_ns as f64,
        ..coarse.row
    }
}

fn sample(press: &Press, share: f64) -> ToolSample {
    let position_m = Vector3::from(press.way_m.map(|x| (share * x) as f32));
    ToolSample { position_m, engaged: 1 }
}

/// Displacement of every node, by input id \[m\].
fn field(press: &Press, engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
    let mut field = vec![[0.0; 3]; press.mesh.nodes_m.len()];
    let nodes = engine.nodes();
    for (&id, &at) in nodes.ids.iter().zip(&nodes.positions_m) {
        field[id as usize] = minus(at, press.mesh.nodes_m[id as usize]);
    }
    field
}

fn parse(image: &ImageBytes) -> Result<Model<'_>> {
    Model::from_bytes(image.as_bytes()).map_err(Error::check)
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|x| a[x] - b[x])
}

fn norm(field: &[[f64; 3]]) -> f64 {
    field.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn mean_link_m(mesh: &Mesh) -> f64 {
    let place = |node: u32| mesh.nodes_m[node as usize];
    let lengths = mesh.links.iter().map(|&[i, j]| norm(&[minus(place(j), place(i))]));
    lengths.sum::<f64>() / mesh.links.len() as f64
}

fn caption(press: &Press) -> String {
    format!(
        "A press of {:.1} mm on a patch of {} nodes ({:.0} mm around) of the generated organ of {} \
         nodes, settled; errors against the network in which every node is a cell.",
        1e3 * press.depth_m,
        press.patch.len(),
        1e3 * PATCH_M,
        press.mesh.nodes_m.len()
    )
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(&[
        "cells",
        "links",
        "cells held",
        "force [N]",
        "force error [%]",
        "field error [%]",
        "profile error [% of depth]",
        "patch error [% of depth]",
        "tick, median [us]",
        "share of the full network's",
        "sweeps to settle",
        "image [kB]",
    ]);
    for (at, row) in rows.iter().enumerate() {
        let error = |error: f64| if at == 0 { "-".to_owned() } else { percent(error) };
        table.row(vec![
            row.cells.to_string(),
            row.links.to_string(),
            row.held_cells.to_string(),
            format!("{:.3}", row.force_n),
            error(row.force_error),
            error(row.field_error),
            error(row.profile_error),
            error(row.patch_error),
            us(row.tick_median_ns),
            format!("{:.3}", row.tick_share),
            row.settle_sweeps.to_string(),
            format!("{:.0}", row.image_bytes as f64 * 1e-3),
        ]);
    }
    table
}

fn text(press: &Press, rows: &[Row]) -> Vec<String> {
    let mut text = vec![format!(
        "The paper leaves open how many elements of the chain one cell may stand for. Here the {} \
         nodes of an organ are put into groups: connected, about equally far apart, fixed and free \
         ones apart, those of the surface by themselves. Each group is a cell at one of its nodes; \
         links between neighbouring groups are as stiff as what they stand for; every node follows \
         the cells around it by weights that reproduce linear fields. The weights are no part of a \
         tick: its cost goes with the cells alone.",
        press.mesh.nodes_m.len()
    )];
    if let [full, coarse @ ..] = rows
        && let (Some(finest), Some(coarsest)) = (coarse.first(), coarse.last())
    {
        let line = |row: &Row| {
            format!(
                "with {} cells the force is off by {} %, the field by {} %, the surface around the \
                 press by {} % of its depth, in {} % of the time a tick",
                row.cells,
                percent(row.force_error),
                percent(row.field_error),
                percent(row.profile_error),
                percent(row.tick_share)
            )
        };
        text.push(format!(
            "Against the full network ({:.3} N, {} us a tick of {SWEEPS} sweeps): {}; {}.",
            full.force_n,
            us(full.tick_median_ns),
            line(finest),
            line(coarsest)
        ));
        let unsettled = rows.iter().map(|row| row.unsettled).fold(0.0, f64::max);
        text.push(format!(
            "Two things do not come for free. A patch is held through the cells of whose groups it \
             has half or more, or the one that has most of it: where groups are larger than the \
             patch, the tool's size is theirs (its nodes then miss the tool by {} % of the depth \
             with {} cells). And an irregular network yields more than its links one by one: a \
             factor from a patch test at rest makes up for it, the same everywhere and at every \
             depth. Between the last two looks, {LOOK_TICKS} ticks apart, no network moved by more \
             than {} % of its displacement.",
            percent(coarsest.patch_error),
            coarsest.cells,
            percent(unsettled)
        ));
    }
    text
}

fn figures(rows: &[Row]) -> Result<Vec<Figure>> {
    let coarse = || rows.iter().skip(1);
    let points = |of: fn(&Row) -> f64| -> Vec<[f64; 2]> {
        coarse().map(|row| [row.cells as f64, 100.0 * of(row)]).collect()
    };
    let error = Chart::new("Error over cells", Axis::log10("cells"), Axis::log10("error [%]"))
        .series("force", Style::MarkedLine, &points(|row| row.force_error.abs()))
        .series("field, all nodes", Style::MarkedLine, &points(|row| row.field_error))
        .series("profile, of the depth", Style::MarkedLine, &points(|row| row.profile_error));
    let times: Vec<[f64; 2]> =
        rows.iter().map(|row| [row.cells as f64, row.tick_median_ns as f64 * 1e-3]).collect();
    let time = Chart::new("Time over cells", Axis::log10("cells"), Axis::log10("time a tick [us]"))
        .series("track, 4 sweeps", Style::MarkedLine, &times)
        .horizontal(1000.0, "1 ms");
    Ok(vec![
        Figure {
            name: "scaling_error".to_owned(),
            caption: "Errors of a press against the network of all nodes.".to_owned(),
            picture: error.draw()?,
        },
        Figure {
            name: "scaling_time".to_owned(),
            caption: "Median time a tick of the press, measured in one run.".to_owned(),
            picture: time.draw()?,
        },
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_cells_are_quicker_and_stay_near_the_full_network() {
        let section = section(&Context { quick: true, ..Context::default() }).unwrap();
        println!("{}\n{}", section.text.join("\n"), section.tables[0].1.markdown());
        let rows = section.json["networks"].as_array().unwrap();
        assert_eq!(rows.len(), 4);
        let of = |row: usize, name: &str| rows[row][name].as_f64().unwrap();
        for row in 1..rows.len() {
            assert!(
                of(row, "cells") < of(row - 1, "cells") && of(row, "links") < of(row - 1, "links")
            );
            assert!(of(row, "field_error") < 0.35 && of(row, "force_error").abs() < 0.5, "{row}");
            assert!(of(row, "ram_bytes") < of(row - 1, "ram_bytes"));
        }
        assert!(of(1, "field_error") < of(3, "field_error"));
        assert_eq!((section.figures.len(), section.numbers.len()), (2, 1));
        assert_eq!(section.numbers[0].csv.lines().count(), 5);
        assert!(section.figures.iter().all(|figure| figure.picture.left_out == 0));
    }
}
