//! Passivity observer: energy in from the hand against energy stored and lost.
//!
//! The device holds a force F until the next one, so the hand's work on the port in a tick is -F . dx,
//! whatever it does in between. While the tool is engaged the observer keeps three sums:
//!
//! ```text
//! S = sum of -F . dx                                  F = the force given to the device
//! H = sum of -F . dx + b |dx|^2 / h                   plus the loss in the device's damping
//! L = sum of (M - G) . dx + b |dx|^2 / h              G = the same as F, see below
//! ```
//!
//! M is the mean of the forces to show before and after dx, the force of a device with continuous time; b is
//! the least damping of the device. S < 0: the device returned more energy than it received. H < 0: the hand
//! received more energy than it put in. L < 0: sampling and holding generated energy, k v^2 h^2 / 2 in each
//! tick of a spring k, and three times that with a delay of a tick (Colgate's b > k h / 2). The energy that
//! the tissue loses or gains counts neither way: a tissue that gives way, or that captures cells for which
//! the hand did no work, makes no debt. G is the force before ramp and clamp, whose energy is not sampling's,
//! less the slew limit's lag, which generates energy too. L holds for a delay of up to a tick; for longer
//! delays see [`delay`](super::delay). L stays within [-[`DEBT_MAX_J`], [`SURPLUS_MAX_J`]], so that a long
//! rest gives no credit for a later oscillation. S and H stay at most [`SURPLUS_MAX_J`] above the energy that
//! tissue and coupling store, so that energy lost in the tissue is no credit. A debt fades within [`FADE_S`]:
//! quantisation hides a little energy in every tick, which adds up in a long hold, and the controller would
//! respond to it with encoder noise. Of H, which withholds a force ([`unpaid`](super::unpaid)), at most
//! [`FADES_W`] fade in a press that began inside the ramp.
//!
//! If ticks are missing in the ledger (an answer was lost, or the force fell in a silence), L starts anew. S
//! and H stay, less the work of the device if it held its last force along the hand's motion meanwhile.
//!
//! **Quantised positions.** An encoder count q that arrives after m ticks was a slow motion, not a jump in
//! the last tick: the device has just crossed the border between two counts and is, at a motion of r = q / m
//! per tick, on average r / 2 beyond it. With r >= q per tick the device is anywhere in its count. So the
//! counted position lags the measured one by (q - r) / 2, never below 0, along the motion; noise of one count
//! moves it little. b |dx|^2 / (m h) is the least dissipation of such a motion, and the coupling's force is
//! evaluated at that position. q is the smallest step that the device has shown so far. That is right for
//! encoders along the axes; for joint encoders it is too small, and the controller then takes slow motions
//! for jumps.
//!
//! Source: B. Hannaford, J.-H. Ryu, Time-domain passivity control of haptic interfaces (2002);
//! J. E. Colgate, G. Schenkel, Passivity of a class of sampled-data systems (1997); quantisation:
//! J. J. Abbott, A. M. Okamura, Effects of position quantization and sampling rate (2005).

use crate::number::cell::{add, dot, scale, sub};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;
use crate::stage::delay::Delay;
use crate::stage::settings::{DELAY_MAX, Passivity};

/// Largest surplus of L \[J\].
pub(super) const SURPLUS_MAX_J: f32 = 2.0e-6;
/// Largest debt of L and of S \[J\].
pub(super) const DEBT_MAX_J: f32 = 1.0e-3;
/// Time in which a debt fades to 1/e \[s\].
const FADE_S: f32 = 1.0;
/// Largest fading of H's debt in a press that began inside the ramp \[W\].
const FADES_W: f32 = 2.0e-4;
/// Largest step that is taken for a count \[m\].
const COUNT_MAX_M: f32 = 1.0e-4;

/// Ticks without a count after which the device is at rest.
const STILL_TICKS: u16 = 1000;

/// Forces on their way to the device, the last one first \[N\].
type Forces<const N: usize> = [[f32; 3]; N];
/// The largest number of forces on their way, and the acting one.
const WAY: usize = DELAY_MAX as usize + 1;

