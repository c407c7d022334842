//! Passes and updates over slices, on the machine's unit and in plain Rust, compared with those that visit
//! links and cells one by one.

mod body;

use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

use super::{Loops, Moved, Points, scalar, sliced};
use crate::backend::slice_set::SliceSet;
use crate::backend::tests::unit;
use crate::backend::{VectorUnit, run};
use crate::energy::held::Contact;
use crate::energy::residual::Terms;
use crate::energy::sliced::SlicedResidual;
use crate::energy::state::States;
use crate::model::image::CELLS_MAX;
use crate::model::{COORDINATE_MAX, Model, rest_length};
use crate::number::cell::Cell;
use crate::number::two_float::TwoFloat;
use crate::solver::awake::Awake;
use body::{Body, Link, Varied};

/// All results of a pass and its updates, as bits.
#[derive(Debug, Default, PartialEq)]
struct Outcome {
    residual: Vec<[u32; 4]>,
    sums: Vec<u32>,
    points: [Vec<[u32; 4]>; 3],
    euler: Vec<[u32; 4]>,
    moved: Vec<(bool, Vec<usize>)>,
}

fn bits(cells: &[Cell]) -> Vec<[u32; 4]> {
    cells.iter().map(|cell| cell.0.map(f32::to_bits)).collect()
}

impl Outcome {
    fn sums(&mut self, sums: [TwoFloat; 4]) {
        self.sums = sums.iter().flat_map(|sum| [sum.hi, sum.lo].map(f32::to_bits)).collect();
    }

    fn moved(&mut self, moved: &Moved) {
        let slices = moved.slices.iter(CELLS_MAX / 8).collect();
        self.moved.push((moved.beyond, slices));
    }
}

const FACTORS: [f32; 2] = [2.25, 0.625];

type Pass<'a> = dyn Fn(Terms<'_, '_>, &Awake, &mut Points<'_, f32>) -> [TwoFloat; 4] + 'a;
type Step<'a> = dyn Fn(&Awake, &mut Points<'_, f32>, &mut Moved) + 'a;
type EulerStep<'a> = dyn Fn(&Awake, &mut [Cell], &[Cell], &mut Moved) + 'a;

#[derive(Debug, Clone)]
struct Case {
    rest: Vec<[f32; 3]>,
    links: Vec<Link>,
    at: Vec<[f32; 3]>,
    held: Vec<u16>,
    alpha: f32,
    varied: Varied,
    closed: bool,
}

impl Case {
    fn model<'a>(&self, body: &'a Body) -> Model<'a> {
        body.model(self.alpha, self.varied)
    }

    fn terms<'a, 'm>(&self, model: &'a Model<'m>) -> Terms<'a, 'm> {
        Terms { closed: self.closed, ..Terms::of(model, States::NONE) }
    }

    /// Pass and updates cell by cell.
    fn scalar(&self, model: &Model<'_>) -> Outcome {
        self.outcome(
            model,
            &|terms, awake, points| scalar::track::residual(terms, &awake.set, points),
            &|awake, points, moved| {
                f32::track_step(self.terms(model), awake, points, FACTORS, moved);
            },
            &|awake, state, residual, moved| {
                f32::euler_step(self.terms(model), awake, state, residual, 0.2, moved);
            },
        )
    }

    /// Pass and updates over slices, in plain Rust without a unit.
    fn slices(&self, model: &Model<'_>, unit: Option<VectorUnit>) -> Outcome {
        self.outcome(
            model,
            &|terms, awake, points| {
                let mut sums = sliced::track::Sums::new(terms, points.published, points.before);
                let (at, residual, awake) = (&*points.at, &mut *points.residual, &awake.set);
                let (held, reduce) = (terms.held(), &mut sums);
                let (slices, list) = (0..model.slice_count(), || (terms.list(), terms.states));
                run(unit, SlicedResidual { awake, slices, at, residual, held, list, reduce });
                sums.totals()
            },
            &|awake, points, moved| {
                let (slices, mobility) = (0..model.slice_count(), model.mobility);
                let (points, factors, saturation) = (points.reborrow(), FACTORS, model.saturation());
                #[rustfmt::skip]
                let step = sliced::track::Step { awake, slices, mobility, points, factors, saturation, moved };
                run(unit, step);
            },
            &|awake, state, residual, moved| {
                let step = 0.2;
                run(unit, sliced::euler::Step { model, awake, state, residual, step, moved });
            },
        )
    }

    fn outcome(
        &self,
        model: &Model<'_>,
        pass: &Pass<'_>,
        step: &Step<'_>,
        euler: &EulerStep<'_>,
    ) -> Outcome {
        let (mut at, held) = self.arrays();
        let terms = Terms { contacts: &held, ..self.terms(model) };
        let mut residual = vec![Cell([9.0; 4]); at.len()];
        // Some cells are at rest, some are not.
        let mut published: Vec<Cell> = at.clone();
        let mut before: Vec<Cell> = model.rest.iter().map(|&rest| Cell::at(rest)).collect();
        for (before, at) in before.iter_mut().zip(&at).step_by(3) {
            *before = *at;
        }
        published.rotate_left(1);
        let mut awake = Awake::NONE;
        awake.wake_all(model);
        if !self.held.is_empty() {
            awake.spread = SliceSet::EMPTY;
        }
        let mut points = Points {
            published: &mut published,
            at: &mut at,
            before: &mut before,
            residual: &mut residual,
        };
        let mut outcome = Outcome::default();
        outcome.sums(pass(terms, &awake, &mut points));
        outcome.residual = bits(points.residual);
        let mut state = points.at.to_vec();
        let mut moved = Moved::NOTHING;
        euler(&awake, &mut state, points.residual, &mut moved);
        outcome.moved(&moved);
        outcome.euler = bits(&state);
        let mut moved = Moved::NOTHING;
        step(&awake, &mut points, &mut moved);
        outcome.moved(&moved);
        outcome.points = [bits(points.published), bits(points.at), bits(points.before)];
        outcome
    }

    fn arrays(&self) -> (Vec<Cell>, Vec<Contact>) {
        let at = self.at.iter().map(|&position| Cell::at(position)).collect();
        (at, self.held.iter().map(|&cell| Contact::new(cell)).collect())
    }
}

