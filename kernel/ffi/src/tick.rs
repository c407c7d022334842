//! The tick, and what can be read from a body and written into it.

use core::mem::offset_of;

use chaincell_kernel::number::cell::{Cell, output, single};
use chaincell_kernel::tick::hash::{and_pins, and_words, state_hash};
use chaincell_kernel::{Flags, Network, Number, TOOLS_MAX, TickOutput, cut_state};

use crate::code::{Code, Detail, Refusal};
use crate::layout::{self, Parts, Published, Tissue, by_scheme, by_touching_scheme};
use crate::memory;

/// Where a tool is. Any bits are admitted: a pose that is not finite, whose `engaged` is neither 0 nor
/// 1, whose opening is above 32768 or whose quaternion is not of length 1/2 to 2 makes the sample a bad one. Held
/// cells go by the position alone, but the quaternion has to be one: 0, 0, 0, 1 for no turn.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct ToolPose {
    /// Where its frame is in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Turns its frame into that of the mesh: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// 1 while the tissue feels it (it holds the contact cells, or touches), else 0.
    pub engaged: u16,
    /// Opening angle between the blades of scissors in 2^-16 of a full turn, 0 to 32768; other tools ignore it.
    pub opening_turns_q16: u16,
}

pub(crate) type KernelPose = chaincell_kernel::ToolPose;
type KernelOutput = chaincell_kernel::ToolOutput;

// Poses of the caller are read as those of the kernel.
const _: () = assert!(size_of::<ToolPose>() == size_of::<KernelPose>());
const _: () = assert!(align_of::<ToolPose>() == align_of::<KernelPose>());
const _: () = assert!(offset_of!(ToolPose, position_m) == offset_of!(KernelPose, position_m));
const _: () = assert!(offset_of!(ToolPose, orientation) == offset_of!(KernelPose, orientation));
const _: () = assert!(offset_of!(ToolPose, engaged) == offset_of!(KernelPose, engaged));
const _: () =
    assert!(offset_of!(ToolPose, opening_turns_q16) == offset_of!(KernelPose, opening_turns_q16));

/// What a tool feels in a tick, of the kernel and of the client alike.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct ToolOutput {
    /// Force of the tissue on the tool \[N\].
    pub force_n: [f32; 3],
    /// Torque on it about its position; 0 for held cells \[N m\].
    pub torque_n_m: [f32; 3],
    /// Number of cells it holds, or of triangles that it is in contact with or whose samples it grips.
    pub contacts: u32,
    /// Limits and events, a sum of `CHAINCELL_FLAG_` numbers.
    pub flags: u32,
}

/// What one tick answers to a tool. It describes the state after the last update.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Output {
    /// What the tool feels. The flags are those of the tick.
    pub tool: ToolOutput,
    /// Certified level: an upper bound of the elastic energy of the published state \[J\].
    pub energy_j: f32,
    /// What the motion of the tool in this tick did to the tissue, exactly: the tissue's side of an energy
    /// ledger, including the work of the torque \[J\].
    pub work_j: f32,
    /// Upper bound of the stiffness that the tool meets within a tick \[N/m\].
    pub stiffness_n_per_m: f32,
    /// Sweeps made: 0 where the sample was late, and in the safe state.
    pub sweeps: u32,
    /// Energy that a body that relaxes has lost by relaxation since its reset, 0 for another one: the work of the
    /// tools that neither the body holds nor a sweep took \[J\].
    pub relaxed_j: f32,
    /// Estimate of the distance between the force, before its limit, and that of the body in equilibrium with the
    /// tools where they are: within it are 99 of 100 errors. Below 0 where none is known: away from the tissue, after a
    /// shortened motion, in late ticks after one, a release or a restore and of cells held in a body that relaxes,
    /// under another scheme than `predict`, and of bodies of links, without a coarse level, or cut \[N\].
    pub force_error_n: f32,
    /// Estimate of the error of the torque on the tool likewise, below 0 for held cells too \[N m\].
    pub torque_error_n_m: f32,
}

/// Stands for an error that is not known \[N, N m\].
const UNKNOWN_N: f32 = -1.0;

/// The error of a force or a torque, or what stands for one that is not known.
fn told(error: Option<f32>) -> f32 {
    error.unwrap_or(UNKNOWN_N)
}

