//! Finite check of samples and answers.
//!
//! Values beyond any physical range are bad too, so that no square or product in the stage overflows single
//! precision.

use crate::contact::pose::ToolPose;
use crate::tick::sample::{Flags, TickOutput};

/// Largest coordinate of a device's position \[m\].
const REACH_M: f32 = 1.0e3;
/// Largest coordinate of a force, a stiffness or a work, in SI units.
const MOST: f32 = 1.0e9;

/// Returns true if the stage may use a sample.
pub(super) fn is_good(sample: &ToolPose) -> bool {
    sample.is_good() && sample.position_m.iter().all(|x| x.abs() <= REACH_M)
}

/// Marks a sample that is bad for the stage as bad for the tissue.
pub(super) fn made_bad(sample: &ToolPose) -> ToolPose {
    ToolPose { engaged: u16::MAX, ..*sample }
}

/// The part of a tissue's answer that the stage may use, and true if that is all of it.
pub(super) fn checked(tissue: &TickOutput) -> (TickOutput, bool) {
    let TickOutput { force_n, energy_j, work_j, stiffness_n_per_m, contacts, sweeps, flags } =
        *tissue;
    let is_sound = force_n.iter().all(|f| f.abs() <= MOST)
        && work_j.abs() <= MOST
        && (0.0..=MOST).contains(&stiffness_n_per_m)
        && energy_j.is_finite();
    if is_sound {
        return (*tissue, true);
    }
    let mut sound = TickOutput { contacts, sweeps, flags, ..TickOutput::NONE };
    sound.flags.insert(Flags::BAD_SAMPLE);
    (sound, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    // REQ-STG-01
    #[test]
    fn numbers_that_nobody_means_are_bad() {
        let at = |x| ToolPose::at(Vector3::new(0.0, x, 0.0), 1);
        assert!(is_good(&at(0.1)) && is_good(&at(-1.0e3)));
        for x in [f32::NAN, f32::INFINITY, 1.1e3, -f32::MAX] {
            assert!(!is_good(&at(x)));
            assert!(!made_bad(&at(x)).is_good());
        }
        assert!(!is_good(&ToolPose { engaged: 2, ..at(0.0) }));
    }

    // REQ-STG-01
    #[test]
    fn an_answer_with_one_bad_number_is_no_force() {
        let good = TickOutput { energy_j: 1.0, contacts: 3, ..TickOutput::NONE };
        assert_eq!(checked(&good), (good, true));
        for bad in [f32::NAN, f32::NEG_INFINITY, 2.0e9] {
            let force_n = Vector3::new(0.0, 1.0, bad);
            for answer in [
                TickOutput { force_n, ..good },
                TickOutput { work_j: bad, ..good },
                TickOutput { stiffness_n_per_m: bad, ..good },
            ] {
                let (sound, is_all) = checked(&answer);
                assert!(!is_all && sound.flags.contains(Flags::BAD_SAMPLE), "{answer:?}");
                assert_eq!(
                    (sound.force_n, sound.energy_j, sound.contacts),
                    (Vector3::zeros(), 0.0, 3)
                );
            }
        }
    }
}