/// Position of a cell: near its rest position, at it, at one of a few points that it shares with others, less
/// than a denormal away from such a point, or as far away as a state may be.
#[derive(Debug, Clone, Copy)]
enum Place {
    Near([f32; 3]),
    Rest,
    Shared(u8),
    Denormal(u8, [u32; 3]),
    Exploded([f32; 3]),
    Corner([bool; 3]),
}

impl Place {
    fn position(self, rest: [f32; 3]) -> [f32; 3] {
        let shared = |point: u8| [[0.0; 3], [1.5, -0.25, 0.0], rest][usize::from(point)];
        let position = match self {
            Self::Near(way) => [rest[0] + way[0], rest[1] + way[1], rest[2] + way[2]],
            Self::Rest => rest,
            Self::Shared(point) => shared(point),
            Self::Denormal(point, bits) => {
                let point = shared(point);
                core::array::from_fn(|axis| point[axis] + f32::from_bits(bits[axis]))
            }
            Self::Exploded(position) => position,
            Self::Corner(signs) => {
                signs.map(|up| if up { COORDINATE_MAX } else { -COORDINATE_MAX })
            }
        };
        // -0.0 becomes +0.0.
        position.map(|x| x + 0.0)
    }
}

/// A body at rest but for its size: every link is within a few roundings of an edge of its band, or of the
/// length below which its direction is undefined.
#[derive(Debug, Clone, Copy)]
struct Size {
    edge: usize,
    roundings: i8,
}

impl Size {
    fn factor(self, alpha: f32) -> f32 {
        let edge = [1.0, 1.0 - alpha, 1.0 + alpha, 1.0e-6, 1.0e-6, 1.0e-6][self.edge];
        edge * (1.0 + 0.5 * f32::EPSILON * f32::from(self.roundings))
    }
}

fn size() -> impl Strategy<Value = Size> {
    (0_usize..6, -9_i8..=9).prop_map(|(edge, roundings)| Size { edge, roundings })
}

fn place() -> impl Strategy<Value = Place> {
    let far = -COORDINATE_MAX..=COORDINATE_MAX;
    prop_oneof![
        4 => prop::array::uniform3(-1.0_f32..1.0).prop_map(Place::Near),
        2 => Just(Place::Rest),
        2 => (0_u8..3).prop_map(Place::Shared),
        1 => (0_u8..3, prop::array::uniform3(0_u32..1 << 23))
            .prop_map(|(point, bits)| Place::Denormal(point, bits)),
        1 => prop::array::uniform3(far).prop_map(Place::Exploded),
        1 => prop::array::uniform3(any::<bool>()).prop_map(Place::Corner),
    ]
}

fn case() -> impl Strategy<Value = Case> {
    (1_usize..60).prop_flat_map(|n| {
        let rest = prop::collection::vec(prop::array::uniform3(-4.0_f32..4.0), n);
        let ends = (0..n as u16, 0..n as u16);
        let links = prop::collection::vec((ends, 0.0_f32..0.99, -9.0_f32..9.0), 0..5 * n);
        let places = prop_oneof![
            3 => prop::collection::vec(place(), n),
            // Most bodies under a tool: slices leave early, or have no coincident cell.
            1 => prop::collection::vec(prop::array::uniform3(-0.1_f32..0.1).prop_map(Place::Near), n),
        ];
        let held = prop::collection::vec(0..n as u16, 0..4);
        let alpha = prop_oneof![Just(0.0_f32), 0.0_f32..0.99];
        let size = prop::option::weighted(0.25, size());
        (rest, links, (places, size), held, alpha, any::<[bool; 3]>()).prop_map(
            |(rest, links, (places, size), mut held, alpha, [alphas, weights, closed])| {
                let length = |[i, j]: [u16; 2]| {
                    rest_length(rest[usize::from(i)], rest[usize::from(j)])
                };
                let mut links: Vec<Link> = links
                    .into_iter()
                    .map(|((a, b), alpha, decade)| {
                        ([a.min(b), a.max(b)], alpha, 10.0_f32.powf(decade))
                    })
                    .filter(|&(ends, ..)| ends[0] != ends[1] && length(ends) > 1e-3)
                    .collect();
                links.sort_unstable_by_key(|&(ends, ..)| ends);
                links.dedup_by_key(|&mut (ends, ..)| ends);
                held.sort_unstable();
                held.dedup();
                let at = places.iter().zip(&rest).map(|(place, &rest)| match size {
                    Some(size) => rest.map(|x| x * size.factor(alpha) + 0.0),
                    None => place.position(rest),
                });
                let (at, varied) = (at.collect(), Varied { alphas, weights });
                Case { rest, links, at, held, alpha, varied, closed }
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn slices_change_no_bit(case in case()) {
        let body = Body::new(&case.rest, &case.links);
        let model = case.model(&body);
        let scalar = case.scalar(&model);
        prop_assert!(scalar.residual.as_flattened().iter().all(|&bits| f32::from_bits(bits).is_finite()));
        prop_assert_eq!(&scalar, &case.slices(&model, None), "plain slices");
        if let Some(unit) = unit("slices_change_no_bit") {
            prop_assert_eq!(&scalar, &case.slices(&model, Some(unit)), "vector unit");
        }
    }
}
