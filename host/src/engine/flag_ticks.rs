//! Number of ticks on which each flag was set, by the flag's name.

use std::collections::BTreeMap;
use std::fmt;

use chaincell_kernel::Flags;
use serde::{Deserialize, Serialize};

use crate::words::counted;

/// Number of flags.
const COUNT: usize = Flags::ALL.len();

/// Counts the ticks on which each flag was set. As JSON an object with the flags that occurred and their
/// counts; as text the same in one line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "BTreeMap<String, u64>", into = "BTreeMap<String, u64>")]
pub struct FlagTicks([u64; COUNT]);

impl FlagTicks {
    /// Counts one tick's flags. Allocates nothing.
    pub fn add(&mut self, flags: Flags) {
        for (ticks, (flag, ..)) in self.0.iter_mut().zip(Flags::ALL) {
            *ticks += u64::from(flags.contains(*flag));
        }
    }

    /// Number of ticks on which a flag was set.
    #[must_use]
    pub fn of(&self, flag: Flags) -> u64 {
        self.0.iter().zip(Flags::ALL).find(|(_, all)| all.0 == flag).map_or(0, |(ticks, _)| *ticks)
    }

    /// The names of the flags that occurred, with their counts.
    fn seen(self) -> impl Iterator<Item = (String, u64)> {
        let all = Flags::ALL.iter().map(|(_, name, _)| name.to_lowercase()).zip(self.0);
        all.filter(|&(_, ticks)| ticks > 0)
    }
}

impl From<FlagTicks> for BTreeMap<String, u64> {
    fn from(flags: FlagTicks) -> Self {
        flags.seen().collect()
    }
}

impl From<BTreeMap<String, u64>> for FlagTicks {
    fn from(named: BTreeMap<String, u64>) -> Self {
        let mut flags = Self::default();
        for (ticks, (_, name, _)) in flags.0.iter_mut().zip(Flags::ALL) {
            *ticks = named.get(&name.to_lowercase()).copied().unwrap_or_default();
        }
        flags
    }
}

impl fmt::Display for FlagTicks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = self.seen().map(|(name, ticks)| format!("{name} on {}", counted(ticks, "tick")));
        let seen: Vec<String> = each.collect();
        f.write_str(if seen.is_empty() { "none" } else { "" })?;
        f.write_str(&seen.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_counted_by_name() {
        let mut flags = FlagTicks::default();
        assert_eq!(flags.to_string(), "none");
        for bits in [1, 3, 1, 0, 128] {
            flags.add(Flags(bits));
        }
        assert_eq!(
            flags.to_string(),
            "motion_clamped on 3 ticks, bad_sample on 1 tick, contact_capacity on 1 tick"
        );
        let text = serde_json::to_string(&flags).unwrap();
        assert_eq!(text, r#"{"bad_sample":1,"contact_capacity":1,"motion_clamped":3}"#);
        assert_eq!(serde_json::from_str::<FlagTicks>(&text).unwrap(), flags);
    }

    #[test]
    fn every_bit_has_one_name() {
        let named = Flags::ALL.iter().fold(0, |bits, (flag, ..)| bits + flag.0);
        assert_eq!(named, 4095);
    }
}
