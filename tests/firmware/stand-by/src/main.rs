//! A board that stands by: it follows a session over a serial line, compares every hash, and goes on with the session
//! when the line falls silent. `host/GUIDE.md` runs it in an emulator.
//!
//! It says on the debugger's channel, one `name value` a line, how far it came. A stream that is damaged, or a tick
//! that differs, ends it: there is no force, and nothing is taken over, as the session may go on elsewhere.
#![no_std]
#![no_main]

#[path = "../../image/src/console.rs"]
mod console;
mod hand;
mod line;
#[path = "../../image/src/panic.rs"]
mod panic;
mod session;
mod snapshot;
mod stream;

use chaincell_kernel::trace::RECORD_BYTES;
use chaincell_kernel::{Model, Tissue, include_model};
use cortex_m_rt::entry;
use semihosting::process;
use static_cell::ConstStaticCell;

use line::Line;
use session::{CELLS, HELD, Scheme, Session};
use snapshot::Snapshot;
use stream::{Stop, Stream};

/// The model, in flash: the board takes it from no line.
static IMAGE: &[u8] =
    include_model!(env!("CHAINCELL_MODEL", "set it to the path of the session's model"));
static TISSUE: ConstStaticCell<Tissue<CELLS, Scheme, HELD>> = ConstStaticCell::new(Tissue::new());
/// Memory for a snapshot.
static SNAPSHOT: ConstStaticCell<[u8; 48 << 10]> = ConstStaticCell::new([0; 48 << 10]);

/// Kinds of frames.
const BEGUN: u8 = 1;
const MODEL: u8 = 2;
const START: u8 = 3;
const RECORDS: u8 = 4;
const ALIVE: u8 = 5;
const END: u8 = 6;
const REFUSED: u8 = 7;

/// Follows to the end of the stream, and goes on if it has none. `None` where nothing can be followed.
fn stand_by(mut line: Line) -> Option<()> {
    let tissue = TISSUE.try_take()?.view();
    let snapshot = SNAPSHOT.try_take()?;
    let model = Model::from_bytes(IMAGE).ok()?;
    let mut begun = [0; 512];
    let joined = Stream::begin(|| line.next()).and_then(|mut stream| {
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
        if let Err(stop) = take(&mut stream, &mut session, begun, snapshot) {
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
    begun: &[u8],
    memory: &mut [u8],
) -> Result<(), Stop> {
    match stream.frame()? {
        MODEL => {
            for bytes in IMAGE.chunks(64) {
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
        _ => Err(Stop::Refused("a frame is unknown here, or damaged")),
    }
}

#[entry]
fn main() -> ! {
    console::log_here();
    process::exit(i32::from(stand_by(Line::begin()).is_none()))
}
