//! The links' bands, the first term: half the squared distance of `P_j` - `P_i` to a shell.
//!
//! - [`law`]: the arithmetic of one link in single precision.
//! - [`number`]: requirements of a link on a number type. Fixed point has its own file.
//! - [`range`]: the range of models that a number type supports.
//! - `bands`: the links of a body in a tick; `term`: their part in a pass and at the cells of a tool.
//! - `memory`: links that relax; `follow`: their memory follows their tension at the start of a tick.
//! - `scalar`, `sliced`, `vfp`: the residual link by link, eight cells side by side, and with the
//!   floating-point unit of Armv7E-M.

pub(crate) mod bands;
mod fixed_point;
#[cfg(feature = "relax")]
pub(crate) mod follow;
pub mod law;
#[cfg(feature = "relax")]
mod memory;
pub mod number;
pub mod range;
pub(crate) mod scalar;
pub(crate) mod sliced;
mod term;
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
pub(crate) mod vfp;
