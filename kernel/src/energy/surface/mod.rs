//! Contact on surfaces: tools touch sample points of the surface's triangles, not cells.
//!
//! Sample points q lie on each triangle at rest: the centres of n^2 equal parts, at fixed weights `A_q` of
//! the triangle's corners, each with the share `a_q` of its area. With dist their depth in a part of a tool,
//! 0 outside, the term is
//!
//! ```text
//! E_c = sum over q of k_q dist^2 / 2,   k_q = c E a_q / h,   c = 8 R / h within 6 and 20
//! ```
//!
//! R is the part's radius, h the mean edge length of the triangle and E Young's modulus there. Contact is
//! about as stiff as tissue of one edge length in depth. A stiffer contact is no more accurate: a coarse mesh
//! is too stiff under a small tool, and soft contact compensates for it. n is at least 2, and samples are at
//! most half a radius apart. Compared with quadratic elements, a quarter to half a radius deep, the force of
//! a sphere is 2 to 14 % low from R = 2 h on, within 17 % from h on, and below that known only to 30 %
//! (`tests/MEASURED.md`).
//!
//! **The theorem.** Half the squared distance to a set, here the outside of a part, curves upwards by at
//! most 1. So E_c curves by at most the sum of `k_q` `A_q'` `A_q`, whose row sums are `k_q` `A_q`: the cells'
//! bounds W grow by a third of the stiffness of each of their triangles in reach, and every certificate of a
//! scheme holds with that W. A tool of several parts is the sum of their terms: where parts overlap, each
//! presses.
//!
//! **Candidates.** The triangles in reach are found once per tick and stay the same in all its passes, so E_c
//! is one function in a tick. Beyond the capacity those deepest in the tools are kept.
//!
//! **The force** on a tool is the sum over the samples of `k_q` dist along the direction into the part, minus
//! the gradient of E_c by the tool's position: no sample makes a jump as it enters or leaves, since its force
//! is 0 at the part's surface. The torque is that of the same forces. Where the body is for it is decided by
//! `felt` in [`contact`](crate::contact).
//!
//! - `samples`: the points of a triangle.
//! - `solid`, `proxy`: the parts of a tool, and the tool as the tissue meets it.
//! - `edge`: the edge of a blade; `scissors`: where it lies between the blades of scissors.
//! - `friction`: anchors of samples in contact, and grips.
//! - `pins`: samples that are held to the world.
//! - `near`: a triangle in reach; [`contact`](crate::contact) finds them.
//! - `press`: force of a part on the samples of a triangle.
//! - `meeting`: energy, force, torque and stiffness of a tool over its triangles.
//! - `tool`: a tool and its contact.
//! - `touch`: the tools' part in passes over the cells.

mod edge;
mod friction;
mod meeting;
mod near;
mod pins;
mod press;
mod proxy;
mod samples;
mod scissors;
mod solid;
mod tool;
mod touch;

pub use edge::EDGE_BYTES;
#[cfg(feature = "cut")]
pub(crate) use edge::EDGE_SAMPLES;
pub(crate) use edge::{Edge, EdgeSample};
pub use friction::Anchor;
pub(crate) use meeting::Meeting;
pub use near::NearTriangle;
pub use pins::PINS_ARE_BUILT;
pub use pins::PinSample;
pub(crate) use press::each_met;
pub(crate) use proxy::Proxy;
pub use proxy::{PARTS_MAX, TOOLS_MAX};
pub(crate) use samples::{Sample, each as each_sample};
pub use scissors::Scissors;
pub(crate) use scissors::{COUNT_RAD, Crossing};
pub(crate) use solid::Solid;
pub(crate) use tool::Proxies;
pub use tool::ToolState;
pub(crate) use touch::{Pulled, Touch, Touching};

/// True if this kernel is built with contact on surfaces.
pub(crate) const IS_BUILT: bool = cfg!(feature = "surface");
/// 1 if it is, else 0: the length of arrays that only contact needs.
pub(crate) const BUILT: usize = IS_BUILT as usize;
