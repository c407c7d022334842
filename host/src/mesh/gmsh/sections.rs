//! The sections of nodes, elements and entities, in text and binary.

use std::collections::BTreeMap;

use super::content::Content;
use super::elements;
use super::file::File;
use crate::error::Result;

/// `$Nodes` of format 2.2: a count, then `tag x y z` each; in `$ParametricNodes` the dimension and the number
/// of the entity follow, and the position on a curve or a surface.
pub(super) fn nodes_v2(file: &mut File, content: &mut Content, parametric: bool) -> Result<()> {
    content.begin_nodes(file)?;
    let count = file.count("the number of nodes")?;
    file.fits(count, 4 + 3 * 8, "nodes")?;
    for _ in 0..count {
        file.record("a node")?;
        let tag = file.whole("the node tag")?;
        content.tag(tag, file)?;
        content.position(file)?;
        if !parametric {
            file.end_of_record()?;
        } else if file.is_binary {
            let dimension = file.whole("the entity dimension")?;
            file.signed("the entity tag")?;
            file.skip_reals(if dimension < 3 { dimension } else { 0 }, "a node's parameters")?;
        }
    }
    Ok(())
}

/// `$Elements` of format 2.2: a count, then `tag type tags.. nodes..` a line; the first tag is the group. In
/// binary files blocks of one type and number of tags each.
pub(super) fn elements_v2(file: &mut File, content: &mut Content) -> Result<()> {
    content.begin_elements(file)?;
    let count = file.count("the number of elements")?;
    if file.is_binary {
        return element_blocks_v2(file, content, count);
    }
    for _ in 0..count {
        file.record("an element")?;
        let tag = file.whole("the element tag")?;
        let kind = file.whole("the element type")?;
        let dimension = elements::dimension(kind, &format_args!("element {tag}"), file)?;
        let tags = file.whole("the number of tags")?;
        let group = first_of(file, tags)?;
        elements::take(content, file, dimension, tag, group)?;
        file.end_of_record()?;
    }
    Ok(())
}

fn element_blocks_v2(file: &mut File, content: &mut Content, count: u64) -> Result<()> {
    // An element has a tag and at least one node.
    file.fits(count, 2 * 4, "elements")?;
    let mut left = count;
    while left > 0 {
        let kind = file.whole("the element type")?;
        let dimension = elements::dimension(kind, &"each element of this block", file)?;
        let follow = file.whole("the number of elements in the block")?;
        if follow == 0 || follow > left {
            return Err(file.refuse(&format!(
                "a block of {follow} elements where {left} are left of the section's {count}; save or copy \
                 the mesh again"
            )));
        }
        let tags = file.whole("the number of tags")?;
        file.fits(follow, 4 * (2 + dimension + tags), "elements")?;
        for _ in 0..follow {
            let tag = file.whole("the element tag")?;
            let group = first_of(file, tags)?;
            elements::take(content, file, dimension, tag, group)?;
        }
        left -= follow;
    }
    Ok(())
}

/// Reads the tags of an element and returns the first, 0 if there is none.
fn first_of(file: &mut File, tags: u64) -> Result<i64> {
    let mut first = 0;
    for at in 0..tags {
        let value = file.signed("the element's group or entity")?;
        if at == 0 {
            first = value;
        }
    }
    Ok(first)
}

/// `$Entities` of format 4.1: points, curves, surfaces and volumes with their physical groups.
pub(super) fn entities(file: &mut File, content: &mut Content) -> Result<()> {
    file.record("the numbers of entities")?;
    let mut physicals = BTreeMap::new();
    let mut counts = [0; 4];
    for (count, name) in counts.iter_mut().zip(["points", "curves", "surfaces", "volumes"]) {
        *count = file.long(&format!("the number of {name}"))?;
    }
    for (dimension, count) in (0..).zip(counts) {
        // A point has its position, the others the corners of their bounding box.
        let (bounds, lists) = if dimension == 0 { (3, 1) } else { (6, 2) };
        file.fits(count, 4 + 8 * bounds + 8 * lists, "entities")?;
        for _ in 0..count {
            file.record("an entity")?;
            let tag = file.signed("the entity tag")?;
            file.skip_reals(bounds, "the entity's bounds")?;
            physicals.insert((dimension, tag), numbers(file, "physical groups")?);
            // In text the rest of the line is not needed.
            if file.is_binary && dimension > 0 {
                numbers(file, "bounding entities")?;
            }
        }
    }
    content.physicals = Some(physicals);
    Ok(())
}