impl Output {
    /// The kernel's answer, which knows neither torque nor relaxation nor the force's error.
    pub(crate) fn of(answer: &TickOutput) -> Self {
        let (contacts, flags) = (answer.contacts, answer.flags.0);
        Self {
            tool: ToolOutput {
                force_n: answer.force_n.into(),
                torque_n_m: [0.0; 3],
                contacts,
                flags,
            },
            energy_j: answer.energy_j,
            work_j: answer.work_j,
            stiffness_n_per_m: answer.stiffness_n_per_m,
            sweeps: answer.sweeps.into(),
            relaxed_j: 0.0,
            force_error_n: UNKNOWN_N,
            torque_error_n_m: UNKNOWN_N,
        }
    }
}

/// The answer to a call without a body.
pub(crate) const SAFE: Output = Output {
    tool: ToolOutput {
        force_n: [0.0; 3],
        torque_n_m: [0.0; 3],
        contacts: 0,
        flags: Flags::SAFE_STATE.0,
    },
    energy_j: 0.0,
    work_j: 0.0,
    stiffness_n_per_m: 0.0,
    sweeps: 0,
    relaxed_j: 0.0,
    force_error_n: UNKNOWN_N,
    torque_error_n_m: UNKNOWN_N,
};

/// Asked after each sweep but the last, with the number of sweeps done and the caller's pointer;
/// other than 0 for a further one.
pub type More = Option<unsafe extern "C" fn(done: u32, context: *mut core::ffi::c_void) -> i32>;

/// How many sweeps a tick makes, at most those of the settings. Under `euler` and `rkl2` the sweeps are
/// the tissue's time: there all are made, whatever the budget.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Budget {
    /// At most so many. 0 for a tick that is late, newer poses waiting: the tool moves, within its
    /// limits, without a sweep; the answer repeats the last force, with `CHAINCELL_FLAG_LATE`, and is 0
    /// where the tool lets go. Tools on a contact surface stay until the next tick with a sweep.
    pub sweeps: u32,
    /// Null, or whether to go on: at least one sweep is made.
    pub more: More,
    /// What `more` is called with.
    pub context: *mut core::ffi::c_void,
    /// 0, or the share of each force at which its estimated error, `force_error_n`, is small enough: no sweep follows.
    /// Where the error is not known, and as contact begins, the other limits alone count.
    pub force_error_share: f32,
}

