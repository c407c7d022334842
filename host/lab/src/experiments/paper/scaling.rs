//! Many chain elements to one neural cell, the paper's first open problem: one press of one body as
//! a network of all its nodes, and as networks of ever fewer cells with the nodes embedded in them.

use chaincell_kernel::{Model, ToolPose};
use nalgebra::Vector3;
use serde::Serialize;

use crate::bodies::Variant;
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use crate::experiments::page::table::{Table, csv, percent, us};
use crate::experiments::page::{Context, Numbers, Section};
use crate::reference::vectors::{distance, dot, minus, norm, plus, size};
use chaincell_host::bake::{BakeOptions, ImageBytes, bake};
use chaincell_host::engine::contact::{automatic, held, inward};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::mesh::{self, Mesh, MeshOptions};
use chaincell_host::session::timing::histogram::Latencies;

/// Depth of the press in mean link lengths of the organ of 5,762 nodes.
const DEPTH_LINKS: f64 = 3.0;
/// A small press, as a share of the depth.
const SHALLOW: f64 = 0.1;
/// Radius of the patch that is pressed \[m\].
const PATCH_M: f64 = 0.015;
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

/// One network at one site; errors as fractions.
#[derive(Debug, Clone, Serialize)]
struct Row {
    site: &'static str,
    cells: usize,
    force_n: f64,
    /// Against the full network, signed.
    force_error: f64,
    field_error: f64,
    patch_error: f64,
    tick_median_ns: u64,
    tick_share: f64,
    /// Change of the field between the last two looks, as a share of it.
    unsettled: f64,
    ram_bytes: usize,
}

/// What is pressed, and how.
struct Press<'a> {
    site: Site,
    mesh: &'a Mesh,
    /// Nodes that the tool holds.
    patch: Vec<u32>,
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

/// Where the body is pressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Site {
    /// The highest point, over the thick of the body, to a small part of the depth.
    Shallow,
    /// The same to the whole depth.
    Dome,
    /// The point farthest from the fixed nodes, the end of a thin lobe.
    Tip,
}

impl Site {
    fn name(self) -> &'static str {
        match self {
            Self::Shallow => "dome, shallow",
            Self::Dome => "dome",
            Self::Tip => "tip",
        }
    }
}

/// The press over numbers of cells.
pub fn section(context: &Context) -> Result<Section> {
    let (size, numbers): (usize, &[usize]) = if context.quick {
        (2000, &[500, 200, 100])
    } else {
        (20_000, &[5000, 2000, 1000, 500, 200])
    };
    let depth_m = DEPTH_LINKS * mean_link_m(&mesh::load("organ", &MeshOptions::default())?);
    let mesh = mesh::load(&format!("organ:{size}"), &MeshOptions::default())?;
    let baked = |cells: Option<usize>| {
        interrupt::check()?;
        bake(&mesh, &mesh.default_fixed, &BakeOptions { cells, ..BakeOptions::default() })
    };
    let image = baked(None)?;
    let images: Result<Vec<ImageBytes>> = numbers.iter().map(|&cells| baked(Some(cells))).collect();
    let (images, mut rows, mut patch_nodes) = (images?, Vec::new(), Vec::new());
    for site in [Site::Shallow, Site::Dome, Site::Tip] {
        let press = Press::at(site, &mesh, &parse(&image)?, depth_m)?;
        let full = settle(&press, &image)?;
        rows.push(full.row.clone());
        for image in &images {
            rows.push(compared(&press, &full, settle(&press, image)?));
        }
        patch_nodes.push(press.patch.len());
    }
    let nodes = mesh.nodes_m.len();
    Ok(Section {
        key: "scaling",
        title: "Many chain elements to one cell".to_owned(),
        results: vec![("Left open: many elements to one cell", result(nodes, depth_m, &rows))],
        text: text(nodes, &rows),
        figures: figures(&rows)?,
        tables: vec![(caption(nodes, depth_m, &patch_nodes), table(&rows))],
        numbers: vec![Numbers { name: "scaling".to_owned(), csv: csv(&rows) }],
        json: serde_json::json!({
            "nodes": nodes,
            "depth_m": depth_m,
            "shallow_depth_m": SHALLOW * depth_m,
            "patch_radius_m": PATCH_M,
            "patch_nodes": patch_nodes,
            "sweeps_per_tick": SWEEPS,
            "networks": rows,
        }),
    })
}

