//! Fig. 6: the liver pressed by a virtual haptic probe, by the network and by `ChainMail`.
//!
//! `host/pictures/organ.png` is `paper_liver.png` of `chaincell paper` without reference data.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::press::{Pressed, Probe, SWEEPS, chainmail, network};
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use crate::charts::{ColourBar, Panel, Sheet, cut};
use crate::experiments::page::table::Table;
use crate::experiments::page::{Context, Numbers, Section};
use crate::experiments::report::scene::{Scene, Source};
use crate::reference::vectors::{minus, norm};
use chaincell_host::error::Result;
use chaincell_host::mesh::Mesh;
use chaincell_host::picture::{Body, Paint, front};
use chaincell_host::words::counted;

/// Radius of the probe and depth of the press [mean link lengths].
const RADIUS_LINKS: f64 = 3.0;
const DEPTH_LINKS: f64 = 1.25;
/// Bounds of the chain.
const CHAIN_ALPHA: f64 = 0.1;
/// Ticks of the press; a tick is a millisecond.
const TICKS: u64 = 1000;
const TICKS_QUICK: u64 = 200;
/// How far above level the eye is, and half the width of the close-ups in radii of the probe.
const ABOVE: f64 = 0.6;
const CLOSE_UP: f64 = 2.4;
/// Steel.
const PROBE_COLOUR: [u8; 3] = [176, 180, 188];

/// The pressed body with all that is known of it.
struct Case {
    scene: Scene,
    mesh: Mesh,
    probe: Probe,
    depth_m: f64,
    network: Pressed,
    chain: Pressed,
}

/// The figures of Fig. 6.
pub fn section(context: &Context) -> Result<Section> {
    let case = Case::new(context)?;
    let [mut network, chain] = [&case.network, &case.chain].map(|pressed| case.figures(pressed));
    let force_max_n = case.network.force_n.iter().copied().fold(0.0, f64::max);
    network["contacts"] = json!(case.network.contacts.get(case.probe.shown));
    let figures_of = [
        ("largest displacement [mm]", "displacement_max_mm"),
        ("nodes that moved by more than 0.1 mm", "moved"),
        ("tetrahedra turned inside out", "inverted"),
        ("step, median [us]", "step_us_p50"),
        ("step, 99 % [us]", "step_us_p99"),
    ];
    let table = Table::of(figures_of)
        .column("", |(name, _)| name)
        .column("network", |(_, key)| number(&network[key]))
        .column("ChainMail", |(_, key)| number(&chain[key]))
        .table();
    let caption =
        "At the moment of the pictures, late in the hold; times over the ticks in contact";
    let pressed = format!(
        "Under the network the whole organ follows the probe, most of all below it; ChainMail moves a \
         block with an edge. Fig. 6: {} ({} cells, {} tetrahedra) pressed {:.1} mm deep by a spherical \
         probe of {:.1} mm radius; colours show how far the surface has moved.",
        case.scene.source,
        case.mesh.nodes_m.len(),
        case.mesh.tetrahedra.len(),
        1e3 * case.depth_m,
        1e3 * case.probe.radius_m
    );
    let figures = case.pictures(pressed)?;
    Ok(Section {
        key: "liver",
        title: "Fig. 6: the liver under a haptic probe".into(),
        results: vec![(
            "Fig. 6: a better shape than ChainMail's",
            format!(
                "{:.1} mm deep under a moving probe of {:.0} mm radius: the network moves {} of {} \
                 smoothly and resists with up to {force_max_n:.2} N; ChainMail moves a block of {} \
                 cells with an edge and gives no force.",
                1e3 * case.depth_m,
                1e3 * case.probe.radius_m,
                network["moved"],
                counted(case.mesh.nodes_m.len(), "cell"),
                chain["moved"]
            ),
        )],
        text: case.text(&network, &chain),
        figures,
        tables: vec![(caption.into(), table)],
        numbers: vec![Numbers { name: "paper_liver_press".into(), csv: case.csv() }],
        json: json!({
            "body": case.scene.source,
            "cells": case.mesh.nodes_m.len(),
            "tetrahedra": case.mesh.tetrahedra.len(),
            "radius_m": case.probe.radius_m,
            "depth_m": case.depth_m,
            "ticks": case.probe.poses.len(),
            "shown_tick": case.probe.shown,
            "sweeps_per_tick": SWEEPS,
            "chainmail_alpha": CHAIN_ALPHA,
            "force_max_n": force_max_n,
            "network": network,
            "chainmail": chain,
        }),
    })
}

