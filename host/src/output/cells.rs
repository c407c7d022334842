//! Positions of all cells as CSV, in input order.

use std::fmt::Write as _;

/// `node,x_m,y_m,z_m` with 9 significant digits, sorted by input id.
///
/// `positions_m` in the model's cell order, `input_id` the input id of each cell.
#[must_use]
pub fn cells_csv(positions_m: &[[f64; 3]], input_id: &[u32]) -> String {
    let mut rows: Vec<(u32, [f64; 3])> =
        input_id.iter().copied().zip(positions_m.iter().copied()).collect();
    rows.sort_unstable_by_key(|&(id, _)| id);
    let mut text = String::from("node,x_m,y_m,z_m\n");
    for (id, [x, y, z]) in rows {
        let _ = writeln!(text, "{id},{x:.8e},{y:.8e},{z:.8e}");
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn rows_stand_in_input_order_with_nine_digits() {
        let text = super::cells_csv(&[[1.0 / 3.0, 0.0, -2e-9], [1.0, 2.0, 3.0]], &[7, 2]);
        assert_eq!(
            text,
            "node,x_m,y_m,z_m\n2,1.00000000e0,2.00000000e0,3.00000000e0\n\
             7,3.33333333e-1,0.00000000e0,-2.00000000e-9\n"
        );
    }
}
