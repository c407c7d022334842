//! Sections of format 2.2, binary.

use super::binary_source::Binary;
use super::content::Content;
use super::elements;
use crate::error::Result;

/// `$Nodes`: the count as text, then a 32-bit tag and three doubles a node; in `$ParametricNodes` the
/// dimension and the number of the entity follow, and the position on a curve or a surface.
pub(super) fn nodes(file: &mut Binary, content: &mut Content, parametric: bool) -> Result<()> {
    content.begin_nodes(file)?;
    let count = file.count_line("number of nodes")?;
    file.bytes.fits(count, 4 + 3 * 8, "nodes")?;
    for _ in 0..count {
        let tag = file.whole("node tag")?;
        content.tag(tag, file)?;
        content.position(file)?;
        if parametric {
            let dimension = file.whole("entity dimension")?;
            file.bytes.i32("an entity tag")?;
            for _ in 0..if dimension < 3 { dimension } else { 0 } {
                file.bytes.f64("a node's parameters")?;
            }
        }
    }
    Ok(())
}

/// `$Elements`: the count as text, then blocks of one type and number of tags each, all 32-bit
/// numbers; the first tag of an element is its group.
pub(super) fn elements(file: &mut Binary, content: &mut Content) -> Result<()> {
    content.begin_elements(file)?;
    let count = file.count_line("number of elements")?;
    // An element has a tag and at least one node.
    file.bytes.fits(count, 2 * 4, "elements")?;
    let mut left = count;
    while left > 0 {
        let kind = file.whole("element type")?;
        let dimension = elements::dimension(kind, &"each element of this block", file)?;
        let follow = file.whole("number of elements in the block")?;
        if follow == 0 || follow > left {
            return Err(file.bytes.error(format!(
                "a block of {follow} elements where {left} are left of the section's {count}; save \
                 or copy the mesh again"
            )));
        }
        let tags = file.whole("number of tags")?;
        file.bytes.fits(follow, 4 * (2 + dimension + tags), "elements")?;
        for _ in 0..follow {
            let tag = file.whole("element tag")?;
            let mut group = 0;
            for at in 0..tags {
                let value = file.bytes.i32("an element's group or entity")?;
                if at == 0 {
                    group = i64::from(value);
                }
            }
            elements::take(content, file, dimension, tag, group)?;
        }
        left -= follow;
    }
    Ok(())
}