kept! {
    /// The observer of one port.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(super) struct Observer {
        /// The measured position, the counted position and the smallest step \[m\].
        measured: Option<[f32; 3]>,
        at: [f32; 3],
        count: f32,
        /// Ticks since the last change of each coordinate.
        still: [u16; 3],
        /// Motion in this tick, the ticks that it took, and the motion per tick \[m\].
        dx: [f32; 3],
        took: u16,
        rate: [f32; 3],
        given: Forces<WAY>,
        asked: Forces<2>,
        port: TwoFloat,
        hand: TwoFloat,
        sampling: TwoFloat,
        shown: [f32; 3],
        /// The last force before ticks in which the device did not receive the computed force \[N\].
        held: [f32; 3],
    }
}

impl Observer {
    pub(super) const NEW: Self = Self {
        measured: None,
        at: [0.0; 3],
        count: COUNT_MAX_M,
        still: [1; 3],
        dx: [0.0; 3],
        took: 1,
        rate: [0.0; 3],
        given: [[0.0; 3]; WAY],
        asked: [[0.0; 3]; 2],
        port: TwoFloat::ZERO,
        hand: TwoFloat::ZERO,
        sampling: TwoFloat::ZERO,
        shown: [0.0; 3],
        held: [0.0; 3],
    };

    /// Notes a sample of the device's position, `ticks` after the last one.
    pub(super) fn see(&mut self, position: [f32; 3], ticks: u16) {
        let Some(measured) = self.measured.replace(position) else {
            self.at = position;
            return;
        };
        // The smallest step seen is the encoder's count.
        let steps = sub(position, measured);
        for step in steps {
            let step = step.abs();
            if step > 0.0 && step < self.count {
                self.count = step;
            }
        }
        // Move the counted position, which lags the measured one.
        let before = self.at;
        let axes = self.at.iter_mut().zip(&mut self.still).zip(position).zip(steps);
        for (((at, still), x), step) in axes {
            *still = still.saturating_add(ticks.saturating_sub(1));
            if step == 0.0 {
                *still = still.saturating_add(1);
                continue;
            }
            let behind = 0.5 * (self.count - step.abs() / f32::from(*still));
            let behind = if behind > 0.0 { behind } else { 0.0 };
            *at = if step > 0.0 { x - behind } else { x + behind };
            *still = 1;
        }
        // Estimate the motion per tick.
        self.dx = sub(self.at, before);
        if self.took >= STILL_TICKS {
            self.rate = [0.0; 3];
        }
        let ticks = f32::from(self.took);
        if self.dx != [0.0; 3] {
            self.rate = scale(1.0 / ticks, self.dx);
            return;
        }
        // After this many ticks without a count the motion cannot be faster than this.
        let most = self.count / ticks;
        let fast = sqrt(dot(self.rate, self.rate));
        if fast > most {
            self.rate = scale(most / fast, self.rate);
        }
    }

    /// Starts the ledger as the tool engages, `shown` being the spring's force \[N\].
    pub(super) fn begin(&mut self, shown: [f32; 3]) {
        (self.port, self.hand) = (TwoFloat::ZERO, TwoFloat::ZERO);
        (self.sampling, self.shown) = (TwoFloat::ZERO, shown);
        // The given forces still act.
        (self.asked, self.held) = ([[0.0; 3]; 2], [0.0; 3]);
    }

    /// Resumes after missing ticks: L starts anew, `shown` being the spring's force \[N\]. If the hand moved
    /// along the last force, the device may have held it all the way.
    pub(super) fn resume(&mut self, shown: [f32; 3]) {
        (self.sampling, self.shown) = (TwoFloat::ZERO, shown);
        let paid = -dot(self.held, self.dx);
        if paid < 0.0 {
            (self.port, self.hand) = (self.port.plus(paid.into()), self.hand.plus(paid.into()));
        }
        self.held = [0.0; 3];
    }

