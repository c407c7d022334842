//! Sweep budget of a tick.

/// Limits the sweeps of a tick, on top of [`Settings::sweeps`](crate::Settings::sweeps).
///
/// The sweeps of a scheme that is not [`Dynamics::IS_ANYTIME`](crate::Dynamics::IS_ANYTIME) are the
/// tissue's time: such a tick makes all of them, whatever the budget.
///
/// ```
/// # use chaincell_kernel::{Flags, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
/// use chaincell_kernel::Budget;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
/// # tissue.choose_contacts(&network, &[47])?;
/// # let poses = [ToolPose::at([0.0, 0.0, -0.001].into(), 1)];
/// let mut is_time_left = |sweeps: u16| sweeps < 2; // a firmware asks its cycle counter
/// let output = tissue.tick(&network, &poses, Budget::While(&mut is_time_left));
/// assert_eq!(output.sweeps, 2);
///
/// let overtaken = tissue.tick(&network, &poses, Budget::LATE);
/// assert!(overtaken.flags.contains(Flags::LATE) && overtaken.sweeps == 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub enum Budget<'a> {
    /// All sweeps of the settings.
    All,
    /// This many; 0 for a tick that is late, see [`Self::LATE`].
    Sweeps(u16),
    /// At least one, then as long as the function returns true: it is called after each sweep but the last,
    /// with the number of sweeps done.
    While(&'a mut dyn FnMut(u16) -> bool),
    /// At least one, then until the [estimated error](crate::TissueMut::force_error_n) of the force on each tool in
    /// contact is at most `share` of its last force, and as long as `more` returns true, if it is given, as in
    /// [`Self::While`]. Where the error is not known, and as contact begins, `more` alone counts.
    Within {
        /// Share of the force.
        share: f32,
        /// Returns true if another sweep fits.
        more: Option<&'a mut dyn FnMut(u16) -> bool>,
    },
}

impl Budget<'_> {
    /// No sweep, for poses that newer ones have overtaken: the tools move within the step limit and the
    /// energy limit as usual, and the energy level is updated. The output repeats the force of the last tick
    /// with [`Flags::LATE`](crate::Flags::LATE), 0 if the tool releases. Bands stay as they are until a tick
    /// with a sweep. Tools on a contact surface stay where they are.
    ///
    /// Cost: the links of the contact cells, at most four times. If the level is unknown (positions were set, or
    /// bands changed), there is one sweep.
    pub const LATE: Self = Self::Sweeps(0);

    /// Budget that repeats a tick of `sweeps` sweeps; `None` repeats one with those of the settings.
    #[must_use]
    pub const fn again(sweeps: Option<u16>) -> Self {
        match sweeps {
            None => Self::All,
            Some(sweeps) => Self::Sweeps(sweeps),
        }
    }

    /// Returns true if another sweep is wanted after `done`.
    pub(super) fn goes_on(&mut self, done: u16) -> bool {
        match self {
            Self::All | Self::Within { more: None, .. } => true,
            Self::Sweeps(sweeps) => done < *sweeps,
            Self::While(more) | Self::Within { more: Some(more), .. } => more(done),
        }
    }

    /// The share of the force at which its error is small enough, if one is named.
    pub(super) fn within(&self) -> Option<f32> {
        if let Self::Within { share, .. } = self { Some(*share) } else { None }
    }

    /// Lets the error end no tick.
    #[cfg(feature = "cut")]
    pub(super) fn forget_error(&mut self) {
        if let Self::Within { share, .. } = self {
            *share = 0.0;
        }
    }

    pub(super) fn is_late(&self) -> bool {
        matches!(self, Self::Sweeps(0))
    }
}
