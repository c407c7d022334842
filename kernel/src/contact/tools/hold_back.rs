//! A tool that gives way again and again stays out where it did.
//!
//! A tool that is pressed on deeper and deeper reaches a depth from which on the tissue slips around it: at
//! one and the same place of the tool the force falls and the samples come nearer, until the tool gives way.
//! Then they recover, and the tool could go in again and lose them anew, several times a second. So a tool
//! that gave way [`TIMES`] times at a place goes no farther in that direction. Fewer times are no hum: under
//! a fast press the tissue lags, and comes too near for some ticks. Sideways the tool moves as before. It is
//! free again when its target is no longer beyond the proxy in that direction, when it has moved by a quarter
//! of its radius, when it touches nothing, and when it engages anew.

use crate::energy::surface::{Meeting, ToolState};
use crate::number::cell::{dot, scale, sub};
use crate::number::sqrt::sqrt;

/// Times that a tool may give way at a place and go in again.
const TIMES: u8 = 3;
/// Way after which a tool is free again, in its smallest radii.
const ELSEWHERE: f32 = 0.25;

impl ToolState {
    /// The position to which the tool may move.
    pub(super) fn free_target(&self) -> [f32; 3] {
        let inward = dot(sub(self.target, self.proxy.pivot), self.held_back);
        if self.times < TIMES || inward <= 0.0 {
            return self.target;
        }
        sub(self.target, scale(inward, self.held_back))
    }

    /// Notes after its move from this pivot whether the tool gave way; `met` is its contact there.
    pub(super) fn hold_back(&mut self, from: [f32; 3], met: &Meeting) {
        let (here, step) = (self.proxy.pivot, sub(self.target, from));
        let (way, apart) = (sub(here, from), sub(here, self.held_at));
        // It gave way if it moved against its target, within 60 degrees.
        let (along, ways, steps) = (dot(way, step), dot(way, way), dot(step, step));
        let gave_way = self.gives_way;
        self.gives_way = along < 0.0 && 4.0 * along * along > ways * steps;
        if self.gives_way {
            // The first direction stays: the proxy may give way aside, and the hand presses on as before.
            if self.times == 0 {
                self.held_back = scale(1.0 / sqrt(steps), step);
            }
            if !gave_way && self.times < TIMES {
                self.times += 1;
            }
            self.held_at = here;
            return;
        }
        // It is free again at its target, elsewhere, and where it touches nothing.
        let elsewhere = ELSEWHERE * self.proxy.radius_min();
        let is_asked_in = dot(sub(self.target, here), self.held_back) > 0.0;
        if !is_asked_in || met.touched == 0 || dot(apart, apart) > elsewhere * elsewhere {
            self.times = 0;
        }
    }
}
