//! Loops for the floating-point unit of Armv7E-M, with as few instructions as its registers allow:
//! loads and stores of several registers, no way through the core's.
//!
//! VMLA and VMLS round the product and the sum, as two instructions would.

pub(crate) mod pass;
pub(crate) mod update;
