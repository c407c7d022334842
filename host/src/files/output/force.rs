//! Answers of a run as CSV.

use std::fmt::Write as _;

use chaincell_kernel::TickOutput;

/// The answer of one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Number of the tick.
    pub tick: u64,
    /// The kernel's answer.
    pub output: TickOutput,
    /// Area that blades have swept so far, of a body that can be cut \[m2\].
    pub cut_area_m2: Option<f32>,
    /// Estimated error of the force, where it is known \[N\].
    pub force_error_n: Option<f32>,
}

/// Returns the rows `tick,fx_n,fy_n,fz_n,energy_j,contacts,flags`, of a body that can be cut also `,cut_area_m2`, and
/// where an error is known `,force_error_n`, NaN in the ticks in which it is not; decimals read back as the same
/// numbers.
#[must_use]
pub fn force_csv(answers: &[Answer]) -> String {
    let mut text = String::from("tick,fx_n,fy_n,fz_n,energy_j,contacts,flags");
    let is_cut = answers.first().is_some_and(|answer| answer.cut_area_m2.is_some());
    let is_told = answers.iter().any(|answer| answer.force_error_n.is_some());
    for (column, is_there) in [(",cut_area_m2", is_cut), (",force_error_n", is_told)] {
        text.push_str(if is_there { column } else { "" });
    }
    text.push('\n');
    for Answer { tick, output, cut_area_m2, force_error_n } in answers {
        let [x, y, z]: [f32; 3] = output.force_n.into();
        let (energy_j, contacts, flags) = (output.energy_j, output.contacts, output.flags.0);
        let _ = write!(text, "{tick},{x:e},{y:e},{z:e},{energy_j:e},{contacts},{flags}");
        let error_n = is_told.then(|| force_error_n.unwrap_or(f32::NAN));
        for more in [*cut_area_m2, error_n].into_iter().flatten() {
            let _ = write!(text, ",{more:e}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_kernel::Flags;
    use nalgebra::Vector3;

    #[test]
    fn numbers_read_back_as_they_were() {
        let force_n = Vector3::new(0.1, -1.0e-30, 0.0);
        let output = TickOutput {
            force_n,
            energy_j: 2.5,
            contacts: 7,
            flags: Flags(33),
            ..TickOutput::NONE
        };
        let answer = Answer { tick: 4, output, cut_area_m2: None, force_error_n: None };
        let text = force_csv(&[answer]);
        let row = text.lines().nth(1).unwrap();
        assert_eq!(row, "4,1e-1,-1e-30,0e0,2.5e0,7,33");
        let text = force_csv(&[Answer { cut_area_m2: Some(0.25), ..answer }]);
        assert!(text.starts_with("tick,fx_n,fy_n,fz_n,energy_j,contacts,flags,cut_area_m2\n"));
        assert!(text.ends_with(",33,2.5e-1\n"), "{text}");
        let text = force_csv(&[answer, Answer { force_error_n: Some(0.5), ..answer }]);
        assert!(text.starts_with("tick,fx_n,fy_n,fz_n,energy_j,contacts,flags,force_error_n\n"));
        assert!(text.contains(",33,NaN\n") && text.ends_with(",33,5e-1\n"), "{text}");
        assert_eq!("1e-1".parse::<f32>(), Ok(0.1));
    }
}
