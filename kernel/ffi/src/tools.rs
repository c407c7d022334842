//! Tools on a model with a contact surface: their choice, a tick with a pose for each, what each
//! feels, what it is in contact with, what it grips.

use core::mem::offset_of;

use chaincell_kernel::{PARTS_MAX, TOOLS_MAX};

use crate::code::{Code, Detail, Refusal};
use crate::layout::{self, Parts, Sizes, Tissue, by_touching_scheme};
use crate::memory;
use crate::settings::Scheme;

/// A convex part of a tool with rounded edges, in the tool's frame. Any bits are admitted: a part
/// that cannot be is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct ToolPart {
    /// Its middle \[m\].
    pub centre_m: [f32; 3],
    /// Turns its own frame into the tool's: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// Half the edges of its core \[m\]: 0 0 0 for a sphere, 0 0 a for a capsule along z, a b c for a
    /// box. Of a half space the core is all that lies below z = -radius: infinite in every axis. Of the
    /// edge of a blade half its length, 0, 0: it lies along x and cuts towards -z, and is the last part of its tool.
    /// Of scissors half the largest thickness between the blades, 0, their length: see `radius_m`.
    pub half_m: [f32; 3],
    /// Radius of the rounded edges around the core, above 0 \[m\]; 0 for the edge of a blade. Tissue is never
    /// pushed deeper into the tool than half of it. Below 0 for scissors: its negative is the distance at which
    /// the edges pass the pivot. Their blades extend along -z and open in the y direction by the angle of the pose;
    /// where the edges cross they cut.
    pub radius_m: f32,
}

/// The contact of one triangle with one part of a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct ContactForce {
    /// Where it acts, in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Pressure on the tool \[N\].
    pub normal_n: [f32; 3],
    /// Friction, or the pull of a grip, on the tool \[N\].
    pub tangential_n: [f32; 3],
    /// Area of the triangle at rest that is in contact \[m2\].
    pub area_m2: f32,
    /// The triangle, in the model's order; beyond the last one for the side of a cut.
    pub triangle: u32,
    /// The cell at the corner that takes the largest share; a copy in a wound.
    pub cell: u32,
    /// The cell of the whole body that it is or was made from; `chaincell_model_input_id` has its id.
    pub origin: u32,
    /// The tool, from 0.
    pub tool: u32,
    /// Which of its parts, from 0.
    pub part: u32,
}

type KernelPart = chaincell_kernel::ToolPart;

// Lists of parts and poses are read where they are.
const _: () = assert!(size_of::<ToolPart>() == size_of::<KernelPart>());
const _: () = assert!(align_of::<ToolPart>() == align_of::<KernelPart>());
const _: () = assert!(offset_of!(ToolPart, centre_m) == offset_of!(KernelPart, centre_m));
const _: () = assert!(offset_of!(ToolPart, orientation) == offset_of!(KernelPart, orientation));
const _: () = assert!(offset_of!(ToolPart, half_m) == offset_of!(KernelPart, half_m));
const _: () = assert!(offset_of!(ToolPart, radius_m) == offset_of!(KernelPart, radius_m));

/// What is the same for every scheme, of a tissue with room for tools.
///
/// # Safety
/// As [`layout::front`].
unsafe fn touching(tissue: *const Tissue) -> Result<(Scheme, Sizes), Code> {
    // SAFETY: the caller's promise is handed on.
    let (scheme, sizes) = unsafe { layout::front(tissue) }?;
    if sizes.touch.is_none() { Err(Code::ContactRoom) } else { Ok((scheme, sizes)) }
}

/// The same, where there is room for this tool.
///
/// # Safety
/// As [`layout::front`].
unsafe fn with_tool(tissue: *const Tissue, tool: u32) -> Result<(Scheme, Sizes, usize), Code> {
    // SAFETY: the caller's promise is handed on.
    let (scheme, sizes) = unsafe { touching(tissue) }?;
    let tool = tool as usize;
    if tool < sizes.touch.tools() { Ok((scheme, sizes, tool)) } else { Err(Code::Range) }
}

