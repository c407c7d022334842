//! Groups as readers collect them: the nodes of all elements and points of the same name.

use std::collections::BTreeMap;

/// Nodes by group, with repetitions.
#[derive(Default)]
pub(super) struct Groups(BTreeMap<String, Vec<u32>>);

impl Groups {
    /// Adds nodes to a group.
    pub(super) fn add(&mut self, name: impl ToString, nodes: impl IntoIterator<Item = u32>) {
        self.0.entry(name.to_string()).or_default().extend(nodes);
    }

    /// Adds the nodes of an element to the group of its reference number; 0 is none.
    pub(super) fn of_element(&mut self, number: i64, nodes: impl IntoIterator<Item = u32>) {
        if number != 0 {
            self.add(number, nodes);
        }
    }

    /// Adds a node to the group of its own reference number, which is not the group of elements of the same
    /// number; 0 is none.
    pub(super) fn of_point(&mut self, number: i64, node: u32) {
        if number != 0 {
            self.add(format_args!("points:{number}"), [node]);
        }
    }

    /// Returns the sorted unique nodes by group.
    pub(super) fn finish(mut self) -> BTreeMap<String, Vec<u32>> {
        for nodes in self.0.values_mut() {
            nodes.sort_unstable();
            nodes.dedup();
        }
        self.0
    }
}
