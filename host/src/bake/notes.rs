//! Data of the mesh that a model keeps for selectors: node groups and the border.

use std::collections::BTreeMap;

use chaincell_kernel::Model;
use serde::{Deserialize, Serialize};

use crate::mesh::Mesh;

/// Groups of input ids, kept in the image as JSON.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// Input ids of each named group.
    pub groups: BTreeMap<String, Vec<u32>>,
    /// Input ids of a plane's border.
    pub border: Vec<u32>,
}

impl Notes {
    pub(super) fn of(mesh: &Mesh) -> Self {
        Self { groups: mesh.groups.clone(), border: mesh.border.clone() }
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }

    /// Returns the notes of a model; empty if it has none.
    #[must_use]
    pub fn read(model: &Model<'_>) -> Self {
        serde_json::from_slice(model.notes()).unwrap_or_default()
    }
}
