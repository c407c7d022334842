//! See `chaincell_tests::fuzz::surface`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| chaincell_tests::fuzz::surface(data));
