//! Poses to play: a path that is played once or repeatedly, with ticks that continue to count.

use chaincell_kernel::ToolPose;

use crate::engine::motion::Pose;
use crate::error::{Error, Result};

/// A path and the number of times that it is played, which does not affect the memory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Playlist<'a> {
    poses: &'a [Pose],
    /// With several tools: the poses of all in each of these ticks, tick by tick.
    tools: &'a [ToolPose],
    repeats: u64,
    /// Ticks from one repeat to the next.
    span: u64,
}

impl<'a> Playlist<'a> {
    /// Creates the list for one tool.
    ///
    /// # Errors
    /// Ticks that do not ascend; none or too many repeats.
    pub(crate) fn new(poses: &'a [Pose], repeats: u64) -> Result<Self> {
        if let Some(pair) = poses.windows(2).find(|pair| pair[1].tick <= pair[0].tick) {
            return Err(Error::input(format!(
                "tick {} follows tick {}: number the ticks of a path upwards",
                pair[1].tick, pair[0].tick
            )));
        }
        let ends = poses.first().zip(poses.last());
        let span = ends.map_or(0, |(first, last)| (last.tick - first.tick).saturating_add(1));
        let last = ends.map_or(0, |(_, last)| last.tick);
        let fits = span.checked_mul(repeats).and_then(|all| all.checked_add(last)).is_some();
        // A path that is played once may reach the largest tick.
        if repeats == 0 || (repeats > 1 && !fits) {
            return Err(Error::input(format!(
                "`repeat` {repeats}: must be at least 1, and the last tick below 2^64"
            )));
        }
        Ok(Self { poses, tools: &[], repeats, span })
    }

    /// Adds the poses of several tools in each tick.
    pub(crate) fn with_tools(self, tools: &'a [ToolPose]) -> Self {
        Self { tools, ..self }
    }

    /// Number of poses to send.
    pub(crate) fn len(&self) -> u64 {
        self.poses.len() as u64 * self.repeats
    }

    /// Returns true if the path is played more than once.
    pub(crate) fn is_repeated(&self) -> bool {
        self.repeats > 1
    }

    /// Returns the pose at an index, which must be below [`Self::len`].
    pub(crate) fn pose(&self, index: u64) -> Pose {
        let length = self.poses.len() as u64;
        let pose = self.poses[(index % length) as usize];
        Pose { tick: pose.tick + index / length * self.span, ..pose }
    }

    /// Returns the poses of all tools at an index; none for a path of one tool.
    pub(crate) fn tools(&self, index: u64) -> &'a [ToolPose] {
        let count = self.tools.len() / self.poses.len().max(1);
        let at = (index % self.poses.len().max(1) as u64) as usize * count;
        self.tools.get(at..at + count).unwrap_or(&[])
    }

    /// Returns the index of a tick, if the list has it. Cost: a binary search in the path.
    pub(crate) fn index_of(&self, tick: u64) -> Option<u64> {
        let first = self.poses.first()?.tick;
        let since = tick.checked_sub(first)?;
        let (repeat, within) = (since / self.span, first + since % self.span);
        let at = self.poses.binary_search_by_key(&within, |pose| pose.tick).ok()?;
        (repeat < self.repeats).then(|| repeat * self.poses.len() as u64 + at as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(ticks: &[u64]) -> Vec<Pose> {
        ticks.iter().map(|&tick| Pose { tick, ..Pose::default() }).collect()
    }

    #[test]
    fn ticks_count_on_and_are_found_again() {
        let poses = path(&[5, 6, 9]);
        let list = Playlist::new(&poses, 3).unwrap();
        let ticks: Vec<u64> = (0..list.len()).map(|index| list.pose(index).tick).collect();
        assert_eq!(ticks, [5, 6, 9, 10, 11, 14, 15, 16, 19]);
        for (index, &tick) in ticks.iter().enumerate() {
            assert_eq!(list.index_of(tick), Some(index as u64));
        }
        for foreign in [0, 4, 7, 8, 12, 13, 17, 18, 20, u64::MAX] {
            assert_eq!(list.index_of(foreign), None, "{foreign}");
        }
    }

    #[test]
    fn what_cannot_be_played_is_refused() {
        assert!(Playlist::new(&path(&[2, 2]), 1).unwrap_err().to_string().contains("upwards"));
        for repeats in [0, u64::MAX] {
            let error = Playlist::new(&path(&[0, 1]), repeats).unwrap_err();
            assert!(error.to_string().contains("`repeat`"), "{error}");
        }
        let last = path(&[u64::MAX]);
        assert_eq!(Playlist::new(&last, 1).unwrap().index_of(u64::MAX), Some(0));
        let empty = Playlist::new(&[], 4).unwrap();
        assert_eq!((empty.len(), empty.index_of(0)), (0, None));
    }
}
