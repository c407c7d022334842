//! Compares the vector unit with the plain definitions, bit by bit; `cargo test --release -p chaincell-kernel
//! simd` checks the optimised build.

mod operations;

use super::VectorUnit;

/// Returns the machine's unit, or prints that the test is skipped.
pub(crate) fn unit(test: &str) -> Option<VectorUnit> {
    let unit = VectorUnit::find();
    if unit.is_none() {
        std::println!("SKIPPED {test}: this processor has no vector unit that the kernel knows");
    }
    unit
}
