//! The numbers of a generator's spec, such as `21x21x0.01`, checked before anything is built.

use crate::error::{Error, Result};

/// Shortest spacing, in metres: far below it, positions in f32 would coincide.
const SPACING_MIN_M: f64 = 1e-9;
/// Longest spacing, in metres.
const SPACING_MAX_M: f64 = 1e6;

/// Parses `N0xN1x..xD` for `form`: node counts along the axes, at most `nodes_max` in all, and the
/// spacing in metres.
pub(super) fn parse<const N: usize>(
    form: &str,
    size: &str,
    nodes_max: usize,
) -> Result<([usize; N], f64)> {
    let kind = form.split(':').next().unwrap_or(form);
    let refuse = |why: String| Err(Error::input(format!("mesh {kind}:{size}: {why}")));
    let words: Vec<&str> = size.split('x').collect();
    if words.len() != N + 1 {
        return refuse(format!(
            "the form is {form}, nodes along each axis and metres between them"
        ));
    }
    // The node counts of the axes.
    let mut counts = [0usize; N];
    let mut cells = 1usize;
    for ((count, word), axis) in counts.iter_mut().zip(&words).zip(["NX", "NY", "NZ"]) {
        match word.parse::<usize>() {
            Ok(n) if n >= 2 => *count = n,
            _ => {
                return refuse(format!(
                    "{axis} is '{word}'; it must be a whole number of 2 or more nodes"
                ));
            }
        }
        cells = cells.saturating_mul(*count);
    }
    if cells > nodes_max {
        return refuse(super::too_many("more", nodes_max, "take fewer nodes"));
    }
    // The spacing.
    match words[N].parse::<f64>() {
        Ok(d) if (SPACING_MIN_M..=SPACING_MAX_M).contains(&d) => Ok((counts, d)),
        _ => refuse(format!(
            "D is '{}'; it must be a number of metres from {SPACING_MIN_M:e} to {SPACING_MAX_M:e}",
            words[N]
        )),
    }
}

/// Coordinate of node `index` of `count` centred on 0, in metres.
pub(super) fn centred(index: usize, count: usize, spacing_m: f64) -> f64 {
    (index as f64 - (count - 1) as f64 / 2.0) * spacing_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CELLS_MAX;

    #[test]
    fn silly_sizes_name_the_field() {
        for (size, part) in [
            ("", "the form is plane:NXxNYxD"),
            ("21x21", "the form is"),
            ("0x21x0.01", "NX is '0'"),
            ("21x1x0.01", "NY is '1'"),
            ("21x-3x0.01", "NY is '-3'"),
            ("99999999999999999999x2x1", "NX is"),
            ("65536x65536x0.01", "65535 cells"),
            ("4294967296x4294967296x0.01", "65535 cells"),
            ("256x256x0.01", "65535 cells"),
            ("3x3xNaN", "D is 'NaN'"),
            ("3x3xinf", "D is 'inf'"),
            ("3x3x0", "D is '0'"),
            ("3x3x-1", "D is '-1'"),
            ("3x3x1e-300", "D is '1e-300'"),
        ] {
            let text = parse::<2>("plane:NXxNYxD", size, CELLS_MAX).unwrap_err().to_string();
            assert!(text.contains(part) && text.contains("mesh plane:"), "{size}: {text}");
        }
        let fits = |nodes_max| parse::<2>("plane:NXxNYxD", "255x257x1e-2", nodes_max);
        assert_eq!(fits(CELLS_MAX).unwrap(), ([255, 257], 0.01));
        assert!(fits(60_000).unwrap_err().to_string().contains("60000"));
    }
}
