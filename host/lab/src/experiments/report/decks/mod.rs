//! Verification cases of other programs beside bodies of this one: dimensions, loads and expected values are theirs,
//! meshes ours unless the deck brings one. The bodies are in equilibrium, in double precision. Code of others is
//! neither built nor copied.

mod beam;
mod body;
mod cube;
mod law;
mod steps;
mod traction;

use self::beam::BeamRow;
use self::body::Elements;
use self::cube::{Cube, CubeRow};
use self::law::{Material, Moduli};
use self::steps::StepRow;
use self::traction::{SOFT, STRETCHES, TractionRow};
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use crate::experiments::page::table::{Table, csv, percent};
use crate::experiments::page::{Context, Numbers, Section};
use chaincell_host::bake::{ORGAN_POISSON, ORGAN_YOUNG_PA};
use chaincell_host::error::Result;
use chaincell_host::interrupt;
use chaincell_host::mesh::{MeshOptions, load};

/// Nodes along the cylinder.
const CYLINDER: usize = 9;
/// Nodes across the bar.
const BAR: usize = 3;
/// Grids of the cantilever; the second is SOFA's own.
const BEAMS: [[usize; 3]; 2] = [[3, 3, 15], [5, 5, 30]];
/// Cells of the generated organs.
const ORGANS: [usize; 2] = [1000, 5000];
/// Points of a curve.
const POINTS: usize = 60;

const TEXT: [&str; 4] = [
    "Dimensions, loads and expected values are those of the programs named; none of their code is in this \
     one. Bodies are in equilibrium, in double precision, on meshes of this program unless said otherwise; nodal \
     shapes have the band that a bake adds.",
    "A uniform state does not depend on the mesh: in traction the nodal shapes are the closed form of their own \
     material to 1e-7, and the difference is that of two materials. That of nodal shapes is linear in stretch and \
     resists less than a neo-Hookean one in compression, more in tension. Links have a Poisson's ratio of 1/4 and are \
     not isotropic on a regular grid.",
    "The cantilever's expected sag is the beam's: Timoshenko's at 1/100 of its weight, the elastica's at all of it. \
     Linear tetrahedra are SOFA's element at small displacements, by our own code.",
    "DJTLED is the explicit method that the first author of the paper published in 2021. Its cube was drawn by its own \
     program on its own mesh of linear tetrahedra, nearly incompressible and neo-Hookean; here the same mesh is drawn \
     with our material. A longest step is h / c, h the least height of a tetrahedron, c the speed of a pressure wave: \
     calculated, not run.",
];

/// Everything computed.
#[derive(serde::Serialize)]
struct Rows {
    traction: Vec<TractionRow>,
    beam: Vec<BeamRow>,
    cube: Vec<CubeRow>,
    steps: Vec<StepRow>,
}

impl Rows {
    fn compute(quick: bool) -> Result<Self> {
        let mut traction = traction::cylinder(CYLINDER)?;
        traction.extend(traction::bar(BAR)?);
        let mut beam = Vec::new();
        for grid in &BEAMS[..if quick { 1 } else { BEAMS.len() }] {
            interrupt::check()?;
            beam.extend(beam::rows(*grid)?);
        }
        let deck = Cube::read()?;
        let mut cube = Vec::new();
        if !quick {
            for elements in [Elements::Shapes, Elements::Links] {
                interrupt::check()?;
                cube.push(deck.row(elements)?);
            }
        }
        Ok(Self { traction, beam, cube, steps: steps(&deck)? })
    }
}

/// The section.
pub(crate) fn section(context: &Context) -> Result<Section> {
    let rows = Rows::compute(context.quick)?;
    let mut numbers = vec![
        ("decks", csv(&rows.traction)),
        ("decks_beam", csv(&rows.beam)),
        ("decks_steps", csv(&rows.steps)),
    ];
    let mut tables =
        vec![cylinder_table(&rows.traction), bar_table(&rows.traction), beam_table(&rows.beam)];
    if !rows.cube.is_empty() {
        numbers.push(("decks_cube", csv(&rows.cube)));
        tables.push(cube_table(&rows.cube));
    }
    tables.push(steps_table(&rows.steps));
    Ok(Section {
        key: "decks",
        title: "Verification cases of others".to_owned(),
        text: TEXT.map(str::to_owned).to_vec(),
        figures: vec![figure()?],
        tables,
        numbers: numbers
            .into_iter()
            .map(|(name, csv)| Numbers { name: name.to_owned(), csv })
            .collect(),
        json: serde_json::json!(rows),
        ..Section::default()
    })
}

