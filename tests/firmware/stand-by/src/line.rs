//! The serial line and the clock of its silences: the first UART of the MPS2 boards, and SysTick.
//!
//! On a board of your own, bytes that come while a tick computes go through DMA or an interrupt into a queue; the
//! emulated UART holds them back.
#![allow(unsafe_code)]

use cortex_m::asm::wfi;
use cortex_m::interrupt::{self, InterruptNumber};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, Peripherals, SCB};

/// Registers of the UART (CMSDK APB UART): data, state, control, interrupt, divider of the baud rate.
const UART: *mut u32 = 0x4000_4000 as *mut u32;
const DATA: usize = 0;
const STATE: usize = 1;
const CONTROL: usize = 2;
const INTERRUPT: usize = 3;
const DIVIDER: usize = 4;
/// A byte has come, as state and as interrupt.
const RECEIVED: u32 = 2;
/// Control: receive, with an interrupt.
const RECEIVE: u32 = 2 | 8;
/// Clocks of the core in a tick of a millisecond.
const CLOCKS_PER_TICK: u32 = 25_000;
/// Ticks without a byte after which the line is silent. A mirror sends at least every 100 ms.
const SILENT_TICKS: u32 = 300;

/// The interrupt of a byte that has come.
#[derive(Clone, Copy)]
struct Received;

// SAFETY: 0 is the number of that interrupt on the MPS2 boards.
unsafe impl InterruptNumber for Received {
    fn number(self) -> u16 {
        0
    }
}

fn read(register: usize) -> u32 {
    // SAFETY: the MPS2 boards have the UART's registers at this address.
    unsafe { UART.add(register).read_volatile() }
}

fn write(register: usize, value: u32) {
    // SAFETY: as above.
    unsafe { UART.add(register).write_volatile(value) }
}

/// The line.
pub struct Line {
    /// True once a byte has come: until then there is no silence.
    has_begun: bool,
}

impl Line {
    /// Starts UART and clock. Their interrupts only wake the core: no handler runs.
    pub fn begin() -> Self {
        interrupt::disable();
        write(DIVIDER, 16);
        write(CONTROL, RECEIVE);
        // SAFETY: nobody else in this program uses the core's peripherals.
        let mut clock = unsafe { Peripherals::steal() }.SYST;
        clock.set_clock_source(SystClkSource::Core);
        clock.set_reload(CLOCKS_PER_TICK - 1);
        clock.clear_current();
        clock.enable_counter();
        clock.enable_interrupt();
        // SAFETY: all interrupts are masked.
        unsafe { NVIC::unmask(Received) };
        Self { has_begun: false }
    }

    /// The next byte; `None` once the line has been silent for [`SILENT_TICKS`].
    pub fn next(&mut self) -> Option<u8> {
        let mut ticks = 0;
        loop {
            if read(STATE) & RECEIVED != 0 {
                self.has_begun = true;
                return Some(read(DATA) as u8);
            }
            if SCB::is_pendst_pending() {
                SCB::clear_pendst();
                ticks += u32::from(self.has_begun);
                if ticks > SILENT_TICKS {
                    return None;
                }
            }
            // A byte that has come since the look is pending, and ends the sleep at once.
            wfi();
            write(INTERRUPT, RECEIVED);
            NVIC::unpend(Received);
        }
    }
}
