//! The limit at which a body tears by itself, in the section `CUTTING` of its image.

#[cfg(feature = "cut")]
use super::image::{ModelError, cutting, kind};

/// The limit at which a body tears by itself. Both limits are scaled by a cell's mean edge h, so that a notched body
/// tears at the same load on a finer mesh: beside a crack the energy grows as 1 / h.
///
/// ```
/// use chaincell_kernel::TearLimit;
///
/// let limit = TearLimit::Stretch(1.5);
/// assert_eq!(limit.strength(160.0, 0.005), 0.5); // strain at the mean edge of 5 mm
/// assert_eq!(limit.strength(160.0, 0.00125), 1.0); // a quarter of the edge, twice the strain
/// assert_eq!(TearLimit::Toughness.strength(160.0, 0.005), 6400.0); // [Pa]
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TearLimit {
    /// The energy of a cell's shape and stiffening bands for each volume, or of its links, times the mean edge, reaches
    /// [`TEAR_SHARE`] of the toughness, and the cell is stretched.
    Toughness,
    /// The largest principal stretch of a cell reaches 1 + (S - 1) sqrt([`TEAR_EDGE_M`] / h), S this number, in
    /// [`TEAR_STRETCH`].
    Stretch(f32),
}

/// Stretches at which a body may tear.
///
/// ```
/// assert!(chaincell_kernel::TEAR_STRETCH.contains(&1.5));
/// ```
pub const TEAR_STRETCH: core::ops::RangeInclusive<f32> = 1.01..=10.0;

/// Share of the toughness that a cell's energy has to reach: with it a notched bar tears at Griffith's force.
///
/// ```
/// assert_eq!(chaincell_kernel::TEAR_SHARE, 0.2);
/// ```
pub const TEAR_SHARE: f32 = 0.2;

/// Mean edge at which a body tears at the stretch that was given \[m\].
///
/// ```
/// assert_eq!(chaincell_kernel::TEAR_EDGE_M, 0.005);
/// ```
pub const TEAR_EDGE_M: f32 = 0.005;

impl TearLimit {
    /// The load at which a cell of this mean edge \[m\] tears: its energy for each volume \[Pa\] for a limit by the
    /// toughness \[J/m^2\], else its largest stretch less 1.
    #[must_use]
    pub fn strength(self, toughness_j_per_m2: f32, edge_m: f32) -> f32 {
        match self {
            Self::Toughness => TEAR_SHARE * toughness_j_per_m2 / edge_m,
            Self::Stretch(stretch) => {
                (stretch - 1.0) * crate::number::sqrt::sqrt(TEAR_EDGE_M / edge_m)
            }
        }
    }

    /// Reads the words of the section.
    #[cfg(feature = "cut")]
    pub(crate) fn read(rule: u32, stretch: u32) -> Result<Self, ModelError> {
        let stretch = f32::from_bits(stretch);
        match rule {
            cutting::BY_TOUGHNESS if stretch.to_bits() == 0 => Ok(Self::Toughness),
            cutting::BY_STRETCH if TEAR_STRETCH.contains(&stretch) => Ok(Self::Stretch(stretch)),
            cutting::BY_TOUGHNESS | cutting::BY_STRETCH => {
                Err(ModelError::Value(kind::CUTTING, cutting::TEAR_STRETCH as u32))
            }
            _ => Err(ModelError::Value(kind::CUTTING, cutting::TEAR_RULE as u32)),
        }
    }
}
