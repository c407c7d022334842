//! The owner of a line: the part, or the assembly around it, which has separate nodes, elements and sets
//! with separate numbers and names.

use std::collections::HashSet;

/// Block of the file that a line is in.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// Neither in a part nor in an assembly: in a file without parts this is the part.
    Model,
    Part,
    Instance,
    Assembly,
}

/// The block of the current line, and the assembly's nodes and elements read so far.
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

    /// Begins a part.
    pub(super) fn part(&mut self, name: Option<String>) {
        (self.place, self.has_parts) = (Place::Part, true);
        self.owner = name.or(self.owner.take());
    }

    /// Begins an instance.
    pub(super) fn instance(&mut self, name: Option<String>) {
        (self.place, self.has_parts) = (Place::Instance, true);
        self.owner = name.or(self.owner.take());
    }

    /// Notes another keyword, which may end the block or begin the assembly.
    pub(super) fn keyword(&mut self, name: &str) {
        self.place = match name {
            "ASSEMBLY" | "END INSTANCE" => Place::Assembly,
            "END PART" | "END ASSEMBLY" => Place::Model,
            _ => return,
        };
    }

    /// Returns true if the current line belongs to the assembly, not to the part.
    pub(super) fn is_outside(&self) -> bool {
        self.place == Place::Assembly || self.place == Place::Model && self.has_parts
    }

    /// Notes a node or an element of the assembly.
    pub(super) fn add(&mut self, of_elements: bool, number: u64) {
        if of_elements { &mut self.elements } else { &mut self.nodes }.insert(number);
    }

    /// Returns true if the assembly has a node or an element of this number.
    pub(super) fn has(&self, of_elements: bool, number: u64) -> bool {
        if of_elements { &self.elements } else { &self.nodes }.contains(&number)
    }

    /// Returns the name that a set of the part has outside of it.
    pub(super) fn outside_name(&self, set: &str) -> String {
        format!("{}.{set}", self.owner.as_deref().unwrap_or("part"))
    }
}
