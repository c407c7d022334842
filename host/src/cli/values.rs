//! A value for every node: one number, one a node from a file, or one for each group of the mesh.

use std::path::Path;

use crate::bake::PerCell;
use crate::bake::tissue::Band;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::text;

/// Largest file of values, one a node \[B\].
const BYTES_MAX: u64 = 64 << 20;

/// Reads a number, `file:PATH` (a JSON array, or numbers between white space or commas), or
/// `group:NAME=VALUE` once or more behind commas, after a number for the other nodes or without one
/// where the groups are the whole mesh.
pub fn per_cell(option: &str, text: &str, mesh: &Mesh) -> Result<PerCell> {
    if let Some(path) = text.strip_prefix("file:") {
        return file(option, Path::new(path)).map(PerCell::Each);
    }
    let mut parts = text.split(',').peekable();
    let others = parts.next_if(|part| !part.starts_with("group:"));
    let others = others.map(|part| number(option, "", part)).transpose()?;
    let mut groups = Vec::new();
    for part in parts {
        let (name, value) = part
            .strip_prefix("group:")
            .and_then(|part| part.split_once('='))
            .ok_or_else(|| Error::input(format!("{option}: `{part}`: give group:NAME=VALUE")))?;
        groups.push((name, number(option, &format!(" group:{name}"), value)?));
    }
    match others {
        Some(value) if groups.is_empty() => Ok(PerCell::Uniform(value)),
        _ => by_group(option, others, &groups, mesh).map(PerCell::Each),
    }
}

/// The options of a bake for branches, each a ratio of moduli and a time \[s\], and for bands:
/// ` --branch 2,0.1 --stiffening 0.1=10000`; empty without any.
#[must_use]
pub fn tissue_options(branches: &[[f64; 2]], is_instant: bool, bands: &[Band]) -> String {
    let mut text: String =
        branches.iter().map(|[ratio, time_s]| format!(" --branch {ratio},{time_s}")).collect();
    if is_instant {
        text += " --instant";
    }
    let bands: Vec<String> = bands.iter().map(Band::to_string).collect();
    if !bands.is_empty() {
        text += &format!(" --stiffening {}", bands.join(","));
    }
    text
}

/// The material of a group, `--material group:NAME,young-pa=E,poisson=NU,toughness-j-per-m2=J`.
#[derive(Debug, Clone, PartialEq)]
pub struct Material<'a> {
    /// The group.
    pub name: &'a str,
    /// Young's modulus \[Pa\] of its nodes, if they have one of their own.
    pub young_pa: Option<f64>,
    /// The same of Poisson's ratio.
    pub poisson: Option<f64>,
    /// The same of the energy that a cut takes for each area \[J/m^2\].
    pub toughness_j_per_m2: Option<f64>,
}

impl<'a> Material<'a> {
    /// Reads a material.
    pub fn parse(text: &'a str) -> Result<Self> {
        let wrong = |why: String| {
            Error::input(format!(
                "--material {text}: {why}; give group:NAME,young-pa=E,poisson=NU,toughness-j-per-m2=J, \
                 one of these at least"
            ))
        };
        let mut parts = text.split(',');
        let name = parts.next().and_then(|part| part.strip_prefix("group:"));
        let name = name.ok_or_else(|| wrong("it begins with group:NAME".to_owned()))?;
        let mut material = Self { name, young_pa: None, poisson: None, toughness_j_per_m2: None };
        for part in parts {
            let slot = match part.split_once('=') {
                Some(("young-pa", _)) => &mut material.young_pa,
                Some(("poisson", _)) => &mut material.poisson,
                Some(("toughness-j-per-m2", _)) => &mut material.toughness_j_per_m2,
                _ => return Err(wrong(format!("`{part}` is no value of it"))),
            };
            let value = part.split_once('=').map_or("", |(_, value)| value);
            *slot = Some(number("--material", &format!(" group:{name}"), value)?);
        }
        let Self { young_pa, poisson, toughness_j_per_m2, .. } = material;
        if [young_pa, poisson, toughness_j_per_m2] == [None; 3] {
            return Err(wrong("it says nothing of the group".to_owned()));
        }
        Ok(material)
    }
}

