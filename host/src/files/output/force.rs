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
}

/// Returns the rows `tick,fx_n,fy_n,fz_n,energy_j,contacts,flags`; decimals read back as the same numbers.
#[must_use]
pub fn force_csv(answers: &[Answer]) -> String {
    let mut text = String::from("tick,fx_n,fy_n,fz_n,energy_j,contacts,flags\n");
    for Answer { tick, output } in answers {
        let [x, y, z]: [f32; 3] = output.force_n.into();
        let (energy_j, contacts, flags) = (output.energy_j, output.contacts, output.flags.0);
        let _ = writeln!(text, "{tick},{x:e},{y:e},{z:e},{energy_j:e},{contacts},{flags}");
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
        let text = force_csv(&[Answer { tick: 4, output }]);
        let row = text.lines().nth(1).unwrap();
        assert_eq!(row, "4,1e-1,-1e-30,0e0,2.5e0,7,33");
        assert_eq!("1e-1".parse::<f32>(), Ok(0.1));
    }
}
