//! Ticks of the scene, from the worst state and at rest, counted in instructions.

use chaincell_kernel::tick::hash::state_hash;
use chaincell_kernel::{Budget, Model, Network, TickOutput, TissueMut, ToolPose};
use chaincell_scenes::{Run, Tools};
use nalgebra::Vector3;

use crate::scene::{LONG, SCENE, SHORT, SWEEPS, Scheme, TICKS, settings};
use crate::{board, console, feed};

/// Sweeps of the two ticks whose difference gives the cost of a sweep.
const FEW: u16 = 1;
pub const MANY: u16 = 5;
/// Worst ticks in a row, so that momentum and the guard's decisions are met too.
const WORST_TICKS: u32 = 3;
/// Ticks at rest: the look for sleepers comes every 16th.
const REST_TICKS: u32 = 33;
/// Instructions from one position interrupt to the next: 1 ms at 480 MHz.
pub const PERIOD: u32 = 480_000;
/// The same where interrupts are to meet every depth of the stack.
pub const DENSE_PERIOD: u32 = 5_000;

/// The tissue of all parts.
pub type Tissue = TissueMut<'static, Scheme>;

/// The same memory for a part of the run.
pub fn part<'a>(tissue: &'a mut Tissue) -> TissueMut<'a, Scheme> {
    TissueMut {
        head: tissue.head,
        state: tissue.state,
        residual: tissue.residual,
        own: tissue.own,
        room: tissue.room,
        contacts: tissue.contacts,
        states: tissue.states.reborrow(),
        touch: tissue.touch.reborrow(),
        cut: tissue.cut.reborrow(),
        team: tissue.team,
    }
}

/// The scene: a tick for each sample that the interrupt hands over. `None` where the kernel
/// refuses the scene, here as below.
pub fn play(tissue: &mut Tissue) -> Option<()> {
    let mut run = Run::new(&SCENE, part(tissue)).ok()?;
    let mut samples = feed::start(TICKS)?;
    board::interrupt_every(PERIOD);
    let (mut ticks, mut state_hash) = (0, 0);
    while ticks < TICKS {
        let Some(sample) = samples.dequeue() else {
            board::wait();
            continue;
        };
        let (output, hash) = run.tick_with(&sample);
        board::apply(output.force_n.into());
        state_hash = hash;
        ticks += 1;
    }
    console::number("ticks", ticks);
    console::number("late", feed::late());
    console::bits("state_hash", state_hash);
    console::bits("digest", run.digest());
    Some(())
}

/// Instructions of one tick, interrupts off.
pub fn count(tick: impl FnOnce() -> TickOutput) -> u32 {
    critical_section::with(|_| {
        let before = board::instructions();
        let output = tick();
        let after = board::instructions();
        board::apply(output.force_n.into());
        after.wrapping_sub(before)
    })
}

pub fn network(sweeps: u16) -> Option<Network<'static>> {
    let model = Model::from_bytes(SCENE.image).ok()?;
    Network::new(model, settings(&model, sweeps)).ok()
}

/// The tool in slow motion: every tick moves the cells it holds, or the tool into the surface.
pub fn moving(tick: u32) -> ToolPose {
    let way_m = 0.01 * SCENE.reach_m * tick as f32;
    let position_m = match SCENE.tools() {
        None => Vector3::new(way_m, 0.0, way_m),
        Some(Tools { start_m: [[x, y, z], _], .. }) => Vector3::new(x + way_m, *y, z - way_m),
    };
    ToolPose::at(position_m, 1)
}

/// Puts the body into a state and ticks; the most instructions of a tick, and those of the first.
fn counted(tissue: &mut Tissue, state: &[u8], sweeps: u16) -> Option<(u32, u32)> {
    let network = network(sweeps)?;
    put(tissue, state, &network)?;
    let mut counts = [0; WORST_TICKS as usize];
    for (tick, slot) in (0..).zip(&mut counts) {
        *slot = count(|| tissue.tick(&network, &[moving(tick)], Budget::All));
    }
    Some((counts.iter().copied().max()?, *counts.first()?))
}

/// Every link out of its band, too long and then too short, the tool holding its cells; the larger
/// of each figure.
pub fn worst(tissue: &mut Tissue) -> Option<()> {
    let (mut sweep, mut tick) = (0, 0);
    #[cfg(feature = "surface")]
    choose(tissue)?;
    for state in [LONG, SHORT] {
        let (_, few) = counted(tissue, state, FEW)?;
        let (_, many) = counted(tissue, state, MANY)?;
        let (most, _) = counted(tissue, state, SWEEPS)?;
        sweep = sweep.max(many.wrapping_sub(few) / u32::from(MANY - FEW));
        tick = tick.max(most);
        deep(tissue, state)?;
    }
    console::number("instructions_per_sweep_worst", sweep);
    console::number("instructions_per_tick_worst", tick);
    Some(())
}

/// Gives the tissue its tool again, after a reset.
#[cfg(feature = "surface")]
pub fn choose(tissue: &mut Tissue) -> Option<()> {
    let network = network(SWEEPS)?;
    let tools = SCENE.tools()?;
    tissue.reset(&network).ok()?;
    tissue.choose_tools(&network, tools.parts, tools.friction).ok()
}

/// The same ticks with interrupts at every depth, for the stack.
fn deep(tissue: &mut Tissue, state: &[u8]) -> Option<()> {
    let network = network(SWEEPS)?;
    put(tissue, state, &network)?;
    board::interrupt_every(DENSE_PERIOD);
    for tick in 0..WORST_TICKS {
        board::apply(tissue.tick(&network, &[moving(tick)], Budget::All).force_n.into());
    }
    board::interrupt_every(PERIOD);
    Some(())
}

pub fn put(tissue: &mut Tissue, state: &[u8], network: &Network<'_>) -> Option<()> {
    tissue.set_positions(network, bytemuck::try_cast_slice(state).ok()?).ok()?;
    tissue.forbid_sleep(network.model());
    Some(())
}

/// The state hash; of a body that relaxes that of its positions alone, since its clock runs at rest too.
fn at_rest(tissue: &Tissue, model: &Model<'_>) -> u64 {
    if model.relaxes() {
        return state_hash(tissue.state, &[], model.saturation());
    }
    tissue.state_hash(model)
}

/// An untouched body. Its first tick, which makes ready for motion, is apart.
pub fn rest(tissue: &mut Tissue) -> Option<()> {
    let network = network(SWEEPS)?;
    tissue.reset(&network).ok()?;
    let before = at_rest(tissue, network.model());
    let away = ToolPose::at(Vector3::zeros(), 0);
    console::number(
        "instructions_of_first_tick",
        count(|| tissue.tick(&network, &[away], Budget::All)),
    );
    let counts = (0..REST_TICKS).map(|_| count(|| tissue.tick(&network, &[away], Budget::All)));
    console::number("instructions_per_tick_rest", counts.max()?);
    let moved = at_rest(tissue, network.model()) != before;
    console::number("moved_at_rest", u32::from(moved));
    Some(())
}