/// Cuts a list of parts into those of each tool.
///
/// # Safety
/// As [`chaincell_choose_tools`].
unsafe fn cut<'a>(
    parts: *const ToolPart,
    counts: &[u32],
    tools: &mut [&'a [KernelPart]; TOOLS_MAX],
) -> Result<(), Refusal> {
    let mut all = 0;
    for (tool, &count) in counts.iter().enumerate() {
        let count = count as usize;
        if !(1..=PARTS_MAX).contains(&count) {
            return Err(Refusal::position(Code::ContactParts, tool).with_sizes(count, PARTS_MAX));
        }
        all += count;
    }
    // SAFETY: the layouts are the same, and the caller says what stands there.
    let mut rest: &'a [KernelPart] = unsafe { memory::slice(parts.cast(), all) }?;
    for (slot, &count) in tools.iter_mut().zip(counts) {
        (*slot, rest) = rest.split_at_checked(count as usize).unwrap_or((rest, &[]));
    }
    Ok(())
}

/// # Safety
/// As [`chaincell_choose_tools`].
unsafe fn choose(
    tissue: *mut Tissue,
    parts: *const ToolPart,
    counts: *const u32,
    tools: usize,
    friction: f32,
) -> Result<(), Refusal> {
    // SAFETY: the caller's promises are handed on.
    let ((scheme, sizes), model) = unsafe { (layout::front(tissue)?, layout::model(tissue)) };
    if !model.has_contact_surface() {
        return Err(Code::ContactNoSurface.into());
    }
    if sizes.touch.is_none() {
        let is_built = cfg!(feature = "surface");
        let code = if is_built { Code::ContactRoom } else { Code::ContactScheme };
        return Err(Refusal::sizes(code, sizes.cells, 0));
    }
    let room = sizes.touch.tools();
    if !(1..=room).contains(&tools) {
        return Err(Refusal::sizes(Code::ContactTools, tools, room));
    }
    let mut lists: [&[KernelPart]; TOOLS_MAX] = [&[]; TOOLS_MAX];
    // SAFETY: the caller's promises are handed on; there are no more counts than slots.
    let counts = unsafe {
        let counts = memory::slice(counts, tools)?;
        cut(parts, counts, &mut lists)?;
        counts
    };
    let lists = lists.get(..tools).unwrap_or(&[]);
    let chosen = by_touching_scheme!(scheme, D => {
        // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
        let Parts { network, tissue: mut body, .. } = unsafe { layout::parts::<D>(tissue, sizes) };
        body.choose_tools(network, lists, friction)
    });
    chosen.map_err(|why| match why {
        chaincell_kernel::ContactError::Part { tool, part } => {
            let before = counts.iter().take(tool).fold(part, |sum, &count| sum + count as usize);
            Refusal::position(Code::ContactPart, before)
        }
        why => why.into(),
    })
}

/// Gives the tissue tools on the model's surface in place of chosen cells: `tools` of them, tool i of
/// `counts[i]` parts, 1 to 8; `parts` has those of the first tool, then those of the second and so on.
/// `friction` is the coefficient of all by Coulomb's law, 0 to 10.
///
/// The model has a contact surface, the tissue was initialised by `chaincell_tissue_init` with room for so
/// many tools, and for samples where there is friction.
/// The lists are copied. Refused while a tool is engaged; a refused choice leaves the old one. `detail`
/// may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `counts` are `tools` numbers, `parts` as
/// many parts as they say, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_choose_tools(
    tissue: *mut Tissue,
    parts: *const ToolPart,
    counts: *const u32,
    tools: usize,
    friction: f32,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe { crate::answer(detail, || choose(tissue, parts, counts, tools, friction)) }
}

