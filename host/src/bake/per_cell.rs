//! Quantities that may differ by node.

/// A quantity of every link: one value, or one per input node, averaged over a link's ends.
#[derive(Debug, Clone, PartialEq)]
pub enum PerCell {
    /// One value everywhere; nothing is stored per link.
    Uniform(f64),
    /// One value per input node.
    Each(Vec<f64>),
}

impl PerCell {
    pub(super) fn of_link(&self, [i, j]: [u32; 2]) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::Each(values) => {
                let at = |node: u32| values.get(node as usize).copied().unwrap_or(f64::NAN);
                0.5 * (at(i) + at(j))
            }
        }
    }
}
