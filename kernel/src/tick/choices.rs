//! The choices of a run. Their codes are those of the C interface, if it has them.

use super::choice::choices;
use crate::number::Number;
use crate::solver::{Dynamics, Euler, Predict, Rkl2, Track};

choices! {
    /// The scheme that moves the network.
    #[derive(Default)]
    Scheme {
        /// The paper's own: one explicit step of common size per sweep; time is physical. 32 bytes per cell.
        Euler = 1, <Euler as Dynamics>::NAME;
        /// Follows the equilibrium: conjugate directions under an energy guard, with a coarse level.
        #[default]
        Track = 0, <Track as Dynamics>::NAME;
        /// Runge-Kutta-Legendre super-steps of second order: the trajectory in time beyond the bound of `euler`.
        Rkl2 = 3, <Rkl2 as Dynamics>::NAME;
        /// `track` that predicts how the body responds to a move of the held cells: the force keeps up in one or
        /// two sweeps per tick. 112 bytes per cell.
        Predict = 7, <Predict as Dynamics>::NAME;
    }
}

impl Scheme {
    /// Returns true if the scheme uses [`Settings::tick_time`](crate::Settings::tick_time).
    #[must_use]
    pub fn goes_by_tick(self) -> bool {
        matches!(self, Self::Rkl2)
    }
}

choices! {
    /// Number format of cells and links, a [`Number`].
    #[derive(Default)]
    Arithmetic {
        /// IEEE 754 single precision: targets with an FPU, all schemes.
        #[default]
        F32 = 1, <f32 as Number>::NAME;
        /// Fixed point, 8.24 bits: targets without an FPU, `euler` and `track` without the coarse level.
        Fixed = 2, <fixed::types::I8F24 as Number>::NAME;
    }
}

choices! {
    /// Unloading: when the links' bands close to their rest lengths (the paper's Fig. 5b).
    ///
    /// ```
    /// # use chaincell_kernel::{Budget, Flags, Model, Network, Settings, Tissue, ToolPose, Track};
    /// # use chaincell_kernel::{coarse_room, include_model};
    /// use chaincell_kernel::Unloading;
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/box5.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// let settings = Settings { unloading: Unloading::Release, ..Settings::for_model(&model) };
    /// # let network = Network::new(model, settings)?;
    /// # let mut tissue = Tissue::<128, Track<{ coarse_room(27, 1) }>>::new();
    /// # tissue.reset(&network)?;
    /// # tissue.choose_contacts(&network, &[53])?;
    /// let mut flags = |engaged| {
    ///     let pose = ToolPose::at([0.0, 0.0, 0.0].into(), engaged);
    ///     tissue.tick(&network, &[pose], Budget::All).flags
    /// };
    /// assert!(!flags(1).contains(Flags::BAND_CLOSED)); // while the tool holds
    /// assert!(flags(0).contains(Flags::BAND_CLOSED)); // from its release on
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Default)]
    Unloading {
        /// Never.
        Off = 0, "off";
        /// From the tool's release until it engages again.
        #[default]
        Release = 1, "release";
        /// Like `release`, and also while the tool has retreated by more than a tenth of a mean link length
        /// from its deepest point, until it passes that point.
        Retreat = 2, "retreat";
    }
}

choices! {
    /// Effect of the tool's displacement on its contact cells.
    #[derive(Default)]
    Drive {
        /// It prescribes their positions: the cells are held where the tool has them.
        #[default]
        Position = 0, "position";
        /// It is the current into each of them, a load of 2 k times the displacement \[N\]; a body that nothing
        /// fixes drifts.
        ///
        /// The current is `I_i` of the cell equation (Eq. 2, 4; section 3.2): I = the tool's displacement
        /// since it engaged, per unit of network time, added to the residual of each contact cell; no cell is
        /// held. As a force it is a load of 2 `k_ref` I per cell \[N\]. At equilibrium the links exert the
        /// opposite force; the settled positions depend on the links' stiffness, and a body without fixed
        /// cells drifts up to K. On release I becomes 0 at once. The guarded quantity is E less the load's
        /// work; a current that may raise the energy above [`Model::energy_max`](crate::Model::energy_max) is cut
        /// (flag 1).
        ///
        /// ```
        /// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
        /// use chaincell_kernel::Drive;
        /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
        /// # let model = Model::from_bytes(image)?;
        /// let settings = Settings { drive: Drive::Current, ..Settings::for_model(&model) };
        /// # let network = Network::new(model, settings)?;
        /// # let mut tissue = Tissue::<128, Track>::new();
        /// # tissue.reset(&network)?;
        /// # tissue.choose_contacts(&network, &[47])?;
        /// # tissue.tick(&network, &[ToolPose::at([0.0; 3].into(), 1)], Budget::All);
        /// let pose = ToolPose::at([0.001, 0.0, 0.0].into(), 1);
        /// let mut force_n = 0.0;
        /// for _ in 0..200 {
        ///     force_n = tissue.tick(&network, &[pose], Budget::All).force_n.x;
        /// }
        /// assert!((force_n + 2.0 * 20.0 * 0.001).abs() < 1e-4); // [N]: 2 k_ref I, 0.04 N against the load
        /// # Ok::<(), Box<dyn std::error::Error>>(())
        /// ```
        Current = 1, "current";
    }
}

choices! {
    /// Cutting by blades and tearing.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, Network, Settings, include_model};
    /// use chaincell_kernel::Cutting;
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    ///
    /// let settings = Settings { cut: Cutting::Off, ..Settings::for_model(&model) };
    /// let words = settings.words(); // seven, as in every trace: it stands above the code of `drive`
    /// assert_eq!((words.len(), words[6]), (Settings::COUNT - 1, 1 << 16));
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[derive(Default)]
    Cutting {
        /// A blade cuts a body that can be cut, and one that tears does.
        #[default]
        On = 0, "on";
        /// No face opens: a blade feels nothing and leaves the tissue that it is in, and no cell tears. What is open
        /// stays open, and splits that wait are made.
        Off = 1, "off";
    }
}

#[cfg(test)]
mod tests {
    use super::super::choice::Choice;
    use super::*;

    fn is_a_table<T: Choice + core::fmt::Debug>() {
        for &value in T::ALL {
            assert_eq!(T::from_name(value.name()), Some(value));
            assert_eq!(T::from_code(value.code()), Some(value));
        }
        assert_eq!((T::from_name("neither"), T::from_code(u16::MAX)), (None, None));
    }

    #[test]
    fn every_name_and_every_code_means_one_value() {
        is_a_table::<Scheme>();
        is_a_table::<Arithmetic>();
        is_a_table::<Unloading>();
        is_a_table::<Drive>();
        is_a_table::<Cutting>();
    }
}
