//! Faults that a loop counts and continues after.

/// Counts a fault, and logs the 1st, 2nd, 4th, 8th and so on, which keeps the log short.
pub(crate) fn complain(
    count: &mut u64,
    what: impl std::fmt::Display,
    detail: impl std::fmt::Debug,
) {
    *count += 1;
    if count.is_power_of_two() {
        log::warn!("{what}: {detail:?} (time {count})");
    }
}
