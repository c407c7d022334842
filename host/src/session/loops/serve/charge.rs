//! Who is in charge of a session, the order of its ticks, and which tools it was seen to release.

use chaincell_kernel::{TOOLS_MAX, ToolPose};

use super::arrived::Arrived;
use crate::engine::order::{TickOrder, TickPlace, follows};

/// What a session that goes on from a snapshot knows of the one before.
#[derive(Debug, Clone, Copy)]
pub struct Resumed {
    /// Last tick before the snapshot, 0 for none.
    pub tick: u64,
    /// Id of the publisher that was in charge, 0 for none.
    pub publisher: u128,
    /// Which tools it was seen to release.
    pub released: [bool; TOOLS_MAX],
    /// Whether it was paused.
    pub is_paused: bool,
}

/// The publisher whose poses are executed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Charge {
    publisher: Option<u128>,
    order: TickOrder,
    /// From its last tick but one to its last.
    step: u64,
    /// Whether a pose with the tool released has been seen, of each. Until then the tissue counts it as
    /// not engaged.
    has_released: [bool; TOOLS_MAX],
    /// Which tools go on in the tissue as they were, while the device is given no force until a release:
    /// it felt nothing since the session was saved.
    withheld: [bool; TOOLS_MAX],
    resumed: Option<Resumed>,
    last_tick_before: u64,
}

impl Charge {
    /// Nobody is in charge of a session that begins at rest.
    #[must_use]
    pub fn new() -> Self {
        Self { step: 1, ..Self::default() }
    }

    /// Nobody is in charge of a session that goes on.
    #[must_use]
    pub fn resuming(resumed: Resumed) -> Self {
        Self { resumed: Some(resumed), last_tick_before: resumed.tick, ..Self::new() }
    }

    /// Whether the session goes on from another one.
    pub(super) fn is_resumed(&self) -> bool {
        self.resumed.is_some()
    }

    /// The last tick of the session before, 0 for none.
    pub(super) fn last_tick_before(&self) -> u64 {
        self.last_tick_before
    }

    /// Which tools are given no force until they were released.
    pub(super) fn withheld(&self) -> [bool; TOOLS_MAX] {
        self.withheld
    }

    /// The publisher in charge and the tools that it was seen to release, for a snapshot. Where nobody has
    /// taken charge since one, what that one said still holds.
    pub(super) fn saved(&self) -> (u128, [bool; TOOLS_MAX]) {
        match (self.publisher, self.resumed) {
            (Some(publisher), _) => (publisher, self.has_released),
            (None, Some(resumed)) => (resumed.publisher, resumed.released),
            (None, None) => (0, self.has_released),
        }
    }

    /// A publisher takes charge. The one of the session before goes on where its tools are; another one
    /// releases them first.
    pub(super) fn take(&mut self, publisher: u128) {
        let before = self.resumed.take().filter(|before| before.publisher == publisher);
        (self.publisher, self.order, self.step) = (Some(publisher), TickOrder::default(), 1);
        match before {
            Some(before) => {
                self.has_released = before.released;
                self.withheld = [true; TOOLS_MAX];
            }
            None => (self.has_released, self.withheld) = ([false; TOOLS_MAX], [false; TOOLS_MAX]),
        }
    }

    /// Judges a tick of the publisher in charge, and notes it: its place, how far it is from the one
    /// before, and how far those were apart.
    pub(super) fn judge(&mut self, tick: u64) -> (TickPlace, [u64; 2]) {
        let (before, usual) = (self.order.last(), self.step);
        let place = self.order.take(tick);
        let step = before.filter(|&before| follows(before, tick)).map_or(1, |last| tick - last);
        if place == TickPlace::Next {
            self.step = step;
        }
        (place, [step, usual])
    }

    /// Takes tools as not engaged, or without a force, until they were seen released.
    pub(super) fn release(&mut self, arrived: &mut Arrived) {
        let seen = self.has_released.iter_mut().zip(&mut self.withheld);
        let each = seen.zip(&mut arrived.release_first).zip(arrived.poses.each_mut());
        for (((has_released, withheld), release_first), ToolPose { engaged, .. }) in each {
            *has_released |= *engaged == 0;
            *withheld &= *engaged != 0;
            *release_first = *engaged == 1 && (!*has_released || *withheld);
            if !*has_released && *engaged == 1 {
                *engaged = 0;
            }
        }
    }
}
