//! What kernel, client and server allocate: nothing of their own once they run.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod client;
mod kernel;
mod session;

use chaincell_tests::allocations::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Ticks before counting: connections are made in the first ones.
const WARM_UP_TICKS: u64 = 50;
/// Ticks that are counted.
const COUNTED_TICKS: u64 = 500;
/// What iceoryx2 allocates for each message that is sent, in one piece.
const BYTES_PER_SEND: u64 = 104;
