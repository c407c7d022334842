//! Checks a surface before it is filled: it must be closed, each edge must belong to two triangles, and it
//! must not intersect itself. Every refusal names a position in the file's unit, and the remedy.

use super::Faces;
use super::meet::meet;
use super::shells::{Refusal, Shells};
use super::tree::{Tree, area2, middle};
use crate::mesh::geometry::{dot, minus};
use crate::words::counted;

/// Twice a triangle's area counts as none below this share of its squared longest edge.
const FLAT: f64 = 1e-12;

/// Most pairs of intersecting triangles that are counted.
const PAIRS_MAX: usize = 10_000;

/// A closed surface whose triangles are counter-clockwise seen from outside.
pub(super) struct Closed {
    pub(super) points_m: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The triangle across the edge from each corner to the next.
    pub(super) across: Vec<[u32; 3]>,
    pub(super) tree: Tree,
    pub(super) shells: Shells,
}

impl Closed {
    /// Checks a surface except for [`Self::check_crossings`]; `unit_m` is the file's unit, for positions in
    /// errors.
    pub(super) fn new(faces: Faces, unit_m: f64) -> Result<Self, Refusal> {
        let (points_m, mut triangles) = merged(faces);
        if triangles.is_empty() {
            return Err("its triangles are points and lines; save the surface of the body".into());
        }
        // Edges, points and areas.
        let at = |id: u32| shown(points_m[id as usize], unit_m);
        let mut across = across(&triangles, &at)?;
        fans(&triangles, &across, points_m.len(), &at)?;
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|id| points_m[id as usize]);
            let longest = [[a, b], [b, c], [c, a]]
                .map(|[p, q]| dot(minus(p, q), minus(p, q)))
                .into_iter()
                .fold(0.0, f64::max);
            let area = area2([a, b, c]);
            if dot(area, area).sqrt() <= FLAT * longest {
                return Err(format!(
                    "the triangle at {} has no area, its corners are in one line; remove such \
                     triangles (in MeshLab: Remove Zero Area Faces, Merge Close Vertices)",
                    at(triangle[0])
                ));
            }
        }
        // Parts and their orientation.
        let shells = Shells::new(&points_m, &mut triangles, &mut across, &at)?;
        let tree = Tree::new(triangles.iter().map(|t| t.map(|id| points_m[id as usize])).collect());
        Ok(Self { points_m, triangles, across, tree, shells })
    }

    /// Refuses triangles that intersect; of a large surface this check takes longest.
    pub(super) fn check_crossings(&self, unit_m: f64) -> Result<(), Refusal> {
        crossings(&self.triangles, &self.tree, unit_m)
    }
}

/// Returns a position as text in the file's unit.
pub(super) fn shown(place_m: [f64; 3], unit_m: f64) -> String {
    let [x, y, z] = place_m.map(|x| x / unit_m);
    format!("({x:.6}, {y:.6}, {z:.6})")
}

/// Merges points at the same position; leaves out triangles that then have a point twice.
fn merged(faces: Faces) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    // Adding 0 turns -0 into 0.
    let places: Vec<[f64; 3]> = faces.points_m.iter().map(|place| place.map(|x| x + 0.0)).collect();
    let mut used = vec![false; places.len()];
    faces.triangles.iter().flatten().for_each(|id| used[*id as usize] = true);
    let key = |id: u32| places[id as usize].map(f64::to_bits);
    let mut order: Vec<u32> = (0..places.len() as u32).filter(|id| used[*id as usize]).collect();
    order.sort_unstable_by_key(|id| (key(*id), *id));
    let mut first = vec![u32::MAX; places.len()];
    for same in order.chunk_by(|a, b| key(*a) == key(*b)) {
        same.iter().for_each(|id| first[*id as usize] = same[0]);
    }
    // The kept points stay in their order.
    let (mut points_m, mut number) = (Vec::new(), vec![0; places.len()]);
    for (id, place) in places.iter().enumerate() {
        if first[id] == id as u32 {
            number[id] = points_m.len() as u32;
            points_m.push(*place);
        }
    }
    let of = |id: u32| number[first[id as usize] as usize];
    let triangles = faces.triangles.iter().map(|triangle| triangle.map(of));
    let kept = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    (points_m, kept)
}

