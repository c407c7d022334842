//! A limit of the stress after von Mises: which nodes were above it, and where the stress was largest.

use chaincell_client::stress::NodeStress;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Keeps watch over the stresses that are given to it.
#[derive(Debug)]
pub struct StressLimit {
    report: StressReport,
    /// For each node, whether it was above the limit.
    above: Vec<bool>,
}

/// The report of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StressReport {
    /// The limit of the stress after von Mises \[Pa\].
    pub limit_pa: f32,
    /// Largest stress after von Mises \[Pa\].
    pub largest_von_mises_pa: f32,
    /// Input id of the node that had it.
    pub node: u32,
    /// The tick in which it had it.
    pub tick: u64,
    /// Number of nodes that were above the limit.
    pub nodes_above: u32,
}

impl StressLimit {
    /// A limit for a body with this number of nodes.
    ///
    /// # Errors
    /// A limit that is no stress.
    pub fn new(limit_pa: f32, nodes: usize) -> Result<Self> {
        if !(limit_pa.is_finite() && limit_pa > 0.0) {
            return Err(Error::input(format!(
                "--stress-limit-pa {limit_pa}: must be above 0, for instance 5000"
            )));
        }
        let none =
            StressReport { limit_pa, largest_von_mises_pa: 0.0, node: 0, tick: 0, nodes_above: 0 };
        Ok(Self { report: none, above: vec![false; nodes] })
    }

    /// Takes the stresses of all nodes after a tick; where none was above the limit before, a sentence on the most
    /// stressed of those that are. Allocates nothing but that.
    pub fn take(&mut self, rows: &[NodeStress], tick: u64) -> Option<String> {
        let had_none = self.report.nodes_above == 0;
        let mut met: Option<NodeStress> = None;
        for (row, was_above) in rows.iter().zip(&mut self.above) {
            if row.von_mises_pa > self.report.largest_von_mises_pa {
                self.report.largest_von_mises_pa = row.von_mises_pa;
                (self.report.node, self.report.tick) = (row.node, tick);
            }
            if row.von_mises_pa > self.report.limit_pa && !*was_above {
                *was_above = true;
                self.report.nodes_above += 1;
                met = met.filter(|met| met.von_mises_pa >= row.von_mises_pa).or(Some(*row));
            }
        }
        met.filter(|_| had_none).map(|of| self.warning(&of, tick))
    }

    /// The sentence for the first node above the limit.
    fn warning(&self, first: &NodeStress, tick: u64) -> String {
        format!(
            "tick {tick}: the stress after von Mises at node {} is {:.0} Pa, above --stress-limit-pa {}",
            first.node, first.von_mises_pa, self.report.limit_pa
        )
    }

    /// The report so far.
    #[must_use]
    pub fn report(&self) -> StressReport {
        self.report
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_node_above_is_told_once_and_each_is_counted_once() {
        let mut limit = StressLimit::new(100.0, 4).unwrap();
        let row = |node, von_mises_pa| NodeStress { node, von_mises_pa, ..NodeStress::default() };
        assert_eq!(limit.take(&[row(10, 40.0), row(11, 100.0)], 3), None);
        let warning = limit.take(&[row(10, 90.0), row(11, 101.0)], 4).unwrap();
        assert!(warning.contains("tick 4: the stress after von Mises at node 11 is 101 Pa"));
        assert_eq!(limit.take(&[row(10, 300.0), row(11, 5.0)], 5), None);
        assert_eq!(limit.take(&[row(10, 200.0), row(11, f32::NAN)], 6), None);
        let report = limit.report();
        assert_eq!((report.nodes_above, report.node, report.tick), (2, 10, 5));
        assert_eq!(report.largest_von_mises_pa, 300.0);
    }

    #[test]
    fn a_limit_that_is_none_is_refused() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let why = StressLimit::new(bad, 1).unwrap_err().to_string();
            assert!(why.contains("--stress-limit-pa") && why.contains("above 0"), "{why}");
        }
    }
}
