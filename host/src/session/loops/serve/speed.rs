//! Rejects poses out of reach of a hand, for a tissue without an output stage, which would reject them
//! itself.

use chaincell_kernel::TOOLS_MAX;
use chaincell_kernel::stage::{Pose, Reach};

use super::arrived::Arrived;
use crate::session::timing::clock::MILLISECOND_NS;

/// Replaces `engaged` in a bad sample.
const BAD: u16 = u16::MAX;

/// Checks the poses of all tools.
#[derive(Debug)]
pub(super) struct SpeedGate {
    /// Largest speed of a hand, infinite for none [m/s].
    max_speed_m_per_s: f32,
    reaches: [Reach; TOOLS_MAX],
    /// Arrival time of the last good pose of each tool \[ns\], and the ticks since.
    good_ns: [u64; TOOLS_MAX],
    ticks: [u64; TOOLS_MAX],
}

impl SpeedGate {
    pub(super) fn new(max_speed_m_per_s: f32) -> Self {
        let reaches = [Reach::NEW; TOOLS_MAX];
        Self { max_speed_m_per_s, reaches, good_ns: [0; TOOLS_MAX], ticks: [0; TOOLS_MAX] }
    }

    /// Accepts the next poses at any place.
    pub(super) fn forget(&mut self) {
        self.reaches.iter_mut().for_each(Reach::forget);
    }

    /// Marks poses out of reach as bad samples; they are `step` ticks after the last ones.
    pub(super) fn judge(&mut self, arrived: &mut Arrived, step: u64) {
        if self.max_speed_m_per_s == f32::INFINITY {
            return;
        }
        let at_ns = arrived.at_ns;
        for (tool, pose) in arrived.poses.each_mut().iter_mut().enumerate() {
            let of = (pose.position_m.into(), pose.engaged);
            pose.engaged = self.judged(tool, of, (at_ns, step));
        }
    }

    /// Returns the value for `engaged`. Delayed poses arrive all at once, and those of a slow controller are
    /// far apart: the hand had the time of the clock or of the ticks, whichever is longer.
    fn judged(
        &mut self,
        tool: usize,
        (position_m, engaged): ([f32; 3], u16),
        (at_ns, step): (u64, u64),
    ) -> u16 {
        self.ticks[tool] = self.ticks[tool].saturating_add(step);
        if engaged > 1 || !position_m.iter().all(|x| x.is_finite()) {
            return engaged;
        }
        let by_ticks_ns = self.ticks[tool].saturating_mul(MILLISECOND_NS);
        let since_ns = at_ns.saturating_sub(self.good_ns[tool]).max(by_ticks_ns);
        let reach_m = self.max_speed_m_per_s * 1e-3;
        let ticks = since_ns as f32 / MILLISECOND_NS as f32;
        match self.reaches[tool].judge(position_m, engaged == 1, reach_m, ticks) {
            Pose::Bad => BAD,
            good => {
                (self.good_ns[tool], self.ticks[tool]) = (at_ns, 0);
                if good == Pose::Elsewhere { 0 } else { engaged }
            }
        }
    }
}
