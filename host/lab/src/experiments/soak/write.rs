//! The histogram of a long run as text, CSV and chart.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::report::SoakReport;
use crate::charts::plot::{Axis, Chart, Style};
use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_host::session::timing::spans::{Spans, width_us};

/// Rows of the text are single microseconds below this, 4 to a doubling beyond \[us\].
const SINGLE_US: u64 = 16;
/// Rows to a doubling, as a power of two.
const ROWS_LOG2: u32 = 2;

/// The extremes of each histogram, the maximum first, a line each \[us\].
#[must_use]
pub fn maxima(report: &SoakReport) -> String {
    let us = |ns: u64| ns as f64 * 1e-3;
    let mut text = String::new();
    for (at, (name, spans)) in report.histograms().into_iter().enumerate() {
        let _ = writeln!(
            text,
            "T: {at} {:<20} Max:{:10.1} Avg:{:8.1} Min:{:8.1} C:{:10}  [us]",
            format!("({name})"),
            us(spans.max_ns),
            us(spans.mean_ns),
            us(spans.min_ns),
            spans.count
        );
    }
    text
}

/// Counts of every histogram by the lower bound of their buckets, which `row` may put together.
fn rows(report: &SoakReport, row: impl Fn(u64) -> u64) -> BTreeMap<u64, [u64; 5]> {
    let mut rows = BTreeMap::<u64, [u64; 5]>::new();
    for (column, (_, spans)) in report.histograms().into_iter().enumerate() {
        for &(from_us, count) in &spans.buckets {
            rows.entry(row(from_us)).or_default()[column] += count;
        }
    }
    rows
}

/// The histograms side by side; rows widen, those that hold nothing are left out.
#[must_use]
pub fn text(report: &SoakReport) -> String {
    let names = report.histograms().map(|(name, _)| format!(" {name:>17}")).concat();
    let mut text = format!("{:>10}{names}\n", "from [us]");
    for (from_us, counts) in rows(report, row_us) {
        let counts = counts.map(|count| format!(" {count:>17}")).concat();
        let _ = writeln!(text, "{from_us:>10}{counts}");
    }
    text
}

/// Lower bound of the row of a bucket \[us\].
fn row_us(from_us: u64) -> u64 {
    let width = if from_us < SINGLE_US { 1 } else { 1 << (from_us.ilog2() - ROWS_LOG2) };
    from_us / width * width
}

/// All buckets that hold anything: `from_us,to_us` and a column for each histogram.
#[must_use]
pub fn csv(report: &SoakReport) -> String {
    let names = report.histograms().map(|(name, _)| format!(",{name}")).concat();
    let mut text = format!("from_us,to_us{names}\n");
    for (from_us, counts) in rows(report, |from_us| from_us) {
        let counts = counts.map(|count| format!(",{count}")).concat();
        let _ = writeln!(text, "{from_us},{}{counts}", from_us + width_us(from_us));
    }
    text
}

/// How many of a million spans are at least so long.
fn tail(spans: &Spans) -> Vec<[f64; 2]> {
    let mut left = spans.count;
    let mut points = Vec::new();
    for &(from_us, count) in &spans.buckets {
        points.push([from_us.max(1) as f64, left as f64 * 1e6 / spans.count as f64]);
        left = left.saturating_sub(count);
    }
    points
}

/// soak.json, histogram.csv, histogram.svg and histogram.png.
///
/// # Errors
/// A file that cannot be written.
pub fn files(report: &SoakReport, folder: &Folder) -> Result<()> {
    folder.write_json("soak.json", report)?;
    folder.write("histogram.csv", csv(report).as_bytes())?;
    let title = "How many ticks took at least so long";
    let mut chart =
        Chart::new(title, Axis::log10("latency [us]"), Axis::log10("ticks of a million"));
    for (name, spans) in report.histograms() {
        let style = if name.starts_with("floor") { Style::Dashed } else { Style::Line };
        if spans.count > 0 {
            chart = chart.series(&name.replace('_', " "), style, &tail(spans));
        }
    }
    chart.vertical(1000.0, "1 ms").write(folder, "histogram").map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::report;
    use super::*;
    use chaincell_host::session::timing::histogram::Latencies;

    fn filled() -> SoakReport {
        let mut latencies = Latencies::new().unwrap();
        for span_ns in [1_200, 1_900, 30_500, 31_500, 5_000_000] {
            latencies.record(span_ns);
        }
        let step = latencies.spans();
        latencies.record(7_000);
        SoakReport { step, round_trip: latencies.spans(), ..report() }
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
        let report = filled();
        for (text, separator) in [(text(&report), ' '), (csv(&report), ',')] {
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
        assert!(csv(&report).contains("\n30,31,0,1,1,0,0\n"));
        assert!(text(&report).lines().any(|row| row.trim_start().starts_with("28 ")));
    }

    #[test]
    fn the_tail_starts_with_all_of_them() {
        let points = tail(&filled().step);
        assert_eq!(points[0], [1.0, 1e6]);
        assert_eq!(points.last().unwrap()[1], 2e5);
        assert!(points.is_sorted_by(|one, two| one[0] < two[0] && one[1] > two[1]));
    }
}
