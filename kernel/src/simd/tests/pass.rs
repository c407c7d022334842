//! The whole pass over slices, on the machine's unit and in plain Rust, against the scalar pass
//! that visits every link once.

use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

use super::super::octet::Octet;
use super::super::sliced::SlicedPass;
use super::super::{VectorUnit, run};
use super::body::{Body, Link, Varied};
use super::unit;
use crate::awake::Awake;
use crate::cell::Cell;
use crate::contact::Contact;
use crate::link::rest_length;
use crate::model::Model;
use crate::pass::{Energy, Held, Links, Reduce};
use crate::tissue::COORDINATE_MAX;

/// Everything that a pass hands to its sums, and the energy.
#[derive(Default)]
struct Record {
    bits: Vec<u32>,
    energy: Energy,
}

impl Reduce for Record {
    #[inline(always)]
    fn slice<V: Octet>(&mut self, slice: usize, at: [V; 3], residual: [V; 4]) {
        self.bits.push(slice as u32);
        for of in at.into_iter().chain(residual) {
            let mut lanes = [0.0; 8];
            of.store(&mut lanes);
            self.bits.extend(lanes.map(f32::to_bits));
        }
        self.energy.slice(slice, at, residual);
    }
}

/// Residuals, what was summed, and the energy.
type Outcome = (Vec<[u32; 4]>, Vec<u32>, [u32; 2]);

fn outcome(residual: &[Cell], record: &Record) -> Outcome {
    let energy = record.energy.total();
    let bits = residual.iter().map(|cell| cell.0.map(f32::to_bits)).collect();
    (bits, record.bits.clone(), [energy.hi, energy.lo].map(f32::to_bits))
}

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

    /// The pass as the schemes call it: over slices with a unit, link by link without.
    fn pass(&self, model: &Model<'_>, vectors: Option<VectorUnit>) -> Outcome {
        let links = Links { model, closed: self.closed, vectors };
        let (at, held) = self.arrays();
        let (mut residual, mut record) = (vec![Cell([9.0; 4]); at.len()], Record::default());
        let mut awake = Awake::NOBODY;
        awake.wake_all(model);
        links.pass(&awake.set, &at, &mut residual, &held, &mut record);
        outcome(&residual, &record)
    }

    /// The pass over slices in plain Rust.
    fn plain_slices(&self, model: &Model<'_>) -> Outcome {
        let links = Links { model, closed: self.closed, vectors: None };
        let (at, held) = self.arrays();
        let (mut residual, mut record) = (vec![Cell([9.0; 4]); at.len()], Record::default());
        let mut awake = Awake::NOBODY;
        awake.wake_all(model);
        let pass = SlicedPass {
            links,
            slices: model.slices.unwrap(),
            awake: &awake.set,
            at: &at,
            residual: &mut residual,
            held: Held::new(&held),
            reduce: &mut record,
        };
        run(None, pass);
        outcome(&residual, &record)
    }

    fn arrays(&self) -> (Vec<Cell>, Vec<Contact>) {
        let at = self.at.iter().map(|&position| Cell::at(position)).collect();
        (at, self.held.iter().map(|&cell| Contact::new(cell)).collect())
    }
}

/// Where a cell is: near its place, in it, at one of a few points that it shares with others,
/// less than a denormal away from such a point, as far away as a state may be.
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
        // There is one zero in the state.
        position.map(|x| x + 0.0)
    }
}

/// A body as at rest but for its size: every link within a few roundings of an edge of its band, or
/// of the length below which it has no direction.
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
            // Most bodies that a tool meets: slices leave early, or have no coincident cell.
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
        let scalar = case.pass(&model, None);
        prop_assert!(scalar.0.as_flattened().iter().all(|&bits| f32::from_bits(bits).is_finite()));
        prop_assert_eq!(&scalar, &case.plain_slices(&model), "plain slices");
        if let Some(unit) = unit("slices_change_no_bit") {
            prop_assert_eq!(&scalar, &case.pass(&model, Some(unit)), "vector unit");
        }
    }
}