/// Explicit steps on the decks' meshes and on generated organs.
fn steps(deck: &Cube) -> Result<Vec<StepRow>> {
    let organ = |size: usize| -> Result<StepRow> {
        let mesh = load(&format!("organ:{size}"), &MeshOptions::default())?;
        let of = Moduli { young_pa: ORGAN_YOUNG_PA, poisson: ORGAN_POISSON };
        Ok(StepRow::of("generated organ, 5 kPa".to_owned(), &mesh, of, cube::DENSITY))
    };
    let cube = StepRow::of("DJTLED cube".to_owned(), &deck.mesh, cube::moduli(), cube::DENSITY);
    let grid = beam::grid(BEAMS[1])?;
    let beam = StepRow::of("SOFA cantilever".to_owned(), &grid.mesh, beam::moduli(), beam::DENSITY);
    let mut rows = vec![cube, beam];
    for size in ORGANS {
        rows.push(organ(size)?);
    }
    Ok(rows)
}

fn of_deck<'r>(rows: &'r [TractionRow], name: &str) -> Vec<&'r TractionRow> {
    rows.iter().filter(|row| row.deck.contains(name)).collect()
}

/// A strain in percent, to a hundred-thousandth; `-` where there is none.
fn strain(of: f64) -> String {
    // The sum takes the sign from a zero.
    if of.is_nan() { "-".to_owned() } else { format!("{:.3}", (1e5 * of).round() / 1e3 + 0.0) }
}

fn cylinder_table(rows: &[TractionRow]) -> (String, Table) {
    let rows = of_deck(rows, "cylinder");
    let cells = rows.first().map_or(0, |row| row.cells);
    let table = Table::of(rows)
        .column("Poisson's ratio", |row| row.poisson)
        .column("traction [E]", |row| format!("{:.3}", row.expected.stress))
        .column("strain expected [%]", |row| strain(row.expected.along))
        .column("nodal shapes [%]", |row| strain(row.shapes.along))
        .column("links [%]", |row| strain(row.links.along))
        .column("across, expected [%]", |row| strain(row.expected.across))
        .column("across, nodal shapes [%]", |row| strain(row.shapes.across))
        .column("across, links [%]", |row| strain(row.links.across));
    let caption = format!(
        "SOFA's cylinder of linear elements in traction, 0.2 x 1 (LinearElasticity_test.cpp), {cells} cells: strains \
         along and across it; SOFA expects Hooke's at every load"
    );
    (caption, table.table())
}

fn bar_table(rows: &[TractionRow]) -> (String, Table) {
    let rows = of_deck(rows, "bar");
    let cells = rows.first().map_or(0, |row| row.cells);
    let table = Table::of(rows)
        .column("stretch", |row| format!("{:.2}", 1.0 + row.expected.along))
        .column("force by area, neo-Hookean [E]", |row| format!("{:.4}", row.expected.stress))
        .column("nodal shapes [E]", |row| format!("{:.4}", row.shapes.stress))
        .column("off by [%]", |row| percent(row.shapes.stress / row.expected.stress - 1.0))
        .column("across, neo-Hookean [%]", |row| strain(row.expected.across))
        .column("across, nodal shapes [%]", |row| strain(row.shapes.across));
    let caption = format!(
        "SOFA's bar of NeoHookean, 1 x 1 x 2.7, 10 kPa, Poisson's ratio 0.45 \
         (TetrahedronHyperelasticityFEMForceField.scn), {cells} cells, drawn and pressed: beside the closed form"
    );
    (caption, table.table())
}

