//! Pressure of tools on a contact surface, at its nodes.

use chaincell_kernel::{ContactForce, Model};
use nalgebra::Vector3;

use crate::engine::{Engine, Nodes, rest_m};

/// Returns the pressure of the tools at each node, in the order of the nodes \[Pa\]; `None` if there is no
/// tool on a contact surface.
///
/// The normal force of each contact is distributed to the corners of its triangle according to its position;
/// the sum at a node is divided by the node's area, a third of that of the triangles around it at rest. So
/// pressure times area, summed over the nodes, is the sum of the magnitudes of the normal forces.
pub(super) fn contact_pressure_pa(engine: &mut Engine<'_>, nodes: &Nodes) -> Option<Vec<f64>> {
    if engine.contact().tools() == 0 {
        return None;
    }
    let contacts = engine.contact_forces();
    Some(pressure_pa(engine.network().model(), &nodes.positions_m, &contacts))
}

fn pressure_pa(model: &Model<'_>, positions_m: &[[f64; 3]], contacts: &[ContactForce]) -> Vec<f64> {
    let triangles = model.triangles();
    let mut force_n = vec![0.0; positions_m.len()];
    for contact in contacts {
        let Some(corners) = triangles.get(contact.triangle as usize) else { continue };
        let corners = corners.map(usize::from);
        let at = corners.map(|cell| positions_m.get(cell).copied().unwrap_or_default());
        let normal_n = Vector3::from(contact.normal_n.map(f64::from)).norm();
        let shares = shares(at, contact.position_m.map(f64::from));
        for (cell, share) in corners.into_iter().zip(shares) {
            if let Some(force_n) = force_n.get_mut(cell) {
                *force_n += share * normal_n;
            }
        }
    }
    let mut area_m2 = vec![0.0; positions_m.len()];
    for corners in triangles {
        let corners = corners.map(usize::from);
        let [a, b, c] = corners.map(|cell| Vector3::from(rest_m(model, cell)));
        let third_m2 = (b - a).cross(&(c - a)).norm() / 6.0;
        for cell in corners {
            if let Some(area_m2) = area_m2.get_mut(cell) {
                *area_m2 += third_m2;
            }
        }
    }
    let over = |(force_n, area_m2): (f64, f64)| if force_n > 0.0 { force_n / area_m2 } else { 0.0 };
    force_n.into_iter().zip(area_m2).map(over).collect()
}

/// Returns the weights of a triangle's corners at a point in it: at least 0, with a sum of 1.
fn shares(at: [[f64; 3]; 3], point: [f64; 3]) -> [f64; 3] {
    let ([a, b, c], point) = (at.map(Vector3::from), Vector3::from(point));
    let normal = (b - a).cross(&(c - a));
    let opposite = |one: Vector3<f64>, other: Vector3<f64>| {
        (one - point).cross(&(other - point)).dot(&normal).max(0.0)
    };
    let shares = [opposite(b, c), opposite(c, a), opposite(a, b)];
    let sum: f64 = shares.iter().sum();
    // A triangle without an area has no inside: weigh its corners equally.
    if sum > 0.0 { shares.map(|share| share / sum) } else { [1.0 / 3.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_shared_to_the_corners() {
        let at = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]];
        let near = |found: [f64; 3], wanted: [f64; 3]| {
            found.iter().zip(wanted).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{found:?}"));
        };
        near(shares(at, at[1]), [0.0, 1.0, 0.0]);
        near(shares(at, [1.0, 0.5, 1.0]), [0.25, 0.5, 0.25]);
        near(shares(at, [1.0, -0.1, 1.0]), [0.55 / 1.05, 0.5 / 1.05, 0.0]);
        near(shares([at[0]; 3], at[0]), [1.0 / 3.0; 3]);
    }
}
