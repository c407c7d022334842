//! Ticks of the scene, from the worst state and at rest, counted in instructions.

use chaincell_kernel::{Dynamics, Model, Network, TissueMut, ToolSample};
use nalgebra::Vector3;

use crate::{board, console, feed, motion, scene};

/// Sweeps of the two ticks whose difference gives the cost of a sweep.
const FEW: u16 = 1;
const MANY: u16 = 5;
/// Worst ticks in a row, so that momentum and the guard's decisions are met too.
const WORST_TICKS: u32 = 3;
/// Ticks at rest: the look for sleepers comes every 16th.
const REST_TICKS: u32 = 33;
/// Instructions from one position interrupt to the next: 1 ms at 400 MHz.
const PERIOD: u32 = 400_000;
/// The same where interrupts are to meet every depth of the stack.
const DENSE_PERIOD: u32 = 5_000;

/// The scene: a tick for each sample that the interrupt hands over.
pub fn play<D: Dynamics>(tissue: &mut TissueMut<'_, D>, network: &Network<'_>) {
    let model = network.model();
    let Some(mut samples) = feed::start(model.unit_m(), scene::TICKS) else { return };
    board::interrupt_every(PERIOD);
    let (mut ticks, mut force_n) = (0, 0.0_f32);
    while ticks < scene::TICKS {
        let Some(sample) = samples.dequeue() else {
            board::wait();
            continue;
        };
        let output = tissue.tick(network, &sample);
        board::apply(output.force_n.into());
        force_n += output.force_n.z;
        ticks += 1;
    }
    console::number("cells", model.cells() as u32);
    console::number("links", model.links() as u32);
    console::number("hats", model.hats() as u32);
    console::number("ticks", ticks);
    console::number("late", feed::late());
    console::number("force_bits", force_n.to_bits());
    console::bits("state_hash", tissue.state_hash(model));
}

/// Instructions of one tick, interrupts off.
fn count<D: Dynamics>(
    tissue: &mut TissueMut<'_, D>,
    network: &Network<'_>,
    sample: &ToolSample,
) -> u32 {
    critical_section::with(|_| {
        let before = board::instructions();
        let output = tissue.tick(network, sample);
        let after = board::instructions();
        board::apply(output.force_n.into());
        after.wrapping_sub(before)
    })
}

/// Every link out of its band, the tool holding its cells; `None` where the kernel refuses that.
pub fn worst<'m, D: Dynamics>(
    tissue: &mut TissueMut<'_, D>,
    network: &impl Fn(u16) -> Option<Network<'m>>,
) -> Option<()> {
    let counted = |tissue: &mut TissueMut<'_, D>, sweeps: u16| {
        let network = network(sweeps)?;
        spread(tissue, &network)?;
        let samples = (0..WORST_TICKS).map(|tick| motion::sample(network.model().unit_m(), tick));
        let first = samples.map(|sample| count(tissue, &network, &sample));
        Some(first.fold((0, 0), |(first, worst), count| {
            (if first == 0 { count } else { first }, if count > worst { count } else { worst })
        }))
    };
    let (few, _) = counted(tissue, FEW)?;
    let (many, _) = counted(tissue, MANY)?;
    let (_, worst) = counted(tissue, scene::SWEEPS)?;
    console::number("instructions_per_sweep_worst", (many - few) / u32::from(MANY - FEW));
    console::number("instructions_per_tick_worst", worst);
    console::number("instructions_first_tick", few);
    // Once more with interrupts at every depth, for the stack.
    let network = network(scene::SWEEPS)?;
    spread(tissue, &network)?;
    board::interrupt_every(DENSE_PERIOD);
    for tick in 0..WORST_TICKS {
        tissue.tick(&network, &motion::sample(network.model().unit_m(), tick));
    }
    board::interrupt_every(PERIOD);
    Some(())
}

/// Puts the body into its worst state.
fn spread<D: Dynamics>(tissue: &mut TissueMut<'_, D>, network: &Network<'_>) -> Option<()> {
    tissue.set_positions(network, bytemuck::try_cast_slice(scene::WORST).ok()?).ok()?;
    tissue.forbid_sleep(network.model());
    Some(())
}

/// An untouched body.
pub fn rest<D: Dynamics>(tissue: &mut TissueMut<'_, D>, network: &Network<'_>) {
    let away = ToolSample { position_m: Vector3::zeros(), engaged: 0 };
    let counts = (0..REST_TICKS).map(|_| count(tissue, network, &away));
    console::number("instructions_per_tick_rest", counts.max().unwrap_or(0));
    let model: &Model<'_> = network.model();
    console::bits("rest_hash", tissue.state_hash(model));
}
