//! Doubts: causes for which the force goes off, and comes again when they are over.

/// A cause for which the force goes off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Doubt {
    /// A message of the service is no state.
    Malformed,
    /// A state without the device.
    NoDevice,
    /// The service says that the device is not ready, or not calibrated.
    NotReady,
    /// A position that is not finite, or farther away than a device reaches.
    OutOfReach,
    /// The device is farther from its last position than a hand moves it.
    Jump,
    /// No state for the time of the watchdog.
    ServiceSilent,
    /// No answer of the tissue for the time of the watchdog.
    TissueSilent,
    /// Another server has the scene now.
    NewSession,
}

impl Doubt {
    /// All of them, with their names in the JSON of a report.
    pub const ALL: [(Self, &str); 8] = [
        (Self::Malformed, "malformed"),
        (Self::NoDevice, "no_device"),
        (Self::NotReady, "not_ready"),
        (Self::OutOfReach, "out_of_reach"),
        (Self::Jump, "jump"),
        (Self::ServiceSilent, "service_silent"),
        (Self::TissueSilent, "tissue_silent"),
        (Self::NewSession, "new_session"),
    ];

    /// Returns true for a fault in what the service sends.
    #[must_use]
    pub fn is_of_states(self) -> bool {
        matches!(self, Self::Malformed | Self::NoDevice | Self::NotReady | Self::OutOfReach)
    }
}

impl std::fmt::Display for Doubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = match self {
            Self::Malformed => {
                "a message of the service is no state of an Inverse3: is it service 3.1 or newer?"
            }
            Self::NoDevice => "the service no longer lists the device: is it plugged in?",
            Self::NotReady => {
                "the service says that the device is not ready or not calibrated: see Haply Hub"
            }
            Self::OutOfReach => {
                "the device's position is not finite, or more than 1 m from its zero"
            }
            Self::Jump => "the device's position jumps: is --max-speed-m-per-s too low?",
            Self::ServiceSilent => "the service is silent: is it busy, or the device unplugged?",
            Self::TissueSilent => "the tissue does not answer: does `chaincell serve` keep up?",
            Self::NewSession => "another server answers on the scene",
        };
        write!(f, "{text}; force off")
    }
}