impl<'a> Press<'a> {
    /// A patch of the surface around a site, pressed inwards; `model` has every node as a cell.
    fn at(site: Site, mesh: &'a Mesh, model: &Model<'_>, depth_m: f64) -> Result<Self> {
        let mut surface: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        surface.sort_unstable();
        surface.dedup();
        surface.retain(|node| mesh.default_fixed.binary_search(node).is_err());
        let place = |node: u32| mesh.nodes_m[node as usize];
        let middle = match site {
            Site::Shallow | Site::Dome => surface
                .iter()
                .copied()
                .max_by(|&a, &b| place(a)[2].total_cmp(&place(b)[2]).then(b.cmp(&a)))
                .map_or([0.0; 3], place),
            Site::Tip => {
                let cells = automatic(model)?;
                let at = cells.iter().map(|&cell| place(model.input_id()[usize::from(cell)]));
                at.fold([0.0; 3], |sum, p| plus(sum, 1.0, p)).map(|x| x / cells.len() as f64)
            }
        };
        let near = |node: &&u32| norm(minus(place(**node), middle)) <= PATCH_M;
        let patch: Vec<u32> = surface.iter().filter(near).copied().collect();
        let depth_m = if site == Site::Shallow { SHALLOW * depth_m } else { depth_m };
        let normal = inward(model, &held(model, &patch)?);
        let way_m = normal.map(|x| depth_m * x / norm(normal));
        Ok(Self { site, mesh, patch, way_m, depth_m })
    }
}

/// Presses a network and waits until it has settled.
fn settle(press: &Press<'_>, image: &ImageBytes) -> Result<Settled> {
    let model = parse(image)?;
    let contacts = held(&model, &press.patch)?;
    let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
    let mut engine =
        variant.unlimited(model, Contact::Cells(contacts), SWEEPS, |settings| settings)?;
    let mut times = Latencies::new()?;
    let mut force_n = [0.0; 3];
    for tick in 0..=PRESS_TICKS {
        let sample = sample(press, tick as f64 / PRESS_TICKS as f64);
        force_n = times.time(|| engine.tick(&sample)).force_n.into();
    }
    let (mut field_m, mut unsettled, mut ticks) = (field(press, &mut engine), f64::INFINITY, 0);
    while unsettled > SETTLED && ticks < LOOKS_MAX * LOOK_TICKS {
        for _ in 0..LOOK_TICKS {
            force_n = engine.tick(&sample(press, 1.0)).force_n.into();
        }
        interrupt::check()?;
        ticks += LOOK_TICKS;
        let now = field(press, &mut engine);
        unsettled = distance(&now, &field_m) / size(&now);
        field_m = now;
    }
    let force_n = force_n.map(f64::from);
    let row = Row {
        site: press.site.name(),
        cells: model.cells(),
        force_n: norm(force_n),
        force_error: 0.0,
        field_error: 0.0,
        patch_error: 0.0,
        tick_median_ns: times.summary().p50,
        tick_share: 1.0,
        unsettled,
        ram_bytes: engine.ram_bytes(),
    };
    Ok(Settled { row, field_m, force_n })
}

/// A network's row, with its errors against the full one.
fn compared(press: &Press<'_>, full: &Settled, coarse: Settled) -> Row {
    // Root mean square over the nodes of the patch, as a share of the depth.
    let patch: Vec<[f64; 3]> =
        press.patch.iter().map(|&node| coarse.field_m[node as usize]).collect();
    let off_m = distance(&patch, &vec![press.way_m; patch.len()]) / (patch.len() as f64).sqrt();
    let along = |force: [f64; 3]| dot(force, full.force_n) / norm(full.force_n);
    Row {
        force_n: along(coarse.force_n),
        force_error: along(coarse.force_n) / along(full.force_n) - 1.0,
        field_error: distance(&coarse.field_m, &full.field_m) / size(&full.field_m),
        patch_error: off_m / press.depth_m,
        tick_share: coarse.row.tick_median_ns as f64 / full.row.tick_median_ns as f64,
        ..coarse.row
    }
}

