//! Forces of contacts as CSV.

use std::fmt::Write as _;

use chaincell_kernel::{ContactForce, Model};

use super::Folder;
use crate::engine::{Contact, Engine};
use crate::error::Result;

/// Rows of contacts, tick by tick.
#[derive(Debug, Default)]
pub struct ContactRows(String);

/// Columns, as the contract defines them.
const HEADER: &str = "tick,tool,part,node,x_m,y_m,z_m,normal_x_n,normal_y_n,normal_z_n,\
    tangential_x_n,tangential_y_n,tangential_z_n,area_m2\n";

impl ContactRows {
    /// Adds the contacts of the last tick of an engine.
    pub fn after(&mut self, tick: u64, engine: &mut Engine<'_>) {
        let contacts = engine.contact_forces();
        self.add(engine.network().model(), tick, &contacts);
    }

    fn add(&mut self, model: &Model<'_>, tick: u64, contacts: &[ContactForce]) {
        for of in contacts {
            let node = model.input_id().get(usize::from(of.origin)).copied().unwrap_or(u32::MAX);
            let _ = write!(self.0, "{tick},{},{},{node}", of.tool, of.part);
            for value in [of.position_m, of.normal_n, of.tangential_n].as_flattened() {
                let _ = write!(self.0, ",{value:e}");
            }
            let _ = writeln!(self.0, ",{:e}", of.area_m2);
        }
    }

    fn csv(&self) -> String {
        format!("{HEADER}{}", self.0)
    }

    /// Writes `contacts.csv`, if the engine has tools on a contact surface.
    ///
    /// # Errors
    /// As [`Folder::write`].
    pub fn write(&self, folder: &Folder, engine: &Engine<'_>) -> Result<()> {
        let has_surface = engine.network().model().has_contact_surface();
        if !has_surface || matches!(engine.contact(), Contact::Cells(_)) {
            return Ok(());
        }
        folder.write("contacts.csv", self.csv().as_bytes())
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
            origin: 0,
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
