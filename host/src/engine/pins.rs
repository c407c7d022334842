//! Pins: points and regions of the surface that are held to the world.

use chaincell_client::command::Refusal;
use chaincell_kernel::trace::Command;
use chaincell_kernel::{Dynamics, Network, PinError, PinOutput};

use super::{Engine, Memory};

/// Interface to the pins of a tissue of any scheme.
pub(super) trait AnyPins {
    fn pin_at(
        &mut self,
        network: &Network<'_>,
        point_m: [f32; 3],
        radius_m: f32,
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError>;
    fn pin_held(
        &mut self,
        network: &Network<'_>,
        tool: usize,
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError>;
    fn unpin(&mut self, pin: u16, ticks: u16) -> Result<(), PinError>;
    fn pin_output(&mut self, network: &Network<'_>, pin: u16) -> Option<PinOutput>;
    fn pins(&mut self) -> Vec<u16>;
    fn newest_pin(&mut self) -> Option<u16>;
}

impl<D: Dynamics> AnyPins for Memory<D> {
    fn pin_at(
        &mut self,
        network: &Network<'_>,
        point_m: [f32; 3],
        radius_m: f32,
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError> {
        self.view().pin_at(network, point_m, radius_m, stiffness_n_per_m)
    }

    fn pin_held(
        &mut self,
        network: &Network<'_>,
        tool: usize,
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError> {
        self.view().pin_held(network, tool, stiffness_n_per_m)
    }

    fn unpin(&mut self, pin: u16, ticks: u16) -> Result<(), PinError> {
        self.view().unpin(pin, ticks)
    }

    fn pin_output(&mut self, network: &Network<'_>, pin: u16) -> Option<PinOutput> {
        self.view().pin_output(network, pin)
    }

    fn pins(&mut self) -> Vec<u16> {
        self.view().pins().collect()
    }

    fn newest_pin(&mut self) -> Option<u16> {
        self.view().pins().last()
    }
}

impl Engine<'_> {
    /// Pins the surface around a point where it is, see
    /// [`TissueMut::pin_at`](chaincell_kernel::TissueMut::pin_at). Returns the number of the pin.
    ///
    /// # Errors
    /// The reason for the refusal; nothing has changed then.
    pub fn pin_at(
        &mut self,
        point_m: [f32; 3],
        radius_m: f32,
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError> {
        self.tissue.pin_at(&self.network, point_m, radius_m, stiffness_n_per_m)
    }

    /// Pins what a tool grips or touches, see
    /// [`TissueMut::pin_held`](chaincell_kernel::TissueMut::pin_held). Returns the number of the pin.
    ///
    /// # Errors
    /// The reason for the refusal; nothing has changed then.
    pub fn pin_held(&mut self, tool: usize, stiffness_n_per_m: f32) -> Result<u16, PinError> {
        self.tissue.pin_held(&self.network, tool, stiffness_n_per_m)
    }

    /// Releases a pin within `ticks` ticks.
    ///
    /// # Errors
    /// No pin has this number.
    pub fn unpin(&mut self, pin: u16, ticks: u16) -> Result<(), PinError> {
        self.tissue.unpin(pin, ticks)
    }

    /// Force, place and stiffness of a pin; `None` if no pin has this number.
    pub fn pin_output(&mut self, pin: u16) -> Option<PinOutput> {
        self.tissue.pin_output(&self.network, pin)
    }

    /// The numbers of the pins, in the order in which they were set.
    pub fn pins(&mut self) -> Vec<u16> {
        self.tissue.pins()
    }

    /// The number of the pin that was set last, of those that hold. Allocates nothing.
    pub fn newest_pin(&mut self) -> Option<u16> {
        self.tissue.newest_pin()
    }

    /// Sets or releases a pin. A refused command changes nothing.
    pub(super) fn obey_pin(&mut self, command: &Command) -> Result<(), Refusal> {
        let done = match *command {
            Command::Pin { tool, stiffness_n_per_m } => {
                let tools = self.contact.tools();
                if tools > 0 && tool as usize >= tools {
                    return Err(Refusal::NoTool);
                }
                self.pin_held(tool as usize, stiffness_n_per_m).map(drop)
            }
            Command::PinAt { point_m, radius_m, stiffness_n_per_m } => {
                self.pin_at(point_m, radius_m, stiffness_n_per_m).map(drop)
            }
            Command::Unpin { pin, ticks } => self.unpin(pin, ticks),
            _ => return Err(Refusal::Unsupported),
        };
        done.map_err(|why| match why {
            PinError::NoTools => Refusal::NoSurface,
            PinError::NothingHeld(_) => Refusal::NothingHeld,
            PinError::Unknown(_) => Refusal::NoPin,
            PinError::Room { .. } => Refusal::PinRoom,
            PinError::Reach { .. } => Refusal::PinReach,
            PinError::Value => Refusal::Value,
            PinError::Model | PinError::Unbuilt => Refusal::Unsupported,
        })
    }
}
