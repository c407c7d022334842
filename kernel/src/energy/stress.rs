//! Strain and stress of the tissue at a cell, for reports: a tick computes neither.

/// Strain and stress of the tissue around a cell of nodal shapes:
/// [`TissueMut::stress`](crate::TissueMut::stress).
///
/// ```
/// let pulled = chaincell_kernel::Stress {
///     gradient: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.1]],
///     stretches: [1.1, 1.0, 1.0],
///     cauchy_pa: [[0.0; 3], [0.0; 3], [0.0, 0.0, 500.0]],
/// };
/// assert_eq!((pulled.von_mises_pa(), pulled.mean_pa()), (500.0, 500.0 / 3.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stress {
    /// Mean deformation gradient F of the tetrahedra around the cell, by rows.
    pub gradient: [[f32; 3]; 3],
    /// Principal stretches, the largest first.
    pub stretches: [f32; 3],
    /// Cauchy stress \[Pa\], by rows; symmetric, above 0 where the tissue is pulled.
    pub cauchy_pa: [[f32; 3]; 3],
}

/// Least volume of a shape in volumes at rest that a stress is divided by.
#[cfg(feature = "nodal")]
const VOLUME_MIN: f32 = 0.05;

/// The volume of a shape in volumes at rest, bounded below, so that the stress of a flat or inverted shape is finite.
#[cfg(feature = "nodal")]
pub(crate) fn bounded_volume(volume: f32) -> f32 {
    if volume > VOLUME_MIN { volume } else { VOLUME_MIN }
}

impl Stress {
    /// The elements of the Cauchy stress xx, yy, zz, xy, yz, xz \[Pa\].
    #[must_use]
    pub fn elements_pa(&self) -> [f32; 6] {
        let [[xx, xy, xz], [_, yy, yz], [.., zz]] = self.cauchy_pa;
        [xx, yy, zz, xy, yz, xz]
    }

    /// Mean stress \[Pa\], a third of the trace: below 0 where the tissue is pressed from all sides.
    #[must_use]
    pub fn mean_pa(&self) -> f32 {
        let [[xx, ..], [_, yy, _], [.., zz]] = self.cauchy_pa;
        (xx + yy + zz) / 3.0
    }

    /// Stress after von Mises \[Pa\]: how far the stress is from one that is equal on all sides; that of a bar
    /// under tension is its tension.
    #[must_use]
    pub fn von_mises_pa(&self) -> f32 {
        let [[xx, xy, xz], [_, yy, yz], [.., zz]] = self.cauchy_pa;
        let apart = |a: f32, b: f32| (a - b) * (a - b);
        let sheared = xy * xy + xz * xz + yz * yz;
        crate::number::sqrt::sqrt(
            0.5 * (apart(xx, yy) + apart(yy, zz) + apart(zz, xx)) + 3.0 * sheared,
        )
    }
}
