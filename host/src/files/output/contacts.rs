//! Forces of contacts as CSV.

use std::fmt::Write as _;

use chaincell_kernel::{ContactForce, Model};

/// Rows of contacts, tick by tick.
#[derive(Debug, Default)]
pub struct ContactRows(String);

/// Columns, see the contract.
const HEADER: &str = "tick,tool,part,node,x_m,y_m,z_m,normal_x_n,normal_y_n,normal_z_n,\
    tangential_x_n,tangential_y_n,tangential_z_n,area_m2\n";

impl ContactRows {
    /// Adds the contacts of a tick.
    pub fn add(&mut self, model: &Model<'_>, tick: u64, contacts: &[ContactForce]) {
        for of in contacts {
            let node = model.input_id().get(usize::from(of.cell)).copied().unwrap_or(u32::MAX);
            let _ = write!(self.0, "{tick},{},{},{node}", of.tool, of.part);
            for value in [of.position_m, of.normal_n, of.tangential_n].as_flattened() {
                let _ = write!(self.0, ",{value:e}");
            }
            let _ = writeln!(self.0, ",{:e}", of.area_m2);
        }
    }

    /// The file.
    #[must_use]
    pub fn csv(&self) -> String {
        format!("{HEADER}{}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_value_for_each_column() {
        let contact = ContactForce {
            position_m: [0.1, 0.2, 0.3],
            normal_n: [0.0, 0.0, 1.5],
            tangential_n: [0.25, 0.0, 0.0],
            area_m2: 1.0e-6,
            cell: 0,
            tool: 1,
            part: 2,
            triangle: 7,
        };
        let image = crate::engine::fixture::plane();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let mut rows = ContactRows::default();
        rows.add(&model, 12, &[contact, contact]);
        let csv = rows.csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.split(',').count() == 14), "{csv}");
        assert!(lines[1].starts_with("12,1,2,") && lines[1].ends_with(",1e-6"), "{csv}");
    }
}
