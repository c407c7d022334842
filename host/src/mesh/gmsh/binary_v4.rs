//! Sections of format 4.1, binary: counts and tags of nodes and elements have 64 bits, types and
//! tags of entities 32.

use std::collections::BTreeMap;

use super::binary_source::Binary;
use super::content::Content;
use super::{elements, v4};
use crate::error::Result;

/// `$Entities`: points, curves, surfaces and volumes with their physical groups.
pub(super) fn entities(file: &mut Binary, content: &mut Content) -> Result<()> {
    let mut physicals = BTreeMap::new();
    let mut counts = [0; 4];
    for (count, name) in counts.iter_mut().zip(["points", "curves", "surfaces", "volumes"]) {
        *count = file.bytes.u64(name)?;
    }
    for (dimension, count) in (0..).zip(counts) {
        // A point has its position, the others the corners of their bounding box.
        let (bounds, lists) = if dimension == 0 { (3, 1) } else { (6, 2) };
        file.bytes.fits(count, 4 + 8 * bounds + 8 * lists, "entities")?;
        for _ in 0..count {
            let tag = i64::from(file.bytes.i32("an entity tag")?);
            for _ in 0..bounds {
                file.bytes.f64("an entity's bounds")?;
            }
            physicals.insert((dimension, tag), numbers(file, "physical groups")?);
            if dimension > 0 {
                numbers(file, "bounding entities")?;
            }
        }
    }
    content.physicals = Some(physicals);
    Ok(())
}

/// Reads a 64-bit count and as many 32-bit numbers.
fn numbers(file: &mut Binary, what: &str) -> Result<Vec<i64>> {
    let count = file.bytes.u64(what)?;
    file.bytes.fits(count, 4, what)?;
    (0..count).map(|_| file.bytes.i32(what).map(i64::from)).collect()
}

/// `$Nodes`: blocks of one entity each, all tags of a block before its coordinates.
pub(super) fn nodes(file: &mut Binary, content: &mut Content) -> Result<()> {
    content.begin_nodes(file)?;
    let blocks = file.bytes.u64("the number of node blocks")?;
    let promised = file.bytes.u64("the number of nodes")?;
    skip_tag_range(file)?;
    file.bytes.fits(blocks, 3 * 4 + 8, "node blocks")?;
    let mut total = 0u64;
    for _ in 0..blocks {
        let dimension = file.whole("entity dimension")?;
        if dimension > 3 {
            return Err(file.bytes.error(format!(
                "the entity dimension is {dimension}; it must be 0 to 3: save or copy the mesh \
                 again"
            )));
        }
        file.bytes.i32("an entity tag")?;
        let parametric = file.whole("parametric flag")? != 0;
        let parameters = if parametric { dimension } else { 0 };
        let count = file.bytes.u64("the number of nodes in the block")?;
        file.bytes.fits(count, 8 * (4 + parameters), "nodes")?;
        for _ in 0..count {
            let tag = file.bytes.u64("a node tag")?;
            content.tag(tag, file)?;
        }
        for _ in 0..count {
            content.position(file)?;
            for _ in 0..parameters {
                file.bytes.f64("a node's parameters")?;
            }
        }
        // Every node counted so far took bytes of the file, so the sum stays small.
        total += count;
    }
    v4::same(file, "nodes", promised, total)
}

/// `$Elements`: blocks of one entity and type each.
pub(super) fn elements(file: &mut Binary, content: &mut Content) -> Result<()> {
    content.begin_elements(file)?;
    let blocks = file.bytes.u64("the number of element blocks")?;
    let promised = file.bytes.u64("the number of elements")?;
    skip_tag_range(file)?;
    file.bytes.fits(blocks, 3 * 4 + 8, "element blocks")?;
    let mut total = 0u64;
    for _ in 0..blocks {
        file.whole("entity dimension")?;
        let entity = i64::from(file.bytes.i32("an entity tag")?);
        let kind = file.whole("element type")?;
        let dimension = elements::dimension(kind, &"each element of this block", file)?;
        let count = file.bytes.u64("the number of elements in the block")?;
        file.bytes.fits(count, 8 * (2 + dimension), "elements")?;
        for _ in 0..count {
            let tag = file.bytes.u64("an element tag")?;
            elements::take(content, file, dimension, tag, entity)?;
        }
        total += count;
    }
    v4::same(file, "elements", promised, total)
}

/// Skips the smallest and largest tag of a section, which are not needed.
fn skip_tag_range(file: &mut Binary) -> Result<()> {
    file.bytes.u64("the smallest tag")?;
    file.bytes.u64("the largest tag").map(|_| ())
}
