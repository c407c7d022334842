//! `f32`: the default. Loops over slices where a vector unit was found, cell by cell without one.

use super::sealed::Points;
use super::{Loops, Number, RangeError, Sum};
use crate::awake::{Awake, SliceSet};
use crate::cell::{Cell, dot};
use crate::contact::Contact;
use crate::hats::{Coarse, Eight, Solve};
use crate::link::{self, Band, Pull};
use crate::model::Model;
use crate::pass::Links;
use crate::scalar;
use crate::simd::coarse::{CoarseStep, Restrict};
use crate::simd::sliced::{self, Energy};
use crate::simd::{euler, run, track};
use crate::slice::Moved;
use crate::two_float::{Lanes, Plain, TwoFloat};

impl Number for f32 {
    const NAME: &'static str = "f32";
    const ZERO: Self = 0.0;
    const HATS: bool = true;
    type Words = [u32; 1];
    type Product = f32;
    type Sum = Plain;
    type Energy = Lanes;
    type Tally = ();
    type Band = Band;

    #[inline(always)]
    fn from_single(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn single(self) -> f32 {
        self
    }

    #[inline(always)]
    fn double(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn words(self) -> [u32; 1] {
        [self.to_bits()]
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn opposite(self) -> Self {
        -self
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        Self::from_bits(self.to_bits() & 0x7fff_ffff)
    }

    #[inline(always)]
    fn inner(a: [Self; 3], b: [Self; 3]) -> f32 {
        dot(a, b)
    }

    #[inline(always)]
    fn product_single(product: f32) -> f32 {
        product
    }

    #[inline(always)]
    fn mark(wd2: f32) -> Self {
        wd2
    }

    #[inline(always)]
    fn count((): &mut (), _wd2: f32) {}

    #[inline(always)]
    fn energy(lanes: &Lanes, (): ()) -> TwoFloat {
        lanes.total()
    }

    #[inline(always)]
    fn energy_term(lane: Self) -> f32 {
        lane
    }

    #[inline(always)]
    fn band(alpha: f32) -> Band {
        Band::new(alpha)
    }

    #[inline(always)]
    fn pull(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<Pull<Self>> {
        link::pull(pi, pj, l0, w, band, rest_difference)
    }

    fn admits(_model: &Model<'_>) -> Result<(), RangeError> {
        Ok(())
    }
}

#[allow(private_interfaces)]
impl Loops for f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    fn accumulate(links: Links<'_, '_>, awake: &SliceSet, v: &[Cell], residual: &mut [Cell]) {
        let model = links.model;
        if model.link_weights.is_some() || !links.closed && model.link_alphas.is_some() {
            return links.accumulate(awake, v, residual, |v| v);
        }
        crate::simd::vfp::pass::accumulate(model, Band::new(links.alpha(0)), awake, v, residual);
    }

    fn pass(
        links: Links<'_, '_>,
        awake: &SliceSet,
        v: &[Cell],
        residual: &mut [Cell],
        held: &[Contact],
    ) -> TwoFloat {
        let mut energy = Energy::default();
        if sliced::pass(links, awake, v, residual, held, &mut energy) {
            energy.total()
        } else {
            scalar::pass::energy(links, awake, v, residual, held)
        }
    }

    fn track_pass(
        links: Links<'_, '_>,
        awake: &SliceSet,
        points: &mut Points<'_, f32>,
        held: &[Contact],
    ) -> [TwoFloat; 4] {
        let mut sums = track::Sums::new(links.model, points.published, points.before);
        if sliced::pass(links, awake, points.at, points.residual, held, &mut sums) {
            sums.totals()
        } else {
            scalar::track::pass(links, awake, points, held)
        }
    }

    fn track_step(
        links: Links<'_, '_>,
        awake: &Awake,
        points: &mut Points<'_, f32>,
        factors: [f32; 2],
    ) -> Moved {
        match links.vectors {
            Some(_) => {
                run(links.vectors, track::Step { model: links.model, awake, points, factors })
            }
            #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
            None => crate::simd::vfp::update::track(links.model, awake, points, factors),
            #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
            None => scalar::track::step(links.model, awake, points, factors),
        }
    }

    fn coarse(
        links: Links<'_, '_>,
        residual: &[Cell],
        room: &mut [Eight],
        coarse: Coarse,
    ) -> TwoFloat {
        let Some(hats) = links.model.hats else { return TwoFloat::ZERO };
        match links.vectors {
            Some(_) => run(links.vectors, Restrict { hats, residual, room }),
            None => scalar::coarse::restrict(&hats, residual, room),
        }
        run(links.vectors, Solve { hats, room, coarse })
    }

    fn coarse_step(
        links: Links<'_, '_>,
        room: &[Eight],
        points: &mut Points<'_, f32>,
        [alpha, beta]: [f32; 2],
    ) -> bool {
        let Some(hats) = links.model.hats else { return false };
        if links.vectors.is_none() {
            return scalar::coarse::step(links.model, &hats, room, points, [alpha, beta]);
        }
        let (mobility, k) = (links.model.mobility, links.model.saturation());
        let Points { published, at, before, residual } = points;
        #[rustfmt::skip]
        let step = CoarseStep { hats, mobility, room, published, at, before, residual, alpha, beta, k };
        run(links.vectors, step)
    }

    fn euler_step(
        links: Links<'_, '_>,
        awake: &Awake,
        state: &mut [Cell],
        residual: &[Cell],
        step: f32,
    ) -> Moved {
        let model = links.model;
        match links.vectors {
            Some(_) => run(links.vectors, euler::Step { model, awake, state, residual, step }),
            #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
            None => crate::simd::vfp::update::euler(model, awake, state, residual, step),
            #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
            None => scalar::euler::step(model, awake, state, residual, step),
        }
    }
}

impl Sum<f32> for Lanes {
    #[inline(always)]
    fn add(&mut self, lane: usize, term: f32) {
        self.add_to(lane, term);
    }

    fn total(&self) -> TwoFloat {
        Self::total(self)
    }
}

impl Sum<f32> for Plain {
    #[inline(always)]
    fn add(&mut self, lane: usize, term: f32) {
        self.add_to(lane, term);
    }

    fn total(&self) -> TwoFloat {
        Self::total(self).into()
    }
}
