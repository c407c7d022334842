//! Fig. 4: a plane of 21 x 21 cells, its border fixed and its centre displaced, by the network and
//! by traditional `ChainMail`.

use chaincell_kernel::{Settings, ToolPose};
use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::bodies::Variant;
use crate::chainmail::{ChainMail, Limits};
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use crate::charts::{ColourBar, Panel, Sheet};
use crate::experiments::page::table::Table;
use crate::experiments::page::{Context, Numbers, Section};
use crate::experiments::report::scene::{Scene, Source};
use crate::reference::profile::{in_input_order, middle_row, nonlinearity};
use crate::reference::vectors::{minus, norm};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::error::Result;
use chaincell_host::mesh::Mesh;
use chaincell_host::picture::{Body, Paint};

/// Displacement of the centre \[m\].
const DEPTH_M: f64 = 0.03;
/// Nodes along each side, and the centre's id.
const NODES: [usize; 2] = [21, 21];
const CENTRE: usize = 220;
/// Moments of the relaxation [dimensionless time].
const MOMENTS: [u32; 3] = [1, 10, 100];
/// Steps of `euler` in a unit of time, within the bound of either plane.
const STEPS: u32 = 10;
/// Ticks of the pull and of the hold after it, and sweeps a tick, of the equilibrium.
const PULL_TICKS: u32 = 300;
const HOLD_TICKS: u32 = 2000;
const SWEEPS: u16 = 4;
/// Bounds of the chain with 4 and 8 neighbours: so wide that the pull reaches the border, ten links
/// away, or the cells before it. A diagonal of generalised `ChainMail` may shear by as much as both its sides.
const CHAIN_ALPHA: [f64; 2] = [0.3, 0.18];
/// Relaxation sweeps of the chain's second shape.
const RELAXATIONS: u32 = 1000;
/// A band of the network's links.
const BAND_ALPHA: f64 = 0.1;

/// The figures of Fig. 4.
pub fn section(_context: &Context) -> Result<Section> {
    let planes = [Plane::new(false)?, Plane::new(true)?];
    let mut json = json!({ "depth_m": DEPTH_M, "chainmail_alpha": CHAIN_ALPHA });
    for plane in &planes {
        json[plane.name()] = plane.json()?;
    }
    let [four, eight] = planes.each_ref().map(Plane::nonlinearities);
    let rows = planes[0].shapes.iter().zip(four?).zip(eight?);
    let table = Table::of(rows)
        .column("method", |((shape, _), _)| &shape.method)
        .column("4 neighbours", |((_, four), _)| format!("{four:.3}"))
        .column("8 neighbours", |(_, eight)| format!("{eight:.3}"))
        .table();
    let caption = "Distance of the middle row from the straight sides of a pyramid: root mean square \
                   over the cells between centre and border, as a fraction of the depth. 0 is a \
                   pyramid, 0.18 a parabola, 0.58 a spike";
    let mut figures = vec![Figure {
        name: "paper_plane".into(),
        caption: format!(
            "Under the network the plane is a tent with hollow sides, under ChainMail a pyramid with \
             straight ones. Fig. 4: 21 x 21 cells, 10 mm apart, border fixed, centre displaced by {:.0} \
             mm. Left the network at equilibrium, right ChainMail right after the move; 4 neighbours \
             above, 8 below.",
            1e3 * DEPTH_M
        ),
        picture: sheet(&planes).draw()?,
    }];
    let mut numbers = Vec::new();
    for plane in &planes {
        let caption = format!(
            "The network is a spike at first and spreads to a tent with hollow sides; those of ChainMail \
             run straight, jagged with 8 neighbours. Profiles along the middle row, {} neighbours: the \
             network at equilibrium and on its way there, and ChainMail.",
            plane.neighbours
        );
        let name = format!("paper_profile_{}", plane.neighbours);
        figures.push(Figure::new(name.as_str(), caption, Picture::of(&plane.chart()?)?));
        numbers.push(Numbers { name, csv: plane.csv()? });
    }
    Ok(Section {
        key: "plane",
        title: "Fig. 4: a plane deformed by the network and by traditional ChainMail".into(),
        results: vec![(
            "Fig. 4: ChainMail gives a pyramid, the network a non-linear shape",
            result(&planes)?,
        )],
        text: text(),
        figures,
        tables: vec![(caption.into(), table)],
        numbers,
        json,
    })
}

