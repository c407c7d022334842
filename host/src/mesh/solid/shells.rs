//! The connected parts of a closed surface (shells), oriented away from the body: an outermost shell has a
//! body inside, a shell directly inside it is the wall of a cavity, a shell in a cavity has a body again.

use super::tree::bounds;
use crate::mesh::geometry::{cross, dot, minus, volume6};

/// Reason for which a surface is refused.
pub(super) type Refusal = String;

/// Most shells.
const SHELLS_MAX: usize = 1_000;

/// Number and volume of the shells.
pub(super) struct Shells {
    /// Shells with a body inside.
    pub(super) bodies: usize,
    /// Shells around a cavity.
    pub(super) cavities: usize,
    /// Triangles that were reversed.
    pub(super) turned: usize,
    /// Volume between them \[m^3\].
    pub(super) volume_m3: f64,
}

impl Shells {
    /// Finds the shells and reverses triangles where needed; `across` is updated.
    pub(super) fn new(
        points_m: &[[f64; 3]],
        triangles: &mut [[u32; 3]],
        across: &mut [[u32; 3]],
        at: &impl Fn(u32) -> String,
    ) -> Result<Self, Refusal> {
        let (of_triangle, count, mut turn) = found(triangles, across, at)?;
        if count > SHELLS_MAX {
            return Err(format!(
                "{count} separate closed parts, the limit is {SHELLS_MAX}; remove the small ones (in \
                 MeshLab: Remove Isolated Pieces)"
            ));
        }
        // Signed volume and bounding box of each shell.
        let corners = |triangle: usize| {
            let [a, b, c] = triangles[triangle].map(|id| points_m[id as usize]);
            if turn[triangle] { [a, c, b] } else { [a, b, c] }
        };
        let mut members = vec![Vec::new(); count];
        of_triangle
            .iter()
            .enumerate()
            .for_each(|(triangle, shell)| members[*shell as usize].push(triangle));
        let volume = |shell: &[usize]| -> f64 {
            let [from, ..] = corners(shell[0]);
            shell
                .iter()
                .map(|&t| {
                    let [a, b, c] = corners(t);
                    volume6([from, a, b, c]) / 6.0
                })
                .sum()
        };
        let volumes: Vec<f64> = members.iter().map(|shell| volume(shell)).collect();
        let boxes: Vec<[[f64; 3]; 2]> =
            members.iter().map(|shell| bounds(shell.iter().flat_map(|&t| corners(t)))).collect();
        // A shell inside an even number of others has a body inside.
        let mut is_body = Vec::with_capacity(count);
        for own in 0..count {
            let [place, ..] = corners(members[own][0]);
            let around = (0..count).filter(|&other| {
                let [low, high] = boxes[other];
                other != own
                    && (0..3).all(|axis| low[axis] < place[axis] && place[axis] < high[axis])
                    && turns_round(place, members[other].iter().map(|&t| corners(t)))
            });
            is_body.push(around.count() % 2 == 0);
        }
        // Orient the triangles: outward for a body, inward for a cavity.
        let inside_out = |shell: usize| (volumes[shell] > 0.0) != is_body[shell];
        for (triangle, shell) in of_triangle.iter().enumerate() {
            turn[triangle] ^= inside_out(*shell as usize);
        }
        let turned = turn.iter().filter(|turn| **turn).count();
        for triangle in (0..triangles.len()).filter(|&triangle| turn[triangle]) {
            triangles[triangle].swap(1, 2);
            // Edges 0-1, 1-2, 2-0 have become 0-2, 2-1, 1-0.
            across[triangle].swap(0, 2);
        }
        let signed = |shell: usize| volumes[shell].abs() * if is_body[shell] { 1.0 } else { -1.0 };
        let bodies = is_body.iter().filter(|is_body| **is_body).count();
        let volume_m3 = (0..count).map(signed).sum();
        Ok(Self { bodies, cavities: count - bodies, turned, volume_m3 })
    }
}

/// Returns the shell of each triangle, the number of shells, and the triangles to reverse so that
/// neighbours agree.
#[allow(clippy::type_complexity, reason = "three lists of one walk")]
fn found(
    triangles: &[[u32; 3]],
    across: &[[u32; 3]],
    at: &impl Fn(u32) -> String,
) -> Result<(Vec<u32>, usize, Vec<bool>), Refusal> {
    let mut shell = vec![u32::MAX; triangles.len()];
    let (mut turn, mut count) = (vec![false; triangles.len()], 0);
    for start in 0..triangles.len() {
        if shell[start] != u32::MAX {
            continue;
        }
        // Walk over the triangles of a new shell.
        shell[start] = count;
        let mut open = vec![start];
        while let Some(own) = open.pop() {
            for k in 0..3 {
                let other = across[own][k] as usize;
                let [i, j] = [triangles[own][k], triangles[own][(k + 1) % 3]];
                // Neighbours agree if they have their common edge in opposite directions.
                let runs_same =
                    (0..3).any(|l| triangles[other][l] == i && triangles[other][(l + 1) % 3] == j);
                let wanted = turn[own] ^ runs_same;
                if shell[other] == u32::MAX {
                    (shell[other], turn[other]) = (count, wanted);
                    open.push(other);
                } else if turn[other] != wanted {
                    return Err(format!(
                        "the surface has one side alone, as a Moebius strip has, around {}; mesh it again",
                        at(i)
                    ));
                }
            }
        }
        count += 1;
    }
    Ok((shell, count as usize, turn))
}

/// Returns true if closed triangles enclose a point: the sum of their solid angles (Van Oosterom and
/// Strackee, 1983) is that of a whole sphere, of either sign, or else 0.
fn turns_round(place: [f64; 3], triangles: impl Iterator<Item = [[f64; 3]; 3]>) -> bool {
    let angle = |[a, b, c]: [[f64; 3]; 3]| {
        let [a, b, c] = [a, b, c].map(|corner| minus(corner, place));
        let [la, lb, lc] = [a, b, c].map(|way| dot(way, way).sqrt());
        let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        2.0 * libm::atan2(dot(a, cross(b, c)), below)
    };
    let sum: f64 = triangles.map(angle).sum();
    sum.abs() > std::f64::consts::TAU
}
