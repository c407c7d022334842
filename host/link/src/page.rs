//! An answer to a receiver that asks, read from the trace.

use std::io;

use chaincell_host::error::{Error, Result};
use chaincell_host::remote::frame::{Ask, Frame, read_head};
use chaincell_host::remote::place::Place;
use chaincell_host::remote::way::{Local, Way};
use chaincell_kernel::trace::RECORD_BYTES;

/// Most frames of records in an answer: 32,768 records, half a minute of a session.
const RECORD_FRAMES_MAX: usize = 8;

/// Gives the frames of an answer to `reply`: what is asked, up to the newest record or to the length of an answer,
/// or why not. It waits for a record at most as long as a mirror is silent, 100 ms.
///
/// # Errors
/// Those of `reply`; a stream that breaks off.
pub fn answer(place: &Place, ask: &Ask, mut reply: impl FnMut(&Frame) -> Result<()>) -> Result<()> {
    let mut stream = match Local::Found(place.clone()).open(ask) {
        Ok(stream) => stream,
        Err(why) => return reply(&Frame::Refused(why.to_string())),
    };
    let broken = |why: io::Error| Error::check(format!("cannot read the session: {why}"));
    read_head(&mut stream).map_err(broken)?;
    let mut record_frames = 0;
    loop {
        let frame = Frame::read(&mut stream).map_err(broken)?;
        record_frames += usize::from(matches!(frame, Frame::Records { .. }));
        reply(&frame)?;
        if is_up_to_date(&frame)
            || matches!(frame, Frame::Refused(_))
            || record_frames == RECORD_FRAMES_MAX
        {
            return Ok(());
        }
    }
}

/// Returns true for a frame after which nothing of the session is missing.
#[must_use]
pub fn is_up_to_date(frame: &Frame) -> bool {
    match frame {
        Frame::Alive { .. } | Frame::End { .. } => true,
        Frame::Records { first, newest, bytes } => {
            u64::from(*first) + (bytes.len() / RECORD_BYTES) as u64 >= u64::from(*newest)
        }
        Frame::Begun(_)
        | Frame::Model(_)
        | Frame::Start { .. }
        | Frame::Refused(_)
        | Frame::Ask(_) => false,
    }
}
