//! Long runs: both processes for hours, with load beside them, and what that did to latencies and
//! memory.
//!
//! - [`load`]: keeps the other cores and the memory busy.
//! - [`memory`]: what a process takes, page by page, and whether it grew.
//! - [`report`]: all figures of a run, and the verdict.
//! - [`write`](mod@write): the histogram as text, CSV and chart.

pub mod load;
pub mod memory;
pub mod report;
pub mod write;
