//! Whose a line is: the part's, or the assembly's around it, which has nodes, elements and sets of its own
//! with numbers and names of their own.

use std::collections::HashSet;

/// Where in the file a line stands.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// In no part and no assembly: in a file without parts this is the part.
    Model,
    Part,
    Instance,
    Assembly,
}

/// The place in the file, and what of the assembly's has been read.
pub(super) struct Scope {
    place: Place,
    has_parts: bool,
    /// Name of the instance, or else of the part.
    owner: Option<String>,
    /// Numbers of the assembly's nodes, which are reference points, and of its elements.
    nodes: HashSet<u64>,
    elements: HashSet<u64>,
}

impl Scope {
    pub(super) fn new() -> Self {
        let (nodes, elements) = (HashSet::new(), HashSet::new());
        Self { place: Place::Model, has_parts: false, owner: None, nodes, elements }
    }

    /// A part begins.
    pub(super) fn part(&mut self, name: Option<String>) {
        (self.place, self.has_parts) = (Place::Part, true);
        self.owner = name.or(self.owner.take());
    }

    /// An instance begins.
    pub(super) fn instance(&mut self, name: Option<String>) {
        (self.place, self.has_parts) = (Place::Instance, true);
        self.owner = name.or(self.owner.take());
    }

    /// Another keyword may end what began.
    pub(super) fn keyword(&mut self, name: &str) {
        self.place = match name {
            "ASSEMBLY" | "END INSTANCE" => Place::Assembly,
            "END PART" | "END ASSEMBLY" => Place::Model,
            _ => return,
        };
    }

    /// Whether what stands here is the assembly's, not the part's.
    pub(super) fn is_outside(&self) -> bool {
        self.place == Place::Assembly || self.place == Place::Model && self.has_parts
    }

    /// Notes a node or an element of the assembly.
    pub(super) fn add(&mut self, of_elements: bool, number: u64) {
        if of_elements { &mut self.elements } else { &mut self.nodes }.insert(number);
    }

    /// Whether the assembly has a node or an element of this number.
    pub(super) fn has(&self, of_elements: bool, number: u64) -> bool {
        if of_elements { &self.elements } else { &self.nodes }.contains(&number)
    }

    /// The name that a set of the part has outside of it.
    pub(super) fn outside_name(&self, set: &str) -> String {
        format!("{}.{set}", self.owner.as_deref().unwrap_or("part"))
    }
}
