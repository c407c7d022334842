//! Error of the force on small organs, for the table of microcontrollers: these compute the same
//! bits as this machine, so the error at a number of sweeps is found here and the instructions there.

use serde::Serialize;

use super::hand::{Reference, play};
use super::motions::Motion;
use super::scene::Source;
use super::snaps::{Snaps, Spread};
use crate::bodies::Variant;
use chaincell_host::bake::{BakeOptions, BasisSpacing};
use chaincell_host::engine::Scheme;
use chaincell_host::error::{Error, Result};
use chaincell_kernel::Choice;

/// An organ with a number of sweeps a tick.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EmbeddedRow {
    /// The scheme.
    pub scheme: &'static str,
    /// Its cells.
    pub cells: usize,
    /// Its coarse basis functions.
    pub coarse_functions: usize,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// Errors of the force.
    pub force: Spread,
    /// Snaps of the reference.
    pub snaps: Snaps,
}

/// Errors of a scheme on the organ of about so many cells, with a coarse level of this spacing.
///
/// # Errors
/// Another name than `track` and `predict`; as the bake and the engine.
pub fn errors(
    scheme: &str,
    cells: usize,
    spacing: BasisSpacing,
    sweeps: &[u16],
) -> Result<Vec<EmbeddedRow>> {
    let unknown = || Error::input(format!("{scheme}: no such scheme, take track or predict"));
    let known = [Scheme::Track, Scheme::Predict];
    let scheme = known.into_iter().find(|of| of.name() == scheme).ok_or_else(unknown)?;
    let options = BakeOptions { coarse_basis: spacing, ..BakeOptions::default() };
    let scene = Source::organ(Some(cells))?.bake(&options)?;
    let model = scene.model()?;
    let reference = Reference::follow(&scene, Motion::SLOW)?;
    let row = |&sweeps: &u16| {
        let variant = Variant::single(scheme, true);
        let (_, force) = play(&scene, &reference, Motion::SLOW, variant, sweeps)?;
        let snaps = reference.snaps.clone();
        let (cells, coarse_functions) = (model.cells(), model.coarse_functions());
        Ok(EmbeddedRow { scheme: scheme.name(), cells, coarse_functions, sweeps, force, snaps })
    };
    sweeps.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_level_and_sweeps_bring_a_small_organ_nearer() {
        let bare = errors("track", 200, BasisSpacing::None, &[1, 4]).unwrap();
        let coarse_functions = errors("track", 200, BasisSpacing::Links(3.5), &[1, 4]).unwrap();
        assert_eq!((bare[0].coarse_functions, bare[0].cells), (0, coarse_functions[0].cells));
        assert!(
            coarse_functions[0].coarse_functions > 0 && coarse_functions[0].snaps == bare[0].snaps
        );
        for (bare, coarse_functions) in bare.iter().zip(&coarse_functions) {
            assert!(
                coarse_functions.force.median < bare.force.median,
                "{bare:?} {coarse_functions:?}"
            );
        }
        assert!(bare[1].force.median < bare[0].force.median, "{bare:?}");
        let predicted = errors("predict", 200, BasisSpacing::None, &[1]).unwrap();
        assert!(predicted[0].force.median < bare[0].force.median, "{predicted:?} {bare:?}");
        for name in ["neither", "track without a coarse level"] {
            assert!(errors(name, 200, BasisSpacing::None, &[1]).is_err(), "{name}");
        }
    }
}
