//! Sizes of tetrahedra that grow with the distance from some regions.

use super::distance::Solid;
use super::tree::Tree;
use crate::mesh::filling::{Finer, GROWTH, HALVINGS_MAX, Region, halvings};
use crate::mesh::geometry::distance;
use crate::mesh::stuffing::Shape;
use crate::words::length;

/// Largest coordinate \[m\].
const FAR_M: f64 = 1e6;

/// Sizes by the distance from regions.
pub(super) struct Graded {
    /// Mean edge in the regions \[m\].
    pub(super) fine_m: f64,
    /// How often it is doubled away from them.
    pub(super) levels: u32,
    regions: Vec<Around>,
}

/// A radius around points.
struct Around {
    points: Tree,
    radius_m: f64,
}

impl Graded {
    /// Checks sizes and regions. `near` returns the places of the nodes that a selector chooses.
    ///
    /// # Errors
    /// In words: sizes that do not differ, a radius that is none, a region beside the body.
    pub(super) fn new(
        size_m: f64,
        finer: &Finer,
        solid: &Solid,
        mut near: impl FnMut(&str) -> Result<Vec<[f64; 3]>, String>,
    ) -> Result<Self, String> {
        let fine_m = finer.size_m;
        let levels = levels(size_m, fine_m)?;
        let regions = finer.regions.iter().map(|region| match region {
            Region::Ball { centre_m, radius_m } => {
                check_ball(solid, *centre_m, *radius_m)?;
                Ok(Around { points: tree(&[*centre_m]), radius_m: *radius_m })
            }
            Region::Near(selector) => {
                Ok(Around { points: tree(&near(selector)?), radius_m: size_m })
            }
        });
        Ok(Self { fine_m, levels, regions: regions.collect::<Result<_, String>>()? })
    }

    /// Mean edge away from the regions \[m\].
    pub(super) fn coarse_m(&self) -> f64 {
        self.fine_m * f64::from(1 << self.levels)
    }

    /// Largest size at a place \[m\]. It is not bounded far away.
    pub(super) fn largest_m(&self, place_m: [f64; 3]) -> f64 {
        self.fine_m + GROWTH * self.outside_m(place_m)
    }

    /// Volume of the regions, at most \[m^3\].
    pub(super) fn volume_m3(&self) -> f64 {
        let ball = |of: &Around| {
            of.points.len() as f64 * of.radius_m.powi(3) * 4.0 / 3.0 * std::f64::consts::PI
        };
        self.regions.iter().map(ball).sum()
    }

    /// Distance from the regions: 0 inside.
    fn outside_m(&self, place_m: [f64; 3]) -> f64 {
        let away = |of: &Around| of.points.nearest(place_m).square.sqrt() - of.radius_m;
        self.regions.iter().map(away).fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// Mean edges \[m\] in the regions and away from them; `None` where there is no edge.
    pub(super) fn edges_m(&self, nodes_m: &[[f64; 3]], links: &[[u32; 2]]) -> [Option<f64>; 2] {
        let largest: Vec<f64> = nodes_m.iter().map(|place_m| self.largest_m(*place_m)).collect();
        // A link counts where cubes of that size alone are around both its ends.
        let (in_m, away_m) = ((1.0 + GROWTH) * self.fine_m, 2.0 * self.coarse_m());
        let mut sums = [(0.0, 0_u32); 2];
        for ends in links.iter().map(|link| link.map(|id| id as usize)) {
            let is_fine = ends.iter().all(|end| largest[*end] <= in_m);
            let is_coarse = ends.iter().all(|end| largest[*end] >= away_m);
            if is_fine || is_coarse {
                let (sum_m, count) = &mut sums[usize::from(is_coarse)];
                *sum_m += distance(nodes_m[ends[0]], nodes_m[ends[1]]);
                *count += 1;
            }
        }
        sums.map(|(sum_m, count)| (count > 0).then(|| sum_m / f64::from(count)))
    }
}

/// The option with both sizes, for errors.
pub(super) fn given(size_m: f64, finer: Option<&Finer>) -> String {
    match finer {
        None => format!("`fill_m` {size_m:?}"),
        Some(finer) => format!("`fill_m` {size_m:?},{:?}", finer.size_m),
    }
}

/// The number of doublings from the fine size nearest to the coarse one.
fn levels(size_m: f64, fine_m: f64) -> Result<u32, String> {
    let half = 0.5 * size_m;
    let refuse =
        |why: &str, take: f64| Err(format!("`fill_m` {size_m:?},{fine_m:?}: {why} {take:?}"));
    if !(fine_m.is_finite() && fine_m > 0.0) {
        return refuse("the second size is no edge in metres; take", half);
    }
    if fine_m >= size_m {
        return refuse("the second size is the finer one and must be below the first; take", half);
    }
    let levels = halvings(size_m, fine_m);
    if levels < 1.0 {
        return refuse("the two sizes hardly differ; leave the second out, or take", half);
    }
    if levels > HALVINGS_MAX {
        let least_m = size_m / HALVINGS_MAX.exp2();
        return refuse("the second size is too fine for the first; take", least_m);
    }
    Ok(levels as u32)
}

fn check_ball(solid: &Solid, centre_m: [f64; 3], radius_m: f64) -> Result<(), String> {
    let [x, y, z] = centre_m;
    let given = format!("`fill_m` ...@{x:?},{y:?},{z:?},{radius_m:?}");
    if !(radius_m > 0.0 && radius_m <= FAR_M) {
        return Err(format!("{given}: the radius is no length above 0; give it in metres"));
    }
    if !centre_m.iter().all(|x| x.abs() <= FAR_M) {
        return Err(format!("{given}: give a place in metres"));
    }
    let outside_m = -solid.distance_m(centre_m);
    if outside_m < radius_m {
        return Ok(());
    }
    let [x, y, z] = solid.project(centre_m);
    Err(format!(
        "{given}: the region does not touch the body, whose nearest point is {x:.6},{y:.6},{z:.6}, {} from its \
         middle; X, Y, Z and R are in metres whatever the unit of the file",
        length(outside_m)
    ))
}

fn tree(points_m: &[[f64; 3]]) -> Tree {
    Tree::new(points_m.iter().map(|place_m| [*place_m; 3]).collect())
}
