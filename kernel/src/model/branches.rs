//! Branches of relaxation in an image: a Prony series of the shear modulus, or of the links' stiffness.
//!
//! A branch k carries the share g' of the instantaneous modulus and forgets with the time tau. With the tick dt,
//! b = 1 - exp(-dt / tau) and c = b tau / dt, see [`following`](crate::energy). The moduli in the sections of nodal
//! shapes, and the stiffness of links, are the instantaneous ones.

use super::image::{BRANCHES_MAX, ModelError, Sections, branch, kind};

/// Numbers of a branch, see [`branch`].
pub(crate) type BranchNumbers = [f32; branch::WORDS];

/// Largest sum of the shares: tissue at rest keeps a hundredth of its instantaneous modulus.
const SHARES_MAX: f32 = 0.99;
/// Times \[ticks\].
const TIMES: core::ops::RangeInclusive<f32> = 1.0..=1.6e6;
/// Lengths of a tick \[s\].
const TICKS_S: core::ops::RangeInclusive<f32> = 1.0e-5..=0.1;
/// Error of a number that follows from others, relative to it.
const ROUNDING: f32 = 1.0e-4;

/// A branch of relaxation: a share of the shear modulus, or of the links' stiffness, that fades.
///
/// ```
/// # use chaincell_kernel::{Model, include_model};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// let model = Model::from_bytes(image)?; // baked without `--branch`
/// assert_eq!(model.branches().count(), 0);
/// # Ok::<(), chaincell_kernel::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Share of the instantaneous modulus.
    pub share: f32,
    /// Time in which a constant strain's stress in the branch falls by 1 / e \[s\].
    pub time_s: f32,
    /// Length of a tick for which the branch was baked \[s\].
    pub tick_s: f32,
}

impl Branch {
    pub(crate) fn of(numbers: &BranchNumbers) -> Self {
        let [share, time, tick_s, ..] = *numbers;
        Self { share, time_s: time * tick_s, tick_s }
    }
}

/// Reads the section; empty for a body that does not relax.
pub(crate) fn read<'a>(sections: &Sections<'a>) -> Result<&'a [BranchNumbers], ModelError> {
    let Some(branches) = sections.optional::<BranchNumbers>(kind::BRANCHES)? else {
        return Ok(&[]);
    };
    if !cfg!(feature = "relax") {
        return Err(ModelError::Unbuilt(kind::BRANCHES));
    }
    if !(1..=BRANCHES_MAX).contains(&branches.len()) {
        return Err(ModelError::SectionSize(kind::BRANCHES));
    }
    // A body that can be cut keeps no memory of its strain.
    if sections.optional::<u32>(kind::CUTTING)?.is_some() {
        return Err(ModelError::Layout);
    }
    check(branches)?;
    Ok(branches)
}

/// Checks shares, times in ascending order, and the numbers that follow from them.
fn check(branches: &[BranchNumbers]) -> Result<(), ModelError> {
    let (mut sum, mut last, mut tick) = (0.0, 0.0, None);
    for (position, numbers) in branches.iter().enumerate() {
        let &[share, time, tick_s, ref faded @ ..] = numbers;
        sum += share;
        let is_one_tick = tick.is_none_or(|of_others| of_others == tick_s);
        let holds = share > 0.0
            && sum <= SHARES_MAX
            && TIMES.contains(&time)
            && time > last
            && TICKS_S.contains(&tick_s)
            && is_one_tick
            && is_decay(time, faded);
        if !holds {
            return Err(ModelError::Value(kind::BRANCHES, position as u32));
        }
        (last, tick) = (time, Some(tick_s));
    }
    Ok(())
}

/// Returns true if these are the parts that fade in 1, 2, 4, … ticks.
fn is_decay(time: f32, faded: &[f32]) -> bool {
    // The first one lies between those of a linear decay and of an exponential one.
    let first = faded.first().copied().unwrap_or(0.0);
    let least = 1.0 / time - 0.5 / (time * time);
    let is_first =
        first > 0.0 && first >= (1.0 - ROUNDING) * least && first * time <= 1.0 + ROUNDING;
    let doubles = faded.iter().zip(faded.iter().skip(1)).all(|(&part, &doubled)| {
        let expected = part * (2.0 - part);
        doubled <= 1.0 && (doubled - expected).abs() <= ROUNDING * expected
    });
    is_first && doubles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of a branch as the bake writes them.
    fn numbers(share: f32, time: f64) -> BranchNumbers {
        let mut numbers = [share, time as f32, 1.0e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for (power, faded) in numbers[branch::FADED..].iter_mut().enumerate() {
            *faded = -(-f64::from(1_u32 << power) / time).exp_m1() as f32;
        }
        numbers
    }

    #[test]
    fn branches_of_all_times_pass() {
        for time in [1.0, 5.0, 20.0, 100.0, 1e4, 1.6e6] {
            assert_eq!(check(&[numbers(0.4, time)]), Ok(()), "{time}");
        }
        let four = [1.0, 30.0, 2e3, 1e5].map(|time| numbers(0.2, time));
        assert_eq!(check(&four), Ok(()));
    }

    #[test]
    fn contradictions_are_named_by_branch() {
        let wrong = |position| Err(ModelError::Value(kind::BRANCHES, position));
        let (fast, slow) = (numbers(0.3, 20.0), numbers(0.3, 2000.0));
        assert_eq!(check(&[slow, fast]), wrong(1)); // out of order
        assert_eq!(check(&[numbers(0.7, 20.0), numbers(0.3, 90.0)]), wrong(1)); // nothing left
        assert_eq!(check(&[fast, numbers(-0.1, 90.0)]), wrong(1));
        assert_eq!(check(&[numbers(0.3, 0.5)]), wrong(0));
        for (row, number) in [(branch::TICK_S, 2.0e-3), (branch::FADED, 0.1), (9, 0.1)] {
            let mut other = slow;
            other[row] = number;
            assert_eq!(check(&[fast, other]), wrong(1), "{row}");
        }
    }
}