/// A tick of the kernel's with the caller's budget.
///
/// # Safety
/// `budget.more` is null or may be called with `budget.context`.
#[inline(always)]
unsafe fn with_budget(
    budget: Option<&Budget>,
    tick: impl FnOnce(chaincell_kernel::Budget<'_>) -> TickOutput,
) -> TickOutput {
    let Some(&Budget { sweeps, more, context, force_error_share }) = budget else {
        return tick(chaincell_kernel::Budget::All);
    };
    let mut goes_on = |done: u16| {
        let is_wanted = u32::from(done) < sweeps;
        // SAFETY: the caller's promise is handed on.
        is_wanted && more.is_none_or(|more| unsafe { more(done.into(), context) } != 0)
    };
    tick(match sweeps {
        0 => chaincell_kernel::Budget::LATE,
        _ if force_error_share > 0.0 => {
            chaincell_kernel::Budget::Within { share: force_error_share, more: Some(&mut goes_on) }
        }
        _ => chaincell_kernel::Budget::While(&mut goes_on),
    })
}

/// Writes `count` answers, at most as many as there may be tools: those of the work, or force 0 in the safe
/// state where it is refused.
///
/// # Safety
/// A pointer that passes [`memory::check`] is storage for `count` answers.
pub(crate) unsafe fn answer_to(
    outputs: *mut Output,
    count: usize,
    work: impl FnOnce(&mut [Output]) -> Result<(), Code>,
) -> Code {
    if let Err(code) = memory::check(outputs) {
        return code;
    }
    let count = count.min(TOOLS_MAX);
    for at in 0..count {
        // SAFETY: checked above, and the caller says that it is storage.
        unsafe { outputs.add(at).write(SAFE) };
    }
    // SAFETY: written just now, and the caller says that they are ours.
    Code::of(work(unsafe { core::slice::from_raw_parts_mut(outputs, count) }))
}

/// One tick into answers in the safe state, as many as there are poses.
///
/// # Safety
/// As [`chaincell_tick`].
unsafe fn tick(
    tissue: *mut Tissue,
    poses: *const ToolPose,
    count: usize,
    budget: *const Budget,
    outputs: &mut [Output],
) -> Result<(), Code> {
    // SAFETY: the caller's promises are handed on.
    let (scheme, sizes) = unsafe { layout::front(tissue) }?;
    if !(1..=sizes.touch.tools().max(1)).contains(&count) {
        return Err(Code::Range);
    }
    // SAFETY: the layouts are the same, and the caller says what stands there.
    let poses: &[KernelPose] = unsafe { memory::slice(poses.cast(), count) }?;
    let budget = match budget.is_null() {
        true => None,
        // SAFETY: the caller's promises are handed on.
        false => Some(unsafe { memory::read(budget) }?),
    };
    let answer = by_scheme!(scheme, D => {
        // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
        let Parts { network, tissue: mut body, .. } = unsafe { layout::parts::<D>(tissue, sizes) };
        // SAFETY: the caller's promise is handed on.
        let answer =
            unsafe { with_budget(budget.as_ref(), |budget| body.tick(network, poses, budget)) };
        let force_error_n = told(body.force_error_n(network, 0));
        Output { relaxed_j: body.relaxed_j(network), force_error_n, ..Output::of(&answer) }
    });
    outputs.fill(answer);
    if cfg!(feature = "surface") && !sizes.touch.is_none() {
        by_touching_scheme!(scheme, D => {
            // SAFETY: as above.
            let Parts { network, tissue: body, .. } = unsafe { layout::parts::<D>(tissue, sizes) };
            for (tool, output) in outputs.iter_mut().enumerate() {
                output.force_error_n = told(body.force_error_n(network, tool));
                output.torque_error_n_m = told(body.torque_error_n_m(network, tool));
            }
            give_each_its_own(outputs, poses, |tool| body.tool_output(network, tool));
        });
    }
    Ok(())
}

/// Gives each of the tools on a surface its own part of the tick's answer, which stands in all `outputs`.
fn give_each_its_own(
    outputs: &mut [Output],
    poses: &[KernelPose],
    felt: impl Fn(usize) -> KernelOutput,
) {
    let tools = outputs.len();
    let is_shared = tools > 1 && (0..tools).any(|tool| felt(tool) != KernelOutput::NONE);
    for (tool, (output, pose)) in outputs.iter_mut().zip(poses).enumerate() {
        let flags = output.tool.flags;
        if flags & Flags::SAFE_STATE.0 != 0 {
            continue;
        }
        // What a tool felt stays until the next tick with a sweep.
        let (felt, is_late) = (felt(tool), flags & Flags::LATE.0 != 0);
        if is_shared && !is_late {
            output.work_j = felt.work_j;
        }
        if tool > 0 {
            output.tool.force_n = felt.force_n.into();
            output.tool.contacts = felt.contacts;
            output.stiffness_n_per_m = felt.stiffness_n_per_m;
        }
        output.tool.torque_n_m = felt.torque_n_m.into();
        if is_late && pose.is_good() && pose.engaged == 0 {
            (output.tool.force_n, output.tool.torque_n_m) = ([0.0; 3], [0.0; 3]);
            (output.force_error_n, output.torque_error_n_m) = (UNKNOWN_N, UNKNOWN_N);
        }
    }
}

/// One tick with a pose for each tool, and an answer to each in `outputs`: infallible with good pointers,
/// and with a number of link passes that is bounded whatever the poses say. Bad samples are held for
/// up to 10 ticks, then the safe state answers.
///
/// `count` is 1, or up to as many tools as the tissue has room for, best as many as were chosen. Tools
/// beyond the poses stay as they are; but all let go where no pose is engaged. One bad pose makes the
/// sample a bad one. A null `budget` stands for all sweeps of the settings; `outputs->sweeps` says how
/// many were made, and the level is certified after every one. A single output has the work of all tools.
///
/// Where a pointer is bad nothing moves, and `outputs` that can be written say force 0 with
/// `CHAINCELL_FLAG_SAFE_STATE`. The calling thread's arithmetic is that of the last reset.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `poses` are `count` poses,
/// `budget` is null or a budget, whose `more` is null or may be called with its `context` and does not
/// touch the tissue; `outputs` is storage for `count` answers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_tick(
    tissue: *mut Tissue,
    poses: *const ToolPose,
    count: usize,
    budget: *const Budget,
    outputs: *mut Output,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe { answer_to(outputs, count, |outputs| tick(tissue, poses, count, budget, outputs)) }
}

