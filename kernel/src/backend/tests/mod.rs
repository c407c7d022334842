//! The vector unit against the plain definitions, bit by bit; `cargo test --release -p
//! chaincell-kernel simd` checks the optimised build.

mod operations;

use super::VectorUnit;

/// The machine's unit, or a line that says what is skipped.
pub(crate) fn unit(test: &str) -> Option<VectorUnit> {
    let unit = VectorUnit::find();
    if unit.is_none() {
        std::println!("SKIPPED {test}: this processor has no vector unit that the kernel knows");
    }
    unit
}
