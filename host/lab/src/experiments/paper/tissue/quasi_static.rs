//! Curves without time: human cortex in three modes, porcine liver under a ball.

use std::fs;
use std::path::Path;

use chaincell_kernel::{Flags, Settings, ToolPose};
use nalgebra::Vector3;

use super::comparison::Compared;
use super::specimen::{Block, Lattice, Specimen, parse, surface, tissue};
use crate::bodies::Variant;
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use chaincell_host::bake::tissue::{DEVICE_HZ, KnownTissue};
use chaincell_host::bake::{BakeOptions, bake};
use chaincell_host::engine::{Contact, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::mesh::{Filling, Finer, Mesh, MeshOptions, Region, load};

/// Block that is pulled and pressed, and slab that is sheared \[m\].
const BAR_M: [f64; 3] = [0.01, 0.01, 0.025];
const SLAB_M: [f64; 3] = [0.04, 0.04, 0.008];
const EDGE_M: f64 = 0.004;
/// Ticks from one point of a curve to the next: on the way, and at rest.
const MOVING: u32 = 10;
const RESTING: u32 = 30;
/// Radius of the ball that the liver was probed with \[m\].
const BALL_M: f64 = 0.004;
/// The block under it, the edges of its tetrahedra, and the radius within which they are fine \[m\].
const BLOCK_M: [f64; 3] = [0.04, 0.04, 0.02];
const COARSE_M: f64 = 0.005;
const FINE_M: f64 = 0.001;
const NEAR_M: f64 = 0.006;
/// Sweeps of a tick under the ball.
const SWEEPS: u16 = 16;
/// Distance from which the ball comes down \[m\].
const ABOVE_M: f64 = 5e-4;

/// The rows of a table of numbers; the first `texts` columns are left out.
fn rows(path: &Path, texts: usize) -> Result<Vec<(String, Vec<f64>)>> {
    let text = fs::read_to_string(path).map_err(|why| Error::file("read curve", path, why))?;
    let row = |(at, line): (usize, &str)| {
        let fields: Vec<&str> = line.split(',').collect();
        let numbers = fields.iter().skip(texts).map(|field| field.trim().parse());
        let numbers: std::result::Result<Vec<f64>, _> = numbers.collect();
        let numbers = numbers.map_err(|_| {
            let name = path.display();
            Error::input(format!("{name}:{}: `{line}`: give numbers, as the header says", at + 2))
        })?;
        Ok((fields[0].to_owned(), numbers))
    };
    text.lines().skip(1).filter(|line| !line.is_empty()).enumerate().map(row).collect()
}

/// Human cortex by `--tissue brain_cortex`: tension, compression and shear, along the lattice of the mesh and askew.
pub fn brain(folder: &Path) -> Result<Vec<Compared>> {
    let rows = rows(&folder.join("tissue/brain_cortex.csv"), 1)?;
    let cortex = KnownTissue::find("brain_cortex")?;
    let mut all = Vec::new();
    for (lattice, words) in [(Lattice::Along, "along the lattice"), (Lattice::Askew, "askew")] {
        let of =
            |size_m| Specimen::new(Block { size_m, edge_m: EDGE_M, lattice }, &cortex, DEVICE_HZ);
        let (bar, slab) = (of(BAR_M)?, of(SLAB_M)?);
        for (mode, curve) in [("T", "tension"), ("C", "compression"), ("S", "shear")] {
            let of_mode = rows.iter().filter(|(name, _)| name == mode);
            // Stretch or shear, and stress in Pa.
            let points: Vec<[f64; 2]> =
                of_mode.map(|(_, numbers)| [numbers[0], 1e3 * numbers[1]]).collect();
            let specimen = if mode == "S" { &slab } else { &bar };
            all.push(Compared {
                tissue: "human cortex",
                curve: curve.to_owned(),
                body: format!("--tissue brain_cortex, {words}"),
                cells: specimen.cells,
                answers: settled(specimen, mode == "S", &points)?,
                points,
            });
        }
    }
    Ok(all)
}

/// The nominal stress at each stretch or shear of a curve, at rest there \[Pa\].
fn settled(specimen: &Specimen, is_shear: bool, points: &[[f64; 2]]) -> Result<Vec<f64>> {
    let mut machine = specimen.machine()?;
    let mut last = if is_shear { 0.0 } else { 1.0 };
    let mut answers = Vec::new();
    for &[to, _] in points {
        let mut stress_pa = 0.0;
        for tick in 1..=MOVING + RESTING {
            let part = f64::from(tick.min(MOVING)) / f64::from(MOVING);
            let at = last + part * (to - last);
            stress_pa = if is_shear { machine.shear(at)? } else { machine.stretch(at)? };
        }
        answers.push(stress_pa);
        last = to;
    }
    Ok(answers)
}

/// The curves of the cortex.
pub fn brain_figure(all: &[Compared]) -> Result<Figure> {
    let axes = (Axis::linear("strain [%]"), Axis::linear("nominal stress [Pa]"));
    let mut chart = Chart::new("Human cortex: measured, and --tissue brain_cortex", axes.0, axes.1);
    let strains = |of: &Compared, points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let rest = if of.curve == "shear" { 0.0 } else { 1.0 };
        points.iter().map(|point| [100.0 * (point[0] - rest), point[1]]).collect()
    };
    for of in all.iter().filter(|of| of.body.ends_with("lattice")) {
        let label = format!("{}, measured", of.curve);
        chart = chart.series(&label, Style::Markers, &strains(of, &of.points));
    }
    for (words, style) in [("along the lattice", Style::Line), ("askew", Style::Dashed)] {
        for of in all.iter().filter(|of| of.body.ends_with(words)) {
            let label = format!("{}, {words}", of.curve);
            chart = chart.series(&label, style, &strains(of, &of.line()));
        }
    }
    let caption = "Tension, compression (below 0) and shear of human cortex (Budday and others 2017), and blocks of \
                   `--tissue brain_cortex` in the kernel's ticks. Its band acts along links, so that the direction of \
                   the load in the mesh decides how much of it is felt. The slab that is sheared is five times as wide \
                   as high: its free edges take some 5 % of the stress.";
    Ok(Figure::new("paper_tissue_brain", caption, Picture::of(&chart)?))
}

