//! The relaxation sweep: what turns the shape of the bounds into one of an elastic body.

use super::{Cost, Elements, Limits};

/// Where all elements go in a sweep, from the positions before it: by the mean of their links'
/// excess over the limits `equilibrium`.
///
/// On a bipartite chain without anything held the sweep may swing between two states.
pub(super) fn relax<N: Iterator<Item = usize>>(
    elements: &Elements,
    neighbours: impl Fn(usize) -> N,
    equilibrium: &Limits,
) -> (Vec<[f64; 3]>, Cost) {
    let mut positions = elements.position_m.clone();
    let mut cost = Cost::default();
    for (element, pinned) in elements.pinned().into_iter().enumerate() {
        if pinned {
            continue;
        }
        cost.visited += 1;
        let here = elements.position_m[element];
        let (mut sum, mut links) = ([0.0; 3], 0_u32);
        for neighbour in neighbours(element) {
            let there = elements.nearest(element, neighbour, equilibrium);
            sum = std::array::from_fn(|axis| sum[axis] + (there[axis] - here[axis]));
            links += 1;
        }
        if links == 0 {
            continue;
        }
        let to = std::array::from_fn(|axis| here[axis] + sum[axis] / f64::from(links));
        cost.moved += usize::from(to != here);
        positions[element] = to;
    }
    (positions, cost)
}