    /// Books a tick after which the spring's force is `shown` \[N\] and tissue and coupling store at most
    /// `level` \[J\]; `early`: the press began inside the ramp; `tick_s` is the duration of a tick.
    pub(super) fn book(
        &mut self,
        of: &Passivity,
        (tick_s, delay): (f32, &Delay),
        shown: [f32; 3],
        (level, early): (f32, bool),
    ) {
        let under_way = delay.whole();
        let given = self.given.get(under_way).copied().unwrap_or_default();
        let asked = if under_way == 0 { self.asked[0] } else { self.asked[1] };
        let (dx, fade) = (self.dx, tick_s / FADE_S);
        // S: the work at the port.
        let (paid, most) = (-dot(given, dx), level + SURPLUS_MAX_J);
        let whole = Limits { most, debt: DEBT_MAX_J, fade, fades: f32::INFINITY };
        self.port = whole.kept(self.port.plus(paid.into()));
        // H: plus the loss in the device's damping.
        let lost = of.device_damping_n_s_per_m * dot(dx, dx) / (f32::from(self.took) * tick_s);
        let fades = if early { FADES_W * tick_s } else { f32::INFINITY };
        self.hand = Limits { debt: f32::INFINITY, fades, ..whole }
            .kept(self.hand.plus((paid + lost).into()));
        // L: the difference to a device with continuous time.
        let ideal = scale(0.5, add(self.shown, shown));
        let gained = lost - dot(sub(asked, ideal), dx);
        self.sampling =
            Limits { most: SURPLUS_MAX_J, ..whole }.kept(self.sampling.plus(gained.into()));
        self.shown = shown;
    }

    /// Notes the force asked for and the force given in this tick.
    pub(super) fn give(&mut self, asked: [f32; 3], given: [f32; 3]) {
        self.asked = [asked, self.asked[0]];
        let mut newer = given;
        for place in &mut self.given {
            core::mem::swap(place, &mut newer);
        }
        self.took = if self.dx == [0.0; 3] { self.took.saturating_add(1) } else { 1 };
        self.dx = [0.0; 3];
    }

    /// Notes that the hand's path is unknown: the device may have held the last force all the way.
    pub(super) fn lost_sight(&mut self) {
        let [last, ..] = self.given;
        if last != [0.0; 3] {
            self.held = last;
        }
    }

    /// Drops the forces on their way, which the device never applies; it may have held the last one.
    pub(super) fn felt_nothing(&mut self) {
        self.lost_sight();
        (self.given, self.asked) = ([[0.0; 3]; WAY], [[0.0; 3]; 2]);
    }

    /// Counted position of the device \[m\].
    pub(super) fn at(&self) -> [f32; 3] {
        self.at
    }

    /// Smallest step of the position \[m\].
    pub(super) fn count(&self) -> f32 {
        self.count
    }

    /// Recent motion per tick \[m\].
    pub(super) fn rate(&self) -> [f32; 3] {
        self.rate
    }

    /// Returns true if L is at its largest debt: the controller cannot compensate the generated energy.
    pub(super) fn is_overdrawn(&self) -> bool {
        self.sampling.hi <= -DEBT_MAX_J
    }

    /// H \[J\].
    pub(super) fn hand_j(&self) -> f32 {
        self.hand.hi
    }

    /// L \[J\].
    pub(super) fn sampling_j(&self) -> f32 {
        self.sampling.hi
    }

    /// Energy that the hand may still get back: S less the work of the forces on their way at the present
    /// motion, at least 0 \[J\].
    pub(super) fn reserve_j(&self, delay: &Delay) -> f32 {
        let reserve = self.port.hi - self.coming_j(delay, self.rate);
        if reserve > 0.0 { reserve } else { 0.0 }
    }

    /// Work that the forces on their way do on the hand at a motion of `rate` per tick \[J\].
    pub(super) fn coming_j(&self, delay: &Delay, rate: [f32; 3]) -> f32 {
        let under_way = self.given.iter().take(delay.whole());
        under_way.fold(0.0, |sum, force| sum + dot(*force, rate))
    }
}

/// Bounds of a ledger.
struct Limits {
    /// Largest surplus and largest debt \[J\].
    most: f32,
    debt: f32,
    /// Share of a debt that fades per tick, and its upper bound \[J\].
    fade: f32,
    fades: f32,
}

impl Limits {
    fn kept(&self, sum: TwoFloat) -> TwoFloat {
        if sum.hi > self.most {
            return self.most.into();
        }
        if sum.hi < -self.debt {
            return (-self.debt).into();
        }
        if sum.hi >= 0.0 {
            return sum;
        }
        let fades = -self.fade * sum.hi;
        sum.plus((if fades < self.fades { fades } else { self.fades }).into())
    }
}
