//! Sets of nodes and of elements. They are resolved when the whole file has been read: a set may name
//! others, and its members may come later.

use std::collections::{BTreeMap, HashMap};

use super::keyword::fields;
use super::scope::Scope;
use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};
use crate::mesh::groups::Groups;

/// A set that a keyword begins.
pub(super) struct Set {
    pub(super) name: String,
    /// True if it belongs to the assembly: the same name in the part is another set.
    pub(super) outside: bool,
}

/// Meaning of the numbers of a set.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    pub(super) of_elements: bool,
    /// True if they may be those of the assembly's nodes and elements.
    pub(super) outside: bool,
}

/// A set, and the meaning of its numbers.
pub(super) type Numbered<'a> = (&'a Set, Numbers);

/// Entries of sets in the order of the file.
#[derive(Default)]
pub(super) struct Sets {
    /// Each set with its name as first written.
    sets: Vec<Set>,
    /// Position of each set of the part, and of the assembly, by its name in upper case.
    places: [HashMap<String, usize>; 2],
    entries: Vec<Entry>,
}

struct Entry {
    set: usize,
    /// Its position in the file.
    item: usize,
    numbers: Numbers,
    what: What,
}

enum What {
    One(u64),
    /// First, last and step.
    Range(u64, u64, u64),
    Set(String),
}

impl Sets {
    /// Begins a set, which exists even without data.
    pub(super) fn begin(&mut self, set: &Set) -> usize {
        let next = self.sets.len();
        let places = &mut self.places[usize::from(set.outside)];
        let place = *places.entry(set.name.to_ascii_uppercase()).or_insert(next);
        if place == next {
            self.sets.push(Set { name: set.name.clone(), outside: set.outside });
        }
        place
    }

    fn push(&mut self, bytes: &Bytes, (set, numbers): Numbered, what: What) {
        let set = self.begin(set);
        self.entries.push(Entry { set, item: bytes.item(), numbers, what });
    }

    /// Adds a node, or the nodes of an element.
    pub(super) fn add(&mut self, set: &Set, of_elements: bool, number: u64, bytes: &Bytes) {
        let numbers = Numbers { of_elements, outside: set.outside };
        self.push(bytes, (set, numbers), What::One(number));
    }

    /// Adds the nodes of another set.
    pub(super) fn copy(&mut self, bytes: &Bytes, of: Numbered, other: &str) {
        self.push(bytes, of, What::Set(other.into()));
    }

    /// Reads a data line of a set: numbers and names of sets.
    pub(super) fn line(
        &mut self,
        bytes: &Bytes,
        (set, numbers): Numbered,
        line: &str,
    ) -> Result<()> {
        for word in fields(line).filter(|word| !word.is_empty()) {
            // `INSTANCE.number` belongs to the part: there is one instance.
            let (outside, number) = match word.rsplit_once('.') {
                Some((_, number)) => (false, number),
                None => (numbers.outside, word),
            };
            let (numbers, what) = match number.parse() {
                Ok(number) => (Numbers { outside, ..numbers }, What::One(number)),
                Err(_) => (numbers, What::Set(word.trim_matches('"').into())),
            };
            self.push(bytes, (set, numbers), what);
        }
        Ok(())
    }

    /// Reads a data line of a generated set: first, last and step.
    pub(super) fn range(&mut self, bytes: &Bytes, of: Numbered, line: &str) -> Result<()> {
        let mut range = [0, 0, 1];
        let mut given = 0;
        for word in fields(line).filter(|word| !word.is_empty()) {
            let Some(number) = range.get_mut(given) else { break };
            *number = bytes.whole_of(word, "a number of a generated set")?;
            given += 1;
        }
        let [first, last, step] = range;
        if given < 2 || last < first || step == 0 {
            return Err(bytes.error(format!(
                "'{}' generates no set; give first, last, step: save the mesh again",
                shown(line)
            )));
        }
        self.push(bytes, of, What::Range(first, last, step));
        Ok(())
    }

