//! Fills a closed surface with tetrahedra of a size, and measures their quality.

use std::collections::BTreeMap;

use super::Faces;
use super::closed::{Closed, shown};
use super::creases::Creases;
use super::distance::Solid;
use super::grading::{Graded, given};
use super::tree::{Tree, middle};
use crate::error::{Error, Result};
use crate::mesh::check::parts;
use crate::mesh::geometry::{corners, cross, distance, dot, edges, minus, volume6};
use crate::mesh::stuffing::graded::{self, Grading};
use crate::mesh::stuffing::smooth::roundness;
use crate::mesh::stuffing::{Shape, TetMesh, fill as stuff, points};
use crate::mesh::surface::boundary;
use crate::mesh::{Filling, Mesh, UnlikelySize, select_among, too_many};
use crate::words::{counted, length};

/// Edge of a lattice cube over the mean edge of the tetrahedra: three of seven edges of the lattice are
/// as long as the cube's, four are half as long as its diagonal.
const CUBE: f64 = 7.0 / (3.0 + 2.0 * 1.732_050_807_568_877_2);
/// Most points of the lattice, which covers the box around the body.
const LATTICE_MAX: f64 = 2.4e7;
/// Largest error of the volume.
const VOLUME_ERROR_MAX: f64 = 0.1;
/// Largest distance between the two surfaces, in sizes: the tip of a spike is always lost.
const DISTANCE_MAX: f64 = 3.0;

/// Largest distance between the two surfaces before smoothing, in sizes.
const DISTANCE_EARLY_MAX: f64 = 6.0;
/// Triangles from which on the checks take longer than filling with a coarse size.
const LARGE: usize = 100_000;
/// Points of the surface that are checked before smoothing.
const POINTS_EARLY: usize = 10_000;
/// Most cubes of a graded lattice for each node that is allowed: some lie outside.
const CUBES: usize = 8;

/// Result of filling a surface, and the distance of the tetrahedra from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Filled {
    /// Triangles of the surface.
    pub triangles: usize,
    /// Triangles that were reversed, so that all are counter-clockwise seen from outside.
    pub turned: usize,
    /// Closed parts of the surface with a body inside.
    pub bodies: usize,
    /// Closed parts around a cavity.
    pub cavities: usize,
    /// Volume inside the surface \[m^3\].
    pub volume_m3: f64,
    /// Relative error of the volume of the tetrahedra: positive if it is larger.
    pub volume_error: f64,
    /// Largest distance between the two surfaces \[m\]: from corners and middles of one to the other.
    pub distance_m: f64,
    /// Smallest and largest angle between two faces of a tetrahedron \[degrees\].
    pub dihedral_deg: [f64; 2],
    /// Least volume over the cubed root mean square edge: 1 for a regular tetrahedron.
    pub roundness: f64,
    /// Mean edge \[m\].
    pub edge_m: f64,
    /// Mean edges of graded tetrahedra in the regions and away from them \[m\], where there are some.
    pub graded_m: Option<[Option<f64>; 2]>,
    /// Unconnected parts of the tetrahedra.
    pub parts: usize,
    /// Number of handles (a ring has one) of the surface, and of the tetrahedra.
    pub handles: [i64; 2],
}

/// Fills a surface with tetrahedra of these sizes, at most `nodes_max` nodes; errors call it `name`, and
/// give positions in its own unit.
pub(in crate::mesh) fn fill_faces(
    name: &str,
    faces: Faces,
    unit_m: f64,
    filling: &Filling,
    nodes_max: usize,
) -> Result<Mesh> {
    let refuse = |why: String| Error::input(format!("{name}: {why}"));
    let size_m = filling.size_m;
    if !(size_m.is_finite() && size_m > 0.0) {
        return Err(refuse(format!(
            "`fill_m` {size_m:?}: give the edge of the tetrahedra, above 0, in metres"
        )));
    }
    // Check the surface.
    let closed = Closed::new(faces, unit_m).map_err(refuse)?;
    if !is_large(&closed) {
        closed.check_crossings(unit_m).map_err(refuse)?;
    }
    // Where the size is unlikely, the unit is what to change, whatever else is wrong.
    let unlikely = UnlikelySize::of(&closed.points_m, unit_m);
    let refuse = |why: String| match &unlikely {
        Some(unlikely) => {
            refuse(format!("{}; read as it is, {why}", unlikely.with_unit("`unit_m`")))
        }
        None => refuse(why),
    };
    let filler = Filler { closed: &closed, solid: &Solid::new(&closed), unit_m, nodes_max };
    filler.fill(filling).map_err(refuse)
}

fn is_large(closed: &Closed) -> bool {
    closed.triangles.len() > LARGE
}

