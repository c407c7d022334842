//! See `chaincell_tests::fuzz::meshes`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| chaincell_tests::fuzz::meshes(data));
