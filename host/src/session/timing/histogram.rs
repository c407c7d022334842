//! Latencies: recorded without allocation, reported as percentiles.

use std::time::Instant;

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::session::timing::spans::Spans;

/// Upper bound of the histogram \[ns\]: longer spans count as this long, except in the maximum.
const LONGEST_NS: u64 = 60_000_000_000;
/// Significant decimal digits of a percentile.
const DIGITS: u8 = 3;

/// A set of spans in nanoseconds, in memory of fixed size.
#[derive(Debug, Clone)]
pub struct Latencies {
    spans: Histogram<u64>,
    max_ns: u64,
}

/// Percentiles of the spans \[ns\]; all are 0 if nothing was recorded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Summary {
    /// Median.
    pub p50: u64,
    /// 99 % are at most this long.
    pub p99: u64,
    /// 99.9 % are at most this long.
    pub p999: u64,
    /// 99.99 % are at most this long.
    pub p9999: u64,
    /// The longest.
    pub max: u64,
}

impl Summary {
    /// Returns the percentiles in one line \[us\].
    #[must_use]
    pub fn in_us(&self) -> String {
        let us = |ns: u64| ns as f64 * 1e-3;
        format!(
            "p50 {:8.1}  p99 {:8.1}  p99.9 {:8.1}  p99.99 {:8.1}  max {:8.1} us",
            us(self.p50),
            us(self.p99),
            us(self.p999),
            us(self.p9999),
            us(self.max)
        )
    }
}

impl Latencies {
    /// Creates an empty set, and allocates all the memory that it needs.
    pub fn new() -> Result<Self> {
        let spans = Histogram::new_with_bounds(1, LONGEST_NS, DIGITS)
            .map_err(|why| Error::check(format!("cannot set up a latency histogram: {why}")))?;
        Ok(Self { spans, max_ns: 0 })
    }

    /// Records a span. Does not allocate.
    pub fn record(&mut self, span_ns: u64) {
        self.spans.saturating_record(span_ns);
        self.max_ns = self.max_ns.max(span_ns);
    }

    /// Runs `work` and records its duration.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = work();
        self.record(start.elapsed().as_nanos() as u64);
        done
    }

    /// Number of spans recorded.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.spans.len()
    }

    /// Returns the spans in buckets, to three significant digits. Allocates, so call it at the end of a run.
    #[must_use]
    pub fn spans(&self) -> Spans {
        if self.spans.is_empty() {
            return Spans::default();
        }
        let mut spans = Spans {
            max_ns: self.max_ns,
            mean_ns: self.spans.mean() as u64,
            min_ns: self.spans.min(),
            ..Spans::default()
        };
        for value in self.spans.iter_recorded() {
            let span_ns = self.spans.lowest_equivalent(value.value_iterated_to());
            spans.push(span_ns, value.count_at_value());
        }
        spans
    }

    /// Returns the quantile of `share`, 0 to 1, to three significant digits.
    #[must_use]
    pub fn at(&self, share: f64) -> u64 {
        self.spans.value_at_quantile(share).min(self.max_ns)
    }

    /// Returns the percentiles, to three significant digits; the maximum is exact.
    #[must_use]
    pub fn summary(&self) -> Summary {
        Summary {
            p50: self.at(0.5),
            p99: self.at(0.99),
            p999: self.at(0.999),
            p9999: self.at(0.9999),
            max: self.max_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_ramp() {
        let mut latencies = Latencies::new().unwrap();
        assert_eq!(latencies.summary(), Summary::default());
        for span_ns in 1..=100_000 {
            latencies.record(span_ns);
        }
        let summary = latencies.summary();
        for (found, wanted) in [
            (summary.p50, 50_000_u64),
            (summary.p99, 99_000),
            (summary.p999, 99_900),
            (summary.p9999, 99_990),
        ] {
            assert!(found.abs_diff(wanted) * 1000 <= wanted, "{found} {wanted}");
        }
        assert_eq!(summary.max, 100_000);
        assert_eq!(latencies.count(), 100_000);
    }

    #[test]
    fn a_span_beyond_the_bounds_is_kept_as_the_maximum() {
        let mut latencies = Latencies::new().unwrap();
        latencies.record(0);
        latencies.record(u64::MAX);
        assert_eq!(latencies.count(), 2);
        assert_eq!(latencies.summary().max, u64::MAX);
    }
}
