//! The tissue's force limit, applied to the coupling's force too: a lower limit holds at once, a higher one
//! takes effect step by step.

use crate::number::kept::kept;

kept! {
    /// A limit: its target and its present value.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(super) struct Limit {
        /// Target \[N\].
        to_n: f32,
        /// Present value \[N\].
        now_n: f32,
    }
}

impl Limit {
    pub(super) const NONE: Self = Self { to_n: f32::INFINITY, now_n: f32::INFINITY };

    /// Sets another limit; one that is not above 0 admits no force.
    pub(super) fn set(&mut self, max_force_n: f32) {
        self.to_n = if max_force_n > 0.0 { max_force_n } else { 0.0 };
        if self.to_n < self.now_n {
            self.now_n = self.to_n;
        }
    }

    /// Raises the present limit by a tick's share of a rise by the device's largest force within `ticks`.
    pub(super) fn rise(&mut self, device_n: f32, ticks: u16) {
        let raised = self.now_n + device_n / f32::from(ticks.max(1));
        let is_there = raised >= self.to_n || raised >= device_n;
        self.now_n = if is_there { self.to_n } else { raised };
    }

    /// The largest force now, of a device with the limit `device_n` \[N\].
    pub(super) fn of(&self, device_n: f32) -> f32 {
        if self.now_n < device_n { self.now_n } else { device_n }
    }
}
