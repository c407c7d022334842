//! Sections of format 4.1.

use std::collections::BTreeMap;

use super::content::Content;
use super::elements;
use super::lines::Lines;
use super::source::Place;
use crate::error::Result;

/// `$Entities`: points, curves, surfaces and volumes with their physical groups.
pub(super) fn entities(lines: &mut Lines, content: &mut Content) -> Result<()> {
    let mut header = lines.record("the numbers of entities")?;
    let mut physicals = BTreeMap::new();
    let mut counts = [0; 4];
    for (count, name) in counts.iter_mut().zip(["points", "curves", "surfaces", "volumes"]) {
        *count = header.whole(&format!("number of {name}"))?;
    }
    for (dimension, count) in (0..).zip(counts) {
        for _ in 0..count {
            let mut fields = lines.record("an entity")?;
            let tag = fields.signed("entity tag")?;
            // A point has its position, the others the corners of their bounding box.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                fields.word("entity's bounds")?;
            }
            let mut groups = Vec::new();
            for _ in 0..fields.whole("number of physical groups")? {
                groups.push(fields.signed("physical group")?);
            }
            physicals.insert((dimension, tag), groups);
        }
    }
    content.physicals = Some(physicals);
    Ok(())
}

/// `$Nodes`: blocks of one entity each, all tags of a block before its coordinates.
pub(super) fn nodes(lines: &mut Lines, content: &mut Content) -> Result<()> {
    content.begin_nodes(lines)?;
    let mut header = lines.record("the numbers of blocks and nodes")?;
    let blocks = header.whole("number of node blocks")?;
    let promised = header.whole("number of nodes")?;
    let mut total = 0u64;
    for _ in 0..blocks {
        let mut block = lines.record("a node block")?;
        block.whole("entity dimension")?;
        block.signed("entity tag")?;
        block.whole("parametric flag")?;
        let count = block.whole("number of nodes in the block")?;
        for _ in 0..count {
            let mut fields = lines.record("a node tag")?;
            let tag = fields.whole("node tag")?;
            content.tag(tag, &fields)?;
            fields.finish()?;
        }
        for _ in 0..count {
            content.position(&mut lines.record("a node's coordinates")?)?;
        }
        // Every node counted so far took a line of the file, so the sum stays small.
        total += count;
    }
    same(lines, "nodes", promised, total)
}

/// `$Elements`: blocks of one entity and type each.
pub(super) fn elements(lines: &mut Lines, content: &mut Content) -> Result<()> {
    content.begin_elements(lines)?;
    let mut header = lines.record("the numbers of blocks and elements")?;
    let blocks = header.whole("number of element blocks")?;
    let promised = header.whole("number of elements")?;
    let mut total = 0u64;
    for _ in 0..blocks {
        let mut block = lines.record("an element block")?;
        block.whole("entity dimension")?;
        let entity = block.signed("entity tag")?;
        let kind = block.whole("element type")?;
        let count = block.whole("number of elements in the block")?;
        let dimension = elements::dimension(kind, &"each element of this block", &block)?;
        for _ in 0..count {
            let mut fields = lines.record("an element")?;
            let tag = fields.whole("element tag")?;
            elements::take(content, &mut fields, dimension, tag, entity)?;
            fields.finish()?;
        }
        total += count;
    }
    same(lines, "elements", promised, total)
}

/// Refuses a header whose number differs from that of its blocks.
pub(super) fn same(at: &impl Place, what: &str, promised: u64, total: u64) -> Result<()> {
    if promised == total {
        return Ok(());
    }
    Err(at.refuse(&format!(
        "the section's first line says {promised} {what}, its blocks have {total}; save the mesh \
         again"
    )))
}