/// A checked surface to be filled.
struct Filler<'a> {
    closed: &'a Closed,
    solid: &'a Solid<'a>,
    /// Unit of positions in errors \[m\].
    unit_m: f64,
    nodes_max: usize,
}

impl Filler<'_> {
    /// Fills the surface; errors are in words.
    fn fill(&self, filling: &Filling) -> std::result::Result<Mesh, String> {
        let Self { closed, solid, unit_m, nodes_max } = *self;
        let size_m = filling.size_m;
        check_size(solid, closed.shells.volume_m3, size_m, nodes_max)?;
        let none_fits = || {
            format!(
                "no tetrahedron of `fill_m` {size_m:?} fits into the surface; take `fill_m` {} or less",
                below(largest_m(closed).min(0.7 * size_m))
            )
        };
        let [low_m, high_m] = solid.bounds_m();
        if size_m > distance(low_m, high_m) {
            return Err(none_fits());
        }
        // Fill it.
        let graded = self.graded(filling)?;
        let mut body = match &graded {
            None => stuff(solid, CUBE * size_m, 0.0),
            Some(graded) => self.stuff_graded(graded)?,
        };
        if body.tetrahedra.is_empty() {
            return Err(none_fits());
        }
        if body.nodes_m.len() > nodes_max {
            return Err(too_many_nodes(filling, body.nodes_m.len(), nodes_max));
        }
        // Of a large surface, the longer check comes last: a size that is too coarse is refused early.
        let is_large = is_large(closed);
        let is_coarse = is_large && closed.triangles.len() > body.tetrahedra.len();
        if is_large && !is_coarse {
            closed.check_crossings(unit_m)?;
        }
        check_early(closed, &body, size_m, unit_m)?;
        let largest_m = graded.as_ref().map_or(size_m, Graded::coarse_m);
        Creases::new(closed, solid).smooth(solid, &mut body, largest_m, graded.is_some());
        // Measure and check the result.
        let mesh = Mesh::from_tetrahedra(body.nodes_m, &body.tetrahedra, BTreeMap::new());
        let (away_m, place_m) = farthest(closed, &mesh);
        let graded_m = graded.as_ref().map(|graded| graded.edges_m(&mesh.nodes_m, &mesh.links));
        let filled = Filled { graded_m, ..measure(closed, &mesh, away_m) };
        check(&filled, size_m, &shown(place_m, unit_m))?;
        if is_coarse {
            closed.check_crossings(unit_m)?;
        }
        Ok(Mesh { filled: Some(filled), ..mesh })
    }

    /// The sizes by place, where they are graded; a selector chooses nodes of the evenly filled body.
    fn graded(&self, filling: &Filling) -> std::result::Result<Option<Graded>, String> {
        let Some(finer) = &filling.finer else { return Ok(None) };
        let near = |selector: &str| {
            let even = self.fill(&Filling::even(filling.size_m))?;
            let nodes = (even.nodes_m.len(), (0..).zip(even.nodes_m.iter().copied()));
            let given = format!("`fill_m` ...@near:{selector}");
            let found = select_among(selector, nodes, &even.groups, &even.border, &given);
            let ids = found.map_err(|why| why.to_string())?;
            Ok(ids.into_iter().map(|id| even.nodes_m[id as usize]).collect())
        };
        Graded::new(filling.size_m, finer, self.solid, near).map(Some)
    }

    /// The lattice of graded sizes, cut by the surface.
    fn stuff_graded(&self, graded: &Graded) -> std::result::Result<TetMesh, String> {
        let (coarse_m, fine_m) = (graded.coarse_m(), graded.fine_m);
        let grading = Grading {
            cube_m: CUBE * coarse_m,
            levels: graded.levels,
            largest_m: &|place_m| CUBE * graded.largest_m(place_m),
            cubes_max: CUBES * self.nodes_max,
        };
        graded::fill(self.solid, &grading).map_err(|_| {
            // Half of a region at the surface is inside.
            let volume_m3 = self.closed.shells.volume_m3.min(0.5 * graded.volume_m3());
            let fits_m = (2.0 * volume_m3 / self.nodes_max as f64).cbrt() / CUBE;
            let more = format!("`fill_m` {coarse_m:?},{fine_m:?} needs far more");
            let fits_m = above(fits_m.max(1.5 * fine_m));
            let remedy = format!("take a finer size of {fits_m} or more, or a smaller region");
            too_many(more, self.nodes_max, &remedy)
        })
    }
}

