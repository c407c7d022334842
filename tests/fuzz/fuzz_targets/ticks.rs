//! See `chaincell_tests::fuzz::ticks`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| chaincell_tests::fuzz::ticks(data));