fn number(value: &Value) -> String {
    match value.as_f64() {
        Some(value) if value.fract() != 0.0 => format!("{value:.1}"),
        _ => value.to_string(),
    }
}

impl Case {
    fn new(context: &Context) -> Result<Self> {
        let source = match &context.reference {
            Some(folder) => Source::liver(folder)?,
            None => Source::organ(None)?,
        };
        let (scene, mesh) = (source.with_alpha(0.0)?, source.mesh);
        let unit_m = f64::from(scene.model()?.unit_m());
        let (radius_m, depth_m) = (RADIUS_LINKS * unit_m, DEPTH_LINKS * unit_m);
        let ticks = if context.quick { TICKS_QUICK } else { TICKS };
        let probe = Probe::new(&scene, radius_m, depth_m, ticks)?;
        let network = network(&scene, &probe)?;
        let chain = chainmail(&scene, &probe, CHAIN_ALPHA)?;
        Ok(Self { scene, mesh, probe, depth_m, network, chain })
    }

    fn text(&self, network: &Value, chain: &Value) -> Vec<String> {
        vec![
            format!(
                "The paper presses a liver of 5,762 mass points with a virtual haptic probe and finds \
                 the network's shape better than ChainMail's. Here a sphere of {:.0} mm radius is pressed \
                 {:.1} mm into the surface at 1 kHz, by the same motion for both: \
                 approach, press, hold with a hand's tremor, retreat in {} ms. The network takes \
                 {SWEEPS} sweeps a tick (track, alpha 0); ChainMail is the generalised form with bounds \
                 of {CHAIN_ALPHA} of a link, the surface elements inside the sphere put on it.",
                1e3 * self.probe.radius_m,
                1e3 * self.depth_m,
                self.probe.poses.len()
            ),
            format!(
                "The network moves the whole body a little, by more than 0.1 mm nearly everywhere, and \
                 steeply near the probe, as an elastic body does. ChainMail has an edge where the slack is \
                 used up and nothing beyond, and its block stays when the probe has gone. At this depth {} \
                 of {} tetrahedra are inside out under the network, {} under ChainMail. Links keep lengths, \
                 not volumes, and have more than one equilibrium: a body that lags behind the probe may end \
                 in one with folds. The scheme predict, the default of chaincell run, lags less, and bodies \
                 by Young's modulus have a band against folds.",
                network["inverted"],
                self.mesh.tetrahedra.len(),
                chain["inverted"]
            ),
        ]
    }

    /// The pictures of the section, the first with this caption.
    fn pictures(&self, pressed: String) -> Result<Vec<Figure>> {
        Ok(vec![
            Figure::new("paper_liver", pressed, self.sheet().draw()?),
            Figure::new(
                "paper_liver_force",
                "The force rises with the press, trembles with the hand and goes with the retreat. \
                 ChainMail has none to show.",
                Picture::of(&self.force())?,
            ),
        ])
    }

    /// Way of every node \[mm\].
    fn ways_mm(&self, at_m: &[[f64; 3]]) -> Vec<f64> {
        let pairs = at_m.iter().zip(&self.mesh.nodes_m);
        pairs.map(|(p, rest)| 1e3 * norm(minus(*p, *rest))).collect()
    }

    fn figures(&self, pressed: &Pressed) -> Value {
        let ways = self.ways_mm(&pressed.shown_m);
        let touching = self.network.contacts.iter().map(|&contacts| contacts > 0);
        let times = pressed.step_ns.iter().zip(touching);
        let mut times: Vec<u64> = times.filter(|(_, on)| *on).map(|(&ns, _)| ns).collect();
        times.sort_unstable();
        let us = |part: usize| {
            times
                .get(times.len().saturating_sub(1) * part / 100)
                .map_or(0.0, |&ns| 1e-3 * ns as f64)
        };
        let inverted = self.mesh.tetrahedra.iter().filter(|corners| {
            let [a, b, c, d] = corners.map(|id| Vector3::from(pressed.shown_m[id as usize]));
            (b - a).cross(&(c - a)).dot(&(d - a)) <= 0.0
        });
        json!({
            "displacement_max_mm": ways.iter().copied().fold(0.0, f64::max),
            "moved": ways.iter().filter(|&&way| way > 0.1).count(),
            "inverted": inverted.count(),
            "step_us_p50": us(50),
            "step_us_p99": us(99),
        })
    }

