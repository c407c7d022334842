//! The last round trips, and if too many of them are too long.

/// Round trips in a window: four seconds at 1 kHz.
pub const WINDOW: usize = 4000;
/// Round trips after which they are judged: a second at 1 kHz.
pub const FIRST: usize = 1000;

/// The round trips of a window.
///
/// ```
/// use chaincell_lan::trips::{FIRST, Trips};
///
/// let mut trips = Trips::new(6_000_000); // [ns]
/// for _ in 1..FIRST {
///     trips.push(400_000);
/// }
/// trips.push(7_000_000); // one in a thousand may be longer
/// assert!(trips.is_known() && !trips.is_slow());
/// trips.push(7_000_000);
/// assert!(trips.is_slow());
/// assert_eq!(trips.quantile_ns(999), 7_000_000);
/// ```
#[derive(Debug, Clone)]
pub struct Trips {
    limit_ns: u64,
    each_ns: Vec<u64>,
    /// Place of the oldest in a full window.
    oldest: usize,
    above: usize,
}

impl Trips {
    /// Starts without a round trip. Allocates the whole window.
    #[must_use]
    pub fn new(limit_ns: u64) -> Self {
        Self { limit_ns, each_ns: Vec::with_capacity(WINDOW), oldest: 0, above: 0 }
    }

    /// Takes a round trip; in a full window it replaces the oldest.
    pub fn push(&mut self, trip_ns: u64) {
        self.above += usize::from(trip_ns > self.limit_ns);
        if self.each_ns.len() < WINDOW {
            self.each_ns.push(trip_ns);
            return;
        }
        let before_ns = std::mem::replace(&mut self.each_ns[self.oldest], trip_ns);
        self.above -= usize::from(before_ns > self.limit_ns);
        self.oldest = (self.oldest + 1) % WINDOW;
    }

    /// Returns true if there are enough round trips to judge them.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.each_ns.len() >= FIRST
    }

    /// Returns true if more than one in a thousand is above the limit; of fewer than a thousand, if two are.
    #[must_use]
    pub fn is_slow(&self) -> bool {
        1000 * self.above > self.each_ns.len().max(FIRST)
    }

    /// Returns the round trip that this many in a thousand do not exceed, 0 without any \[ns\]. Sorts a copy.
    #[must_use]
    pub fn quantile_ns(&self, of_1000: usize) -> u64 {
        let mut sorted = self.each_ns.clone();
        sorted.sort_unstable();
        quantile_ns(&sorted, of_1000)
    }
}

/// Returns the value that this many in a thousand of sorted ones do not exceed, 0 without any \[ns\].
#[must_use]
pub fn quantile_ns(sorted_ns: &[u64], of_1000: usize) -> u64 {
    let at = (sorted_ns.len() * of_1000).div_ceil(1000).max(1) - 1;
    sorted_ns.get(at).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT_NS: u64 = 6_000_000;

    #[test]
    fn the_verdict_is_that_of_the_quantile_at_every_moment() {
        let mut trips = Trips::new(LIMIT_NS);
        let mut all = Vec::new();
        for at in 0..3 * WINDOW {
            // Bursts of long ones, then none for more than a window.
            let trip_ns =
                if at % 1700 == 3 || (5000..5004).contains(&at) { LIMIT_NS + 1 } else { LIMIT_NS };
            trips.push(trip_ns);
            all.push(trip_ns);
            let mut window = all[all.len().saturating_sub(WINDOW)..].to_vec();
            window.sort_unstable();
            assert_eq!(trips.is_known(), all.len() >= FIRST);
            // Around each change, and now and then between.
            if trips.is_known() && (at % 97 == 0 || at % 1700 < 6 || at % 1000 < 6) {
                assert_eq!(trips.is_slow(), quantile_ns(&window, 999) > LIMIT_NS, "{at}");
            }
        }
    }

    #[test]
    fn two_long_ones_refuse_before_a_thousand_are_known() {
        let mut trips = Trips::new(LIMIT_NS);
        assert_eq!((trips.quantile_ns(999), trips.is_slow()), (0, false));
        trips.push(LIMIT_NS + 1);
        assert!(!trips.is_slow());
        trips.push(LIMIT_NS + 1);
        assert!(trips.is_slow() && !trips.is_known());
    }
}
