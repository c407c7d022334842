//! Haptic devices by their published limits.

use crate::tick::choice::choices;

choices! {
    /// A haptic device by its published limits.
    Device {
        /// 3D Systems Touch: 3.3 N, 400 N/m.
        Touch = 0, "touch";
        /// 3D Systems Phantom Premium 3.0: 22 N, 1000 N/m.
        Premium = 1, "premium";
        /// Novint Falcon: 8 N, 3000 N/m.
        Falcon = 2, "falcon";
        /// Force Dimension omega: 12 N, 5000 N/m.
        Omega = 3, "omega";
        /// Force Dimension sigma.7: 12 N, 4000 N/m.
        Sigma = 4, "sigma";
    }
}

impl Device {
    /// Largest force \[N\].
    #[must_use]
    pub const fn max_force_n(self) -> f32 {
        match self {
            Self::Touch => 3.3,
            Self::Premium => 22.0,
            Self::Falcon => 8.0,
            Self::Omega | Self::Sigma => 12.0,
        }
    }

    /// Largest stiffness that the device can show \[N/m\].
    #[must_use]
    pub const fn max_stiffness_n_per_m(self) -> f32 {
        match self {
            Self::Touch => 400.0,
            Self::Premium => 1000.0,
            Self::Falcon => 3000.0,
            Self::Omega => 5000.0,
            Self::Sigma => 4000.0,
        }
    }

    /// Stiffness of the default coupling: the device's, or the most at which the controller keeps a handle of
    /// its mass quiet in a loose hand, despite the encoder's quantisation \[N/m\].
    #[must_use]
    pub const fn coupling_n_per_m(self) -> f32 {
        match self {
            Self::Touch => 400.0,
            Self::Premium | Self::Falcon => 1000.0,
            Self::Omega | Self::Sigma => 2000.0,
        }
    }

    /// Damping of the default coupling, which keeps a soft hand from oscillating; 0 where the encoder's
    /// counts are too coarse to be damped [N s/m].
    #[must_use]
    pub const fn coupling_n_s_per_m(self) -> f32 {
        match self {
            Self::Touch | Self::Premium | Self::Falcon => 0.0,
            Self::Omega | Self::Sigma => 0.5,
        }
    }
}
