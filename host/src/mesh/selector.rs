//! SELECTOR: a set of nodes described in text, for `--fix` and contacts.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Result};
use crate::text;

/// Largest file of ids, in bytes.
const FILE_BYTES_MAX: u64 = 64 << 20;

/// The grammar, for error texts.
const FORMS: &str = "nodes:0,5,7 or 0,5,7, file:PATH, file:PATH#KEY, box:x0,x1,y0,y1,z0,z1, \
                     group:NAME or border";

/// Returns the nodes that `text` selects, sorted and unique, at least one.
///
/// `nodes:0,5,7` or bare ids; `file:PATH`, ids between white space or commas, or a JSON array;
/// `file:PATH#KEY`, an array inside a JSON object; `box:x0,x1,y0,y1,z0,z1`, bounds in metres,
/// inclusive; `group:NAME`; `border`. `nodes_m` is `[node][axis]` in metres; nodes without a link
/// can be selected too. `option` names the option in errors.
pub fn select(
    text: &str,
    nodes_m: &[[f64; 3]],
    groups: &BTreeMap<String, Vec<u32>>,
    border: &[u32],
    option: &str,
) -> Result<Vec<u32>> {
    let places = (0u32..).zip(nodes_m.iter().copied());
    select_among(text, (nodes_m.len(), places), groups, border, &format!("{option} {text}"))
}

/// As [`select`] if only some node numbers have a position: takes the count of numbers, and the nodes
/// with their positions \[m\]. There may be far more numbers than positions. Errors begin with `given`, the
/// option with its whole value.
pub fn select_among(
    text: &str,
    (nodes, places): (usize, impl Iterator<Item = (u32, [f64; 3])>),
    groups: &BTreeMap<String, Vec<u32>>,
    border: &[u32],
    given: &str,
) -> Result<Vec<u32>> {
    let selector = Selector { given, nodes };
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let picked = match (kind, rest) {
        ("border", "") if border.is_empty() => {
            return Err(selector.refuse("only a plane has a border; take box: or group:"));
        }
        ("border", "") => border.to_vec(),
        ("nodes", list) => selector.listed(list)?,
        ("file", path) => selector.file(path)?,
        ("box", bounds) => return selector.boxed(bounds, places),
        ("group", name) => selector.group(name, groups)?,
        (list, "") if list.trim().starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
            selector.listed(list)?
        }
        _ => return Err(selector.refuse(format!("unknown selector; give {FORMS}"))),
    };
    if picked.is_empty() {
        return Err(selector.refuse("it selects no node; give at least one"));
    }
    Ok(picked)
}

/// Context for error messages.
struct Selector<'a> {
    given: &'a str,
    nodes: usize,
}

