//! What all pages see: the newest frame and the newest notice, kept for pages that join.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tungstenite::{Bytes, Utf8Bytes};

use super::bell::Bell;

/// Pages that may be open at a time.
pub const PAGES_MAX: usize = 8;

/// Time for which a page that asks for the stress gets it.
const STRESS_TIME: Duration = Duration::from_secs(2);

/// The newest frame and notice. One side publishes, each page takes what it has not seen; frames in between
/// are skipped.
#[derive(Debug, Default)]
pub struct Feed {
    newest: Mutex<Newest>,
    pages: Mutex<Vec<Arc<Bell>>>,
    /// When the last page that asked for the stress has had it for its time.
    stress_until: Mutex<Option<Instant>>,
}

/// A frame and a notice, each with its number from 1; 0 before the first.
#[derive(Debug, Default)]
struct Newest {
    frame: (u64, Bytes),
    notice: (u64, Utf8Bytes),
    has_ended: bool,
}

/// The place of a page, free again when this is dropped.
#[derive(Debug)]
pub(super) struct Place<'a> {
    feed: &'a Feed,
    pub(super) bell: Arc<Bell>,
}

impl Feed {
    /// Replaces the frame.
    pub fn publish(&self, frame: Vec<u8>) {
        self.change(|newest| newest.frame = (newest.frame.0 + 1, frame.into()));
    }

    /// Replaces the notice, a text that pages show: JSON, as the page's `live.mjs` reads it.
    pub fn notify(&self, notice: String) {
        self.change(|newest| {
            if newest.notice.1.as_str() != notice {
                newest.notice = (newest.notice.0 + 1, notice.into());
            }
        });
    }

    /// Returns true while a page asks for the stress of the body.
    #[must_use]
    pub fn wants_stress(&self) -> bool {
        locked(&self.stress_until).is_some_and(|until| Instant::now() < until)
    }

    /// Notes that a page asks for the stress.
    pub(super) fn ask_for_stress(&self) {
        *locked(&self.stress_until) = Some(Instant::now() + STRESS_TIME);
    }

    /// Number of open pages.
    #[must_use]
    pub fn pages(&self) -> usize {
        locked(&self.pages).len()
    }

    /// Asks all pages to end.
    pub(super) fn end(&self) {
        self.change(|newest| newest.has_ended = true);
    }

    /// Returns true after [`Self::end`].
    pub(super) fn has_ended(&self) -> bool {
        locked(&self.newest).has_ended
    }

    /// Takes a place for a page; `None` if all are taken.
    pub(super) fn join(&self) -> io::Result<Option<Place<'_>>> {
        let bell = Arc::new(Bell::new()?);
        let mut pages = locked(&self.pages);
        if pages.len() >= PAGES_MAX {
            return Ok(None);
        }
        pages.push(Arc::clone(&bell));
        Ok(Some(Place { feed: self, bell }))
    }

    /// The frame and its number, if it is not frame number `seen`.
    pub(super) fn frame_unlike(&self, seen: u64) -> Option<(u64, Bytes)> {
        let newest = locked(&self.newest);
        (newest.frame.0 != seen).then(|| newest.frame.clone())
    }

    /// The notice and its number, if it is not notice number `seen`.
    pub(super) fn notice_unlike(&self, seen: u64) -> Option<(u64, Utf8Bytes)> {
        let newest = locked(&self.newest);
        (newest.notice.0 != seen).then(|| newest.notice.clone())
    }

    fn change(&self, change: impl FnOnce(&mut Newest)) {
        change(&mut locked(&self.newest));
        locked(&self.pages).iter().for_each(|bell| bell.ring());
    }
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        locked(&self.feed.pages).retain(|bell| !Arc::ptr_eq(bell, &self.bell));
    }
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
