//! Pins at run time: points and regions of the surface that are held to the world.

use super::settings::Network;
use super::tissue::TissueMut;
use crate::contact::error::PinError;
use crate::contact::output::PinOutput;
use crate::contact::tools::{self, NewPin};
use crate::energy::residual::places;
use crate::energy::surface::PINS_ARE_BUILT;
use crate::model::Model;
use crate::number::cell::{add, scale, sub};
use crate::number::clamp::finite;
#[cfg(feature = "cut")]
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;

/// Least stiffness of a pin, far from the smallest numbers [N/m].
const STIFFNESS_MIN_N_PER_M: f32 = 1.0e-6;

impl<D: Dynamics> TissueMut<'_, D> {
    /// Pins the surface within `radius_m` of a point where it is now: its samples there are held in the world, by
    /// springs of this stiffness in all [N/m]. An infinite stiffness, or one above that of a rigid pin, makes a rigid
    /// one: 200 times as stiff as tissue of one edge length in depth, of a body of links 10 times. Returns the number
    /// of the pin, the lowest free one.
    ///
    /// Pinning makes no force: the springs begin unloaded. Call it between two ticks. A pin holds until
    /// [`Self::unpin`], and until a reset or another choice of cells. Tools must have been chosen; none needs to be
    /// engaged. Cost: one look at each sample of the surface; then in each sweep one at each pinned sample.
    ///
    /// ```
    #[doc = include_str!("../contact/example.txt")]
    /// # if !FEATURES.contains(&"pins") {
    /// #     return Ok(());
    /// # }
    /// let pin = tissue.pin_at(&network, [0.0, 0.0, 0.030], 0.006, f32::INFINITY)?; // [m], on the top; rigid
    /// for step in 0..=6 {
    ///     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
    ///     tissue.tick(&network, &[pose], Budget::All);
    /// }
    /// let held = tissue.pin_output(&network, pin).ok_or("no pin")?;
    /// assert!(held.force_n.z < -0.05 && held.given_m[2].abs() < 0.001); // [N], [m]: it bears the press
    ///
    /// tissue.unpin(pin, 20)?; // within 20 ticks
    /// # for _ in 0..21 {
    /// #     tissue.tick(&network, &[ToolPose::at([0.0, 0.0, 0.030].into(), 1)], Budget::All);
    /// # }
    /// assert_eq!(tissue.pin_output(&network, pin), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The reason for the refusal; nothing has changed then.
    pub fn pin_at(
        &mut self,
        network: &Network<'_>,
        point_m: [f32; 3],
        radius_m: f32,
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError> {
        self.may_pin(network, stiffness_n_per_m)?;
        let is_place = point_m.iter().all(|x| x.is_finite());
        if !(is_place && radius_m > 0.0 && radius_m.is_finite()) {
            return Err(PinError::Value);
        }
        self.pin(network, stiffness_n_per_m, |tissue, model, stiffness| {
            let unit_m = model.unit_m();
            let middle = scale(1.0 / unit_m, sub(point_m, model.centre_m()));
            let at = places(model, &*tissue.state);
            let arrays = tissue.touch.arrays(model.cells()).ok_or(PinError::NoTools)?;
            let state = arrays.state.first_mut().ok_or(PinError::NoTools)?;
            let mut pin = NewPin::behind(arrays.pins, state).ok_or(PinError::Unbuilt)?;
            let nearest = pin.around(model, middle, radius_m / unit_m, &at);
            if pin.is_empty() {
                return Err(PinError::Reach { nearest_m: finite(nearest * unit_m) });
            }
            pin.set(stiffness)
        })
    }

    /// Pins what a tool grips where it is now, or what it touches if it grips nothing; else as [`Self::pin_at`]. The
    /// tool keeps its grip: [`Self::let_go`] frees it, and its pull passes to the pin along that ramp.
    ///
    /// ```
    #[doc = include_str!("../contact/example.txt")]
    /// # if !FEATURES.contains(&"pins") {
    /// #     return Ok(());
    /// # }
    /// # for step in 0..=6 {
    /// #     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
    /// #     tissue.tick(&network, &[pose], Budget::All);
    /// # }
    /// tissue.grip(&network, 0);
    /// let pin = tissue.pin_held(&network, 0, f32::INFINITY)?;
    /// tissue.let_go(0, 20);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The reason for the refusal; nothing has changed then.
    pub fn pin_held(
        &mut self,
        network: &Network<'_>,
        tool: usize,
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError> {
        self.may_pin(network, stiffness_n_per_m)?;
        self.pin(network, stiffness_n_per_m, |tissue, model, stiffness| {
            let at = places(model, &*tissue.state);
            let mut arrays = tissue.touch.arrays(model.cells()).ok_or(PinError::NoTools)?;
            tools::pin_held(&mut arrays, model, tool, stiffness, &at)
        })
    }

    /// Releases a pin within `ticks` ticks, at least one: its force falls to 0 without a jump, and then it is gone.
    ///
    /// # Errors
    /// No pin has this number.
    pub fn unpin(&mut self, pin: u16, ticks: u16) -> Result<(), PinError> {
        let fade = 1.0 / f32::from(if ticks > 0 { ticks } else { 1 });
        let pins = self.touch.whole().map(|arrays| arrays.pins_mut()).unwrap_or_default();
        let mut is_any = false;
        for sample in pins.iter_mut().filter(|sample| sample.pin == pin) {
            (sample.fade, is_any) = (fade, true);
        }
        if is_any { Ok(()) } else { Err(PinError::Unknown(pin)) }
    }

    /// Output of a pin in the published state; `None` if no pin has this number.
    #[must_use]
    pub fn pin_output(&self, network: &Network<'_>, pin: u16) -> Option<PinOutput> {
        let model = network.model();
        let at = places(model, self.state.get(..model.cells())?);
        let (mut force, mut place, mut given) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let (mut stiffness, mut energy, mut samples) = (0.0, 0.0, 0_u16);
        for sample in self.touch.pins().iter().filter(|sample| sample.pin == pin) {
            let pulled = sample.pull(&at);
            (force, energy) = (sub(force, pulled.force), energy + pulled.energy);
            place = add(place, sample.place);
            given = add(given, sub(sample.point(&at), sample.place));
            stiffness += sample.stiffness();
            samples = samples.saturating_add(1);
        }
        if samples == 0 {
            return None;
        }
        let mean = model.unit_m() / f32::from(samples);
        Some(PinOutput {
            force_n: scale(model.force_unit_n(), force).map(finite).into(),
            position_m: add(model.centre_m(), scale(mean, place)),
            given_m: scale(mean, given),
            // The term's energy is in units of 2 k_ref.
            stiffness_n_per_m: finite(2.0 * model.stiffness_n_per_m() * stiffness),
            energy_j: finite(energy * model.energy_unit_j()),
            samples: samples.into(),
        })
    }

    /// The numbers of the pins, each once, in the order in which they were set.
    pub fn pins(&self) -> impl Iterator<Item = u16> {
        let pins = self.touch.pins();
        pins.chunk_by(|one, other| one.pin == other.pin).filter_map(|pin| Some(pin.first()?.pin))
    }

    /// Sets a pin on the body as it is, with a stiffness in the model's units. The next pass starts anew from the
    /// published points, where the pin has no energy.
    fn pin(
        &mut self,
        network: &Network<'_>,
        stiffness_n_per_m: f32,
        set: impl FnOnce(&mut Self, &Model<'_>, f32) -> Result<u16, PinError>,
    ) -> Result<u16, PinError> {
        let stiffness = stiffness_n_per_m / (2.0 * network.model().stiffness_n_per_m());
        let pin =
            self.with_body_model(network.model(), |tissue, model| set(tissue, model, stiffness))?;
        self.head.awake.wake_all(network.model());
        self.head.dynamics.interrupt();
        Ok(pin)
    }

    /// Energy of all pins; `None` without one.
    #[cfg(feature = "cut")]
    pub(super) fn energy_of_pins(&self, model: &Model<'_>) -> Option<TwoFloat> {
        if !PINS_ARE_BUILT || self.touch.pins().is_empty() {
            return None;
        }
        let at = places(model, self.state.get(..model.cells()).unwrap_or(&[]));
        Some(tools::energy_of_pins(self.touch.pins().iter(), &at))
    }

    /// Names the corners of the pinned samples anew after cells have split; the pins had this energy before. Samples
    /// of dropped pieces are dropped.
    #[cfg(feature = "cut")]
    pub(super) fn rename_pins(&mut self, network: &Network<'_>, before: TwoFloat) {
        let is_changed = self.with_body_model(network.model(), |tissue, model| {
            let Some(arrays) = tissue.touch.whole() else { return false };
            let Some(surface) = model.contact_surface() else { return false };
            let mut is_changed = false;
            for pin in arrays.pins_mut() {
                let found = surface.named(pin.triangle).map(|(corners, _)| corners);
                let corners = found.filter(|[a, b, _]| a != b);
                is_changed |= corners != Some(pin.corners);
                match corners {
                    Some(corners) => pin.corners = corners,
                    None => pin.share = 0.0,
                }
            }
            if is_changed {
                tools::drop_empty(arrays);
            }
            is_changed
        });
        if is_changed {
            let after = self.energy_of_pins(network.model()).unwrap_or(TwoFloat::ZERO);
            self.head.level.shift(tools::rise(before, after));
            self.head.awake.wake_all(network.model());
            self.head.dynamics.pushed();
        }
    }

    /// Checks that pins can be set.
    fn may_pin(&self, network: &Network<'_>, stiffness_n_per_m: f32) -> Result<(), PinError> {
        if !PINS_ARE_BUILT {
            Err(PinError::Unbuilt)
        } else if self.head.model != Some(network.model().checksum()) {
            Err(PinError::Model)
        } else if !self.head.has_tools {
            Err(PinError::NoTools)
        } else if stiffness_n_per_m.is_nan() || stiffness_n_per_m < STIFFNESS_MIN_N_PER_M {
            Err(PinError::Value)
        } else {
            Ok(())
        }
    }
}