/// Young's moduli \[Pa\] and Poisson's ratios: those of the options, and of each material in its
/// group.
pub fn with_materials(
    young_pa: Option<PerCell>,
    poisson: PerCell,
    materials: &[Material<'_>],
    mesh: &Mesh,
) -> Result<(PerCell, PerCell)> {
    let young = young_pa.unwrap_or(PerCell::Uniform(f64::NAN));
    let young = of_materials(young, materials, |material| material.young_pa, mesh)?;
    let ratio = of_materials(poisson, materials, |material| material.poisson, mesh)?;
    let unused = |node: usize| mesh.unused.contains(&(node as u32));
    let bare = |&(node, value): &(usize, &f64)| value.is_nan() && !unused(node);
    if let Some((node, _)) = young.iter().enumerate().find(bare) {
        return Err(Error::input(format!(
            "--material: node {node} is in no group of a material; give --young-pa for the others"
        )));
    }
    Ok((PerCell::Each(young), PerCell::Each(ratio)))
}

/// The toughness \[J/m^2\] of the options, and of each material that has one in its group.
pub fn toughness_with_materials(
    toughness_j_per_m2: PerCell,
    materials: &[Material<'_>],
    mesh: &Mesh,
) -> Result<PerCell> {
    let value = |material: &Material<'_>| material.toughness_j_per_m2;
    if materials.iter().all(|material| value(material).is_none()) {
        return Ok(toughness_j_per_m2);
    }
    of_materials(toughness_j_per_m2, materials, value, mesh).map(PerCell::Each)
}

/// A value of each node: that of the options, or of the last material with one in a group of the node.
fn of_materials(
    values: PerCell,
    materials: &[Material<'_>],
    value: impl Fn(&Material<'_>) -> Option<f64>,
    mesh: &Mesh,
) -> Result<Vec<f64>> {
    let mut each = match values {
        PerCell::Uniform(value) => vec![value; mesh.nodes_m.len()],
        PerCell::Each(values) => values,
    };
    for material in materials {
        for &node in group("--material", material.name, mesh)? {
            if let (Some(slot), Some(value)) = (each.get_mut(node as usize), value(material)) {
                *slot = value;
            }
        }
    }
    Ok(each)
}

fn by_group(
    option: &str,
    others: Option<f64>,
    groups: &[(&str, f64)],
    mesh: &Mesh,
) -> Result<Vec<f64>> {
    let mut values = vec![others; mesh.nodes_m.len()];
    for &(name, value) in groups {
        for &node in group(option, name, mesh)? {
            values[node as usize] = Some(value);
        }
    }
    let unused = |node: usize| mesh.unused.contains(&(node as u32));
    let value = |(node, value): (usize, Option<f64>)| match value {
        None if !unused(node) => Err(Error::input(format!(
            "{option}: node {node} is in none of the groups; begin with a number for the others"
        ))),
        value => Ok(value.unwrap_or(1.0)),
    };
    values.into_iter().enumerate().map(value).collect()
}

fn group<'m>(option: &str, name: &str, mesh: &'m Mesh) -> Result<&'m [u32]> {
    mesh.groups.get(name).map(Vec::as_slice).ok_or_else(|| {
        let known: Vec<&str> = mesh.groups.keys().map(String::as_str).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        Error::input(format!("{option}: the mesh has no group '{name}'; its groups: {known}"))
    })
}

fn number(option: &str, place: &str, token: &str) -> Result<f64> {
    token.parse().map_err(|_| {
        Error::input(format!(
            "{option}{place}: `{token}` is no number; give one, file:PATH or group:NAME=VALUE"
        ))
    })
}

fn file(option: &str, path: &Path) -> Result<Vec<f64>> {
    let content = text::read(path, BYTES_MAX)
        .map_err(|why| Error::file(&format!("read {option}"), path, why))?;
    let tokens = content
        .split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']'))
        .filter(|token| !token.is_empty());
    let place = |at: usize| format!(" {}, value {at}", path.display());
    tokens.enumerate().map(|(at, token)| number(option, &place(at), token)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        let groups = [("left", vec![0, 1]), ("right", vec![2, 3]), ("all", vec![0, 1, 2, 3, 4])];
        let groups = groups.into_iter().map(|(name, ids)| (name.to_owned(), ids)).collect();
        Mesh { nodes_m: vec![[0.0; 3]; 5], groups, ..Mesh::default() }
    }

    #[test]
    fn values_come_from_numbers_and_groups() {
        let of = |text: &str| per_cell("--alpha", text, &mesh());
        assert_eq!(of("0.5").unwrap(), PerCell::Uniform(0.5));
        let each = |values: [f64; 5]| PerCell::Each(values.to_vec());
        assert_eq!(of("0.5,group:left=2").unwrap(), each([2.0, 2.0, 0.5, 0.5, 0.5]));
        assert_eq!(of("group:all=1,group:right=3").unwrap(), each([1.0, 1.0, 3.0, 3.0, 1.0]));
    }

    #[test]
    fn materials_stand_for_their_groups() {
        let mesh = mesh();
        let stiff = Material::parse("group:left,young-pa=2000,poisson=0.4").unwrap();
        assert_eq!(stiff.toughness_j_per_m2, None);
        let tough = Material::parse("group:right,toughness-j-per-m2=9").unwrap();
        let of = |materials: &[Material<'_>]| {
            toughness_with_materials(PerCell::Uniform(4.0), materials, &mesh).unwrap()
        };
        assert_eq!(of(std::slice::from_ref(&stiff)), PerCell::Uniform(4.0));
        assert_eq!(of(&[stiff.clone(), tough]), PerCell::Each(vec![4.0, 4.0, 9.0, 9.0, 4.0]));
        let even = PerCell::Uniform(0.45);
        let base = Some(PerCell::Uniform(500.0));
        let (young, poisson) = with_materials(base, even.clone(), &[stiff], &mesh).unwrap();
        assert_eq!(young, PerCell::Each(vec![2000.0, 2000.0, 500.0, 500.0, 500.0]));
        assert_eq!(poisson, PerCell::Each(vec![0.4, 0.4, 0.45, 0.45, 0.45]));
        let stiff = Material::parse("group:left,young-pa=2000").unwrap();
        let why = with_materials(None, even, &[stiff], &mesh).unwrap_err().to_string();
        assert!(why.contains("node 2") && why.contains("--young-pa"), "{why}");
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, place) in [
            ("group:left=2", "node 2"),
            ("1,group:other=2", "no group 'other'; its groups: all, left, right"),
            ("1,group:left", "`group:left`"),
            ("1,2", "`2`"),
            ("1,group:left=x", "group:left: `x`"),
            ("x", "`x`"),
        ] {
            let why = per_cell("--alpha", text, &mesh()).unwrap_err().to_string();
            assert!(why.contains("--alpha") && why.contains(place), "{text}: {why}");
        }
        for (text, place) in [
            ("left,young-pa=1", "begins with group:NAME"),
            ("group:left", "says nothing"),
            ("group:left,stiff=1", "`stiff=1`"),
            ("group:left,poisson=y", "`y`"),
        ] {
            let why = Material::parse(text).unwrap_err().to_string();
            assert!(why.contains("--material") && why.contains(place), "{text}: {why}");
        }
    }
}