/// Returns the triangle across each edge; every edge must have two.
fn across(triangles: &[[u32; 3]], at: &impl Fn(u32) -> String) -> Result<Vec<[u32; 3]>, Refusal> {
    // Sort all edges, then pair those with the same ends.
    let mut edges: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, ids) in (0..).zip(triangles) {
        for k in 0..3 {
            let (i, j) = (ids[k], ids[(k + 1) % 3]);
            edges.push(([i.min(j), i.max(j)], triangle, k));
        }
    }
    edges.sort_unstable();
    let mut across = vec![[u32::MAX; 3]; triangles.len()];
    let (mut open, mut shared) = ((0usize, None), (0usize, None));
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        match same {
            [one, other] => {
                across[one.1 as usize][one.2] = other.1;
                across[other.1 as usize][other.2] = one.1;
            }
            [one] => open = (open.0 + 1, open.1.or(Some(one.0))),
            _ => shared = (shared.0 + 1, shared.1.or(Some(same[0].0))),
        }
    }
    // Refuse edges with one triangle, then those with more than two.
    if let (count, Some([i, j])) = open {
        return Err(format!(
            "{} with a triangle on one side alone, one from {} to {}: the surface has holes; close them \
             (in MeshLab: Close Holes; where parts only touch: Merge Close Vertices)",
            counted(count, "edge"),
            at(i),
            at(j)
        ));
    }
    if let (count, Some([i, j])) = shared {
        return Err(format!(
            "{} with more than two triangles, one from {} to {}; part what meets there (in MeshLab: Repair \
             Non Manifold Edges)",
            counted(count, "edge"),
            at(i),
            at(j)
        ));
    }
    Ok(across)
}

/// Refuses points at which parts of the surface touch that share no edge there.
fn fans(
    triangles: &[[u32; 3]],
    across: &[[u32; 3]],
    points: usize,
    at: &impl Fn(u32) -> String,
) -> Result<(), Refusal> {
    // Number of triangles at each point.
    let mut around = vec![0u32; points];
    triangles.iter().flatten().for_each(|id| around[*id as usize] += 1);
    let mut seen = vec![false; points];
    for (start, ids) in (0..).zip(triangles) {
        for &point in ids {
            if std::mem::replace(&mut seen[point as usize], true) {
                continue;
            }
            // Walk around the point from triangle to triangle, and count them.
            let (mut triangle, mut from, mut count) = (start, u32::MAX, 0u32);
            loop {
                count += 1;
                let own = triangles[triangle as usize];
                let ways = (0..3).filter(|&k| own[k] == point || own[(k + 1) % 3] == point);
                let next = ways.map(|k| across[triangle as usize][k]).find(|next| *next != from);
                let Some(next) = next else { break };
                (from, triangle) = (triangle, next);
                if triangle == start || count > around[point as usize] {
                    break;
                }
            }
            if count != around[point as usize] {
                return Err(format!(
                    "at {} parts of the surface touch in one point; part them (in MeshLab: Repair Non \
                     Manifold Vertices)",
                    at(point)
                ));
            }
        }
    }
    Ok(())
}

/// Refuses triangles that meet outside common corners and edges.
fn crossings(triangles: &[[u32; 3]], tree: &Tree, unit_m: f64) -> Result<(), Refusal> {
    let (mut count, mut first) = (0usize, None);
    for triangle in 0..triangles.len() as u32 {
        if count >= PAIRS_MAX {
            break;
        }
        tree.meeting(triangle, |other| {
            let ids = [triangles[triangle as usize], triangles[other as usize]];
            if meet([tree.corners(triangle), tree.corners(other)], ids) {
                count += 1;
                first = first.or(Some([triangle, other]));
            }
        });
    }
    let Some([one, other]) = first else { return Ok(()) };
    let middle = |triangle: u32| shown(middle(tree.corners(triangle)), unit_m);
    let more = if count >= PAIRS_MAX { "at least " } else { "" };
    Err(format!(
        "{more}{} of triangles that run through each other, the first around {} and {}; mend them (in MeshLab: \
         Select Self Intersecting Faces, delete and Close Holes)",
        counted(count, "pair"),
        middle(one),
        middle(other)
    ))
}
