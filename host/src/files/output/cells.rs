//! Positions of all nodes as CSV, in input order.

use std::fmt::Write as _;

use crate::engine::Nodes;

/// Returns the rows `node,x_m,y_m,z_m` with 9 significant digits, sorted by input id.
#[must_use]
pub fn cells_csv(nodes: &Nodes) -> String {
    let mut rows: Vec<(u32, [f64; 3])> =
        nodes.ids.iter().copied().zip(nodes.positions_m.iter().copied()).collect();
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
        let positions_m = vec![[1.0 / 3.0, 0.0, -2e-9], [1.0, 2.0, 3.0]];
        let text = super::cells_csv(&super::Nodes { ids: vec![7, 2], positions_m });
        assert_eq!(
            text,
            "node,x_m,y_m,z_m\n2,1.00000000e0,2.00000000e0,3.00000000e0\n\
             7,3.33333333e-1,0.00000000e0,-2.00000000e-9\n"
        );
    }
}
