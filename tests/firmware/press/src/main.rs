//! Presses a body on an emulated Cortex-M7: the recipe of `host/BOARD.md`, which copies this folder.

#![no_std]
#![no_main]

use core::fmt::Display;
use core::panic::PanicInfo;

use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
use cortex_m as _;
use cortex_m_rt::entry;
use semihosting::{println, process};
use static_cell::ConstStaticCell;

/// The cells of the body, and the input id that the tool holds.
const CELLS: usize = 144;
const HELD: u32 = 122;

static IMAGE: &[u8] = include_model!("../../body.chaincell");
static TISSUE: ConstStaticCell<Tissue<CELLS, Track>> = ConstStaticCell::new(Tissue::new());

/// Prints why the kernel refuses something.
fn printed<T>(result: Result<T, impl Display>) -> Option<T> {
    result.map_err(|why| println!("{why}")).ok()
}

/// Presses the body; `None` where the kernel refuses the model or the settings.
fn press() -> Option<()> {
    let model = printed(Model::from_bytes(IMAGE))?;
    let network = printed(Network::new(model, Settings::for_model(&model)))?;
    let mut tissue = TISSUE.take().view();
    printed(tissue.reset(&network))?;
    let held = printed(model.cell_of_input(HELD).ok_or("the body has no such node"))?;
    printed(tissue.choose_contacts(&network, &[held]))?;
    let mut force_n = 0.0;
    for tick in 0..200_u16 {
        // On a board: sleep until the position interrupt, then read the encoders.
        let position_m = [0.0, 0.0, -f32::from(tick) / 32768.0].into();
        let output = tissue.tick(&network, &[ToolPose::at(position_m, 1)], Budget::All);
        // On a board: to the amplifiers, through `chaincell_kernel::stage`.
        force_n = output.force_n.z;
    }
    println!("force {} mN", (force_n * 1000.0) as i32);
    println!("state hash {:016x}", tissue.state_hash(&model));
    Some(())
}

#[entry]
fn main() -> ! {
    process::exit(i32::from(press().is_none()))
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    process::exit(2)
}
