//! Follows a session frame by frame, and goes on with it when the line falls silent.

use chaincell_kernel::trace::RECORD_BYTES;
use chaincell_kernel::{Model, TissueMut};

use super::console;
use super::hand;
use super::session::{Scheme, Session};
use super::snapshot::Snapshot;
use super::stream::{Stop, Stream};

/// Kinds of frames.
const BEGUN: u8 = 1;
const MODEL: u8 = 2;
const START: u8 = 3;
const RECORDS: u8 = 4;
const ALIVE: u8 = 5;
const END: u8 = 6;
const REFUSED: u8 = 7;
const PACKED: u8 = 9;

/// Follows the line `next` to its end, and goes on if the session has none, with the model of `image` in `tissue`.
/// `memory` has room for a snapshot. `None` where nothing can be followed.
pub fn stand_by(
    next: impl FnMut() -> Option<u8>,
    image: &'static [u8],
    tissue: TissueMut<'static, Scheme>,
    memory: &mut [u8],
) -> Option<()> {
    let model = Model::from_bytes(image).ok()?;
    let mut begun = [0; 512];
    let joined = Stream::begin(next).and_then(|mut stream| {
        let begun = match stream.frame()? {
            BEGUN => stream.rest(&mut begun)?,
            _ => return Err(Stop::Refused("no header comes first")),
        };
        Ok((Session::begin(begun, model, tissue)?, begun, stream))
    });
    let (mut session, begun, mut stream) = match joined {
        Ok(joined) => joined,
        Err(Stop::Refused(why)) => return refuse(why),
        Err(_) => return refuse("the line was silent before the session began"),
    };
    let stop = loop {
        if let Err(stop) = take(&mut stream, &mut session, image, begun, memory) {
            break stop;
        }
    };
    session.say();
    match stop {
        Stop::Refused(why) => return refuse(why),
        Stop::Ended => console::say("ended", "by itself"),
        Stop::Silent | Stop::Killed => {
            console::say("goes_on", "from the last record");
            hand::press(&mut session);
        }
    }
    Some(())
}

fn refuse(why: &str) -> Option<()> {
    console::say("refused", why);
    None
}

/// Takes a frame. Returns why the board follows no further.
fn take(
    stream: &mut Stream<impl FnMut() -> Option<u8>>,
    session: &mut Session,
    image: &[u8],
    begun: &[u8],
    memory: &mut [u8],
) -> Result<(), Stop> {
    match stream.frame()? {
        MODEL => {
            for bytes in image.chunks(64) {
                let mut sent = [0; 64];
                let sent = sent.get_mut(..bytes.len()).unwrap_or(&mut []);
                stream.take(sent)?;
                if sent != bytes {
                    return Err(Stop::Refused("the mirror's model is another one, or damaged"));
                }
            }
            stream.end()
        }
        START => {
            let [records, _seal, low, high] =
                [stream.number()?, stream.number()?, stream.number()?, stream.number()?];
            let snapshot = Snapshot::read(stream.rest(memory)?).filter(|of| of.begun == begun);
            let snapshot = snapshot.ok_or(Stop::Refused("the snapshot is of another session"))?;
            session.restore(&snapshot, records, u64::from(low) | u64::from(high) << 32)
        }
        RECORDS => {
            let [first, _newest] = [stream.number()?, stream.number()?];
            let mut index = first;
            while stream.left() > 0 {
                // A record has a checksum of its own: it is played when it has come.
                let mut record = [0; RECORD_BYTES];
                stream.take(&mut record)?;
                if index >= session.next_record() {
                    session.play(&record)?;
                }
                index = index.saturating_add(1);
            }
            stream.end()
        }
        ALIVE => {
            stream.number()?;
            stream.end()
        }
        END => {
            let [_newest, is_whole] = [stream.number()?, stream.number()?];
            stream.end()?;
            Err(if is_whole != 0 { Stop::Ended } else { Stop::Killed })
        }
        REFUSED => Err(Stop::Refused("the mirror sends nothing further")),
        PACKED => Err(Stop::Refused("records are packed: start the mirror without --packed")),
        _ => Err(Stop::Refused("a frame is unknown here, or damaged")),
    }
}
