//! RISC-V `virt`: start-up, position interrupt on the machine timer, instructions from `minstret`.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use riscv::interrupt::Interrupt;
use riscv::register::{mie, minstret, mstatus};
use riscv_rt::{core_interrupt, entry};
use semihosting::process;

/// Instructions that a clock of the timer counts: it runs at 10 MHz.
const PER_CLOCK: u32 = 100;
/// The timer of hart 0 and what it is compared with.
const TIME: *const u32 = 0x0200_bff8 as *const u32;
const COMPARE: *mut u32 = 0x0200_4000 as *mut u32;
