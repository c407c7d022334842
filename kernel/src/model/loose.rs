//! The fate of pieces of a body that come loose, in the section `CUTTING` of its image.

/// The fate of pieces of a cut body that hang on no fixed cell and on none that a tool holds; of a body that
/// nothing holds all but the largest.
///
/// ```
/// use chaincell_kernel::Loose;
///
/// assert_eq!(Loose::default(), Loose::Leave);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Loose {
    /// They move as tools and other sides push them.
    #[default]
    Leave,
    /// They stay where they came loose; tools and other sides feel them.
    Freeze,
    /// They are gone: nothing feels them.
    Drop,
}

#[cfg(feature = "cut")]
impl Loose {
    /// Reads the upper half of the first word of the section.
    pub(crate) fn read(word: u32) -> Option<Self> {
        [Self::Leave, Self::Freeze, Self::Drop].into_iter().find(|loose| loose.word() == word)
    }
}

impl Loose {
    /// The word that stands for it, in the upper half of the first word of the section.
    #[must_use]
    pub const fn word(self) -> u32 {
        match self {
            Self::Leave => 0,
            Self::Freeze => 1,
            Self::Drop => 2,
        }
    }
}
