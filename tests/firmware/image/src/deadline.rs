//! Ticks that end in time, by the cycle counter: as many sweeps as fit.

use chaincell_kernel::Budget;

use crate::measure::{MANY, Tissue, count, moving, network, put};
use crate::scene::LONG;
use crate::{board, console};

/// Half the time of a whole tick from the worst state, interrupts on.
pub fn meet(tissue: &mut Tissue) -> Option<()> {
    let network = network(MANY)?;
    put(tissue, LONG, &network)?;
    let budget = count(|| tissue.tick(&network, &[moving(0)], Budget::All)) / 2;
    put(tissue, LONG, &network)?;
    let start = board::instructions();
    let mut is_time_left = |_| board::instructions().wrapping_sub(start) < budget;
    let output = tissue.tick(&network, &[moving(0)], Budget::While(&mut is_time_left));
    board::apply(output.force_n.into());
    console::number("sweeps_at_most", MANY.into());
    console::number("sweeps_in_budget", output.sweeps.into());
    console::bits("hash_in_budget", tissue.state_hash(network.model()));
    Some(())
}