/// The contacts of all tools in the last tick, one for each triangle and part of a tool: writes the first
/// `room` of them and says in `count` how many there are. `contacts` may be null where `room` is 0.
///
/// Cost: one look at the samples in reach.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `contacts` has room for
/// `room` of them, `count` is storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_contact_forces(
    tissue: *mut Tissue,
    contacts: *mut ContactForce,
    room: usize,
    count: *mut usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { touching(tissue) }.and_then(|(scheme, sizes)| {
        memory::check(count)?;
        if room > 0 {
            memory::check(contacts)?;
        }
        let mut found = 0;
        by_touching_scheme!(scheme, D => {
            // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
            let Parts { network, tissue: mut body, .. } =
                unsafe { layout::parts::<D>(tissue, sizes) };
            body.contact_forces(network, |of| {
                if found < room {
                    // SAFETY: checked above, and the caller says that there is room for it.
                    unsafe { contacts.add(found).write(ContactForce::of(of)) };
                }
                found += 1;
            });
        });
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(count, found) }
    }))
}

impl ContactForce {
    fn of(kernel: &chaincell_kernel::ContactForce) -> Self {
        Self {
            position_m: kernel.position_m,
            normal_n: kernel.normal_n,
            tangential_n: kernel.tangential_n,
            area_m2: kernel.area_m2,
            triangle: kernel.triangle,
            cell: kernel.cell.into(),
            origin: kernel.origin.into(),
            tool: kernel.tool.into(),
            part: kernel.part.into(),
        }
    }
}

/// A tool, from 0, grips what it is in contact with: it holds these samples where they are in its frame,
/// without slip, until `chaincell_let_go` or until it is no longer engaged. A tool that stays is a pin.
/// `samples` says how many it holds, 0 where it touches nothing; it may be null.
///
/// The force does not jump: a grip begins without pull. Between two ticks. The tissue must have room for
/// samples.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `samples` is null or
/// storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_grip(
    tissue: *mut Tissue,
    tool: u32,
    samples: *mut usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { with_tool(tissue, tool) }.and_then(|(scheme, sizes, tool)| {
        if !sizes.touch.holds() {
            return Err(Code::ContactSamples);
        }
        if !samples.is_null() {
            memory::check(samples)?;
        }
        let held = by_touching_scheme!(scheme, D => {
            // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
            let Parts { network, tissue: mut body, .. } =
                unsafe { layout::parts::<D>(tissue, sizes) };
            body.grip(network, tool)
        });
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write_if_asked(samples, held) }
    }))
}

/// A tool, from 0, lets go of what it grips, within so many ticks, at most 65,535: the pull falls to 0
/// evenly. 0 is as 1.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_let_go(tissue: *mut Tissue, tool: u32, ticks: u32) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { with_tool(tissue, tool) }.and_then(|(scheme, sizes, tool)| {
        let ticks = u16::try_from(ticks).map_err(|_| Code::Range)?;
        by_touching_scheme!(scheme, D => {
            // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
            let Parts { tissue: mut body, .. } = unsafe { layout::parts::<D>(tissue, sizes) };
            body.let_go(tool, ticks);
        });
        Ok(())
    }))
}

/// Torque of the tissue on the handles of the scissors of a tool, from 0, about their pivot in the last tick with a
/// sweep \[N m\]: above 0 it resists closing. 0 for a tool without scissors. No limit clamps it.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `torque_n_m` is storage for
/// the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_opening_torque(
    tissue: *mut Tissue,
    tool: u32,
    torque_n_m: *mut f32,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { with_tool(tissue, tool) }.and_then(|(scheme, sizes, tool)| {
        let found = by_touching_scheme!(scheme, D => {
            // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
            let Parts { network, tissue: body, .. } =
                unsafe { layout::parts::<D>(tissue, sizes) };
            body.opening_torque_n_m(network, tool)
        });
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(torque_n_m, found) }
    }))
}

/// Samples that a tool, from 0, grips.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `samples` is storage for
/// the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_gripped(
    tissue: *mut Tissue,
    tool: u32,
    samples: *mut usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { with_tool(tissue, tool) }.and_then(|(scheme, sizes, tool)| {
        let held = by_touching_scheme!(scheme, D => {
            // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
            let Parts { network, tissue: mut body, .. } =
                unsafe { layout::parts::<D>(tissue, sizes) };
            body.gripped(network, tool)
        });
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(samples, held) }
    }))
}