/// Porcine liver under a ball: the body of the table, and the modulus that meets the median best.
pub struct Liver {
    /// The comparisons.
    pub compared: Vec<Compared>,
    /// Depth \[m\] and quartiles of the force \[N\].
    quartiles: Vec<[f64; 3]>,
    /// The modulus that meets the median best \[Pa\].
    pub young_pa: f64,
}

/// Presses a ball into a block of `--tissue liver`. Tissue without bands has forces in proportion to its modulus.
pub fn liver(folder: &Path) -> Result<Liver> {
    let rows = rows(&folder.join("tissue/porcine_liver_region1_median.csv"), 0)?;
    let points: Vec<[f64; 2]> = rows.iter().map(|(_, of)| [1e-3 * of[0], of[2]]).collect();
    let quartiles = rows.iter().map(|(_, of)| [1e-3 * of[0], of[1], of[3]]).collect();
    let known = KnownTissue::find("liver")?;
    let (cells, answers) = pressed(&known, &points)?;
    // The factor of least squares.
    let product: f64 = answers.iter().zip(&points).map(|(answer, point)| answer * point[1]).sum();
    let factor = product / answers.iter().map(|answer| answer * answer).sum::<f64>();
    let young_pa = factor * known.young_pa;
    let best = answers.iter().map(|answer| factor * answer).collect();
    let of = |body: String, answers: Vec<f64>| Compared {
        tissue: "porcine liver",
        curve: "ball of 4 mm, median of 221 sites".to_owned(),
        body,
        cells,
        points: points.clone(),
        answers,
    };
    let compared = vec![
        of("--tissue liver".to_owned(), answers.clone()),
        of(format!("--tissue liver --young-pa {young_pa:.0}"), best),
    ];
    Ok(Liver { compared, quartiles, young_pa })
}

