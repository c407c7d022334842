//! Contact force of each triangle in contact on its tool.

use crate::energy::surface::{Anchor, NearTriangle, Proxies, each_met};
use crate::model::Model;
use crate::number::cell::{add, scale, sub};

/// The contact of one triangle with one part of a tool, at the points where the tool's force is taken, in the
/// model's units; a [`Tissue`](crate::TissueMut::contact_forces) gives it in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// Its point of action: the mean of the samples in contact, weighted by force, in the frame of the input
    /// mesh \[m\].
    pub position_m: [f32; 3],
    /// Pressure on the tool \[N\].
    pub normal_n: [f32; 3],
    /// Friction, or the pull of a grip, on the tool \[N\].
    pub tangential_n: [f32; 3],
    /// Area of the triangle at rest that its samples in contact represent \[m2\].
    pub area_m2: f32,
    /// The cell of the corner with the largest share; a copy in a wound.
    pub cell: u16,
    /// The cell of the whole body that it is or was made from, which has an input id.
    pub origin: u16,
    /// The tool, from 0.
    pub tool: u8,
    /// Index of the part in the tool.
    pub part: u8,
    /// The triangle, in the model's order. That of a face that a cut has opened has the number of the model's
    /// triangles, plus four times its tetrahedron, plus the corner of that opposite to it.
    pub triangle: u32,
}

/// Contacts of all tools in the model's units: lengths in mean link lengths, forces in 2 `k_ref` times
/// that, areas in shares of the triangle's. `body` is the body as its image has it, `points` are
/// the published points and those of the next pass: each tool's contacts are where its force is taken.
pub(crate) fn forces<'a, At: Fn(usize) -> [f32; 3]>(
    body: &'a Model<'_>,
    tools: Proxies<'a>,
    near: &'a [NearTriangle],
    anchors: &'a [Anchor],
    [published, next]: &'a [At; 2],
) -> impl Iterator<Item = ContactForce> + 'a {
    near.iter().filter_map(move |near| {
        let solid = tools.part(near.of)?;
        let is_ahead = tools.0.get(near.tool()).is_some_and(|tool| tool.is_ahead);
        let at = if is_ahead { next } else { published };
        // Sum force, position and shares over the samples.
        let (mut normal, mut drag, mut place) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let (mut corners, mut whole, mut samples) = ([0.0; 3], 0.0, 0.0_f32);
        each_met(solid, near, anchors, near.corners.map(|cell| at(cell.into())), |sample| {
            normal = sub(normal, sample.push);
            drag = sub(drag, sample.drag);
            // A grip without contact has almost no weight next to samples in contact.
            let share = sample.stiffness * (sample.depth + 1.0e-6 * solid.whole);
            place = add(place, scale(share, sample.point));
            corners = add(corners, scale(share, sample.weights));
            whole += share;
            samples += 1.0;
        });
        if whole <= 0.0 {
            return None;
        }
        // The corner with the largest share.
        let origins = body.whole_triangle(near.index).unwrap_or(near.corners);
        let cells = near.corners.into_iter().zip(origins);
        let (_, (cell, origin)) = corners.into_iter().zip(cells).fold(
            (0.0, (near.corners[0], origins[0])),
            |most, corner| {
                if corner.0 > most.0 { corner } else { most }
            },
        );
        let all = f32::from(near.parts) * f32::from(near.parts);
        Some(ContactForce {
            position_m: scale(1.0 / whole, place),
            normal_n: normal,
            tangential_n: drag,
            area_m2: samples / all,
            cell,
            origin,
            tool: near.tool() as u8,
            part: near.part() as u8,
            triangle: near.index,
        })
    })
}
