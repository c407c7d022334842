//! Which setting to take for a time budget: the one with the least error among those that keep
//! within a bound on their errors.

use super::press::PressRow;

/// Budgets a tick \[us\].
pub const BUDGETS_US: [f64; 4] = [125.0, 250.0, 500.0, 1000.0];
/// Largest error of the field and of the force during the press that a recommended setting may
/// have: about the difference of a force that a hand just notices.
pub const ERROR_MAX: f64 = 0.07;

/// The answer for a budget.
#[derive(Debug, Clone, Copy)]
pub struct Recommended<'r> {
    /// Whether the errors keep within [`ERROR_MAX`]; if not, this is merely the least error.
    pub qualifies: bool,
    /// The setting with its figures.
    pub row: &'r PressRow,
}

/// The larger one of the errors of field and force during the press.
fn error(row: &PressRow) -> f64 {
    row.largest.field.max(row.largest.force)
}

/// The setting with the least error whose median tick is within the budget; none where none of the
/// settings measured is.
#[must_use]
pub fn choose<'r>(rows: &[&'r PressRow], budget_us: f64) -> Option<Recommended<'r>> {
    let fits = rows.iter().filter(|row| row.tick_ns.p50 as f64 * 1e-3 <= budget_us);
    let row = fits.min_by(|a, b| error(a).total_cmp(&error(b)))?;
    Some(Recommended { qualifies: error(row) <= ERROR_MAX, row })
}

#[cfg(test)]
mod tests {
    use super::super::press::Errors;
    use super::super::setting::Setting;
    use super::*;

    fn row(sweeps: u16, tick_us: u64, field: f64, force: f64) -> PressRow {
        let mut row = PressRow::new("", Setting::TRACK, sweeps);
        row.tick_ns.p50 = 1000 * tick_us;
        row.largest = Errors { field, force };
        row
    }

    #[test]
    fn a_setting_beyond_the_bound_is_not_recommended() {
        let rows = [row(1, 200, 0.93, 0.4), row(4, 400, 0.05, 0.08), row(8, 800, 0.06, 0.01)];
        let rows: Vec<&PressRow> = rows.iter().collect();
        let choice = |budget_us| {
            choose(&rows, budget_us).map(|choice| (choice.row.sweeps, choice.qualifies))
        };
        assert_eq!(choice(125.0), None);
        assert_eq!(choice(250.0), Some((1, false)));
        // The field is within the bound, the force is not.
        assert_eq!(choice(500.0), Some((4, false)));
        assert_eq!(choice(1000.0), Some((8, true)));
    }
}
