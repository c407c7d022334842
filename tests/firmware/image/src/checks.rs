//! What an image built with the feature `checks` tries behind the measured parts: traces both ways,
//! and states and samples that should never come.

use chaincell_kernel::Budget;
use chaincell_kernel::Model;
use chaincell_kernel::trace::{RECORD_BYTES, Reader, header_bytes};
use chaincell_scenes::Run;
use chaincell_scenes::adverse::endure;
use static_cell::ConstStaticCell;

use crate::console;
use crate::measure::{Tissue, part};
use crate::scene::{ALTERED, CELLS, HELD, SCENE, Scheme, TRACE, TRACE_TICKS};

/// Bytes of a trace in a line.
const LINE_BYTES: usize = 40;
/// A place for each cell, for the states.
static PLACES: ConstStaticCell<[[f32; 3]; CELLS]> = ConstStaticCell::new([[0.0; 3]; CELLS]);

/// All of it. `None` where the kernel refuses the scene or a trace.
pub fn run(tissue: &mut Tissue) -> Option<()> {
    replay(tissue, TRACE, ["replayed", "compared", "differs_at"])?;
    replay(tissue, ALTERED, ["altered_replayed", "altered_compared", "altered_differs_at"])?;
    record(tissue)?;
    adverse(tissue)
}

/// Plays a trace of the workstation; says how many ticks and hashes, or the first that differs.
fn replay(tissue: &mut Tissue, trace: &[u8], names: [&str; 3]) -> Option<()> {
    let [replayed, compared, differs_at] = names;
    let trace = Reader::open(trace).ok().filter(|trace| trace.header().is_of::<Scheme>())?;
    let model = Model::from_bytes(SCENE.image).ok()?;
    let network = trace.header().network(model).ok()?;
    let mut room = [0; HELD.len()];
    tissue.reset(&network).ok()?;
    tissue.choose_contacts(&network, trace.contact_cells(&model, &mut room).ok()?).ok()?;
    let played = trace.play(|record| {
        // The traces of the scenes have no late ticks, whose code is left out here.
        let most = record.sweeps.unwrap_or(u16::MAX);
        tissue.tick(&network, &[record.sample], Budget::While(&mut |done| done < most));
        tissue.state_hash(&model)
    });
    match played {
        Ok(played) => {
            console::number(replayed, played.ticks);
            console::number(compared, played.compared);
        }
        Err(why) => console::number(differs_at, why.tick as u32),
    }
    Some(())
}

/// Plays the scene once more and sends its trace, as hexadecimal lines: what a device writes to its
/// flash, or to a wire.
fn record(tissue: &mut Tissue) -> Option<()> {
    let mut run = Run::new(&SCENE, part(tissue)).ok()?;
    let mut header = [0; header_bytes(HELD.len())];
    let (mut writer, _) = run.begin_trace(&mut header)?;
    header.chunks(LINE_BYTES).for_each(send);
    for _ in 0..TRACE_TICKS {
        send(&writer.record(&run.record()));
    }
    Some(())
}

/// Sends bytes of the trace as a line.
fn send(bytes: &[u8]) {
    let mut digits = heapless::Vec::<u8, { 2 * RECORD_BYTES }>::new();
    for &byte in bytes {
        // No line has more bytes than a record.
        let _ = digits.extend_from_slice(&console::digits_of(byte));
    }
    console::put_line("trace", &digits);
}

/// Endures all hard states; says the digest after each, or what went wrong.
fn adverse(tissue: &mut Tissue) -> Option<()> {
    let places = PLACES.try_take()?;
    if let Err(why) = endure(&SCENE, part(tissue), places, console::bits) {
        console::say("wrong", why.what.name());
        console::say("wrong_state", why.state);
        console::number("wrong_tick", why.tick);
    }
    Some(())
}
