//! Ticks of a blade that cuts the body, counted in instructions.

use chaincell_kernel::Budget;

use crate::measure::{DENSE_PERIOD, PERIOD, Tissue, choose, count, network};
use crate::scene::{SCENE, SWEEPS, TICKS};
use crate::{board, console};

/// The scene from a whole body on: the dearest tick in which cells split, and the dearest of the others.
pub fn draw(tissue: &mut Tissue) -> Option<()> {
    let network = network(SWEEPS)?;
    choose(tissue)?;
    let (mut split, mut copies_of_that_tick, mut whole, mut copies) = (0, 0, 0, 0);
    for tick in 0..TICKS {
        let sample = SCENE.sample(tick);
        let instructions = count(|| tissue.tick(&network, &[sample], Budget::All));
        let made = tissue.cut_output(&network).copies.wrapping_sub(copies);
        copies += made;
        if made == 0 {
            whole = instructions.max(whole);
        } else if instructions > split {
            (split, copies_of_that_tick) = (instructions, made);
        }
    }
    console::number("instructions_per_tick_split", split);
    console::number("copies_of_that_tick", copies_of_that_tick);
    console::number("instructions_per_tick_whole", whole);
    console::number("opened_faces", tissue.cut_output(&network).opened_faces);
    console::number("copies", copies);
    deep(tissue)
}

/// The same ticks with interrupts at every depth, for the stack.
fn deep(tissue: &mut Tissue) -> Option<()> {
    let network = network(SWEEPS)?;
    choose(tissue)?;
    board::interrupt_every(DENSE_PERIOD);
    for tick in 0..TICKS {
        let output = tissue.tick(&network, &[SCENE.sample(tick)], Budget::All);
        board::apply(output.force_n.into());
    }
    board::interrupt_every(PERIOD);
    Some(())
}
