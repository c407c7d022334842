//! Pins from tick to tick: they fade when they are released, and others are set.

use super::energies::rise;
use crate::contact::error::PinError;
use crate::contact::memory::{TouchArrays, TouchState};
use crate::energy::surface::{PinSample, Proxies, each_met, each_sample};
use crate::model::Model;
use crate::number::cell::{dot, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;

/// Energy of some pins.
pub(crate) fn energy_of_pins<'a>(
    pins: impl Iterator<Item = &'a PinSample>,
    at: &impl Fn(usize) -> [f32; 3],
) -> TwoFloat {
    pins.fold(TwoFloat::ZERO, |sum, pin| sum.plus(pin.pull(at).energy.into()))
}

/// Fades the released pins, and drops those that hold nothing any more. Returns the change of the energy; `None`
/// if no pin fades.
pub(super) fn fade(
    arrays: &mut TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
) -> Option<TwoFloat> {
    let fades = |pin: &&PinSample| pin.fade > 0.0;
    if !arrays.pins().iter().any(|pin| fades(&pin)) {
        return None;
    }
    let before = energy_of_pins(arrays.pins().iter().filter(fades), at);
    for pin in arrays.pins_mut().iter_mut().filter(|pin| pin.fade > 0.0) {
        let share = pin.share - pin.fade;
        pin.share = if share > 0.0 { share } else { 0.0 };
    }
    let after = energy_of_pins(arrays.pins().iter().filter(fades), at);
    drop_empty(arrays);
    Some(rise(before, after))
}

/// Drops the samples that hold nothing, in place.
pub(crate) fn drop_empty(arrays: &mut TouchArrays<'_>) {
    let (pins, mut count) = (arrays.pins_mut(), 0);
    for index in 0..pins.len() {
        let pin = pins.get(index).copied().unwrap_or(PinSample::NONE);
        if pin.share > 0.0 {
            if let Some(slot) = pins.get_mut(count) {
                *slot = pin;
            }
            count += 1;
        }
    }
    if let Some(state) = arrays.state.first_mut() {
        (state.pins, state.pins_changed) = (count, true);
    }
}

/// The lowest number that no pin has.
fn free_number(pins: &[PinSample]) -> u16 {
    let is_free = |number: &u16| pins.iter().all(|pin| pin.pin != *number);
    (0..u16::MAX).find(is_free).unwrap_or(u16::MAX)
}

/// A pin in the making: its samples lie behind those of the other pins.
pub(crate) struct NewPin<'a> {
    slots: &'a mut [PinSample],
    state: &'a mut TouchState,
    number: u16,
    /// Samples found; those beyond the memory are counted too.
    found: usize,
}

impl<'a> NewPin<'a> {
    /// In the memory of all pins, behind those that are set.
    pub fn behind(all: &'a mut [PinSample], state: &'a mut TouchState) -> Option<Self> {
        let (pins, slots) = all.split_at_mut_checked(state.pins)?;
        Some(Self { slots, state, number: free_number(pins), found: 0 })
    }

    fn put(&mut self, sample: PinSample, at: &impl Fn(usize) -> [f32; 3]) {
        if let Some(slot) = self.slots.get_mut(self.found) {
            // -0.0 becomes +0.0.
            let here = PinSample { pin: self.number, ..sample }.here(at);
            *slot = PinSample { place: here.place.map(|x| x + 0.0), ..here };
        }
        self.found += 1;
    }

    /// Takes the samples of the surface within a ball. Returns the distance of the nearest sample from its middle.
    pub fn around(
        &mut self,
        model: &Model<'_>,
        middle: [f32; 3],
        radius: f32,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> f32 {
        let mut nearest = f32::MAX;
        // A square beyond f32 is within no radius.
        let most = (radius * radius).min(f32::MAX);
        let Some(surface) = model.contact_surface() else { return nearest };
        for index in 0..surface.triangles.len() {
            let Some((corners, sampling)) = surface.triangle(index) else { continue };
            let share = surface.share(index, sampling.edge, at);
            if share <= 0.0 {
                continue;
            }
            let parts = sampling.parts(radius);
            let full =
                share * sampling.rigid(model.is_nodal()) / (f32::from(parts) * f32::from(parts));
            let triangle = surface.name(index);
            each_sample(parts, corners.map(|cell| at(cell.into())), |weights, point| {
                let way = sub(point, middle);
                let squared = dot(way, way);
                nearest = if squared < nearest { squared } else { nearest };
                if squared <= most {
                    let sample = PinSample { corners, weights, triangle, full, ..PinSample::NONE };
                    self.put(sample, at);
                }
            });
        }
        sqrt(nearest)
    }

    /// Returns true if it has no sample.
    pub fn is_empty(&self) -> bool {
        self.found == 0
    }

    /// Sets the stiffness of the whole pin, at most that of a rigid one, and counts it among the pins. Returns its
    /// number.
    pub fn set(self, stiffness: f32) -> Result<u16, PinError> {
        let Self { slots, state, number, found } = self;
        let capacity = slots.len();
        let own = slots.get_mut(..found).ok_or(PinError::Room { needed: found, capacity })?;
        let whole = own.iter().fold(0.0, |sum, pin| sum + pin.full);
        if stiffness < whole {
            own.iter_mut().for_each(|pin| pin.full *= stiffness / whole);
        }
        state.pins += found;
        state.pins_changed = true;
        Ok(number)
    }
}

/// Pins what a tool grips, or what it touches if it grips nothing. Returns the number of the pin.
pub(crate) fn pin_held(
    arrays: &mut TouchArrays<'_>,
    model: &Model<'_>,
    tool: usize,
    stiffness: f32,
    at: &impl Fn(usize) -> [f32; 3],
) -> Result<u16, PinError> {
    let Some(surface) = model.contact_surface() else { return Err(PinError::NoTools) };
    let grips = super::held_by(arrays, tool) > 0;
    let (near_count, anchors) = (arrays.near().len(), arrays.state.first());
    let anchors = anchors.map_or(&[][..], |state| state.present(arrays.anchors));
    let (tools, near) = (Proxies(arrays.tools), arrays.near.get(..near_count).unwrap_or(&[]));
    let state = arrays.state.first_mut().ok_or(PinError::NothingHeld(tool))?;
    let mut pin = NewPin::behind(arrays.pins, state).ok_or(PinError::Unbuilt)?;
    for near in near.iter().filter(|near| near.tool() == tool) {
        let Some((solid, (_, sampling))) = tools.part(near.of).zip(surface.named(near.index))
        else {
            continue;
        };
        let all = f32::from(near.parts) * f32::from(near.parts);
        let own = near.anchors_of(anchors);
        each_met(solid, near, anchors, near.corners.map(|cell| at(cell.into())), |sample| {
            let is_gripped =
                own.iter().any(|anchor| anchor.sample == sample.index && anchor.is_grip());
            if if grips { is_gripped } else { sample.depth > 0.0 } {
                pin.put(
                    PinSample {
                        corners: near.corners,
                        weights: sample.weights,
                        triangle: near.index,
                        full: sampling.rigid(model.is_nodal()) / all,
                        ..PinSample::NONE
                    },
                    at,
                );
            }
        });
    }
    if pin.is_empty() { Err(PinError::NothingHeld(tool)) } else { pin.set(stiffness) }
}
