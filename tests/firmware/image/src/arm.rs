//! Cortex-M: start-up, position interrupt on SysTick, instructions on a timer of the board.
//!
//! Where one instruction is one nanosecond (`-icount shift=0`) a clock of 25 MHz counts 40
//! instructions.
#![allow(unsafe_code)]

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};
use cortex_m_rt::{entry, exception};
use semihosting::process;

/// Instructions that a clock counts.
const PER_CLOCK: u32 = 40;
/// The free-running timer of the MPS2 boards (CMSDK APB timer 0): control, value, reload.
const TIMER: *mut u32 = 0x4000_0000 as *mut u32;
const TIMER_ON: u32 = 1;

#[entry]
fn start() -> ! {
    // SAFETY: the MPS2 boards have the timer's registers at this address.
    unsafe {
        TIMER.add(2).write_volatile(u32::MAX);
        TIMER.add(1).write_volatile(u32::MAX);
        TIMER.write_volatile(TIMER_ON);
    }
    crate::run()
}

/// Instructions so far, wrapping; counted in steps of 40.
pub fn instructions() -> u32 {
    // SAFETY: as above.
    let value = unsafe { TIMER.add(1).read_volatile() };
    (u32::MAX - value).wrapping_mul(PER_CLOCK)
}

/// The position interrupt comes every so many instructions from here on.
pub fn interrupt_every(instructions: u32) {
    // SAFETY: nobody else in this program touches SysTick.
    let mut clock = unsafe { Peripherals::steal() }.SYST;
    begin(&mut clock, instructions / PER_CLOCK - 1);
}

fn begin(clock: &mut SYST, reload: u32) {
    clock.set_clock_source(SystClkSource::Core);
    clock.set_reload(reload);
    clock.clear_current();
    clock.enable_counter();
    clock.enable_interrupt();
}

#[exception]
fn SysTick() {
    crate::feed::due();
}

/// Sleeps until the next interrupt.
pub fn wait() {
    cortex_m::asm::wfi();
}

/// Hands a force to the device's amplifiers; here to nobody, yet it must be computed.
pub fn apply(force_n: [f32; 3]) {
    core::hint::black_box(force_n);
}

/// Ends the run.
pub fn exit(well: bool) -> ! {
    process::exit(i32::from(!well))
}
