//! Quantities that may differ by node.

use crate::mesh::Refined;

/// A quantity of every link: one value, or one per input node, averaged over a link's ends.
#[derive(Debug, Clone, PartialEq)]
pub enum PerCell {
    /// One value everywhere; nothing is stored per link.
    Uniform(f64),
    /// One value per input node.
    Each(Vec<f64>),
}

impl PerCell {
    /// The same quantity on a mesh that was cut once: a middle has the mean of its edge.
    pub(super) fn refined(&self, refined: &Refined) -> Self {
        match self {
            Self::Uniform(value) => Self::Uniform(*value),
            Self::Each(values) => {
                let middles = refined.edges.iter().map(|&edge| self.of_link(edge));
                Self::Each(values.iter().copied().chain(middles).collect())
            }
        }
    }

    pub(super) fn of_node(&self, node: u32) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::Each(values) => values.get(node as usize).copied().unwrap_or(f64::NAN),
        }
    }

    pub(super) fn of_link(&self, [i, j]: [u32; 2]) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::Each(_) => 0.5 * (self.of_node(i) + self.of_node(j)),
        }
    }
}