/// Output of a state in single precision.
fn published<N: Number>(network: &Network<'_>, v: &Cell<N>) -> [f32; 3] {
    single(output(v.xyz(), N::from_single(network.model().saturation())))
}

/// The state hash: 64 bits over the published positions of all cells, over their shapes where they have
/// any, and over the cuts of a body that is cut; the same on every target.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread writes it; `hash` is storage
/// for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_state_hash(tissue: *const Tissue, hash: *mut u64) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { layout::front(tissue) }.and_then(|(scheme, sizes)| {
        memory::check(hash)?;
        // SAFETY: a tissue of this scheme stands there, and nobody writes it.
        let value = unsafe {
            by_scheme!(scheme, D => {
                let of = layout::published::<D>(tissue, sizes);
                let model = of.network.model();
                let hash = state_hash(of.state, of.terms, model.saturation());
                let hash = cut_state(of.words, model).map_or(hash, |words| and_words(hash, words));
                of.pins.map_or(hash, |(state, pins)| and_pins(hash, state, pins))
            })
        };
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(hash, value) }
    }))
}

/// Published position of a node of the input mesh, by its id, in the frame of the input mesh \[m\]: of a
/// model baked with --cells and without --lean from the cells around the node, of others that of the
/// node's cell. Cost: the node's weights, or a look through all cells for the id.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread writes it; `position_m` is
/// storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_position(
    tissue: *const Tissue,
    input_id: u32,
    position_m: *mut [f32; 3],
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { layout::front(tissue) }.and_then(|(scheme, sizes)| {
        memory::check(position_m)?;
        // SAFETY: a tissue of this scheme stands there, and nobody writes it.
        let (network, position) = unsafe {
            by_scheme!(scheme, D => {
                let Published { network, state, .. } = layout::published::<D>(tissue, sizes);
                let (model, at) =
                    (network.model(), |cell: usize| state.get(cell).map(|v| published(network, v)));
                let of_cell = || model.cell_of_input(input_id).and_then(|cell| at(cell.into()));
                (network, model.fine_position(input_id as usize, at).or_else(of_cell))
            })
        };
        let (model, [x, y, z]) = (network.model(), position.ok_or(Code::UnknownId)?);
        let ([a, b, c], unit) = (model.centre_m(), model.unit_m());
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(position_m, [a + x * unit, b + y * unit, c + z * unit]) }
    }))
}

/// Published positions of all cells, x, y, z of each in the model's order (`chaincell_model_input_id`)
/// [mean link lengths from the body's centre]: bit by bit what `chaincell_set_positions` takes.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread writes it; `positions` has room
/// for 3 `cells` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_positions(
    tissue: *const Tissue,
    positions: *mut f32,
    cells: usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { layout::front(tissue) }.and_then(|(scheme, sizes)| {
        if cells != sizes.cells {
            return Err(Code::StateCount);
        }
        memory::check(positions)?;
        // SAFETY: a tissue of this scheme stands there, and nobody writes it.
        unsafe {
            by_scheme!(scheme, D => {
                let Published { network, state, .. } = layout::published::<D>(tissue, sizes);
                for (cell, v) in state.iter().enumerate() {
                    // SAFETY: the caller says that there is room for all cells.
                    positions.cast::<[f32; 3]>().add(cell).write(published(network, v));
                }
            })
        }
        Ok(())
    }))
}

/// Puts every cell, fixed ones too, at a position, without motion and with the tool released; the
/// contact cells stay chosen. Order and unit are those of `chaincell_positions`. A refused state
/// changes nothing. `detail` may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `positions` are 3
/// `cells` numbers, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_set_positions(
    tissue: *mut Tissue,
    positions: *const f32,
    cells: usize,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            if cells != sizes.cells {
                return Err(Refusal::sizes(Code::StateCount, sizes.cells, cells));
            }
            let positions = memory::slice(positions.cast::<[f32; 3]>(), cells)?;
            by_scheme!(scheme, D => {
                let Parts { network, tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                Ok(body.set_positions(network, positions)?)
            })
        })
    }
}
