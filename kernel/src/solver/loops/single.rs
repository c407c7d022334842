//! The loops of `f32`: over slices if a vector unit was found, otherwise cell by cell.

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
use super::vfp;
use super::{Loops, Moved, Points, scalar, sliced};
use crate::backend::run;
use crate::backend::slice_set::SliceSet;
use crate::energy::residual::Terms;
use crate::energy::sliced::{self as sliced_terms, Energy};
use crate::model::coarse_basis::CoarseBasis;
use crate::number::cell::Cell;
use crate::number::two_float::{Eight, TwoFloat};
use crate::solver::awake::Awake;
use crate::solver::coarse::elastic::ElasticSolve;
use crate::solver::coarse::sides;
use crate::solver::coarse::sliced::Restrict;
use crate::solver::coarse::turns::turn;
use crate::solver::coarse::{self, Coarse, CoarseTouch, Solve};

#[allow(private_interfaces)]
impl Loops for f32 {
    const COARSE: bool = true;

    fn residual(
        terms: Terms<'_, '_>,
        changed: &SliceSet,
        awake: &SliceSet,
        v: &[Cell],
        residual: &mut [Cell],
    ) -> TwoFloat {
        let mut energy = Energy::default();
        if sliced_terms::residual(terms, changed, awake, v, residual, &mut energy) {
            energy.total()
        } else {
            terms.update(changed, v);
            terms.energy(awake, v, residual)
        }
    }

    fn track_residual(
        terms: Terms<'_, '_>,
        awake: &SliceSet,
        points: &mut Points<'_, f32>,
    ) -> [TwoFloat; 4] {
        track_residual(terms, awake, points)
    }

    fn elastic_residual(
        terms: Terms<'_, '_>,
        awake: &SliceSet,
        points: &mut Points<'_, f32>,
    ) -> [TwoFloat; 5] {
        track_residual(terms, awake, points)
    }

    fn track_step(
        terms: Terms<'_, '_>,
        awake: &Awake,
        points: &mut Points<'_, f32>,
        factors: [f32; 2],
        moved: &mut Moved,
    ) {
        match terms.vectors {
            Some(_) => sliced::track::step(terms, awake, points, factors, moved),
            #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
            None => vfp::track(terms, awake, points, factors, moved),
            #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
            None => scalar::track::step(terms, awake, points, factors, moved),
        }
    }

    fn coarse(
        terms: Terms<'_, '_>,
        residual: &[Cell],
        room: &mut [Eight],
        how: Coarse,
    ) -> TwoFloat {
        let Some(basis) = terms.model.coarse_basis else { return TwoFloat::ZERO };
        restrict(terms, basis, residual, room);
        run(terms.vectors, Solve { basis, room, coarse: how })
    }

    fn coarse_step(
        terms: Terms<'_, '_>,
        room: &[Eight],
        points: &mut Points<'_, f32>,
        [alpha, beta]: [f32; 2],
    ) -> bool {
        let Some(basis) = terms.model.coarse_basis else { return false };
        if terms.vectors.is_none() {
            return coarse::scalar::step(terms, &basis, room, points, [alpha, beta]);
        }
        coarse::sliced::step(terms, &basis, room, points, [alpha, beta])
    }

    fn elastic(
        terms: Terms<'_, '_>,
        residual: &[Cell],
        room: &mut [Eight],
        corrections: usize,
        touch: Option<&CoarseTouch>,
    ) -> [TwoFloat; 2] {
        let Some(basis) = terms.model.coarse_basis else { return [TwoFloat::ZERO; 2] };
        restrict(terms, basis, residual, room);
        let vector = basis.row_blocks();
        turn(terms, &basis, room.get_mut(..vector).unwrap_or(&mut []), true);
        sides::turn(terms, &basis, room, true);
        let products = ElasticSolve { basis, room, corrections, touch }.solve(
            terms.vectors,
            terms.team,
            terms.model.thread_parts().count(),
        );
        turn(terms, &basis, room.get_mut(vector..2 * vector).unwrap_or(&mut []), false);
        sides::turn(terms, &basis, room, false);
        products
    }

    fn euler_step(
        terms: Terms<'_, '_>,
        awake: &Awake,
        state: &mut [Cell],
        residual: &[Cell],
        step: f32,
        moved: &mut Moved,
    ) {
        let model = terms.model;
        match terms.vectors {
            Some(_) => {
                let step = sliced::euler::Step { model, awake, state, residual, step, moved };
                run(terms.vectors, step);
            }
            #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
            None => vfp::euler(model, awake, state, residual, step, moved),
            #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
            None => scalar::euler::step(model, awake, state, residual, step, moved),
        }
    }
}

/// The pass of `track`, over slices or cell by cell.
fn track_residual<const SUMS: usize>(
    terms: Terms<'_, '_>,
    awake: &SliceSet,
    points: &mut Points<'_, f32>,
) -> [TwoFloat; SUMS] {
    if terms.vectors.is_none() {
        return scalar::track::residual(terms, awake, points);
    }
    let sums = if terms.model.thread_parts().count() > 1 {
        sliced::track::residual_in_parts(terms, awake, points)
    } else {
        sliced::track::residual(terms, awake, points)
    };
    sums.unwrap_or_else(|| scalar::track::residual(terms, awake, points))
}

/// P' r into the first three vectors of the coarse memory.
#[inline(always)]
fn restrict(terms: Terms<'_, '_>, basis: CoarseBasis<'_>, residual: &[Cell], room: &mut [Eight]) {
    match terms.vectors {
        Some(_) => run(terms.vectors, Restrict { basis, residual, room }),
        None => coarse::scalar::restrict(&basis, residual, room),
    }
}
