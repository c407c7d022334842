//! Poses under way: keeps the send time of each until its answer arrives. The memory is fixed.

use crate::session::ipc::services::QUEUE_MESSAGES;

/// Capacity: the poses of 16 s. A controller that stood still for this long sends them at once, before the
/// first of their answers arrives.
const ROOM: usize = 16 * QUEUE_MESSAGES;

/// A pose under way; `index` is `u64::MAX` for none.
#[derive(Debug, Clone, Copy)]
struct Slot {
    index: u64,
    sent_ns: u64,
}

const EMPTY: Slot = Slot { index: u64::MAX, sent_ns: u64::MAX };

/// The poses under way, and the numbers of sent and answered ones.
#[derive(Debug)]
pub(crate) struct Outstanding {
    slots: Vec<Slot>,
    sent: u64,
    answered: u64,
}

impl Outstanding {
    /// Creates an empty set. Every slot is written now, which keeps page faults out of the loop.
    pub(crate) fn new() -> Self {
        Self { slots: vec![EMPTY; ROOM], sent: 0, answered: 0 }
    }

    /// Notes that the pose `index` was sent at `sent_ns`.
    pub(crate) fn send(&mut self, index: u64, sent_ns: u64) {
        self.slots[index as usize % ROOM] = Slot { index, sent_ns };
        self.sent += 1;
    }

    /// Notes the answer to a pose. Returns its send time, `None` if it was not sent or was already answered.
    pub(crate) fn answer(&mut self, index: u64) -> Option<u64> {
        let slot = &mut self.slots[index as usize % ROOM];
        if slot.index != index || index == u64::MAX {
            return None;
        }
        let sent_ns = slot.sent_ns;
        *slot = EMPTY;
        self.answered += 1;
        Some(sent_ns)
    }

    /// Number of poses sent.
    pub(crate) fn sent(&self) -> u64 {
        self.sent
    }

    /// Number of poses answered.
    pub(crate) fn answered(&self) -> u64 {
        self.answered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pose_is_answered_once_in_any_order() {
        let mut poses = Outstanding::new();
        assert_eq!(poses.answer(0), None);
        for at in 0..3 {
            poses.send(at, 100 + at);
        }
        assert_eq!((poses.answer(2), poses.answer(0)), (Some(102), Some(100)));
        assert_eq!((poses.answer(2), poses.answer(3), poses.answer(u64::MAX)), (None, None, None));
        assert_eq!(poses.answer(1), Some(101));
        assert_eq!((poses.sent(), poses.answered()), (3, 3));
    }

    #[test]
    fn an_answer_that_never_comes_makes_room() {
        let mut poses = Outstanding::new();
        for at in 0..=ROOM as u64 {
            poses.send(at, at);
        }
        assert_eq!(poses.answer(0), None, "its slot was taken");
        assert_eq!(poses.answer(ROOM as u64), Some(ROOM as u64));
        assert_eq!(poses.answer(1), Some(1));
    }
}
