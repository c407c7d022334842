//! Long runs: both processes for hours, with load beside them, and what that did to latencies and
//! memory.
//!
//! The text and `histogram.csv` give wake-up, step and round trip in buckets of a microsecond, and
//! the same of the machine alone (`floor_*`), measured for a tenth of the time before and after. An
//! answer later than 1 ms counts under its cause: sent late (the controller was not woken in time),
//! in the step (the tick itself took too long), or on the way. Compare these counts with those of
//! the machine alone. Memory is counted in pages that no file on a disk backs, from the end of the
//! warm-up on. `soak.json` holds all figures. The exit code is 1 where a tick was not answered or a
//! process grew.
//!
//! - [`load`]: keeps the other cores and the memory busy.
//! - [`memory`]: what a process takes, page by page, and whether it grew.
//! - [`report`]: all figures of a run, and the verdict.
//! - [`write`](mod@write): the histogram as text, CSV and chart.

pub mod load;
pub mod memory;
pub mod report;
pub mod write;
