//! A tissue by name beside its measured curves: human cortex in tension, compression and shear.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs;

use chaincell_host::bake::tissue::{Band, BandSide, KnownTissue, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell, bake};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::Model;
use chaincell_lab::reference::{Nodal, Stiffening};
use nalgebra::{Matrix3, Vector3};

/// A body whose links have all directions.
const BODY: &str = "organ:300";
/// Change of a stretch or shear for a difference.
const STEP: f64 = 1e-4;

/// A point of a curve: `T`, `C` or `S`, stretch or shear, nominal stress \[Pa\].
struct Point {
    mode: String,
    value: f64,
    stress_pa: f64,
}

fn points(text: &str) -> Vec<Point> {
    let point = |line: &str| {
        let mut fields = line.split(',');
        let mode = fields.next().unwrap().to_owned();
        let [value, stress_kpa] = [(); 2].map(|()| fields.next().unwrap().parse::<f64>().unwrap());
        Point { mode, value, stress_pa: 1e3 * stress_kpa }
    };
    text.lines().skip(1).filter(|line| !line.is_empty()).map(point).collect()
}

/// A body in uniform strain, in double precision.
struct Uniform {
    rest: Vec<[f64; 3]>,
    shapes: Nodal,
    bands: Stiffening,
    /// Energy unit over the body's volume \[J/m^3\].
    unit_pa: f64,
}

impl Uniform {
    fn of(tissue: Tissue) -> Self {
        let mesh = load(BODY, &MeshOptions::default()).unwrap();
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let volumes = mesh.tetrahedra.iter().map(|nodes| {
            let [a, b, c, d] = nodes.map(|node| Vector3::from(mesh.nodes_m[node as usize]));
            (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
        });
        Self {
            rest: (0..model.cells()).map(|cell| model.rest_position(cell).map(f64::from)).collect(),
            shapes: Nodal::of_model(&model).unwrap().unwrap(),
            bands: Stiffening::of_model(&model),
            unit_pa: f64::from(model.energy_unit_j()) / volumes.sum::<f64>(),
        }
    }

    /// Energy for each volume \[J/m^3\].
    fn density_pa(&self, gradient: Matrix3<f64>) -> f64 {
        let at: Vec<[f64; 3]> =
            self.rest.iter().map(|rest| (gradient * Vector3::from(*rest)).into()).collect();
        let energies = [self.shapes.energies(&at), self.bands.energies(&at)];
        self.unit_pa * energies.iter().flatten().sum::<f64>()
    }

    /// Nominal stress \[Pa\]: of a strip that is free across, or in simple shear.
    fn stress_pa(&self, point: &Point) -> f64 {
        let mut across = if point.mode == "S" { 1.0 } else { point.value.powf(-0.45) };
        let density_pa = |value: f64, across: f64| {
            self.density_pa(match point.mode.as_str() {
                "S" => Matrix3::new(1.0, value, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
                _ => Matrix3::from_diagonal(&Vector3::new(across, across, value)),
            })
        };
        if point.mode != "S" {
            // The stretch across at which the energy is least, by parabolas.
            for _ in 0..4 {
                let [below, at, above] =
                    [-STEP, 0.0, STEP].map(|step| density_pa(point.value, across + step));
                across -= 0.5 * STEP * (above - below) / (above - 2.0 * at + below);
            }
        }
        let [ahead, behind] = [STEP, -STEP].map(|step| density_pa(point.value + step, across));
        (ahead - behind) / (2.0 * STEP)
    }

    /// Root mean square distance from the points of a mode, over their peak.
    fn misfit(&self, points: &[Point], mode: &str) -> f64 {
        let points = || points.iter().filter(|point| point.mode == mode);
        let peak_pa = points().map(|point| point.stress_pa.abs()).fold(0.0, f64::max);
        let squares: f64 =
            points().map(|point| (self.stress_pa(point) - point.stress_pa).powi(2)).sum();
        (squares / points().count() as f64).sqrt() / peak_pa
    }
}

/// The band on the side of compression alone is what the three curves ask for: bands of both sides cannot follow them.
#[test]
fn the_cortex_of_the_table_follows_its_curves() {
    let Some(folder) = chaincell_tests::reference("the_cortex_of_the_table_follows_its_curves")
    else {
        return;
    };
    let text = fs::read_to_string(folder.join("tissue/brain_cortex.csv")).unwrap();
    let points = points(&text);
    let cortex = KnownTissue::find("brain_cortex").unwrap();
    let of = |stiffening: Vec<Band>| {
        let tissue =
            Tissue::new(PerCell::Uniform(cortex.young_pa), PerCell::Uniform(cortex.poisson));
        let body = Uniform::of(Tissue { stiffening, ..tissue });
        ["T", "C", "S"].map(|mode| body.misfit(&points, mode))
    };
    let own = of(cortex.stiffening.clone());
    let both: Vec<Band> =
        cortex.stiffening.iter().map(|band| Band { side: BandSide::Both, ..*band }).collect();
    let both = of(both);
    println!("misfit in tension, compression, shear: {own:.3?}; by bands of both sides {both:.3?}");
    assert!(own[0] < 0.03 && own[1] < 0.05 && own[2] < 0.05, "{own:?}");
    assert!(both[0] > 0.1, "{both:?}");
}
