//! Sections of format 2.2.

use super::content::Content;
use super::elements;
use super::lines::Lines;
use crate::error::Result;

/// `$Nodes`: a count, then `tag x y z` a line; in `$ParametricNodes` the dimension and the number of the
/// entity follow, and the position in it.
pub(super) fn nodes(lines: &mut Lines, content: &mut Content, parametric: bool) -> Result<()> {
    content.begin_nodes(lines)?;
    let count = lines.record("the number of nodes")?.whole("number of nodes")?;
    for _ in 0..count {
        let mut fields = lines.record("a node")?;
        let tag = fields.whole("node tag")?;
        content.tag(tag, &fields)?;
        content.position(&mut fields)?;
        if !parametric {
            fields.finish()?;
        }
    }
    Ok(())
}

/// `$Elements`: a count, then `tag type tags.. nodes..` a line; the first tag is the group.
pub(super) fn elements(lines: &mut Lines, content: &mut Content) -> Result<()> {
    content.begin_elements(lines)?;
    let count = lines.record("the number of elements")?.whole("number of elements")?;
    for _ in 0..count {
        let mut fields = lines.record("an element")?;
        let tag = fields.whole("element tag")?;
        let kind = fields.whole("element type")?;
        let dimension = elements::dimension(kind, &format_args!("element {tag}"), &fields)?;
        let mut group = 0;
        for at in 0..fields.whole("number of tags")? {
            let value = fields.signed("element's group or entity")?;
            if at == 0 {
                group = value;
            }
        }
        elements::take(content, &mut fields, dimension, tag, group)?;
        fields.finish()?;
    }
    Ok(())
}