/// Reads a count and as many numbers.
fn numbers(file: &mut File, what: &str) -> Result<Vec<i64>> {
    let count = file.long(&format!("the number of {what}"))?;
    file.fits(count, 4, what)?;
    (0..count).map(|_| file.signed(what)).collect()
}

/// Reads the head of a section of format 4.1: the number of blocks, and of nodes or elements in all of them.
fn head(file: &mut File, each: &str) -> Result<(u64, u64)> {
    file.record(&format!("the numbers of blocks and {each}s"))?;
    let blocks = file.long(&format!("the number of {each} blocks"))?;
    let promised = file.long(&format!("the number of {each}s"))?;
    if file.is_binary {
        file.long("the smallest tag")?;
        file.long("the largest tag")?;
    }
    file.fits(blocks, 3 * 4 + 8, &format!("{each} blocks"))?;
    Ok((blocks, promised))
}

/// `$Nodes` of format 4.1: blocks of one entity each, all tags of a block before its coordinates.
pub(super) fn nodes_v4(file: &mut File, content: &mut Content) -> Result<()> {
    content.begin_nodes(file)?;
    let (blocks, promised) = head(file, "node")?;
    let mut total = 0u64;
    for _ in 0..blocks {
        file.record("a node block")?;
        let dimension = file.whole("the entity dimension")?;
        if dimension > 3 {
            return Err(file.refuse(&format!(
                "the entity dimension is {dimension}; it must be 0 to 3: save or copy the mesh again"
            )));
        }
        file.signed("the entity tag")?;
        let is_parametric = file.whole("the parametric flag")? != 0;
        let parameters = if is_parametric { dimension } else { 0 };
        let count = file.long("the number of nodes in the block")?;
        file.fits(count, 8 * (4 + parameters), "nodes")?;
        for _ in 0..count {
            file.record("a node tag")?;
            let tag = file.long("the node tag")?;
            content.tag(tag, file)?;
            file.end_of_record()?;
        }
        for _ in 0..count {
            file.record("a node's coordinates")?;
            content.position(file)?;
            // In text the rest of the line is not needed.
            file.skip_reals(if file.is_binary { parameters } else { 0 }, "a node's parameters")?;
        }
        // Every node counted so far took bytes of the file, so the sum stays small.
        total += count;
    }
    check_total(file, "nodes", promised, total)
}

/// `$Elements` of format 4.1: blocks of one entity and type each.
pub(super) fn elements_v4(file: &mut File, content: &mut Content) -> Result<()> {
    content.begin_elements(file)?;
    let (blocks, promised) = head(file, "element")?;
    let mut total = 0u64;
    for _ in 0..blocks {
        file.record("an element block")?;
        file.whole("the entity dimension")?;
        let entity = file.signed("the entity tag")?;
        let kind = file.whole("the element type")?;
        let dimension = elements::dimension(kind, &"each element of this block", file)?;
        let count = file.long("the number of elements in the block")?;
        file.fits(count, 8 * (2 + dimension), "elements")?;
        for _ in 0..count {
            file.record("an element")?;
            let tag = file.long("the element tag")?;
            elements::take(content, file, dimension, tag, entity)?;
            file.end_of_record()?;
        }
        total += count;
    }
    check_total(file, "elements", promised, total)
}

/// Refuses a head whose number differs from that of its blocks.
fn check_total(file: &File, what: &str, promised: u64, total: u64) -> Result<()> {
    if promised == total {
        return Ok(());
    }
    Err(file.refuse(&format!(
        "the section's first line says {promised} {what}, its blocks have {total}; save the mesh again"
    )))
}
