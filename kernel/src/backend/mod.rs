//! Loops over slices of eight cells, on vector units chosen at run time; the same bits everywhere.
//!
//! A loop is written once, as `Work` over the eight lanes of an `F32x8`, and compiled for each
//! unit: AVX2 on x86-64, NEON on aarch64, `simd128` on WebAssembly, plain Rust elsewhere.

#[cfg(target_arch = "x86_64")]
mod avx2;
pub(crate) mod f32x8;
#[cfg(any(
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
mod halves;
#[cfg(feature = "nodal")]
pub(crate) mod lane;
pub(crate) mod slice_set;
pub(crate) mod slices;
mod sums;
pub(crate) mod team;
#[cfg(test)]
pub(crate) mod tests;
#[cfg(any(
    target_arch = "x86_64",
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
mod vector;
#[cfg(not(any(
    target_arch = "x86_64",
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
mod vector {
    //! No vector unit: a proof of one cannot be made.

    use super::{VectorUnit, Work};

    pub(super) type Proof = core::convert::Infallible;

    pub(super) fn find() -> Option<Proof> {
        None
    }

    pub(super) fn run<W: Work>(unit: VectorUnit, _work: W) -> W::Output {
        match unit.0 {}
    }
}

use f32x8::{F32x8, Lanes8};

/// A vector unit that this processor and its operating system offer. A value of this type is the proof.
///
/// ```
/// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
/// use chaincell_kernel::VectorUnit;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// let has_unit = VectorUnit::find().is_some(); // a reset takes it by itself
/// let (mut fast, mut plain) = (Tissue::<128, Track>::new(), Tissue::<128, Track>::new());
/// for tissue in [&mut fast, &mut plain] {
///     tissue.reset(&network)?;
///     tissue.choose_contacts(&network, &[47])?;
/// }
/// plain.view().go_scalar();
/// # let mut force_n = 0.0;
/// for depth_m in [0.0, 0.002, 0.004] {
///     let pose = [ToolPose::at([0.0, 0.0, -depth_m].into(), 1)];
///     let output = fast.tick(&network, &pose, Budget::All);
///     assert_eq!(output, plain.tick(&network, &pose, Budget::All), "{has_unit}"); // the same bits
/// #     force_n = output.force_n.z;
/// }
/// # assert!(force_n > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VectorUnit(vector::Proof);

impl VectorUnit {
    /// Asks the processor. This takes a few microseconds in a virtual machine: call it once, not every tick.
    #[must_use]
    pub fn find() -> Option<Self> {
        vector::find().map(Self)
    }
}

/// A loop that any vector unit can do.
pub(crate) trait Work {
    /// The loop's result.
    type Output;
    /// Runs the loop. Implementations are `#[inline(always)]`, and so are all functions that they call: code
    /// is compiled for the unit only if it is inlined into the unit's own function.
    fn run<V: F32x8>(self) -> Self::Output;
}

/// Runs the work on the unit, or in plain Rust without one.
#[inline]
pub(crate) fn run<W: Work>(unit: Option<VectorUnit>, work: W) -> W::Output {
    match unit {
        Some(unit) => vector::run(unit, work),
        None => work.run::<Lanes8>(),
    }
}
