//! Moves the points of `track` with the tool.

use super::{ARRAYS, TRACK};
use crate::backend::Work;
use crate::backend::f32x8::F32x8;
use crate::backend::slices::{Chunks, ChunksMut};
use crate::energy::residual::Terms;
use crate::model::parts::PARTS;
use crate::number::cell::{Cell, add, peak, scale};
use crate::number::two_float::LANES;
use crate::solver::awake::Awake;

/// Moves the points of the next pass and of the last one along the fields, for a motion of the tool by `way`.
/// Returns true if some coordinate is beyond K.
pub(super) fn follow(
    terms: Terms<'_, '_>,
    own: &mut [Cell],
    awake: &mut Awake,
    way: [f32; 3],
) -> bool {
    let model = terms.model;
    let cells = model.cells();
    if own.len() != ARRAYS * cells {
        return false;
    }
    let Some((points, fields)) = own.split_at_mut_checked(TRACK * cells) else { return false };
    let Some((at, before)) = points.split_at_mut_checked(cells) else { return false };
    let Some((x, rest)) = fields.split_at_checked(cells) else { return false };
    let Some((y, z)) = rest.split_at_checked(cells) else { return false };
    awake.wake_all(model);
    let saturation = model.saturation();
    if terms.vectors.is_none() {
        return one_by_one(at, before, [x, y, z], way) > saturation;
    }
    let (parts, mut beyond) = (model.thread_parts(), [false; PARTS]);
    let points = parts.split_mut(at).into_iter().zip(parts.split_mut(before));
    let fields = parts.split(x).into_iter().zip(parts.split(y)).zip(parts.split(z));
    let mut arrays = points.zip(fields).zip(&mut beyond);
    let works = parts.each(|_| {
        let (((at, before), ((x, y), z)), beyond) = arrays.next()?;
        Some(Follow { at, before, fields: [x, y, z], way, saturation, beyond })
    });
    terms.team.run(terms.vectors, works.map(Option::flatten));
    beyond.contains(&true)
}

/// Moves both points cell by cell. Returns the largest magnitude of a coordinate of the first one.
fn one_by_one(at: &mut [Cell], before: &mut [Cell], [x, y, z]: [&[Cell]; 3], way: [f32; 3]) -> f32 {
    let mut highest = 0.0;
    for ((at, before), ((x, y), z)) in at.iter_mut().zip(before).zip(x.iter().zip(y).zip(z)) {
        let along = add(scale(way[0], x.xyz()), scale(way[1], y.xyz()));
        let along = add(along, scale(way[2], z.xyz()));
        *at = Cell::at(add(at.xyz(), along));
        *before = Cell::at(add(before.xyz(), along));
        let here = peak(at.xyz());
        highest = if here > highest { here } else { highest };
    }
    highest
}

/// The same over slices of a part.
struct Follow<'a> {
    at: &'a mut [Cell],
    before: &'a mut [Cell],
    fields: [&'a [Cell]; 3],
    way: [f32; 3],
    saturation: f32,
    /// Set to true if some coordinate of the first point is beyond K.
    beyond: &'a mut bool,
}

impl Work for Follow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let ([a, b, c], [x, y, z]) = (self.way, self.fields);
        let (a, b, c) = (V::splat(a), V::splat(b), V::splat(c));
        let (x, y) = (Chunks::new(x, Cell::ZERO), Chunks::new(y, Cell::ZERO));
        let (z, slices) = (Chunks::new(z, Cell::ZERO), self.at.len().div_ceil(LANES));
        let (mut at, mut before) = (ChunksMut::new(self.at), ChunksMut::new(self.before));
        let mut highest = V::splat(0.0);
        for slice in 0..slices {
            let (x, y, z) = (x.at(slice), y.at(slice), z.at(slice));
            let (at, before) = (at.at(slice), before.at(slice));
            // Two cells at a time; their fourth lanes become 0.
            for pair in 0..LANES / 2 {
                let along = a.times(V::pair(x, pair)).plus(b.times(V::pair(y, pair)));
                let along = along.plus(c.times(V::pair(z, pair)));
                let next = V::pair(at, pair).plus(along).positions();
                highest = highest.larger_magnitude(next);
                next.put_pair(at, pair);
                V::pair(before, pair).plus(along).positions().put_pair(before, pair);
            }
        }
        at.finish();
        before.finish();
        *self.beyond = V::any(highest.above(V::splat(self.saturation)));
    }
}