/// The paper's finding and ours.
fn result(planes: &[Plane; 2]) -> Result<String> {
    let [four, eight] = planes.each_ref().map(Plane::nonlinearities);
    let (four, eight) = (four?, eight?);
    Ok(format!(
        "The plane, its centre held {:.0} mm away. Distance of the profile from the straight sides of \
         a pyramid, over the depth: with 4 neighbours ChainMail {:.3}, the network {:.3} at \
         equilibrium and {:.2} to {:.2} on the way there; with 8 neighbours ChainMail {:.3}, the \
         network {:.3}.",
        1e3 * DEPTH_M,
        four[CHAINMAIL],
        four[0],
        four[MOMENTS.len()],
        four[1],
        eight[CHAINMAIL],
        eight[0]
    ))
}

fn text() -> Vec<String> {
    vec![
        format!(
            "The paper shows a plane that the network deforms nonlinearly where traditional ChainMail \
             gives a straight-sided pyramid. Both are computed here: the network with alpha 0 at its \
             equilibrium (track, {PULL_TICKS} ms of pull, {HOLD_TICKS} ms of hold), a cusp around the \
             contact point; ChainMail with bounds of {} of a link with 4 neighbours, so wide that \
             the pull just reaches the border, and {} with 8. With 8 the difference is small: a \
             diagonal may shear by as much as both its sides, so the chain's sides are jagged about \
             straight lines.",
            CHAIN_ALPHA[0], CHAIN_ALPHA[1]
        ),
        "Which moment is shown matters, and the paper does not say which. On the way to equilibrium \
         (euler, centre displaced at t = 0; t is the network's own time, dP/dt = sum of mu \
         (P_j - P_i)) the profile is a spike first, far from straight, and \
         spreads slowly; a band of slack keeps it pointed for ever. ChainMail's own elastic \
         relaxation, run to its end, bends its sides too: the pyramid is the shape right after a \
         move, which is what is compared here."
            .into(),
    ]
}

/// A plane's shape under one method.
struct Shape {
    method: String,
    key: String,
    positions_m: Vec<[f64; 3]>,
}

impl Shape {
    fn new(method: impl Into<String>, key: impl Into<String>, positions_m: Vec<[f64; 3]>) -> Self {
        Self { method: method.into(), key: key.into(), positions_m }
    }

    fn profile(&self) -> Result<Vec<[f64; 2]>> {
        middle_row(&self.positions_m, NODES)
    }
}

/// Where `ChainMail` stands among the shapes; the network at equilibrium comes first.
const CHAINMAIL: usize = 5;

/// The plane with 4 or 8 neighbours under every method.
struct Plane {
    neighbours: u8,
    mesh: Mesh,
    shapes: Vec<Shape>,
}

impl Plane {
    fn new(diagonals: bool) -> Result<Self> {
        let source = Source::plane(diagonals)?;
        let scene = source.with_alpha(0.0)?;
        let mut shapes = vec![Shape::new("network, equilibrium", "network", equilibrium(&scene)?)];
        for (t, positions_m) in relaxation(&scene)? {
            shapes.push(Shape::new(
                format!("network, t = {t}"),
                format!("network_t{t}"),
                positions_m,
            ));
        }
        let banded = equilibrium(&source.with_alpha(BAND_ALPHA)?)?;
        let method = format!("network, alpha {BAND_ALPHA}, equilibrium");
        shapes.push(Shape::new(method, "network_band", banded));
        let [moved, relaxed] = chainmail(&source.mesh, diagonals)?;
        let method = "ChainMail";
        shapes.push(Shape::new(method, "chainmail", moved));
        let method = format!("{method}, {RELAXATIONS} relaxation sweeps");
        shapes.push(Shape::new(method, "chainmail_relaxed", relaxed));
        Ok(Self { neighbours: if diagonals { 8 } else { 4 }, mesh: source.mesh, shapes })
    }

    fn name(&self) -> String {
        format!("neighbours_{}", self.neighbours)
    }

    fn nonlinearities(&self) -> Result<Vec<f64>> {
        self.shapes.iter().map(|shape| Ok(nonlinearity(&shape.profile()?))).collect()
    }

    fn json(&self) -> Result<Value> {
        let mut json = json!({});
        for (shape, off) in self.shapes.iter().zip(self.nonlinearities()?) {
            json[&shape.key] = json!({ "nonlinearity": off });
        }
        Ok(json)
    }

    fn csv(&self) -> Result<String> {
        let keys: Vec<String> =
            self.shapes.iter().map(|s| format!("{0}_x_m,{0}_z_m", s.key)).collect();
        let profiles: Result<Vec<_>> = self.shapes.iter().map(Shape::profile).collect();
        let profiles = profiles?;
        let mut csv = format!("{}\n", keys.join(","));
        for at in 0..NODES[0] {
            let row: Vec<String> =
                profiles.iter().map(|p| format!("{:?},{:?}", p[at][0], p[at][1])).collect();
            csv += &format!("{}\n", row.join(","));
        }
        Ok(csv)
    }

