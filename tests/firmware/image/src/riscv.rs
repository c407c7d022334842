//! RISC-V `virt`: start-up, position interrupt on the machine timer, instructions from `minstret`.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use riscv::interrupt::Interrupt;
use riscv::register::{mie, minstret, mstatus};
use riscv_rt::{core_interrupt, entry};
use semihosting::process;

/// Instructions that a clock of the timer counts where one instruction is one nanosecond: it runs
/// at 10 MHz.
const PER_CLOCK: u32 = 100;
/// What the timer of hart 0 is compared with, low and high word, and the timer.
const COMPARE: *mut u32 = 0x0200_4000 as *mut u32;
const TIME: *const u32 = 0x0200_bff8 as *const u32;

/// Clocks from one interrupt to the next.
static PERIOD: core::sync::atomic::AtomicU32 = core::sync::atomic::AtomicU32::new(0);

#[entry]
fn start() -> ! {
    crate::run()
}

/// Instructions so far, wrapping.
pub fn instructions() -> u32 {
    minstret::read64() as u32
}

/// The position interrupt comes every so many instructions from here on.
pub fn interrupt_every(instructions: u32) {
    PERIOD.store(instructions / PER_CLOCK, core::sync::atomic::Ordering::Relaxed);
    next();
    // SAFETY: the handler of the one interrupt that this lets in is below.
    unsafe {
        mie::set_mtimer();
        mstatus::set_mie();
    }
}

/// Sets the time of the next interrupt. A run takes less than the 430 s of a word's clocks.
fn next() {
    let period = PERIOD.load(core::sync::atomic::Ordering::Relaxed);
    // SAFETY: the board `virt` has the timer's registers at these addresses.
    unsafe {
        let at = TIME.read_volatile().wrapping_add(period);
        COMPARE.add(1).write_volatile(0);
        COMPARE.write_volatile(at);
    }
}

#[core_interrupt(Interrupt::MachineTimer)]
fn timer() {
    keep_floats();
}

/// Calls [`due`] with the caller's FPU registers kept: the trap of `riscv-rt` keeps those of the
/// integers alone.
#[unsafe(naked)]
extern "C" fn keep_floats() {
    naked_asm!(
        "addi sp, sp, -96",
        "sw ra, 0(sp)",
        "fsw ft0, 4(sp)",
        "fsw ft1, 8(sp)",
        "fsw ft2, 12(sp)",
        "fsw ft3, 16(sp)",
        "fsw ft4, 20(sp)",
        "fsw ft5, 24(sp)",
        "fsw ft6, 28(sp)",
        "fsw ft7, 32(sp)",
        "fsw ft8, 36(sp)",
        "fsw ft9, 40(sp)",
        "fsw ft10, 44(sp)",
        "fsw ft11, 48(sp)",
        "fsw fa0, 52(sp)",
        "fsw fa1, 56(sp)",
        "fsw fa2, 60(sp)",
        "fsw fa3, 64(sp)",
        "fsw fa4, 68(sp)",
        "fsw fa5, 72(sp)",
        "fsw fa6, 76(sp)",
        "fsw fa7, 80(sp)",
        "frcsr t0",
        "sw t0, 84(sp)",
        "call {due}",
        "lw t0, 84(sp)",
        "fscsr t0",
        "lw ra, 0(sp)",
        "flw ft0, 4(sp)",
        "flw ft1, 8(sp)",
        "flw ft2, 12(sp)",
        "flw ft3, 16(sp)",
        "flw ft4, 20(sp)",
        "flw ft5, 24(sp)",
        "flw ft6, 28(sp)",
        "flw ft7, 32(sp)",
        "flw ft8, 36(sp)",
        "flw ft9, 40(sp)",
        "flw ft10, 44(sp)",
        "flw ft11, 48(sp)",
        "flw fa0, 52(sp)",
        "flw fa1, 56(sp)",
        "flw fa2, 60(sp)",
        "flw fa3, 64(sp)",
        "flw fa4, 68(sp)",
        "flw fa5, 72(sp)",
        "flw fa6, 76(sp)",
        "flw fa7, 80(sp)",
        "addi sp, sp, 96",
        "ret",
        due = sym due,
    )
}

extern "C" fn due() {
    next();
    crate::feed::due();
}

/// Sleeps until the next interrupt.
pub fn wait() {
    riscv::asm::wfi();
}

/// Hands a force to the device's amplifiers; here to nobody, yet it must be computed.
pub fn apply(force_n: [f32; 3]) {
    core::hint::black_box(force_n);
}

/// Ends the run.
pub fn exit(well: bool) -> ! {
    process::exit(i32::from(!well))
}
