//! Sets of nodes and of elements, which are resolved when the whole file is known: a set may name
//! others, and what it lists may come later.

use std::collections::{BTreeMap, HashMap};

use super::keyword::fields;
use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};
use crate::mesh::groups::Groups;

/// What the file says of sets, in its order.
#[derive(Default)]
pub(super) struct Sets {
    /// Name of each set as it is first written.
    names: Vec<String>,
    /// Position of a name in upper case.
    places: HashMap<String, usize>,
    entries: Vec<Entry>,
}

struct Entry {
    set: usize,
    /// Where it stands in the file.
    item: usize,
    of_elements: bool,
    what: What,
}

enum What {
    One(u64),
    /// First, last and step.
    Range(u64, u64, u64),
    Set(String),
}

impl Sets {
    /// A set begins: it is there, even without data.
    pub(super) fn begin(&mut self, name: &str) -> usize {
        let next = self.names.len();
        let place = *self.places.entry(name.to_ascii_uppercase()).or_insert(next);
        if place == next {
            self.names.push(name.to_string());
        }
        place
    }

    fn push(&mut self, name: &str, bytes: &Bytes, of_elements: bool, what: What) {
        let set = self.begin(name);
        self.entries.push(Entry { set, item: bytes.item(), of_elements, what });
    }

    /// Adds a node.
    pub(super) fn node(&mut self, name: &str, number: u64, bytes: &Bytes) {
        self.push(name, bytes, false, What::One(number));
    }

    /// Adds the nodes of an element.
    pub(super) fn element(&mut self, name: &str, number: u64, bytes: &Bytes) {
        self.push(name, bytes, true, What::One(number));
    }

    /// Adds the nodes of another set.
    pub(super) fn copy(&mut self, bytes: &Bytes, name: &str, other: &str) {
        self.push(name, bytes, true, What::Set(other.into()));
    }

    /// A data line of a set: numbers and names of sets, or first, last and step.
    pub(super) fn line<const ELEMENTS: bool>(
        &mut self,
        bytes: &Bytes,
        name: &str,
        line: &str,
        generate: bool,
    ) -> Result<()> {
        if generate {
            let mut numbers = [0, 0, 1];
            let mut given = 0;
            for word in fields(line).filter(|word| !word.is_empty()) {
                let Some(number) = numbers.get_mut(given) else { break };
                *number = bytes.whole_of(word, "a number of a generated set")?;
                given += 1;
            }
            let [first, last, step] = numbers;
            if given < 2 || last < first || step == 0 {
                return Err(bytes.error(format!(
                    "'{}' generates no set; give first, last, step: save the mesh again",
                    shown(line)
                )));
            }
            self.push(name, bytes, ELEMENTS, What::Range(first, last, step));
            return Ok(());
        }
        for word in fields(line).filter(|word| !word.is_empty()) {
            // Of `INSTANCE.number` the number: there is one instance.
            let number = word.rsplit('.').next().unwrap_or(word);
            let what = match number.parse() {
                Ok(number) => What::One(number),
                Err(_) => What::Set(word.trim_matches('"').into()),
            };
            self.push(name, bytes, ELEMENTS, what);
        }
        Ok(())
    }

    /// The nodes of every set; `nodes` and `elements` give those of a number.
    pub(super) fn groups<'a>(
        &self,
        bytes: &mut Bytes,
        nodes: impl Fn(u64) -> Option<&'a [u32]>,
        elements: impl Fn(u64) -> Option<&'a [u32]>,
    ) -> Result<BTreeMap<String, Vec<u32>>> {
        let mut members: Vec<Members> = self.names.iter().map(|_| Members::default()).collect();
        for entry in &self.entries {
            bytes.return_to(entry.item);
            let of = |number: u64| if entry.of_elements { elements(number) } else { nodes(number) };
            let kind = if entry.of_elements { "element" } else { "node" };
            match &entry.what {
                What::One(number) => {
                    let ids = of(*number).ok_or_else(|| {
                        bytes.error(format!(
                            "the set refers to {kind} {number}, which the file does not have; save the \
                             mesh again"
                        ))
                    })?;
                    members[entry.set].add(ids);
                }
                What::Range(first, last, step) => {
                    let mut number = *first;
                    while number <= *last {
                        let Some(ids) = of(number) else {
                            return Err(bytes.error(format!(
                                "the generated set refers to {kind} {number}, which the file does not \
                                 have; save the mesh again"
                            )));
                        };
                        members[entry.set].add(ids);
                        let Some(next) = number.checked_add(*step) else { break };
                        number = next;
                    }
                }
                What::Set(name) => {
                    let bare = name.rsplit('.').next().unwrap_or(name).to_ascii_uppercase();
                    let Some(&other) = self.places.get(&bare) else {
                        return Err(bytes.error(format!(
                            "'{}' is neither a number nor a set in front; save the mesh again",
                            shown(name)
                        )));
                    };
                    let ids = members[other].0.clone();
                    members[entry.set].add(&ids);
                }
            }
        }
        let mut groups = Groups::default();
        for (name, members) in self.names.iter().zip(members) {
            groups.add(name, members.0);
        }
        Ok(groups.finish())
    }
}

/// Nodes of a set; repetitions are dropped now and then, so that sets of sets stay small.
#[derive(Default)]
struct Members(Vec<u32>, usize);

impl Members {
    fn add(&mut self, ids: &[u32]) {
        self.0.extend(ids);
        if self.0.len() > 2 * self.1 + 1024 {
            self.0.sort_unstable();
            self.0.dedup();
            self.1 = self.0.len();
        }
    }
}
