//! Passes samples from a position interrupt to the tick: a lock-free queue for one producer and one consumer,
//! from `heapless`.
//!
//! ```
//! use chaincell_kernel::handover::SampleQueue;
//! use chaincell_kernel::ToolPose;
//! use nalgebra::Vector3;
//!
//! let mut queue: SampleQueue<8> = SampleQueue::new(); // a `static mut` or a cell in firmware
//! let (mut interrupt, mut control_loop) = queue.split();
//! // In the interrupt: a full queue gives the sample back, and the tick holds the last good one.
//! let lost = interrupt.enqueue(ToolPose::at(Vector3::zeros(), 0)).is_err();
//! // In the 1 kHz loop: one tick a sample.
//! let sample = control_loop.dequeue();
//! assert!(!lost && sample.is_some());
//! ```

use crate::contact::pose::ToolPose;

/// Queue of at most `N - 1` samples; `const` constructible, split into its two ends once.
pub type SampleQueue<const N: usize> = heapless::spsc::Queue<ToolPose, N>;