    /// Returns the nodes of every set; `nodes` and `elements` return those of a number of the part.
    pub(super) fn groups<'a>(
        &self,
        bytes: &mut Bytes,
        scope: &Scope,
        nodes: impl Fn(u64) -> Option<&'a [u32]>,
        elements: impl Fn(u64) -> Option<&'a [u32]>,
    ) -> Result<BTreeMap<String, Vec<u32>>> {
        // Add the members of each entry; numbers of the assembly are left out.
        let mut members: Vec<Members> = self.sets.iter().map(|_| Members::default()).collect();
        for entry in &self.entries {
            bytes.return_to(entry.item);
            let Numbers { of_elements, outside } = entry.numbers;
            let own = &mut members[entry.set];
            let mut add = |number: u64, set: &str| -> Result<()> {
                if outside && scope.has(of_elements, number) {
                    own.left_out = true;
                    return Ok(());
                }
                let ids = if of_elements { elements(number) } else { nodes(number) };
                let kind = if of_elements { "element" } else { "node" };
                own.add(ids.ok_or_else(|| {
                    bytes.error(format!(
                        "the {set} refers to {kind} {number}, which the file does not have; save the \
                         mesh again"
                    ))
                })?);
                Ok(())
            };
            // A number, a range, or the members of a set before this one.
            match &entry.what {
                What::One(number) => add(*number, "set")?,
                What::Range(first, last, step) => {
                    let mut next = Some(*first);
                    while let Some(number) = next.filter(|number| number <= last) {
                        add(number, "generated set")?;
                        next = number.checked_add(*step);
                    }
                }
                What::Set(name) => {
                    let other = self.find(name, outside).ok_or_else(|| {
                        bytes.error(format!(
                            "'{}' is neither a number nor a set in front; save the mesh again",
                            shown(name)
                        ))
                    })?;
                    let (ids, left_out) = (members[other].ids.clone(), members[other].left_out);
                    members[entry.set].add(&ids);
                    members[entry.set].left_out |= left_out;
                }
            }
        }
        Ok(self.named(scope, &members))
    }

    /// Returns the set of a name: that of the assembly first if the name may refer to it.
    fn find(&self, name: &str, outside: bool) -> Option<usize> {
        let (instance, bare) = name.rsplit_once('.').map_or((None, name), |(a, b)| (Some(a), b));
        let [of_part, of_assembly] =
            [0, 1].map(|place: usize| self.places[place].get(&bare.to_ascii_uppercase()).copied());
        if outside && instance.is_none() {
            of_assembly.or(of_part)
        } else {
            of_part.or(of_assembly)
        }
    }

    /// Returns the groups by name. A set that has only reference points is none; a set of the part whose
    /// name the assembly has too gets the instance's name in front.
    fn named(&self, scope: &Scope, members: &[Members]) -> BTreeMap<String, Vec<u32>> {
        let is_there = |of: &Members| !(of.left_out && of.ids.is_empty());
        let mut groups = Groups::default();
        for (set, own) in self.sets.iter().zip(members).filter(|(_, own)| is_there(own)) {
            let twin = self.places[1].get(&set.name.to_ascii_uppercase());
            let has_twin = !set.outside && twin.is_some_and(|twin| is_there(&members[*twin]));
            let name = if has_twin { scope.outside_name(&set.name) } else { set.name.clone() };
            groups.add(name, own.ids.iter().copied());
        }
        groups.finish()
    }
}

/// Nodes of a set; repetitions are dropped from time to time, so that sets of sets stay small.
#[derive(Default)]
struct Members {
    ids: Vec<u32>,
    /// Their number when repetitions were dropped last.
    unique: usize,
    /// True if it had a reference point, or an element of the assembly.
    left_out: bool,
}

impl Members {
    fn add(&mut self, ids: &[u32]) {
        self.ids.extend(ids);
        if self.ids.len() > 2 * self.unique + 1024 {
            self.ids.sort_unstable();
            self.ids.dedup();
            self.unique = self.ids.len();
        }
    }
}
