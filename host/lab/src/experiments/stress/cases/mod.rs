//! The cases, by what is hard about them.

mod bodies;
mod drift;
mod floats;
mod hands;
mod material;
mod surface;

use super::case::{Case, Findings, Scale};
use super::trial::Trial;
use crate::bodies::shape::cuboid;
use crate::bodies::{Body, Shape};
use crate::monitor::Step;
use crate::states::State;
use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;

/// All of them, in the order of the table.
pub fn all() -> impl Iterator<Item = Case> {
    let groups =
        [bodies::CASES, material::CASES, surface::CASES, hands::CASES, floats::CASES, drift::CASES];
    groups.concat().into_iter()
}

/// Ticks of a press of [`pressing`].
const PRESS_TICKS: u32 = 80;
/// Ticks after a state, and after a press, in the quick suite.
const TICKS: u32 = 60;

/// The box of links.
fn the_box(scale: Scale) -> Result<Body> {
    plain(cuboid(scale.nodes())?)
}

/// The box of links and that of nodal shapes.
fn boxes(scale: Scale) -> Result<Vec<(&'static str, Body)>> {
    each_material(&cuboid(scale.nodes())?, &BakeOptions::default())
}

/// A body of links and, where the mesh has elements, one of nodal shapes, with these options besides.
fn each_material(shape: &Shape, options: &BakeOptions) -> Result<Vec<(&'static str, Body)>> {
    let mut bodies = vec![("links", Body::new(shape.clone(), options)?)];
    if !shape.mesh.tetrahedra.is_empty() {
        let tissue = Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45)));
        let options = BakeOptions { tissue, ..options.clone() };
        bodies.push(("shapes", Body::new(shape.clone(), &options)?));
    }
    Ok(bodies)
}

/// A body of links by the default options.
fn plain(shape: Shape) -> Result<Body> {
    Body::new(shape, &BakeOptions::default())
}

/// Down by `depth_m` in 40 ticks, there for 40, then gone.
fn pressing(depth_m: f32) -> impl Fn(u32) -> Step {
    move |tick| {
        let part = tick.saturating_sub(1).min(39) as f32 / 39.0;
        Step::at([0.0, 0.0, -part * depth_m], u32::from(tick < PRESS_TICKS))
    }
}

/// Away, holding still, away again, a third of the ticks each.
fn touching_once(ticks: u32) -> impl Fn(u32) -> Step {
    move |tick| Step::at([0.0; 3], u32::from((ticks / 3..2 * ticks / 3).contains(&tick)))
}

/// A press by this many mean link lengths, and after it at least `free` ticks.
fn pressed<'b>(
    label: impl Into<String>,
    body: &'b Body,
    links: f32,
    free: u32,
) -> Result<Trial<'b>> {
    let depth_m = links * body.plain()?.unit_m();
    Ok(Trial::new(label, body, PRESS_TICKS + free).under(pressing(depth_m)))
}

/// From a state of the free cells, or of all.
fn displaced<'b>(label: &str, body: &'b Body, state: State, all: bool, ticks: u32) -> Trial<'b> {
    let cells = if all { "all cells" } else { "free cells" };
    let trial = Trial::new(format!("{label}, {cells}"), body, ticks);
    let trial = trial.from(move |model| match all {
        true => state.positions(model, 0),
        false => state.of_free_cells(model, 0),
    });
    trial.under(touching_once(ticks))
}

/// Presses a body by two mean link lengths and lets it go; inverts it; puts it into one point.
fn press_and_disturb(scale: Scale, found: &mut Findings, name: &str, body: &Body) -> Result<()> {
    let ticks = scale.ticks(TICKS);
    found.play(&pressed(format!("{name}, pressed"), body, 2.0, ticks)?)?;
    for (label, state) in
        [("inverted", State::Inverted), ("in one point", State::Coincident([0.0; 3]))]
    {
        found.play(&displaced(&format!("{name}, {label}"), body, state, false, ticks))?;
    }
    Ok(())
}
