//! A body in a microcontroller: the kernel in a control loop at 1 kHz, checked and measured.
//!
//! The position interrupt hands samples to the loop through the kernel's queue. The image plays
//! its scene, then ticks from the worst state and at rest, and says on the debugger's channel, one
//! `name value` a line, what `tests/firmware/runner` compares and holds against its budgets.
#![no_std]
#![no_main]

#[cfg_attr(target_arch = "arm", path = "arm.rs")]
#[cfg_attr(target_arch = "riscv32", path = "riscv.rs")]
mod board;
#[cfg(any(feature = "canary-panic", feature = "canary-alloc"))]
mod canary;
mod console;
mod feed;
mod measure;
mod motion;
mod panic;
mod scene;
mod stack;

use chaincell_kernel::{Model, Network, Tissue};
use static_cell::ConstStaticCell;

/// The body's state.
type Body = Tissue<{ scene::CELLS }, scene::Scheme, { scene::HELD.len() }>;

static BODY: ConstStaticCell<Body> = ConstStaticCell::new(Tissue::new());

/// All of it; the board's start-up calls it once.
fn run() -> ! {
    stack::paint();
    console::log_here();
    #[cfg(any(feature = "canary-panic", feature = "canary-alloc"))]
    canary::sing();
    match prepare() {
        Some(()) => board::exit(true),
        None => {
            console::say("refused", "the kernel refuses this image's own scene");
            board::exit(false)
        }
    }
}

/// Sets the scene up and runs it; `None` where the kernel refuses a part of it.
fn prepare() -> Option<()> {
    let model = Model::from_bytes(scene::IMAGE).ok()?;
    let network = |sweeps| Network::new(model, scene::settings(&model, sweeps)).ok();
    let mut held = [0; scene::HELD.len()];
    for (cell, id) in held.iter_mut().zip(scene::HELD) {
        *cell = model.cell_of_input(id)?;
    }
    held.sort_unstable();
    let tissue = BODY.try_take()?;
    tissue.reset(&network(scene::SWEEPS)?).ok()?;
    tissue.choose_contacts(&network(scene::SWEEPS)?, &held).ok()?;
    measure::play(&mut tissue.view(), &network(scene::SWEEPS)?);
    measure::worst(&mut tissue.view(), &network)?;
    tissue.reset(&network(scene::SWEEPS)?).ok()?;
    measure::rest(&mut tissue.view(), &network(scene::SWEEPS)?);
    console::number("stack_bytes", stack::deepest());
    Some(())
}
