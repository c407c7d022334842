//! Words that depend on a number, and numbers in words.

use std::fmt;

/// A count with its noun in the singular or the plural: `1 sweep`, `2 sweeps`.
#[must_use]
pub fn counted(count: impl fmt::Display, noun: &str) -> String {
    let count = count.to_string();
    let ending = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// A rate: `500 Hz`, `1 kHz`.
#[must_use]
pub fn rate(hz: u32) -> String {
    if hz < 1000 { format!("{hz} Hz") } else { format!("{} kHz", f64::from(hz) / 1e3) }
}

/// The share, 0 to 1, that a text like `1%` names.
#[must_use]
pub fn percent(text: &str) -> Option<f64> {
    let percent: f64 = text.strip_suffix('%')?.parse().ok()?;
    (0.0..=100.0).contains(&percent).then_some(percent / 100.0)
}

/// A length \[m\] with three digits, in mm below a metre: `7.74 mm`, `190 m`.
#[must_use]
pub fn length(metres: f64) -> String {
    let (number, unit) = if metres.abs() < 1.0 { (1e3 * metres, "mm") } else { (metres, "m") };
    format!("{} {unit}", three_digits(number))
}

/// A volume \[m^3\] with three digits, in cm^3 below a cubic metre.
#[must_use]
pub fn volume(cubic_metres: f64) -> String {
    let is_small = cubic_metres.abs() < 1.0;
    let (number, unit) = if is_small { (1e6 * cubic_metres, "cm") } else { (cubic_metres, "m") };
    format!("{} {unit}^3", three_digits(number))
}

/// A number with three digits that count, never in powers of ten below a million.
#[must_use]
pub fn three_digits(number: f64) -> String {
    if !number.is_finite() || number.abs() >= 1e6 {
        return format!("{number:.2e}");
    }
    let before = if number == 0.0 { 0.0 } else { number.abs().log10().floor() };
    let behind = (2.0 - before).clamp(0.0, 6.0) as usize;
    format!("{number:.behind$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_in_mm_below_a_metre() {
        let lengths = [0.007_744, 0.19, 190.4, 1.0, 0.0, 2.5e-5, 0.999, 2.87e6, f64::NAN];
        assert_eq!(
            lengths.map(length),
            [
                "7.74 mm",
                "190 mm",
                "190 m",
                "1.00 m",
                "0.00 mm",
                "0.0250 mm",
                "999 mm",
                "2.87e6 m",
                "NaN m"
            ]
        );
        assert_eq!([1.369e-3, 2.5].map(volume), ["1369 cm^3", "2.50 m^3"]);
    }

    #[test]
    fn one_is_the_only_singular() {
        assert_eq!(
            [0, 1, 2, 11].map(|n| counted(n, "sweep")),
            ["0 sweeps", "1 sweep", "2 sweeps", "11 sweeps"]
        );
    }
}
