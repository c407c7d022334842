//! The profile of a pulled plane along its middle row, and how far it is from a pyramid's.
//!
//! Fig. 4 of the paper tells the network's curved plane from the straight-sided pyramid of
//! traditional `ChainMail` by eye; [`nonlinearity`] is the same in one number.

use chaincell_kernel::Model;

use chaincell_host::error::{Error, Result};

/// Positions given in the model's order of cells, put into that of the input nodes.
///
/// `positions_m` and the result `[cell or node][axis]` \[m\]; nodes that are no cell are left out.
#[must_use]
pub fn in_input_order(model: &Model<'_>, positions_m: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut rows: Vec<(u32, [f64; 3])> =
        model.input_id().iter().copied().zip(positions_m.iter().copied()).collect();
    rows.sort_unstable_by_key(|&(id, _)| id);
    rows.into_iter().map(|(_, position)| position).collect()
}

/// The row of cells along x through the middle of a plane: `[distance from the centre cell along
/// x, height z]` of each \[m\], from one border to the other.
///
/// `positions_m` of the nodes of `plane:NXxNYxD` in input order \[m\], `nodes` = `[NX, NY]`.
///
/// # Errors
/// Another number of positions; a plane without a centre cell.
pub fn middle_row(positions_m: &[[f64; 3]], nodes: [usize; 2]) -> Result<Vec<[f64; 2]>> {
    let [nx, ny] = nodes;
    if nx % 2 == 0 || ny % 2 == 0 || positions_m.len() != nx * ny {
        return Err(Error::input(format!(
            "{} positions for a profile of {nx} x {ny} nodes; give each node of a plane with odd \
             numbers of nodes",
            positions_m.len()
        )));
    }
    let row = || positions_m.iter().skip(ny / 2).step_by(ny);
    let centre = row().nth(nx / 2).map_or(0.0, |p| p[0]);
    Ok(row().map(|p| [p[0] - centre, p[2]]).collect())
}

/// Root mean square of the height between a profile and the straight lines from its centre to its
/// two ends, over the points between them, as a fraction of the depth: 0 for a pyramid, and 0 for
/// a profile without depth.
///
/// `profile` as of [`middle_row`]; the depth is the height between the centre and the mean of both
/// ends. With many points a parabola tends to 0.18 and a spike, only its centre raised, to 0.58.
#[must_use]
pub fn nonlinearity(profile: &[[f64; 2]]) -> f64 {
    let middle = profile.len() / 2;
    let (Some(centre), Some(first), Some(last)) =
        (profile.get(middle), profile.first(), profile.last())
    else {
        return 0.0;
    };
    let depth = centre[1] - 0.5 * (first[1] + last[1]);
    let (mut sum, mut points) = (0.0, 0_u32);
    for (at, point) in profile.iter().enumerate() {
        let end = if at < middle { first } else { last };
        if at == 0 || at == middle || at + 1 == profile.len() {
            continue;
        }
        let part = (point[0] - centre[0]) / (end[0] - centre[0]);
        let straight = centre[1] + part * (end[1] - centre[1]);
        sum += (point[1] - straight).powi(2);
        points += 1;
    }
    if depth == 0.0 || points == 0 { 0.0 } else { (sum / f64::from(points)).sqrt() / depth.abs() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::bake::{BakeOptions, bake};
    use chaincell_host::mesh::{MeshOptions, load};

    /// 21 points 10 mm apart with heights by the distance in halves of the row.
    fn row(height: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        (-10..=10).map(|i| [0.01 * f64::from(i), height(f64::from(i) / 10.0)]).collect()
    }

    #[test]
    fn a_pyramid_has_none_whatever_its_depth_and_border() {
        assert!(nonlinearity(&row(|x| 0.03 * (1.0 - x.abs()))) < 1e-15);
        assert!(nonlinearity(&row(|x| 0.5 - 2.0 * (1.0 - x.abs()))) < 1e-15);
        assert_eq!(nonlinearity(&row(|_| 0.2)), 0.0);
        assert_eq!(nonlinearity(&[]), 0.0);
    }

    #[test]
    fn known_shapes() {
        // A parabola is x - x^2 above its straight line.
        let exact = (1..10).map(|i| f64::from(i) / 10.0).map(|x| (x - x * x).powi(2));
        let exact = (exact.sum::<f64>() / 9.0).sqrt();
        for depth in [0.03, -0.2] {
            let parabola = nonlinearity(&row(|x| depth * (1.0 - x * x)));
            assert!((parabola - exact).abs() < 1e-14, "{parabola} {exact}");
        }
        let spike = nonlinearity(&row(|x| if x == 0.0 { 1.0 } else { 0.0 }));
        let straight = ((1..10).map(|i| (f64::from(i) / 10.0).powi(2)).sum::<f64>() / 9.0).sqrt();
        assert!((spike - straight).abs() < 1e-14);
        // One flank that sags counts as much as on the other side.
        let left = nonlinearity(&row(|x| if x < 0.0 { 1.0 - x * x } else { 1.0 - x }));
        let right = nonlinearity(&row(|x| if x > 0.0 { 1.0 - x * x } else { 1.0 + x }));
        assert!((left - right).abs() < 1e-15 && (left - exact * 0.5_f64.sqrt()).abs() < 1e-14);
    }

    /// The middle row of a plane whose heights name the nodes, from the order of cells.
    #[test]
    fn the_middle_row_runs_along_x() {
        let mesh = load("plane:5x3x0.5", &MeshOptions::default()).unwrap();
        let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let of_cell = |&id: &u32| {
            let [x, y, _] = mesh.nodes_m[id as usize];
            [x, y, f64::from(id)]
        };
        let cells: Vec<[f64; 3]> = model.input_id().iter().map(of_cell).collect();
        let nodes = in_input_order(&model, &cells);
        assert!(nodes.iter().enumerate().all(|(id, p)| p[2] == id as f64));
        let profile = middle_row(&nodes, [5, 3]).unwrap();
        let exact = [[-1.0, 1.0], [-0.5, 4.0], [0.0, 7.0], [0.5, 10.0], [1.0, 13.0]];
        assert_eq!(profile, exact);
        assert!(middle_row(&nodes, [3, 3]).is_err() && middle_row(&nodes[..8], [2, 4]).is_err());
    }
}
