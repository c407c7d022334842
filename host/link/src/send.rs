//! Publishes the records of a session while it is recorded, and answers receivers that miss some.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, sleep};
use std::time::Duration;

use chaincell_host::error::{Error, Result};
use chaincell_host::files::recording::{Tail, seal_of};
use chaincell_host::remote::frame::{Ask, Frame, read_head};
use chaincell_host::remote::place::Place;
use chaincell_host::remote::way::{Local, Way};
use chaincell_host::{interrupt, terminal};
use chaincell_kernel::trace::RECORD_BYTES;
use zenoh::qos::CongestionControl;
use zenoh::query::Query;
use zenoh::{Config, Session, Wait};

use crate::message::{Keys, Message, frame_of, to_bytes};
use crate::page;
use crate::settings;

/// Most answers at a time; a receiver that gets none asks again.
const ANSWERS_MAX: usize = 64;
/// Time between repeated ends of a session: a message may be lost.
const END_AGAIN: Duration = Duration::from_millis(100);

/// Publishes a session under `keys` and answers questions until Ctrl-C, also after the recording has ended.
///
/// # Errors
/// A trace that cannot be read, or in which another session has begun; no place to listen; a router that refuses this
/// side's certificate, or has one that is not trusted here; Ctrl-C.
pub fn send(place: &Place, keys: &Keys, config: &Config) -> Result<()> {
    let tail = Tail::open(&place.trace)?;
    settings::check_connect(config)?;
    let session = settings::open(config)?;
    answer_each(&session, place, keys)?;
    terminal::say("ready")?;
    publish(&session, place, keys, &tail)
}

/// Answers each question in a thread of its own, from now on.
fn answer_each(session: &Session, place: &Place, keys: &Keys) -> Result<()> {
    let (place, answers) = (place.clone(), Arc::new(AtomicUsize::new(0)));
    let take = move |query: Query| {
        if answers.fetch_add(1, Ordering::Relaxed) >= ANSWERS_MAX {
            answers.fetch_sub(1, Ordering::Relaxed);
            return;
        }
        let (place, count) = (place.clone(), Arc::clone(&answers));
        let work = move || {
            if let Err(why) = answer(&query, &place) {
                log::warn!("a receiver got no whole answer: {why}");
            }
            count.fetch_sub(1, Ordering::Relaxed);
        };
        if let Err(why) = thread::Builder::new().name("answer".into()).spawn(work) {
            answers.fetch_sub(1, Ordering::Relaxed);
            log::warn!("cannot begin a thread: {why}");
        }
    };
    session
        .declare_queryable(keys.ask.clone())
        .complete(true)
        .callback(take)
        .background()
        .wait()
        .map_err(Error::check)
}

/// Answers one question.
fn answer(query: &Query, place: &Place) -> Result<()> {
    let asked = query.payload().and_then(|payload| frame_of(&payload.to_bytes()));
    let Some(Frame::Ask(ask)) = asked else { return Err(Error::check("it is no receiver")) };
    let key = query.key_expr();
    page::answer(place, &ask, |frame| {
        query.reply(key, to_bytes(frame)).wait().map_err(Error::check)
    })
}

/// Publishes records as they come, and then the end.
fn publish(session: &Session, place: &Place, keys: &Keys, tail: &Tail) -> Result<()> {
    let publisher = session
        .declare_publisher(keys.records.clone())
        .congestion_control(CongestionControl::Drop)
        .express(true)
        .wait()
        .map_err(Error::check)?;
    let put = |message: &Message| publisher.put(message.to_bytes()).wait().map_err(Error::check);
    // What was recorded before is asked for.
    let next = tail.count()?;
    let mut seal = tail.seal(next)?;
    let ask = Ask { goes_on: Some((seal, next)), ..Ask::default() };
    let mut stream = Local::Found(place.clone()).open(&ask)?;
    let broken = |why: io::Error| match interrupt::check() {
        Ok(()) => Error::check(format!("cannot read the session: {why}")),
        Err(interrupted) => interrupted,
    };
    read_head(&mut stream).map_err(broken)?;
    loop {
        interrupt::check()?;
        let frame = Frame::read(&mut stream).map_err(broken)?;
        match &frame {
            Frame::Records { bytes, .. } => {
                let last = bytes.as_chunks::<RECORD_BYTES>().0.last().map_or(seal, seal_of);
                put(&Message { seal, frame })?;
                seal = last;
            }
            Frame::Alive { .. } => put(&Message { seal, frame })?,
            Frame::End { .. } => {
                let end = Message { seal, frame };
                loop {
                    put(&end)?;
                    interrupt::check()?;
                    sleep(END_AGAIN);
                }
            }
            Frame::Refused(why) => return Err(Error::input(why)),
            Frame::Begun(_) | Frame::Model(_) | Frame::Start { .. } | Frame::Ask(_) => {}
        }
    }
}