impl Selector<'_> {
    fn refuse(&self, why: impl std::fmt::Display) -> Error {
        Error::input(format!("{}: {why}", self.given))
    }

    fn wrong(&self, place: Option<&str>, token: &str) -> Error {
        let place = place.map_or_else(String::new, |place| format!("{place}: "));
        self.refuse(format!(
            "{place}'{token}' is no node; ids are whole numbers from 0 to {}",
            self.nodes as i128 - 1
        ))
    }

    fn id(&self, place: Option<&str>, token: &str) -> Result<u32> {
        let digits = !token.is_empty() && token.bytes().all(|b| b.is_ascii_digit());
        match token.parse::<u32>() {
            Ok(id) if digits && (id as usize) < self.nodes => Ok(id),
            _ => Err(self.wrong(place, token)),
        }
    }

    /// Sorts ids and refuses one that is given twice.
    fn once(&self, mut ids: Vec<u32>) -> Result<Vec<u32>> {
        ids.sort_unstable();
        match ids.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => {
                Err(self.refuse(format!("node {} is given twice; give it once", pair[0])))
            }
            None => Ok(ids),
        }
    }

    fn listed(&self, list: &str) -> Result<Vec<u32>> {
        let ids = list.split(',').map(|token| self.id(None, token.trim()));
        self.once(ids.collect::<Result<_>>()?)
    }

    fn boxed(
        &self,
        bounds: &str,
        places: impl Iterator<Item = (u32, [f64; 3])>,
    ) -> Result<Vec<u32>> {
        const NAMES: [&str; 6] = ["x0", "x1", "y0", "y1", "z0", "z1"];
        let words: Vec<&str> = bounds.split(',').map(str::trim).collect();
        if words.len() != NAMES.len() {
            return Err(self.refuse(format!(
                "a box has six bounds in metres, x0,x1,y0,y1,z0,z1; there are {}",
                words.len()
            )));
        }
        let mut bound = [0.0; 6];
        for ((value, word), name) in bound.iter_mut().zip(words).zip(NAMES) {
            *value = word.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
                self.refuse(format!("{name} is '{word}'; give a finite number of metres"))
            })?;
        }
        for axis in 0..3 {
            let (low, high) = (2 * axis, 2 * axis + 1);
            if bound[low] > bound[high] {
                let (low, high) = (NAMES[low], NAMES[high]);
                return Err(self.refuse(format!("{low} is above {high}; exchange them")));
            }
        }
        let inside =
            |at: &[f64; 3]| (0..3).all(|a| (bound[2 * a]..=bound[2 * a + 1]).contains(&at[a]));
        let (mut ids, mut low, mut high) = (Vec::new(), [f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (id, at) in places {
            ids.extend(inside(&at).then_some(id));
            low = std::array::from_fn(|axis| low[axis].min(at[axis]));
            high = std::array::from_fn(|axis| high[axis].max(at[axis]));
        }
        if ids.is_empty() {
            let extent = [0, 1, 2].map(|axis| format!("{:.4},{:.4}", low[axis], high[axis]));
            return Err(self.refuse(format!(
                "it selects no node; all nodes are in box:{}, in metres: take a box that reaches into it",
                extent.join(",")
            )));
        }
        ids.sort_unstable();
        Ok(ids)
    }

    /// Returns the nodes of a group, or of several separated by commas.
    fn group(&self, names: &str, groups: &BTreeMap<String, Vec<u32>>) -> Result<Vec<u32>> {
        if let Some(ids) = groups.get(names) {
            return Ok(ids.clone());
        }
        let mut all = Vec::new();
        for name in names.split(',') {
            all.extend(groups.get(name).ok_or_else(|| {
                let known: Vec<&str> = groups.keys().map(String::as_str).collect();
                let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                self.refuse(format!("the mesh has no group '{name}'; its groups: {known}"))
            })?);
        }
        all.sort_unstable();
        all.dedup();
        Ok(all)
    }

    fn file(&self, path: &str) -> Result<Vec<u32>> {
        // A path may contain a #.
        let (path, key) = match path.rsplit_once('#') {
            Some((file, key)) if !Path::new(path).exists() => (file, Some(key)),
            _ => (path, None),
        };
        let text = self.content(path)?;
        if key.is_none() && !text.trim_start().starts_with(['[', '{']) {
            let mut ids = Vec::new();
            for (number, line) in (1..).zip(text.lines()) {
                let words = line.split(|c: char| c.is_whitespace() || c == ',');
                for word in words.filter(|word| !word.is_empty()) {
                    ids.push(self.id(Some(&format!("{path}:{number}")), word)?);
                }
            }
            return self.once(ids);
        }
        let json: Value = serde_json::from_str(&text)
            .map_err(|why| self.refuse(format!("{path}: no valid JSON: {why}; mend it")))?;
        self.array(path, key, &json)
    }

    fn content(&self, path: &str) -> Result<String> {
        text::read(Path::new(path), FILE_BYTES_MAX)
            .map_err(|why| self.refuse(format!("cannot read {path}: {why}")))
    }

    fn array(&self, path: &str, key: Option<&str>, json: &Value) -> Result<Vec<u32>> {
        let (place, value) = match (json, key) {
            (Value::Array(_), None) => (path.to_string(), json),
            (Value::Object(map), Some(key)) if map.contains_key(key) => {
                (format!("{path}#{key}"), &map[key])
            }
            (Value::Object(map), _) => {
                let keys: Vec<&str> = map.keys().map(String::as_str).collect();
                let keys = keys.join(", ");
                return Err(match key {
                    Some(key) => {
                        self.refuse(format!("{path} has no key '{key}'; its keys: {keys}"))
                    }
                    None => self.refuse(format!("{path} is an object; add #KEY, one of: {keys}")),
                });
            }
            _ => return Err(self.refuse(format!("{path} is no JSON object; leave #KEY out"))),
        };
        let Value::Array(items) = value else {
            return Err(
                self.refuse(format!("{place} is no array; give nodes:ID for a single node"))
            );
        };
        let ids = (0..).zip(items).map(|(at, item): (usize, &Value)| {
            self.id(Some(&format!("{place}, item {at}")), &item.to_string())
        });
        self.once(ids.collect::<Result<_>>()?)
    }
}
