//! The laboratory around chaincell: what the paper and the report show, measured.
//!
//! Each module uses only those above it:
//!
//! - [`reference`]: the static minimum in double precision, and published data.
//! - [`baseline`]: the methods that chaincell is compared with.
//! - [`charts`]: curves and bodies as pictures.
//! - [`experiments`]: report, paper, stress, soak and identification.
//! - [`cli`]: the command line of `chaincell-lab`.

pub mod baseline;
pub mod charts;
pub mod cli;
pub mod experiments;
pub mod reference;
