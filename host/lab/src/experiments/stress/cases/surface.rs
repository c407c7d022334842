//! Tools on the surface of links and of nodal shapes that do what no hand does.

use chaincell_kernel::{Model, ToolPart, ToolPose};

use super::hands::cut;
use super::material::stiffening;
use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::{Positions, Trial};
use crate::monitor::{Act, Step};
use crate::states::{State, scattered};
use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "surface-deep",
        checks: "spheres of 0.2 and 0.5 edges pressed by 0.9 of the body, there, then gone",
        run: deep,
    },
    Case {
        name: "surface-jumps",
        checks: "sphere of 2 edges into the body and out every 3 ticks, then anywhere within a width, \
                 every tick",
        run: teleport,
    },
    Case {
        name: "surface-squeeze",
        checks: "two spheres, two half spaces from both sides until they meet; then gone",
        run: squeeze,
    },
    Case {
        name: "surface-turns",
        checks: "capsule and rounded box turning in the body, by 0.3 and by 2.5 rad a tick",
        run: turns,
    },
    Case {
        name: "surface-half-space",
        checks: "half space over the whole body and back, upright and askew, in 20 ticks and at once",
        run: half_space,
    },
    Case {
        name: "surface-friction",
        checks: "friction 10: sphere and box pressed in and to and fro by 2 edges every tick",
        run: friction,
    },
    Case {
        name: "surface-grip",
        checks: "grip, away by 5 widths slowly and at once, let go in 1 and 20 ticks; with friction",
        run: grip,
    },
    Case {
        name: "surface-inside",
        checks: "engaged inside the body, every 4 ticks elsewhere",
        run: inside,
    },
    Case {
        name: "surface-folded",
        checks: "engaged at a body flat, mirrored, inside out, shaken, in one point, scattered",
        run: folded,
    },
    Case {
        name: "surface-energy-max",
        checks: "a tool may load 0.2 mJ: sphere with friction pressed in by a width and aside, large \
                 sphere anywhere, grip and away",
        run: energy_max,
    },
    Case {
        name: "surface-late",
        checks: "sphere within half a width, 6 of 10 ticks late, others cut to 1 or 2 sweeps",
        run: late,
    },
];

/// Ticks under tools, and ticks after them.
const HELD: u32 = 40;
const FREE: u32 = 12;
/// What a tool may load into a body of which that is hard \[J\].
const ENERGY_MAX_J: f64 = 2e-4;
/// Distance of the nodes \[m\].
const EDGE_M: f32 = 0.01;

/// What a trial has besides tools and a script.
#[derive(Clone, Copy, Default)]
struct Besides {
    /// Where the free cells start, where they are not at rest.
    state: Option<State>,
    friction: f32,
    /// Whether ticks are late or cut.
    is_late: bool,
}

/// Bodies and what they are measured by.
struct Bodies {
    bodies: Vec<(&'static str, Body)>,
    /// Half the width \[m\]; the centre \[m\].
    half_m: f32,
    centre_m: [f32; 3],
    held: u32,
    free: u32,
}

/// A box of links, one of liver, and one nearly of constant volume that stiffens.
fn bodies(scale: Scale) -> Result<Bodies> {
    let of = PerCell::Uniform;
    let stiffened = Tissue { stiffening: stiffening(), ..Tissue::new(of(5000.0), of(0.49)) };
    let kinds = [("links", None), ("liver", liver()), ("stiffened, nu 0.49", Some(stiffened))];
    baked(scale, kinds.into(), None)
}

fn liver() -> Option<Tissue> {
    Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45)))
}