/// The refusal of a body of too many nodes, with sizes that fit.
fn too_many_nodes(filling: &Filling, nodes: usize, nodes_max: usize) -> String {
    let larger = (1.05 * nodes as f64 / nodes_max as f64).cbrt();
    let finer = filling.finer.as_ref();
    let fits = above(filling.size_m * larger);
    let remedy = match finer {
        None => format!("take `fill_m` {fits} or more"),
        Some(finer) => {
            let fine = above(finer.size_m * larger);
            format!("take `fill_m` {fits},{fine}@... or more, or a smaller region")
        }
    };
    let more = format!("{nodes} nodes of {}, more", given(filling.size_m, finer));
    too_many(more, nodes_max, &remedy)
}

/// A size with two digits that is not below `size_m`, as an option takes it \[m\].
fn above(size_m: f64) -> f64 {
    two_digits(size_m, f64::ceil)
}

/// A size with two digits that is not above `size_m`.
fn below(size_m: f64) -> f64 {
    two_digits(size_m, f64::floor)
}

fn two_digits(size_m: f64, round: impl Fn(f64) -> f64) -> f64 {
    if !(size_m.is_finite() && size_m > 0.0) {
        return size_m;
    }
    // Divided by a whole power of ten, the decimals print as they are.
    let behind = 1 - size_m.log10().floor() as i32;
    let digits = round(size_m * 10.0_f64.powi(behind));
    if behind > 0 { digits / 10.0_f64.powi(behind) } else { digits * 10.0_f64.powi(-behind) }
}

/// Returns a size at which enough tetrahedra fit into a body without thin parts to keep its volume.
fn largest_m(closed: &Closed) -> f64 {
    (closed.shells.volume_m3 / 60.0).cbrt()
}

/// Refuses sizes that need too many nodes or lattice points, before any is made.
fn check_size(
    solid: &Solid,
    volume_m3: f64,
    size_m: f64,
    nodes_max: usize,
) -> std::result::Result<(), String> {
    let cube_m = CUBE * size_m;
    // There is one corner and one centre a cube.
    let nodes = 2.0 * volume_m3 / (cube_m * cube_m * cube_m);
    let points = points(solid.bounds_m(), cube_m);
    let of_nodes_m = (2.0 * volume_m3 / nodes_max as f64).cbrt() / CUBE;
    let of_points_m = size_m * (points / LATTICE_MAX).cbrt();
    // For a size near 0 the number of points is not finite.
    let fits_m = 1.05 * Some(of_points_m).filter(|m| m.is_finite()).unwrap_or(0.0).max(of_nodes_m);
    if nodes > nodes_max as f64 {
        let count = if nodes < 1e15 { format!("about {nodes:.0}") } else { "above 1e15".into() };
        let more = format!("{count} nodes of `fill_m` {size_m:?}, more");
        return Err(too_many(more, nodes_max, &format!("take `fill_m` {} or more", above(fits_m))));
    }
    if points > LATTICE_MAX {
        return Err(format!(
            "a lattice of {points:.1e} points for `fill_m` {size_m:?}, the limit is {LATTICE_MAX:.1e}; take \
             `fill_m` {} or more",
            above(fits_m)
        ));
    }
    Ok(())
}

fn measure(closed: &Closed, mesh: &Mesh, distance_m: f64) -> Filled {
    let all = || mesh.tetrahedra.iter().map(|ids| corners(&mesh.nodes_m, *ids));
    let volume_m3 = closed.shells.volume_m3;
    let (mut least, mut most) = (180.0f64, 0.0f64);
    for angle in all().flat_map(dihedral_deg) {
        (least, most) = (least.min(angle), most.max(angle));
    }
    let lengths = mesh
        .links
        .iter()
        .map(|[i, j]| distance(mesh.nodes_m[*i as usize], mesh.nodes_m[*j as usize]));
    Filled {
        triangles: closed.triangles.len(),
        turned: closed.shells.turned,
        bodies: closed.shells.bodies,
        cavities: closed.shells.cavities,
        volume_m3,
        volume_error: all().map(|points| volume6(points) / 6.0).sum::<f64>() / volume_m3 - 1.0,
        distance_m,
        dihedral_deg: [least, most],
        roundness: all().map(roundness).fold(1.0, f64::min),
        edge_m: lengths.sum::<f64>() / mesh.links.len() as f64,
        graded_m: None,
        parts: parts(mesh.nodes_m.len(), mesh.nodes_m.len(), &mesh.links),
        handles: [&closed.triangles, &mesh.triangles].map(|triangles| handles(triangles)),
    }
}

