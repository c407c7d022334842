//! Ticks of a tool that presses the surface, counted in instructions.

use chaincell_kernel::{Budget, Flags, ToolPose};

use crate::measure::{MANY, Tissue, choose, count, network, put};
use crate::scene::{REST, SCENE, SWEEPS};
use crate::{board, console};

/// Sweeps of the other of the two ticks whose difference gives the cost of a sweep.
const FEW: u16 = 1;
/// Ticks of a press.
const TICKS: u32 = 24;

/// What is seen in a press.
#[derive(Default)]
struct Seen {
    /// Instructions of the last tick, and the most of one.
    last: u32,
    most: u32,
    contacts: u32,
    flags: u32,
    force_n: [f32; 3],
}

/// The tool straight in.
fn sample(tick: u32, engaged: u32) -> Option<ToolPose> {
    let [x, y, z] = SCENE.tools()?.start_m[0];
    let way_m = SCENE.reach_m * tick as f32 / TICKS as f32;
    Some(ToolPose::at([x, y, z - way_m].into(), engaged))
}

/// A press from rest, its last tick with so many sweeps; the tool lets go `free` ticks before that.
fn pressed(tissue: &mut Tissue, sweeps: u16, free: u32) -> Option<Seen> {
    let (plain, last) = (network(SWEEPS)?, network(sweeps)?);
    put(tissue, REST, &plain)?;
    let mut seen = Seen::default();
    for tick in 0..=TICKS {
        let network = if tick < TICKS { &plain } else { &last };
        let sample = sample(tick, u32::from(tick + free <= TICKS))?;
        seen.last = count(|| {
            let output = tissue.tick(network, &[sample], Budget::All);
            seen.contacts = output.contacts;
            seen.flags |= output.flags.0;
            seen.force_n = output.force_n.into();
            output
        });
        seen.most = seen.most.max(seen.last);
    }
    board::apply(seen.force_n);
    Some(seen)
}

/// What contact costs: a sweep, the dearest tick of a press, the last one, and that of a tool that
/// let go one tick before.
pub fn press(tissue: &mut Tissue) -> Option<()> {
    choose(tissue)?;
    let [few, many] = [pressed(tissue, FEW, 0)?, pressed(tissue, MANY, 0)?];
    let (whole, free) = (pressed(tissue, SWEEPS, 0)?, pressed(tissue, SWEEPS, 2)?);
    let sweep = many.last.wrapping_sub(few.last) / u32::from(MANY - FEW);
    console::number("instructions_per_sweep_touch", sweep);
    console::number("instructions_per_tick_touch", whole.most);
    console::number("instructions_of_last_touch", whole.last);
    console::number("instructions_without_tool", free.last);
    console::number("contacts_touch", whole.contacts);
    console::number("contacts_without_tool", free.contacts);
    let is_full = whole.flags & Flags::CONTACT_CAPACITY.0 != 0;
    console::number("slots_full", u32::from(is_full));
    grip(tissue)
}

/// A grip of what the tool touches while it turns: none of this may panic either.
fn grip(tissue: &mut Tissue) -> Option<()> {
    pressed(tissue, SWEEPS, 0)?;
    let network = network(SWEEPS)?;
    console::number("gripped", tissue.grip(&network, 0) as u32);
    let sample = sample(TICKS, 1)?;
    let pose = ToolPose { orientation: [0.0, 0.0, 0.1, 1.0], ..ToolPose::at(sample.position_m, 1) };
    board::apply(tissue.tick(&network, &[pose], Budget::All).force_n.into());
    board::apply(tissue.tool_output(&network, 0).torque_n_m.into());
    let mut contacts = 0;
    tissue.contact_forces(&network, |contact| {
        board::apply(contact.tangential_n);
        contacts += 1;
    });
    console::number("contact_forces", contacts);
    tissue.let_go(0, 1);
    board::apply(tissue.tick(&network, &[pose], Budget::LATE).force_n.into());
    board::apply(tissue.tick(&network, &[pose], Budget::All).force_n.into());
    console::number("gripped_after", tissue.gripped(&network, 0) as u32);
    Some(())
}