    fn chart(&self) -> Result<Chart> {
        let mut chart = Chart::new(
            &format!("Profile of the pulled plane, {} neighbours", self.neighbours),
            Axis::linear("distance from the centre cell [mm]"),
            Axis::linear("height [mm]"),
        );
        let millimetres = |profile: &[[f64; 2]]| -> Vec<[f64; 2]> {
            profile.iter().map(|p| p.map(|x| 1e3 * x)).collect()
        };
        for (at, shape) in self.shapes.iter().enumerate() {
            let style = match at {
                0 => Style::MarkedLine,
                CHAINMAIL => Style::MarkedLine,
                _ => Style::Dashed,
            };
            if shape.key != "network_band" && shape.key != "chainmail_relaxed" {
                chart = chart.series(&shape.method, style, &millimetres(&shape.profile()?));
            }
        }
        Ok(chart)
    }
}

/// The network and `ChainMail` side by side.
fn sheet(planes: &[Plane; 2]) -> Sheet {
    let panels = planes.iter().flat_map(|plane| {
        [0, CHAINMAIL].map(|at| {
            let shape = &plane.shapes[at];
            Panel {
                title: format!("{}, {} neighbours", shape.method, plane.neighbours),
                bodies: vec![body(plane, shape)],
                close_up: None,
            }
        })
    });
    Sheet {
        title: "A plane pulled at its centre".into(),
        panels: panels.collect(),
        columns: 2,
        panel_height_px: 340,
        towards: [0.42, -1.0, 0.42],
        up: [0.0, 0.0, 1.0],
        bar: ColourBar { label: "displacement [mm]".into(), range: [0.0, 1e3 * DEPTH_M] },
    }
}

fn body(plane: &Plane, shape: &Shape) -> Body {
    let cells = shape.positions_m.iter().zip(&plane.mesh.nodes_m);
    let way = |(p, rest): (&[f64; 3], &[f64; 3])| 1e3 * norm(minus(*p, *rest));
    let sides = plane.mesh.links.iter().filter(|[i, j]| [1, NODES[1] as u32].contains(&(j - i)));
    Body {
        points_m: shape.positions_m.clone(),
        triangles: plane.mesh.triangles.clone(),
        paint: Paint::Values(cells.map(way).collect()),
        wires: sides.copied().collect(),
        unlit: false,
    }
}

/// Cells of an engine in input order \[m\].
fn positions(engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
    let positions_m = engine.positions_m();
    in_input_order(engine.network().model(), &positions_m)
}

/// The centre pulled up by a share of the depth.
fn pull(engine: &mut Engine<'_>, scene: &Scene, share: f64) {
    let position_m = scene.direction.map(|x| (-share * DEPTH_M * x) as f32);
    engine.tick(&ToolPose::at(Vector3::from(position_m), 1));
}

fn equilibrium(scene: &Scene) -> Result<Vec<[f64; 3]>> {
    let track = Variant::single(Scheme::Track, true);
    let mut engine = scene.engine(track, SWEEPS, |settings| settings)?;
    for tick in 0..=PULL_TICKS + HOLD_TICKS {
        pull(&mut engine, scene, f64::from(tick.min(PULL_TICKS)) / f64::from(PULL_TICKS));
    }
    Ok(positions(&mut engine))
}

/// The centre displaced at once, then the paper's own relaxation.
fn relaxation(scene: &Scene) -> Result<Vec<(u32, Vec<[f64; 3]>)>> {
    let step = 1.0 / STEPS as f32;
    let euler = Variant::single(Scheme::Euler, true);
    let mut engine = scene.engine(euler, 1, |settings| Settings { step, ..settings })?;
    pull(&mut engine, scene, 0.0);
    let mut steps = 0;
    let moments = MOMENTS.into_iter().map(|t| {
        while steps < t * STEPS {
            pull(&mut engine, scene, 1.0);
            steps += 1;
        }
        (t, positions(&mut engine))
    });
    Ok(moments.collect())
}

/// The chain right after the move, and relaxed.
fn chainmail(mesh: &Mesh, diagonals: bool) -> Result<[Vec<[f64; 3]>; 2]> {
    let limits = Limits::of_alpha(CHAIN_ALPHA[usize::from(diagonals)])?;
    let mut chain = ChainMail::new(&mesh.nodes_m, &mesh.links, &mesh.default_fixed, limits)?;
    let [x, y, z] = chain.rest_m()[CENTRE];
    chain.move_to(&[(CENTRE, [x, y, z + DEPTH_M])])?;
    let moved = chain.positions_m().to_vec();
    (0..RELAXATIONS).for_each(|_| chain.relax(&Limits::RIGID));
    Ok([moved, chain.positions_m().to_vec()])
}