/// The number of cells of a block, and the force at each depth at rest there \[N\].
fn pressed(known: &KnownTissue, points: &[[f64; 2]]) -> Result<(usize, Vec<f64>)> {
    let mesh = block()?;
    let bottom_m = -0.5 * BLOCK_M[2];
    let is_fixed = |node: &[f64; 3]| node[2] < bottom_m + 0.02 * COARSE_M;
    let nodes = (0..).zip(&mesh.nodes_m).filter(|(_, node)| is_fixed(node));
    let fixed: Vec<u32> = nodes.map(|(node, _)| node).collect();
    let options = BakeOptions { tissue: Some(tissue(known, DEVICE_HZ)), ..BakeOptions::default() };
    let image = bake(&mesh, &fixed, &options)?;
    let (model, contact) = (parse(&image)?, Contact::sphere(BALL_M as f32, 0.0));
    let cells = model.cells();
    let change = |settings: Settings| Settings { max_force_n: 1e3, ..settings };
    let variant = Variant::single(Scheme::Predict, true);
    let mut engine = variant.unlimited(model, contact, SWEEPS, change)?;
    // From above the surface from depth to depth.
    let (mut last_m, mut forces_n) = (-ABOVE_M, Vec::new());
    for &[to_m, _] in points {
        let mut force_n = 0.0;
        for tick in 1..=MOVING + RESTING {
            interrupt::check()?;
            let depth_m =
                last_m + f64::from(tick.min(MOVING)) / f64::from(MOVING) * (to_m - last_m);
            let height_m = 0.5 * BLOCK_M[2] + BALL_M - depth_m;
            let output = engine.tick(&ToolPose::at(Vector3::new(0.0, 0.0, height_m as f32), 1));
            if output.flags.contains(Flags::MOTION_CLAMPED) {
                return Err(Error::check(format!("the ball was stopped before {depth_m} m")));
            }
            force_n = f64::from(output.force_n[2]);
        }
        forces_n.push(force_n);
        last_m = to_m;
    }
    Ok((cells, forces_n))
}

/// A block whose tetrahedra are fine under the ball.
fn block() -> Result<Mesh> {
    let folder = tempfile::tempdir().map_err(Error::check)?;
    let path = folder.path().join("block.stl");
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    fs::write(&path, surface(BLOCK_M, axes)).map_err(|why| Error::file("write", &path, why))?;
    let centre_m = [0.0, 0.0, 0.5 * BLOCK_M[2]];
    let regions = vec![Region::Ball { centre_m, radius_m: NEAR_M }];
    let finer = Some(Finer { size_m: FINE_M, regions });
    let filling = Some(Filling { size_m: COARSE_M, finer });
    load(&path.to_string_lossy(), &MeshOptions { filling, ..MeshOptions::default() })
}

/// The curves of the liver.
pub fn liver_figure(of: &Liver) -> Result<Figure> {
    let axes = (Axis::linear("depth [mm]"), Axis::linear("force [N]"));
    let mut chart = Chart::new("Porcine liver under a ball of 4 mm radius", axes.0, axes.1);
    let mm = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().map(|point| [1e3 * point[0], point[1]]).collect()
    };
    if let Some(first) = of.compared.first() {
        chart = chart.series("measured, median", Style::Markers, &mm(&first.points));
    }
    for (label, place) in [("measured, a quarter below", 1), ("measured, a quarter above", 2)] {
        let points: Vec<[f64; 2]> = of.quartiles.iter().map(|row| [row[0], row[place]]).collect();
        chart = chart.series(label, Style::Dashed, &mm(&points));
    }
    for (compared, label) in
        of.compared.iter().zip(["--tissue liver", &format!("{:.1} kPa", 1e-3 * of.young_pa)])
    {
        chart = chart.series(label, Style::Line, &mm(&compared.line()));
    }
    let caption = "Ex vivo porcine liver (vu-arma-dev/robot-palpation-data), 221 sites, and a block of `--tissue \
                   liver`, 20 mm thick and held at its bottom, under the ball. Thickness, support and speed of the \
                   measurement are not known.";
    Ok(Figure::new("paper_tissue_liver", caption, Picture::of(&chart)?))
}
