//! What an axis shows: its range, its ticks, and which numbers it can take.

use super::{Axis, Scale};

/// Numbers beyond this cannot be spread over a frame without overflow.
const LARGEST: f64 = 1e150;
/// A range narrower than this part of its numbers would show their rounding.
const NARROWEST: f64 = 1e-9;

/// An axis' range in its own scale: the numbers themselves or their decimal logarithms.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    scale: Scale,
    /// Lower end, in scale.
    pub from: f64,
    /// Upper end, in scale.
    pub to: f64,
    /// Places with a label, in scale.
    pub ticks: Vec<f64>,
    /// Places with a fine line alone, in scale.
    pub fine: Vec<f64>,
}

impl Span {
    /// The range of `numbers` with some air around it, with about `count` ticks.
    pub fn new(axis: &Axis, numbers: impl Iterator<Item = f64>, count: usize) -> Self {
        Self::between(axis.scale, around(axis.scale, numbers), count)
    }

    /// The range between two places in scale, with about `count` ticks.
    pub fn between(scale: Scale, (from, to): (f64, f64), count: usize) -> Self {
        let mut span = Self { scale, from, to, ticks: Vec::new(), fine: Vec::new() };
        match scale {
            Scale::Linear => span.ticks = even(from, to, count),
            Scale::Log10 => span.decades(count),
        }
        span
    }

    /// Where a number stands, in scale; `None` where it has no place in this range.
    pub fn place(&self, number: f64) -> Option<f64> {
        place(self.scale, number).filter(|at| (self.from..=self.to).contains(at))
    }

    /// How far along the axis a place in scale is, 0 to 1.
    pub fn part(&self, at: f64) -> f64 {
        (at - self.from) / (self.to - self.from)
    }

    /// The label of a tick.
    pub fn label(&self, tick: f64) -> String {
        let number = match self.scale {
            Scale::Linear => tick,
            Scale::Log10 => 10_f64.powf(tick),
        };
        let size = number.abs();
        // Twelve digits hide the rounding of the logarithm and of the step.
        let rounded = format!("{number:.11e}").parse().unwrap_or(number);
        let none = self.scale == Scale::Linear && size < (self.to - self.from) * NARROWEST;
        match rounded {
            _ if none => "0".into(),
            _ if (1e-3..1e5).contains(&size) => format!("{rounded}"),
            _ => format!("{rounded:e}"),
        }
    }

    fn decades(&mut self, count: usize) {
        let all = |leads: &[f64]| -> Vec<f64> {
            let decades = self.from.floor() as i32..=self.to.floor() as i32;
            let at = |decade| leads.iter().map(move |lead: &f64| f64::from(decade) + lead.log10());
            decades.flat_map(at).filter(|at| (self.from..=self.to).contains(at)).collect()
        };
        let wide = self.to - self.from;
        if wide > count as f64 {
            self.ticks = even(self.from, self.to, count);
            return;
        }
        self.fine = all(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        self.ticks = match wide {
            _ if wide > 0.45 * count as f64 => all(&[1.0]),
            _ if wide > 0.25 * count as f64 => all(&[1.0, 3.0]),
            _ if wide > 0.3 => all(&[1.0, 2.0, 5.0]),
            // Within a factor of two, steps of the number itself.
            _ => {
                let (from, to) = (10_f64.powf(self.from), 10_f64.powf(self.to));
                even(from, to, count).into_iter().map(f64::log10).collect()
            }
        };
    }
}

fn place(scale: Scale, number: f64) -> Option<f64> {
    match scale {
        Scale::Linear => (number.abs() <= LARGEST).then_some(number),
        // Below the normal numbers the decades end.
        Scale::Log10 => (f64::MIN_POSITIVE..=LARGEST).contains(&number).then(|| number.log10()),
    }
}

fn narrowest((from, to): (f64, f64)) -> f64 {
    (NARROWEST * from.abs().max(to.abs())).max(f64::MIN_POSITIVE / NARROWEST)
}

/// The range of the numbers that have a place, with air around it.
fn around(scale: Scale, numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (from, to) = numbers
        .filter_map(|number| place(scale, number))
        .fold(ends, |(from, to), at| (at.min(from), at.max(to)));
    if from > to {
        return (0.0, 1.0);
    }
    if to - from <= narrowest((from, to)) {
        let half = match scale {
            Scale::Linear if from.abs() > narrowest((0.0, 1.0)) => 0.5 * from.abs(),
            Scale::Linear | Scale::Log10 => 0.5,
        };
        return (from - half, to + half);
    }
    let air = 0.05 * (to - from);
    // Nothing below zero is shown where nothing is below zero.
    let floor = if scale == Scale::Linear && from >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
    ((from - air).max(floor), to + air)
}

/// Multiples of 1, 2 or 5 times a power of ten within the range, about `count` of them.
fn even(from: f64, to: f64, count: usize) -> Vec<f64> {
    let coarse = (to - from) / count.max(1) as f64;
    let power = 10_f64.powi(coarse.log10().floor() as i32);
    let step =
        [1.0, 2.0, 5.0].into_iter().find(|lead| lead * power >= coarse).unwrap_or(10.0) * power;
    let (first, last) = ((from / step).ceil() as i64, (to / step).floor() as i64);
    (first..=last).take(4 * count).map(|n| n as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, numbers: &[f64], count: usize) -> Vec<String> {
        let span = Span::new(axis, numbers.iter().copied(), count);
        span.ticks.iter().map(|&tick| span.label(tick)).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(&Axis::linear(""), &[0.0, 1.0], 5), ["0", "0.5", "1"]);
        assert_eq!(labels(&Axis::linear(""), &[-0.3, 0.3], 6), ["-0.2", "0", "0.2"]);
        assert_eq!(labels(&Axis::linear(""), &[0.0, 3e6], 4), ["0", "1e6", "2e6", "3e6"]);
        assert_eq!(
            labels(&Axis::log10(""), &[1e-5, 1.0], 6),
            ["1e-5", "1e-4", "0.001", "0.01", "0.1", "1"]
        );
        assert_eq!(labels(&Axis::log10(""), &[60.0, 900.0], 8), ["100", "200", "500", "1000"]);
        assert_eq!(
            labels(&Axis::log10(""), &[10.0, 15.0], 6),
            ["10", "11", "12", "13", "14", "15"]
        );
    }

    #[test]
    fn a_single_number_stands_in_the_middle() {
        for axis in [Axis::linear(""), Axis::log10("")] {
            let span = Span::new(&axis, [7.0].into_iter(), 6);
            let at = span.place(7.0).unwrap();
            assert!((at - 0.5 * (span.from + span.to)).abs() < 1e-12 && span.ticks.len() >= 2);
        }
    }
}
