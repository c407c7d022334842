//! A body in a microcontroller: the kernel in a control loop at 1 kHz, checked and measured.
//!
//! The position interrupt hands samples to the loop through the kernel's queue. The image plays
//! its scene, then ticks from the worst state, against the clock and at rest, and says on the
//! debugger's channel, one `name value` a line, what `tests/firmware/runner` compares and holds
//! against its budgets.
#![no_std]
#![no_main]

#[cfg_attr(target_arch = "arm", path = "arm.rs")]
#[cfg_attr(target_arch = "riscv32", path = "riscv.rs")]
mod board;
#[cfg(any(feature = "canary-panic", feature = "canary-alloc"))]
mod canary;
#[cfg(feature = "checks")]
mod checks;
mod console;
#[cfg(feature = "cut")]
mod cut;
mod deadline;
mod feed;
mod measure;
mod memory;
mod panic;
mod scene;
mod stack;
#[cfg(all(feature = "surface", not(feature = "cut")))]
mod touch;

/// All of it; the board's start-up calls it once.
fn run() -> ! {
    stack::paint();
    console::log_here();
    #[cfg(any(feature = "canary-panic", feature = "canary-alloc"))]
    canary::sing();
    let done = memory::take().and_then(|mut tissue| {
        measure::play(&mut tissue)?;
        measure::worst(&mut tissue)?;
        deadline::meet(&mut tissue)?;
        #[cfg(all(feature = "surface", not(feature = "cut")))]
        touch::press(&mut tissue)?;
        #[cfg(feature = "cut")]
        cut::draw(&mut tissue)?;
        measure::rest(&mut tissue)?;
        console::number("stack_bytes", stack::deepest());
        #[cfg(feature = "checks")]
        checks::run(&mut tissue)?;
        Some(())
    });
    if done.is_none() {
        console::say("refused", "the kernel refuses this image's own scene");
    }
    board::exit(done.is_some())
}