/// What a body is called, and its nodal shapes; none for links.
type Kind = (&'static str, Option<Tissue>);

/// Boxes into which a tool may load this energy \[J\].
fn baked(scale: Scale, kinds: Vec<Kind>, energy_max_j: Option<f64>) -> Result<Bodies> {
    let nodes = scale.nodes() - 1;
    let bodies = kinds.into_iter().map(|(name, tissue)| {
        let options = BakeOptions { tissue, energy_max_j, ..BakeOptions::default() };
        Ok((name, Body::new(cuboid(nodes)?, &options)?))
    });
    let bodies = bodies.collect::<Result<Vec<_>>>()?;
    let half_m = 0.5 * EDGE_M * (nodes - 1) as f32;
    let centre_m = match bodies.first() {
        Some((_, body)) => body.plain()?.centre_m(),
        None => [0.0; 3],
    };
    Ok(Bodies { bodies, half_m, centre_m, held: scale.ticks(HELD), free: scale.ticks(FREE) })
}

impl Bodies {
    /// Plays a script of `held` ticks, after which the tools are gone, on every body.
    fn play(
        &self,
        found: &mut Findings,
        (label, tools): (&str, &[&[ToolPart]]),
        besides: Besides,
        script: impl Fn(u32) -> Step + Clone + 'static,
    ) -> Result<()> {
        for (body_label, body) in &self.bodies {
            let (held, script) = (self.held, script.clone());
            let trial = Trial::new(format!("{body_label}, {label}"), body, held + self.free);
            let trial = trial.under(move |tick| {
                let mut step = script(tick.min(held - 1));
                step.sweeps = cut(tick).filter(|_| besides.is_late);
                if tick >= held {
                    step.act = None;
                    step.poses.iter_mut().for_each(|pose| pose.engaged = 0);
                }
                step
            });
            let state = besides.state.map(|state| {
                Box::new(move |model: &Model<'_>| state.of_free_cells(model, 0)) as Positions
            });
            let parts = tools.iter().map(|parts| parts.to_vec()).collect();
            found.play(&Trial { state, tools: Some((parts, besides.friction)), ..trial })?;
        }
        Ok(())
    }

    /// A tool at a place from the centre \[half widths\].
    fn at(&self) -> impl Fn([f32; 3]) -> ToolPose + Copy + 'static {
        let (centre_m, half_m) = (self.centre_m, self.half_m);
        move |way| {
            let at_m: [f32; 3] = std::array::from_fn(|axis| centre_m[axis] + half_m * way[axis]);
            ToolPose::at(at_m.into(), 1)
        }
    }
}

/// A pose turned about y and x \[rad\].
fn turned(pose: ToolPose, angle: f32) -> ToolPose {
    let (sin, cos) = (libm::sinf(0.5 * angle), libm::cosf(0.5 * angle));
    ToolPose { orientation: [0.6 * sin, 0.8 * sin, 0.0, cos], ..pose }
}

/// From 0 to 1 in `ticks`, then 1.
fn ramp(tick: u32, ticks: u32) -> f32 {
    tick.min(ticks) as f32 / ticks as f32
}

fn deep(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    for share in [0.2_f32, 0.5] {
        let sphere = ToolPart::sphere(share * EDGE_M);
        let (at, held) = (bodies.at(), bodies.held);
        let radius = share * EDGE_M / bodies.half_m;
        bodies.play(
            found,
            (&format!("{share} edges"), &[&[sphere]]),
            Besides::default(),
            move |tick| {
                let depth = 1.8 * ramp(tick, held / 2);
                Step::of(&[at([0.13, 0.07, 1.0 + radius - depth])])
            },
        )?;
    }
    Ok(())
}

fn teleport(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let sphere = [ToolPart::sphere(2.0 * EDGE_M)];
    let at = bodies.at();
    bodies.play(found, ("in and out", &[&sphere]), Besides::default(), move |tick| {
        let up = if (tick / 3) % 2 == 0 { 0.2 } else { 4.0 };
        Step::of(&[at([0.1, 0.05, up])])
    })?;
    let places = scattered(5, bodies.held as usize, 2.0);
    bodies.play(found, ("anywhere", &[&sphere]), Besides::default(), move |tick| {
        Step::of(&[at(places[tick as usize])])
    })
}

fn squeeze(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let (at, held) = (bodies.at(), bodies.held);
    let radius_m = 1.5 * EDGE_M;
    let radius = radius_m / bodies.half_m;
    let sphere = [ToolPart::sphere(radius_m)];
    bodies.play(found, ("spheres", &[&sphere, &sphere]), Besides::default(), move |tick| {
        let x = 1.2 + radius - (1.2 + radius) * ramp(tick, 2 * held / 3);
        Step::of(&[at([x, 0.1, 0.3]), at([-x, 0.05, 0.35])])
    })?;
    // The half space of a tool is what lies below its z = 0: a quarter turn puts it aside.
    let plane = [ToolPart::half_space(0.4 * EDGE_M)];
    let aside = std::f32::consts::FRAC_1_SQRT_2;
    bodies.play(found, ("half spaces", &[&plane, &plane]), Besides::default(), move |tick| {
        let x = 1.2 - 1.2 * ramp(tick, 2 * held / 3);
        let (right, left) = (at([x, 0.0, 0.0]), at([-x, 0.0, 0.0]));
        let right = ToolPose { orientation: [0.0, -aside, 0.0, aside], ..right };
        Step::of(&[right, ToolPose { orientation: [0.0, aside, 0.0, aside], ..left }])
    })
}

fn turns(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let at = bodies.at();
    let capsule = [ToolPart::capsule(0.8 * bodies.half_m, 0.5 * EDGE_M)];
    let rounded =
        [ToolPart::rounded_box([0.6 * bodies.half_m, EDGE_M, 0.5 * EDGE_M], 0.3 * EDGE_M)];
    for (name, part) in [("capsule", &capsule), ("rounded box", &rounded)] {
        for angle in [0.3_f32, 2.5] {
            let label = format!("{name}, {angle} rad");
            bodies.play(found, (&label, &[part]), Besides::default(), move |tick| {
                let depth = ramp(tick, 30);
                Step::of(&[turned(at([0.1, 0.0, 1.6 - 1.3 * depth]), angle * tick as f32)])
            })?;
        }
    }
    Ok(())
}

fn half_space(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let at = bodies.at();
    let plane = [ToolPart::half_space(0.5 * EDGE_M)];
    for (name, angle) in [("upright", std::f32::consts::PI), ("askew", 2.4)] {
        for every in [20, 1] {
            let label = format!("{name}, {every} ticks");
            bodies.play(found, (&label, &[&plane]), Besides::default(), move |tick| {
                let part = ramp(tick % (2 * every), every);
                let up = 1.5 - 3.0 * if (tick / (2 * every)) % 2 == 0 { part } else { 1.0 - part };
                Step::of(&[turned(at([0.0, 0.0, up]), angle)])
            })?;
        }
    }
    Ok(())
}

fn friction(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let at = bodies.at();
    let side = 2.0 * EDGE_M / bodies.half_m;
    let sphere = [ToolPart::sphere(1.2 * EDGE_M)];
    let rounded = [ToolPart::rounded_box([0.8 * EDGE_M; 3], 0.4 * EDGE_M)];
    for (name, part) in [("sphere", &sphere), ("rounded box", &rounded)] {
        let up = 1.0 + 1.2 * EDGE_M / bodies.half_m;
        let rough = Besides { friction: 10.0, ..Besides::default() };
        bodies.play(found, (name, &[part]), rough, move |tick| {
            let way = if tick % 2 == 0 { side } else { -side };
            let at_m = [way, 0.3 * way, up - 0.8 * ramp(tick, 40)];
            Step::of(&[turned(at(at_m), 0.05 * tick as f32)])
        })?;
    }
    Ok(())
}

fn grip(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let (at, held) = (bodies.at(), bodies.held);
    let sphere = [ToolPart::sphere(1.5 * EDGE_M)];
    let up = 1.0 + 1.5 * EDGE_M / bodies.half_m;
    for (name, away, fade, friction) in
        [("slowly", 40, 20, 0.0), ("at once", 1, 1, 0.0), ("with friction", 40, 20, 1.0)]
    {
        let rough = Besides { friction, ..Besides::default() };
        bodies.play(found, (name, &[&sphere]), rough, move |tick| {
            let (gripped, let_go) = (held / 4, 3 * held / 4);
            let act = match tick {
                _ if tick == gripped => Some(Act::Grip(0)),
                _ if tick == let_go => Some(Act::LetGo(0, fade)),
                _ => None,
            };
            let pulled = 10.0 * ramp(tick.saturating_sub(gripped), away);
            let z = up - 0.3 * ramp(tick, gripped) + pulled;
            Step { act, ..Step::of(&[at([0.1 + 0.2 * pulled, 0.0, z])]) }
        })?;
    }
    Ok(())
}

fn inside(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let (at, places) = (bodies.at(), scattered(9, 20, 0.8));
    for (name, radius) in [("small", 0.4), ("large", 2.0)] {
        let (sphere, places) = ([ToolPart::sphere(radius * EDGE_M)], places.clone());
        bodies.play(found, (name, &[&sphere]), Besides::default(), move |tick| {
            let pose = at(places[(tick / 4) as usize % places.len()]);
            Step::of(&[ToolPose { engaged: u16::from(tick % 4 > 0), ..pose }])
        })?;
    }
    Ok(())
}

fn folded(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let at = bodies.at();
    let rounded = [ToolPart::rounded_box([EDGE_M; 3], 0.5 * EDGE_M)];
    for (name, state) in [
        ("flat", State::Flattened),
        ("mirrored", State::Mirrored),
        ("inside out", State::Inverted),
        ("shaken", State::Shaken),
        ("in one point", State::Coincident([0.0, 0.0, 0.2])),
        ("scattered", State::Scattered(10.0)),
    ] {
        let from = Besides { state: Some(state), ..Besides::default() };
        bodies.play(found, (name, &[&rounded]), from, move |tick| {
            Step::of(&[turned(at([0.1, 0.0, 0.6 - 0.4 * ramp(tick, 30)]), 0.1 * tick as f32)])
        })?;
    }
    Ok(())
}

fn energy_max(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = baked(scale, vec![("links", None), ("liver", liver())], Some(ENERGY_MAX_J))?;
    let (at, held) = (bodies.at(), bodies.held);
    let sphere = [ToolPart::sphere(1.5 * EDGE_M)];
    let up = 1.0 + 1.5 * EDGE_M / bodies.half_m;
    let rough = Besides { friction: 1.0, ..Besides::default() };
    bodies.play(found, ("pressed", &[&sphere]), rough, move |tick| {
        Step::of(&[at([
            ramp(tick.saturating_sub(held / 2), 10),
            0.0,
            up - 2.0 * ramp(tick, held / 2),
        ])])
    })?;
    let places = scattered(11, bodies.held as usize, 2.0);
    let large = [ToolPart::sphere(3.0 * EDGE_M)];
    bodies.play(found, ("anywhere", &[&large]), Besides::default(), move |tick| {
        Step::of(&[at(places[(tick / 2) as usize])])
    })?;
    bodies.play(found, ("gripped", &[&sphere]), Besides::default(), move |tick| {
        let act = (tick == 12).then_some(Act::Grip(0));
        let pulled = 3.0 * ramp(tick.saturating_sub(12), 30);
        Step { act, ..Step::of(&[at([0.1, 0.0, up - 0.1 * ramp(tick, 12) + pulled])]) }
    })
}

fn late(scale: Scale, found: &mut Findings) -> Result<()> {
    let bodies = bodies(scale)?;
    let (at, places) = (bodies.at(), scattered(3, bodies.held as usize, 1.0));
    let sphere = [ToolPart::sphere(1.5 * EDGE_M)];
    for friction in [0.0, 0.5] {
        let late = Besides { friction, is_late: true, ..Besides::default() };
        let places = places.clone();
        let label = format!("friction {friction}");
        bodies.play(found, (&label, &[&sphere]), late, move |tick| {
            let [x, y, z] = places[(tick / 2) as usize];
            Step::of(&[at([x, y, 1.2 + z])])
        })?;
    }
    Ok(())
}
