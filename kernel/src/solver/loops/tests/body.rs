//! Small bodies of any shape, built without a bake.

use std::vec;
use std::vec::Vec;

use crate::model::cuttable::Cuttable;
use crate::model::opened::Opened;
use crate::model::others::NONE;
use crate::model::pin::Pins;
use crate::model::{Model, Slices, rest_length};
use crate::number::two_float::LANES;

/// Links of cells `i < j` with alpha and weight.
pub(super) type Link = ([u16; 2], f32, f32);

/// The sections of a model's image.
pub(super) struct Body {
    rest: Vec<[f32; 3]>,
    rows: Vec<u32>,
    upper: Vec<u16>,
    rest_length: Vec<f32>,
    back_rows: Vec<u32>,
    lower: Vec<u16>,
    back_link: Vec<u32>,
    mobility: Vec<f32>,
    alphas: Vec<f32>,
    weights: Vec<f32>,
    slice_rows: Vec<u32>,
    neighbours: Vec<[u16; LANES]>,
    lengths: Vec<[f32; LANES]>,
    slice_alphas: Vec<[f32; LANES]>,
    slice_weights: Vec<[f32; LANES]>,
}

/// Flags of the properties in which a body's links differ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Varied {
    pub alphas: bool,
    pub weights: bool,
}

impl Body {
    /// The links must be in ascending order, without repeats.
    pub fn new(rest: &[[f32; 3]], links: &[Link]) -> Self {
        let cells = rest.len();
        let mut of_cell = vec![Vec::new(); cells];
        for (index, &([i, j], ..)) in links.iter().enumerate() {
            of_cell[usize::from(i)].push((j, index));
            of_cell[usize::from(j)].push((i, index));
        }
        let (mut rows, mut back_rows) = (vec![0], vec![0]);
        let (mut lower, mut back_link) = (Vec::new(), Vec::new());
        for (cell, own) in of_cell.iter_mut().enumerate() {
            own.sort_unstable();
            let below = own.iter().filter(|&&(other, _)| usize::from(other) < cell);
            lower.extend(below.clone().map(|&(other, _)| other));
            back_link.extend(below.map(|&(_, index)| index as u32));
            back_rows.push(lower.len() as u32);
            let above = links.iter().filter(|&&([i, _], ..)| usize::from(i) <= cell);
            rows.push(above.count() as u32);
        }
        let at = |cell: u16| rest[usize::from(cell)];
        let rest_length = links.iter().map(|&([i, j], ..)| rest_length(at(i), at(j)));
        let mut body = Self {
            rest: rest.to_vec(),
            rows,
            upper: links.iter().map(|&([_, j], ..)| j).collect(),
            rest_length: rest_length.collect(),
            back_rows,
            lower,
            back_link,
            mobility: of_cell.iter().map(|own| 1.0 / (own.len() as f32 + 0.5)).collect(),
            alphas: links.iter().map(|&(_, alpha, _)| alpha).collect(),
            weights: links.iter().map(|&(.., weight)| weight).collect(),
            slice_rows: vec![0],
            neighbours: Vec::new(),
            lengths: Vec::new(),
            slice_alphas: Vec::new(),
            slice_weights: Vec::new(),
        };
        body.slice(&of_cell);
        body
    }

    fn slice(&mut self, of_cell: &[Vec<(u16, usize)>]) {
        for (slice, own) in of_cell.chunks(LANES).enumerate() {
            for group in 0..own.iter().map(Vec::len).max().unwrap_or(0) {
                let link = |lane: usize| own.get(lane).and_then(|own| own.get(group)).copied();
                let value = |values: &[f32], padding: f32| {
                    core::array::from_fn(|lane| link(lane).map_or(padding, |(_, at)| values[at]))
                };
                self.lengths.push(value(&self.rest_length, 0.0));
                self.slice_alphas.push(value(&self.alphas, 0.0));
                self.slice_weights.push(value(&self.weights, 1.0));
                self.neighbours.push(core::array::from_fn(|lane| {
                    let itself = (slice * LANES + lane).min(of_cell.len() - 1) as u16;
                    link(lane).map_or(itself, |(other, _)| other)
                }));
            }
            self.slice_rows.push(self.neighbours.len() as u32);
        }
    }

    /// A model of the body, all links with the band `alpha` and weight 1 unless they differ.
    pub fn model(&self, alpha: f32, varied: Varied) -> Model<'_> {
        Model {
            cuttable: Cuttable::NONE,
            rest: &self.rest,
            rows: &self.rows,
            upper: &self.upper,
            rest_length: &self.rest_length,
            back_rows: &self.back_rows,
            lower: &self.lower,
            back_link: &self.back_link,
            mobility: &self.mobility,
            fixed: &[],
            input_id: &[],
            slices: Some(Slices {
                rows: &self.slice_rows,
                neighbours: &self.neighbours,
                lengths: &self.lengths,
                alphas: varied.alphas.then_some(&self.slice_alphas),
                weights: varied.weights.then_some(&self.slice_weights),
            }),
            coarse_basis: None,
            link_alphas: varied.alphas.then_some(&self.alphas),
            link_weights: varied.weights.then_some(&self.weights),
            weight_min: 1.0,
            surface: &[],
            normals: &[],
            triangles: &[],
            tetrahedra: &[],
            contact: None,
            opened: Opened::NONE,
            notes: &[],
            embedded: None,
            others: (Pins::NONE, NONE),
            dimension: 3,
            unit_m: 1.0,
            centre_m: [0.0; 3],
            stiffness_n_per_m: 1.0,
            alpha,
            saturation: 1.0e6,
            resistance: 1.0,
            capacitance: 1.0,
            degree_bound: 1.0,
            energy_max: 1.0,
            parts: 1,
            input_nodes: self.rest.len() as u32,
            checksum: 0,
        }
    }
}
