//! A tool engages, aims at its pose and releases.

use crate::contact::context::approach;
use crate::contact::pose::ToolPose;
use crate::energy::surface::{Meeting, ToolState};
use crate::model::Model;
use crate::number::cell::sub;

/// Largest coordinate of a tool [mean link lengths], so that its square stays finite.
const PLACE_MAX: f32 = 2.0e6;

/// Converts a position in the mesh's frame \[m\] to mean link lengths from the body's centre.
pub(super) fn internal(model: &Model<'_>, position_m: [f32; 3]) -> [f32; 3] {
    sub(position_m, model.centre_m()).map(|x| (x / model.unit_m()).clamp(-PLACE_MAX, PLACE_MAX))
}

/// Change of a tool's engagement in a tick.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Edge {
    None,
    In,
    /// The tool is engaged and has waited inside the body.
    Waits,
    Out,
}

impl ToolState {
    /// Returns true if the tool is engaged and has no contact yet.
    pub(crate) fn waits(&self) -> bool {
        self.is_in && self.proxy.is_away()
    }

    /// Starts a tick: the tool engages or releases. One that waits engages anew.
    pub(super) fn engage(&mut self, pose: Option<&ToolPose>) -> Edge {
        (self.way, self.spin) = ([0.0; 3], [0.0; 3]);
        if let Some(crossing) = self.proxy.edge.crossing_mut() {
            crossing.slid = 0.0;
        }
        match pose.map(|pose| pose.engaged == 1) {
            Some(true) if !self.is_in || self.waits() => {
                let edge = if self.waits() { Edge::Waits } else { Edge::In };
                if let Some(crossing) = self.proxy.edge.crossing_mut() {
                    crossing.go(1.0);
                }
                self.proxy = self.proxy.at(self.target, self.target_turn, 1.0);
                self.proxy.edge.leave();
                self.is_in = true;
                (self.times, self.gives_way) = (0, false);
                edge
            }
            Some(false) if self.is_in => {
                self.leave();
                Edge::Out
            }
            _ => Edge::None,
        }
    }

    /// Releases the tool.
    pub(crate) fn leave(&mut self) {
        self.is_in = false;
        self.proxy.edge.leave();
        if let Some(crossing) = self.proxy.edge.crossing_mut() {
            (crossing.slid, crossing.push) = (0.0, 0.0);
        }
        (self.met, self.is_ahead) = (Meeting::NONE, false);
        (self.way, self.spin, self.fade) = ([0.0; 3], [0.0; 3], 0.0);
    }

    /// Sets the target from a pose, within the step limit. Returns true if the limit shortened it.
    pub(super) fn aim(&mut self, model: &Model<'_>, pose: &ToolPose, step: f32) -> bool {
        let wished = internal(model, pose.position_m.into());
        if let Some(turn) = pose.turn() {
            self.target_turn = turn;
        }
        if let Some(crossing) = self.proxy.edge.crossing_mut() {
            crossing.aim(pose.opening_turns_q16);
        }
        if !self.is_in || self.waits() {
            self.target = wished;
            return false;
        }
        let (to, is_short) = approach(self.target, wished, step);
        self.target = to;
        is_short
    }

    /// Returns true if the proxy is at the tool's pose.
    pub(super) fn is_at_target(&self) -> bool {
        self.proxy.pivot == self.target
            && self.proxy.turn == self.target_turn
            && self.proxy.edge.crossing().is_there()
    }

    /// Returns true if it also has its full size.
    pub(super) fn is_there(&self) -> bool {
        self.is_at_target() && self.proxy.share >= 1.0 && self.fade <= 0.0
    }
}
