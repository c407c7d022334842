//! Carries the stream of `chaincell mirror` to many followers over zenoh.
//!
//! ```text
//! chaincell/NAME/records   published: 4 bytes that identify the session up to the frame's records, then a frame
//! chaincell/NAME/ask       queryable: asked with a frame `ask`, answers with the frames of a mirror, each a reply
//! ```
//!
//! Frames are those of [`chaincell_host::remote::frame`], records packed. A message may be lost on its way: a receiver
//! sees by the number of the next record that some are missing, and asks for them; the answer comes from the trace. The
//! same question brings the session to a late receiver. An answer has a bounded length, and a receiver asks until it
//! has all: how fast it reads is no matter of the network.
//!
//! Each module uses only those above it:
//!
//! - [`settings`]: zenoh's configuration; nothing but this machine is reached unless it says so.
//! - [`message`]: what is published and asked.
//! - [`sequence`]: which records a receiver has, and what it misses.
//! - [`page`]: an answer, read from the trace.
//! - [`send`], [`receive`]: the two sides.

pub mod message;
pub mod page;
pub mod receive;
pub mod send;
pub mod sequence;
pub mod settings;