/// Returns the largest distance between the two surfaces, and the point at which it was found.
fn farthest(closed: &Closed, mesh: &Mesh) -> (f64, [f64; 3]) {
    let own = |ids: &[u32; 3]| ids.map(|id| mesh.nodes_m[id as usize]);
    let skin = Tree::new(mesh.triangles.iter().map(own).collect());
    let of_skin = mesh.triangles.iter().map(|ids| middle(own(ids)));
    let of_file =
        closed.triangles.iter().map(|ids| middle(ids.map(|id| closed.points_m[id as usize])));
    let from_skin = of_skin.map(|place| (closed.tree.nearest(place).square.sqrt(), place));
    let from_file = of_file
        .chain(closed.points_m.iter().copied())
        .map(|place| (skin.nearest(place).square.sqrt(), place));
    from_skin
        .chain(from_file)
        .fold((0.0, [0.0; 3]), |most, next| if next.0 > most.0 { next } else { most })
}

/// Returns the number of handles of closed triangles, by Euler's formula.
fn handles(triangles: &[[u32; 3]]) -> i64 {
    let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let edges: Vec<[u32; 2]> = edges.filter(|[i, j]| i < j).collect();
    let mut points = triangles.as_flattened().to_vec();
    points.sort_unstable();
    points.dedup();
    let nodes = points.last().map_or(0, |last| *last as usize + 1);
    let shells = parts(nodes, points.len(), &edges);
    shells as i64 - (points.len() as i64 - triangles.len() as i64 / 2) / 2
}

/// Refuses faults that smoothing cannot repair, before the long work: another number of parts, and a
/// surface that is far away at some of its points.
fn check_early(
    closed: &Closed,
    body: &TetMesh,
    size_m: f64,
    unit_m: f64,
) -> std::result::Result<(), String> {
    let skin = boundary(&body.tetrahedra);
    let skin = Tree::new(skin.iter().map(|ids| ids.map(|id| body.nodes_m[id as usize])).collect());
    let each = closed.points_m.len().div_ceil(POINTS_EARLY);
    let away = closed.points_m.iter().step_by(each);
    let away = away.map(|place_m| (skin.nearest(*place_m).square.sqrt(), place_m));
    let farthest = away.max_by(|a, b| a.0.total_cmp(&b.0));
    let found = parts(body.nodes_m.len(), body.nodes_m.len(), &edges(&body.tetrahedra));
    let most = if found == closed.shells.bodies { DISTANCE_EARLY_MAX } else { DISTANCE_MAX };
    match farthest {
        Some((away_m, place_m)) if away_m > most * size_m => {
            Err(too_far(&shown(*place_m, unit_m), away_m, size_m))
        }
        _ => check_parts(closed.shells.bodies, found, size_m),
    }
}

/// Refuses a body that has lost a part or too much of its shape; `place` is the point farthest away.
fn check(filled: &Filled, size_m: f64, place: &str) -> std::result::Result<(), String> {
    if filled.distance_m > DISTANCE_MAX * size_m {
        return Err(too_far(place, filled.distance_m, size_m));
    }
    check_parts(filled.bodies, filled.parts, size_m)?;
    if filled.volume_error.abs() > VOLUME_ERROR_MAX {
        return Err(format!(
            "the volume of the tetrahedra of `fill_m` {size_m:?} is off by {:.1} %, the limit is {:.0} %; \
             take `fill_m` {} or less",
            100.0 * filled.volume_error,
            100.0 * VOLUME_ERROR_MAX,
            // The volume that a curved surface cuts off grows with the square of the size.
            below(0.9 * size_m * (VOLUME_ERROR_MAX / filled.volume_error.abs()).sqrt())
        ));
    }
    Ok(())
}

fn check_parts(bodies: usize, found: usize, size_m: f64) -> std::result::Result<(), String> {
    if bodies == found {
        return Ok(());
    }
    Err(format!(
        "the surface has {} and the tetrahedra of `fill_m` {size_m:?} {found}: what is thinner than they are \
         is lost, a neck or a gap; take a smaller size",
        counted(bodies, "part")
    ))
}

fn too_far(place: &str, away_m: f64, size_m: f64) -> String {
    format!(
        "around {place} the tetrahedra of `fill_m` {size_m:?} are {} from the surface: what is thinner \
         than they are is lost; take a smaller size, or thicken it",
        length(away_m)
    )
}

/// Angles between the faces of a tetrahedron at its six edges \[degrees\].
fn dihedral_deg(points: [[f64; 3]; 4]) -> [f64; 6] {
    const ENDS: [[usize; 4]; 6] =
        [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];
    ENDS.map(|[i, j, k, l]| {
        let edge = minus(points[j], points[i]);
        let normals = [k, l].map(|other| cross(edge, minus(points[other], points[i])));
        let [a, b] = normals;
        let cosine = dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
        libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees()
    })
}