fn beam_table(rows: &[BeamRow]) -> (String, Table) {
    let mm = |of_m: f64| format!("{:.4}", 1e3 * of_m);
    let off = |of_m: f64, row: &BeamRow| percent(of_m / row.expected_m - 1.0);
    let table = Table::of(rows)
        .column("cells", |row| row.cells)
        .column("mean edge [mm]", |row| format!("{:.1}", 1e3 * row.edge_m))
        .column("weight", |row| row.weight)
        .column("beam [mm]", |row| mm(row.expected_m))
        .column("nodal shapes [mm]", |row| mm(row.shapes_m))
        .column("off by [%]", |row| off(row.shapes_m, row))
        .column("links off by [%]", |row| off(row.links_m, row))
        .column("linear tetrahedra off by [%]", |row| {
            row.tetrahedra_m.map_or_else(|| "-".to_owned(), |of_m| off(of_m, row))
        });
    let caption = "SOFA's cantilever, 20 x 20 x 200 mm, 2 MPa, Poisson's ratio 0.45, 1,100 kg/m^3 \
                   (examples/Validation/cantilever_beam), under its weight: sag of its end";
    (caption.to_owned(), table.table())
}

fn cube_table(rows: &[CubeRow]) -> (String, Table) {
    let table = Table::of(rows)
        .column("body", |row| row.body)
        .column("cells", |row| row.cells)
        .column("field off by [%]", |row| percent(row.field))
        .column("of what is not even [%]", |row| percent(row.uneven))
        .column("force [N]", |row| format!("{:.1}", row.force_n))
        .column("DJTLED [N]", |row| format!("{:.1}", row.expected_n))
        .column("off by [%]", |row| percent(row.force_n / row.expected_n - 1.0));
    let caption = "DJTLED's dented cube (models/NH.txt), 0.1 m, 19.6 kPa, Poisson's ratio 0.49, drawn by half of its \
                   length, on its own mesh: distance of the displacements, and the force";
    (caption.to_owned(), table.table())
}

fn steps_table(rows: &[StepRow]) -> (String, Table) {
    let table = Table::of(rows)
        .column("body", |row| row.body.clone())
        .column("cells", |row| row.cells)
        .column("least height [mm]", |row| format!("{:.2}", 1e3 * row.height_m))
        .column("pressure wave [m/s]", |row| format!("{:.1}", row.wave_m_per_s))
        .column("longest step [ms]", |row| format!("{:.4}", 1e3 * row.step_s))
        .column("explicit steps in 1 ms", |row| row.steps)
        .column("a shear wave crosses the body in [ms]", |row| {
            format!("{:.0}", 1e3 * row.crossed_s)
        });
    let caption = format!(
        "Steps of an explicit method in the millisecond in which a tick makes at most 4 sweeps: calculated. DJTLED's \
         deck itself takes steps of {} ms. A tick is quasi-static: it does not wait for the wave",
        1e3 * cube::STEP_S
    );
    (caption, table.table())
}

/// Force of the bar over its stretch, of each material.
fn figure() -> Result<Figure> {
    let materials = [
        ("nodal shapes", Material::Shapes(SOFT)),
        ("neo-Hookean (SOFA)", Material::NeoHooke(SOFT)),
        ("neo-Hookean (DJTLED)", Material::Isochoric(SOFT)),
        ("Hooke", Material::Hooke(SOFT)),
    ];
    let axes = (Axis::linear("stretch"), Axis::linear("force by area at rest [E]"));
    let mut chart = Chart::new("A bar drawn along its axis, by its material", axes.0, axes.1);
    let [from, to] = [STRETCHES[0] - 0.2, STRETCHES[STRETCHES.len() - 1]];
    for (name, material) in materials {
        let point = |at: usize| -> Result<[f64; 2]> {
            let along = from + (to - from) * at as f64 / POINTS as f64;
            Ok([along, material.at_stretch(along)?.stress_pa / SOFT.young_pa])
        };
        let points: Vec<[f64; 2]> = (0..=POINTS).map(point).collect::<Result<_>>()?;
        chart = chart.series(name, Style::Line, &points);
    }
    let caption = "Closed forms at Poisson's ratio 0.45. Below a stretch of 0.7 the band of nodal shapes resists as well.";
    Ok(Figure::new("decks", caption, Picture::of(&chart)?))
}