fn sample(press: &Press<'_>, share: f64) -> ToolPose {
    let position_m = Vector3::from(press.way_m.map(|x| (share * x) as f32));
    ToolPose::at(position_m, 1)
}

/// Displacement of every node, by input id \[m\].
fn field(press: &Press<'_>, engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
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

fn mean_link_m(mesh: &Mesh) -> f64 {
    let place = |node: u32| mesh.nodes_m[node as usize];
    let lengths = mesh.links.iter().map(|&[i, j]| norm(minus(place(j), place(i))));
    lengths.sum::<f64>() / mesh.links.len() as f64
}

fn caption(nodes: usize, depth_m: f64, patch_nodes: &[usize]) -> String {
    let patches: Vec<String> = patch_nodes.iter().map(ToString::to_string).collect();
    format!(
        "Presses of {:.1} mm (shallow) and {:.1} mm on all surface nodes within {:.0} mm ({}) of the \
         generated organ's highest point and of its thin lobe's tip, {nodes} nodes, settled; errors \
         against the network in which every node is a cell.",
        1e3 * SHALLOW * depth_m,
        1e3 * depth_m,
        1e3 * PATCH_M,
        patches.join(" and ")
    )
}

fn table(rows: &[Row]) -> Table {
    let all = rows.iter().map(|row| row.cells).max();
    let error = |of: fn(&Row) -> f64| {
        move |row: &Row| match Some(row.cells) == all {
            true => "-".to_owned(),
            false => percent(of(row)),
        }
    };
    Table::of(rows)
        .column("site", |row| row.site)
        .column("cells", |row| row.cells)
        .column("force [N]", |row| format!("{:.3}", row.force_n))
        .column("force error [%]", error(|row| row.force_error))
        .column("field error [%]", error(|row| row.field_error))
        .column("patch error [% of depth]", error(|row| row.patch_error))
        .column("tick, median [us]", |row| us(row.tick_median_ns))
        .column("share of the full network's", |row| format!("{:.3}", row.tick_share))
        .column("still moving [% of the field]", |row| percent(row.unsettled))
        .table()
}

fn result(nodes: usize, depth_m: f64, rows: &[Row]) -> String {
    let list = |rows: &[Row], of: fn(&Row) -> String| {
        rows.iter().skip(1).map(of).collect::<Vec<_>>().join(", ")
    };
    let site = |rows: &[Row]| {
        format!(
            " {}: as {} cells, {} % of the time a tick, field {} % and force {} % off.",
            rows[0].site,
            list(rows, |row| row.cells.to_string()),
            list(rows, |row| percent(row.tick_share)),
            list(rows, |row| percent(row.field_error)),
            list(rows, |row| percent(row.force_error.abs()))
        )
    };
    let sites: String = rows.chunk_by(|a, b| a.site == b.site).map(site).collect();
    format!(
        "The organ of {nodes} nodes pressed at its dome and its tip by cells held by the tool, {:.0} mm \
         deep (shallow: {:.0} mm).{sites}",
        1e3 * depth_m,
        1e3 * SHALLOW * depth_m
    )
}

fn text(nodes: usize, rows: &[Row]) -> Vec<String> {
    let first = format!(
        "The paper leaves open how many elements of the chain one cell may stand for. Here the \
         {nodes} nodes of an organ are put into groups: connected, about equally far apart, fixed \
         and free ones apart, those of the surface by themselves. Each group is a cell at one of \
         its nodes; links between neighbouring groups are as stiff as what they stand for; every \
         node follows the cells around it by weights that reproduce linear fields. The weights are \
         no part of a tick: its cost goes with the cells alone."
    );
    let worst = |of: fn(&Row) -> f64| 100.0 * rows.iter().map(of).fold(0.0, f64::max);
    let last = format!(
        "Cells cost accuracy in three ways. A patch is held through the cells of whose groups it \
         has half or more, or the one that has most of it: where groups are as large as the patch, \
         the tool's size is theirs, and its nodes miss the tool by up to {:.0} % of the depth. A thin \
         lobe keeps few cells across, so it bends too easily and folds elsewhere. And an irregular \
         network yields more than its links one by one: one factor from a patch test at rest makes \
         up for it on the whole, not at each place and depth. Each press is held for at most {} sweeps, \
         until the field moves by less than {} % in {LOOK_TICKS} ticks.",
        worst(|row| row.patch_error),
        LOOKS_MAX * LOOK_TICKS * usize::from(SWEEPS),
        percent(SETTLED)
    );
    vec![first, last]
}

fn figures(rows: &[Row]) -> Result<Vec<Figure>> {
    let chart = |title: &str, y: &str, of: fn(&Row) -> f64, skip: usize| {
        let chart = Chart::new(title, Axis::log10("cells"), Axis::log10(y));
        rows.chunk_by(|a, b| a.site == b.site).fold(chart, |chart, site| {
            let point = |row: &Row| [row.cells as f64, of(row)];
            let points: Vec<[f64; 2]> = site.iter().skip(skip).map(point).collect();
            chart.series(site[0].site, Style::MarkedLine, &points)
        })
    };
    let field = chart("Error of the field", "error [%]", |row| 100.0 * row.field_error, 1);
    let force = chart("Error of the force", "error [%]", |row| 100.0 * row.force_error.abs(), 1);
    let time = |row: &Row| 1e-3 * row.tick_median_ns as f64;
    let time = chart("Time of a tick", "time [us]", time, 0).horizontal(1000.0, "1 ms");
    let figure = |name, sees: &str, chart: Chart| -> Result<Figure> {
        let caption = format!(
            "{sees} Each line is a press at one place, its points networks of fewer cells to the left."
        );
        Ok(Figure::new(name, caption, Picture::of(&chart)?))
    };
    let off = "against the network of all nodes, at the end of the press.";
    Ok(vec![
        figure(
            "scaling_field",
            &format!("The fewer the cells, the larger the error of the displacements {off}"),
            field,
        )?,
        figure(
            "scaling_force",
            &format!("The fewer the cells, the larger the error of the force {off}"),
            force,
        )?,
        figure(
            "scaling_time",
            "A tick takes less time with fewer cells: the median tick of the press under track.",
            time,
        )?,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_cells_are_quicker_and_stay_near_the_full_network() {
        // With CHAINCELL_SLOW=1 as the report runs it.
        let quick = std::env::var_os("CHAINCELL_SLOW").is_none();
        let section = section(&Context { quick, ..Context::default() }).unwrap();
        println!("{}\n{:#?}", section.text.join("\n"), section.tables[0].1);
        let rows = section.json["networks"].as_array().unwrap();
        let each = if quick { 4 } else { 6 };
        assert_eq!(rows.len(), 3 * each);
        let of = |row: usize, name: &str| rows[row][name].as_f64().unwrap();
        for row in (1..3 * each).filter(|row| row % each > 0) {
            for name in ["cells", "ram_bytes"] {
                assert!(of(row, name) < of(row - 1, name), "{row}: {name}");
            }
        }
        // A small press over the thick of the body; deep ones fold the body elsewhere.
        assert!(of(1, "field_error") < 0.35 && of(1, "force_error").abs() < 0.3);
        assert!(of(1, "patch_error") < 0.25);
        assert_eq!((section.figures.len(), section.numbers.len()), (3, 1));
        assert_eq!(section.numbers[0].csv.lines().count(), 1 + 3 * each);
        assert!(section.figures.iter().all(|figure| figure.picture.left_out == 0));
    }
}