    fn sheet(&self) -> Sheet {
        let up = self.scene.direction.map(|x| -x);
        let front = front(&self.mesh.nodes_m, up);
        let [deep, touch] = self.probe.centres_m();
        let states = [
            ("initial state", &self.mesh.nodes_m, touch),
            ("network", &self.network.shown_m, deep),
            ("ChainMail", &self.chain.shown_m, deep),
        ];
        let whole = states.iter().map(|(title, at_m, probe_m)| Panel {
            title: (*title).into(),
            bodies: vec![self.body(at_m), self.ball(*probe_m)],
            close_up: None,
        });
        let opened = states.iter().map(|(title, at_m, probe_m)| {
            let ball = self.ball(*probe_m);
            // Tetrahedra from the middle of the ball to its skin.
            let mut solid = ball.clone();
            solid.points_m.push(*probe_m);
            let middle = ball.points_m.len() as u32;
            let wedges: Vec<[u32; 4]> =
                ball.triangles.iter().map(|&[a, b, c]| [a, b, c, middle]).collect();
            // A hair before the body's face, where links between the cells on it cross the ball.
            let before = std::array::from_fn(|x| deep[x] + 1e-3 * self.probe.radius_m * front[x]);
            let body = cut(&self.body(at_m), &self.mesh.tetrahedra, deep, front);
            Panel {
                title: format!("{title}, cut through the probe"),
                bodies: body.into_iter().chain(cut(&solid, &wedges, before, front)).collect(),
                close_up: Some((
                    std::array::from_fn(|x| deep[x] - 0.4 * self.probe.radius_m * up[x]),
                    CLOSE_UP * self.probe.radius_m,
                )),
            }
        });
        let largest = self.ways_mm(&self.network.shown_m).into_iter().fold(0.0, f64::max);
        Sheet {
            title: format!("A probe pressed {:.1} mm into {}", 1e3 * self.depth_m, self.name()),
            panels: whole.chain(opened).collect(),
            columns: 3,
            panel_height_px: 460,
            towards: std::array::from_fn(|x| front[x] + ABOVE * up[x]),
            up,
            bar: ColourBar { label: "displacement [mm]".into(), range: [0.0, largest.max(1e-9)] },
        }
    }

    fn body(&self, at_m: &[[f64; 3]]) -> Body {
        Body {
            points_m: at_m.to_vec(),
            triangles: self.mesh.triangles.clone(),
            paint: Paint::Values(self.ways_mm(at_m)),
            wires: Vec::new(),
            unlit: false,
        }
    }

    fn ball(&self, centre_m: [f64; 3]) -> Body {
        Body::sphere(centre_m, self.probe.radius_m, PROBE_COLOUR, 32)
    }

    fn name(&self) -> &'static str {
        if self.scene.name == "liver" { "the liver" } else { "a generated organ" }
    }

    fn force(&self) -> Chart {
        let force = self.network.force_n.iter().enumerate();
        let force: Vec<[f64; 2]> = force.map(|(tick, force_n)| [tick as f64, *force_n]).collect();
        Chart::new("Force on the probe", Axis::linear("time [ms]"), Axis::linear("force [N]"))
            .series("network", Style::Line, &force)
            .vertical(self.probe.shown as f64, "pictures")
    }

    fn csv(&self) -> String {
        let mut csv = String::from(
            "tick,x_m,y_m,z_m,force_n,network_contacts,network_step_ns,chainmail_contacts,\
             chainmail_step_ns\n",
        );
        for (tick, pose) in self.probe.poses.iter().enumerate() {
            let [x, y, z] = pose.position_m;
            let (network, chain) = (&self.network, &self.chain);
            csv += &format!(
                "{tick},{x:?},{y:?},{z:?},{:?},{},{},{},{}\n",
                network.force_n[tick],
                network.contacts[tick],
                network.step_ns[tick],
                chain.contacts[tick],
                chain.step_ns[tick]
            );
        }
        csv
    }
}
