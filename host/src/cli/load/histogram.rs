//! The histograms of a session under load as text and as CSV.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use crate::session::timing::spans::{Spans, width_us};

/// Rows of the text are 1 us wide below this, beyond it 4 per doubling \[us\].
const SINGLE_US: u64 = 16;
/// Base-2 logarithm of the number of rows per doubling.
const ROWS_LOG2: u32 = 2;

/// Histograms of a session under load, in the order of their columns.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Histograms {
    /// Delay with which the controller woke up.
    pub wakeup: Spans,
    /// Duration of a tick.
    pub step: Spans,
    /// Time from a send to its answer.
    pub round_trip: Spans,
    /// The delay of the wake-up without a tissue.
    pub floor_wakeup: Spans,
    /// The round trip without a tissue.
    pub floor_round_trip: Spans,
}

impl Histograms {
    /// Returns the histograms with their names.
    #[must_use]
    pub fn named(&self) -> [(&'static str, &Spans); 5] {
        [
            ("wakeup", &self.wakeup),
            ("step", &self.step),
            ("round_trip", &self.round_trip),
            ("floor_wakeup", &self.floor_wakeup),
            ("floor_round_trip", &self.floor_round_trip),
        ]
    }
}

/// Returns a line for the extremes of each histogram, the maximum first \[us\].
#[must_use]
pub fn maxima(histograms: &Histograms) -> String {
    let us = |ns: u64| ns as f64 * 1e-3;
    let mut text = String::new();
    for (number, (name, spans)) in histograms.named().into_iter().enumerate() {
        let _ = writeln!(
            text,
            "T: {number} {:<20} Max:{:10.1} Avg:{:8.1} Min:{:8.1} C:{:10}  [us]",
            format!("({name})"),
            us(spans.max_ns),
            us(spans.mean_ns),
            us(spans.min_ns),
            spans.count
        );
    }
    text
}

/// Returns the counts of every histogram by the lower bound of their rows; `row` maps that of a bucket to it.
fn rows(histograms: &Histograms, row: impl Fn(u64) -> u64) -> BTreeMap<u64, [u64; 5]> {
    let mut rows = BTreeMap::<u64, [u64; 5]>::new();
    for (column, (_, spans)) in histograms.named().into_iter().enumerate() {
        for &(from_us, count) in &spans.buckets {
            rows.entry(row(from_us)).or_default()[column] += count;
        }
    }
    rows
}

/// Returns the histograms side by side, in rows that become wider; empty rows are left out.
#[must_use]
pub fn text(histograms: &Histograms) -> String {
    let names = histograms.named().map(|(name, _)| format!(" {name:>17}")).concat();
    let mut text = format!("{:>10}{names}\n", "from [us]");
    for (from_us, counts) in rows(histograms, row_us) {
        let counts = counts.map(|count| format!(" {count:>17}")).concat();
        let _ = writeln!(text, "{from_us:>10}{counts}");
    }
    text
}

/// Returns the lower bound of the row of a bucket \[us\].
fn row_us(from_us: u64) -> u64 {
    let width = if from_us < SINGLE_US { 1 } else { 1 << (from_us.ilog2() - ROWS_LOG2) };
    from_us / width * width
}

/// Returns all buckets that are not empty: `from_us,to_us` and a column for each histogram.
#[must_use]
pub fn csv(histograms: &Histograms) -> String {
    let names = histograms.named().map(|(name, _)| format!(",{name}")).concat();
    let mut text = format!("from_us,to_us{names}\n");
    for (from_us, counts) in rows(histograms, |from_us| from_us) {
        let counts = counts.map(|count| format!(",{count}")).concat();
        let _ = writeln!(text, "{from_us},{}{counts}", from_us + width_us(from_us));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::timing::histogram::Latencies;

    fn filled() -> Histograms {
        let mut latencies = Latencies::new().unwrap();
        for span_ns in [1_200, 1_900, 30_500, 31_500, 5_000_000] {
            latencies.record(span_ns);
        }
        let step = latencies.spans();
        latencies.record(7_000);
        Histograms { step, round_trip: latencies.spans(), ..Histograms::default() }
    }

    #[test]
    fn the_maximum_leads_its_line() {
        let text = maxima(&filled());
        let line = text.lines().nth(1).unwrap();
        assert!(line.starts_with("T: 1 (step)"), "{line}");
        assert!(line.contains("Max:    5000.0 Avg:") && line.contains("C:         5"), "{line}");
        assert_eq!(text.lines().count(), 5);
    }

    #[test]
    fn every_span_stands_in_text_and_csv() {
        let filled = filled();
        for (text, separator) in [(text(&filled), ' '), (csv(&filled), ',')] {
            let column = |at: usize| -> u64 {
                let rows = text.lines().skip(1);
                rows.map(|row| {
                    let fields = row.split(separator).filter(|field| !field.is_empty());
                    fields.rev().nth(at).unwrap().parse::<u64>().unwrap()
                })
                .sum()
            };
            assert_eq!([column(4), column(3), column(2), column(1)], [0, 5, 6, 0], "{text}");
        }
        assert!(csv(&filled).contains("\n30,31,0,1,1,0,0\n"));
        assert!(text(&filled).lines().any(|row| row.trim_start().starts_with("28 ")));
    }
}
