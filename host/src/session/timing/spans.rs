//! Latency histograms with buckets of one microsecond, like those of `cyclictest`.

use serde::{Deserialize, Serialize};

/// Buckets are wider from here on: 16 per doubling \[us\].
const FINE_US: u64 = 1024;
/// Base-2 logarithm of the number of wider buckets per doubling.
const PER_DOUBLING_LOG2: u32 = 4;

/// Returns the lower bound of the bucket of a span \[us\]. Buckets are 1 us wide below 1,024 us, and at most
/// 6 % of their lower bound beyond.
#[must_use]
pub fn bucket_from_us(span_ns: u64) -> u64 {
    let span_us = span_ns / 1000;
    let width = width_us(span_us);
    span_us / width * width
}

/// Returns the width of the bucket that contains a span \[us\].
#[must_use]
pub fn width_us(span_us: u64) -> u64 {
    if span_us < FINE_US { 1 } else { 1 << (span_us.ilog2() - PER_DOUBLING_LOG2) }
}

/// Spans of one kind: their number, extremes, mean, and the buckets that are not empty.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spans {
    /// The longest \[ns\].
    pub max_ns: u64,
    /// The mean, to three significant digits \[ns\].
    pub mean_ns: u64,
    /// The shortest, to three significant digits \[ns\].
    pub min_ns: u64,
    /// Number of spans.
    pub count: u64,
    /// Lower bound \[us\] and count of each bucket that is not empty, ascending; see [`bucket_from_us`].
    pub buckets: Vec<(u64, u64)>,
}

impl Spans {
    /// Adds `count` spans; their bucket must not be below the last one.
    pub(crate) fn push(&mut self, span_ns: u64, count: u64) {
        let from_us = bucket_from_us(span_ns);
        match self.buckets.last_mut() {
            Some((last_us, held)) if *last_us == from_us => *held += count,
            _ => self.buckets.push((from_us, count)),
        }
        self.count += count;
    }

    /// Returns the spans of both.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let count = self.count + other.count;
        let mean = |spans: &Self| u128::from(spans.mean_ns) * u128::from(spans.count);
        let mean_ns = (mean(self) + mean(other)) / u128::from(count.max(1));
        let shortest = [self, other].into_iter().filter(|spans| spans.count > 0);
        let mut buckets = std::collections::BTreeMap::new();
        for &(from_us, held) in self.buckets.iter().chain(&other.buckets) {
            *buckets.entry(from_us).or_insert(0) += held;
        }
        Self {
            max_ns: self.max_ns.max(other.max_ns),
            mean_ns: u64::try_from(mean_ns).unwrap_or(u64::MAX),
            min_ns: shortest.map(|spans| spans.min_ns).min().unwrap_or(0),
            count,
            buckets: buckets.into_iter().collect(),
        }
    }

    /// Returns the number of spans in the bucket with this lower bound \[us\].
    #[must_use]
    pub fn at_us(&self, from_us: u64) -> u64 {
        let found = self.buckets.binary_search_by_key(&from_us, |bucket| bucket.0);
        found.ok().and_then(|at| self.buckets.get(at)).map_or(0, |bucket| bucket.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::timing::histogram::Latencies;

    #[test]
    fn buckets_are_a_microsecond_wide_and_later_a_sixteenth_of_a_doubling() {
        let bounds = [(0, 0), (999, 0), (1000, 1), (1_023_999, 1023), (1_024_000, 1024)];
        for (span_ns, from_us) in bounds {
            assert_eq!(bucket_from_us(span_ns), from_us, "{span_ns}");
        }
        assert_eq!((bucket_from_us(1_087_999), bucket_from_us(1_088_000)), (1024, 1088));
        assert_eq!((width_us(1023), width_us(3000), width_us(1 << 20)), (1, 128, 1 << 16));
        let mut from_us = 0;
        while from_us < 60_000_000 {
            let next_us = from_us + width_us(from_us);
            assert_eq!(bucket_from_us(next_us * 1000 - 1), from_us);
            assert_eq!(bucket_from_us(next_us * 1000), next_us);
            from_us = next_us;
        }
    }

    #[test]
    fn spans_of_a_histogram_hold_all_it_recorded() {
        let mut latencies = Latencies::new().unwrap();
        assert_eq!(latencies.spans(), Spans::default());
        for span_ns in [1_500, 1_700, 2_000, 70_000_000] {
            latencies.record(span_ns);
        }
        let spans = latencies.spans();
        assert_eq!((spans.count, spans.max_ns), (4, 70_000_000));
        assert_eq!((spans.at_us(1), spans.at_us(2), spans.at_us(3)), (2, 1, 0));
        assert_eq!(spans.at_us(bucket_from_us(70_000_000)), 1);
        let both = spans.and(&Spans::default()).and(&spans);
        assert_eq!((both.count, both.at_us(1), both.min_ns), (8, 4, spans.min_ns));
        assert!(both.mean_ns.abs_diff(spans.mean_ns) <= 1);
    }
}
