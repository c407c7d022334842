//! What is measured of an image, as JSON and as a table.

use anyhow::{Context, Result, ensure};
use chaincell_kernel::Choice;
use chaincell_scenes::Tier;
use serde::Serialize;

use crate::case::{Ready, Shape};
use crate::emulate::Said;
use crate::host::{self, Answer};
use crate::image::Image;
use crate::target::Target;

/// Cycles beyond one that a square root or a division keeps the FPU busy: 14 on the Cortex-M4 by
/// its reference manual; that of the Cortex-M7 gives none.
const STALL_CYCLES: u64 = 13;

/// Figures of one image.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    pub target: &'static str,
    pub core: &'static str,
    pub scene: &'static str,
    pub tier: &'static str,
    pub scheme: &'static str,
    pub cells: usize,
    pub links: usize,
    pub coarse_functions: usize,
    pub sweeps: u16,
    pub ticks: u64,
    pub state_hash: String,
    pub host_state_hash: String,
    pub digest: String,
    pub host_digest: String,
    pub instructions_per_tick_worst: u64,
    pub instructions_per_sweep_worst: u64,
    pub instructions_per_tick_rest: u64,
    /// Of a tool that presses the surface, its slots full.
    pub touch: Option<Touch>,
    /// Of a blade.
    pub cut: Option<Cut>,
    /// Sweeps of a tick that ended when half the instructions of a whole one were used up.
    pub sweeps_in_budget: u64,
    /// Sweeps of that whole one.
    pub sweeps_at_most: u64,
    /// An estimate, not a measurement: see [`estimate`]. Cortex-M7 only.
    pub cycles_per_tick_worst_estimate: Option<u64>,
    pub flash_bytes: u64,
    pub ram_bytes: u64,
    pub stack_bytes: u64,
    pub model_bytes: usize,
    /// Interrupts that found the queue full, since a tick took more than 480,000 instructions.
    pub late_interrupts: u64,
}

/// What a tool on the surface costs.
#[derive(Debug, Clone, Serialize)]
pub struct Touch {
    /// The dearest tick of a press.
    pub instructions_per_tick_touch: u64,
    pub instructions_per_sweep_touch: u64,
    /// The last tick of it, and the same where the tool let go before.
    pub instructions_of_last_touch: u64,
    pub instructions_without_tool: u64,
    pub contacts: u64,
}

impl Touch {
    /// A further line of the table.
    fn line(&self) -> String {
        let Self { contacts, instructions_of_last_touch: with, .. } = self;
        format!(
            "\n  on the surface: sweep {}, tick at most {}; the last one of the press, {contacts} \
             triangles in contact, {with}, without a tool {}",
            self.instructions_per_sweep_touch,
            self.instructions_per_tick_touch,
            self.instructions_without_tool
        )
    }

    fn of(ready: &Ready, said: &Said) -> Result<Option<Self>> {
        let Some(tool) = ready.case.tool.filter(|_| !ready.is_cut()) else {
            return Ok(None);
        };
        let contacts = said.number("contacts_touch")?;
        ensure!(contacts > 0, "the press touches nothing");
        ensure!(said.number("contacts_without_tool")? == 0, "a tool that let go is in contact");
        let grips = ["gripped", "contact_forces", "gripped_after"];
        let [gripped, forces, after] = grips.map(|name| said.number(name));
        let grips_well = gripped? > 0 && forces? > 0 && after? == 0;
        ensure!(grips_well, "the tool does not grip and let go");
        // A golden scene has slots to spare.
        let is_full = said.number("slots_full")? == 1 || matches!(tool.shape, Shape::Golden);
        ensure!(is_full, "not all slots for triangles are taken");
        Ok(Some(Self {
            instructions_per_tick_touch: said.number("instructions_per_tick_touch")?,
            instructions_per_sweep_touch: said.number("instructions_per_sweep_touch")?,
            instructions_of_last_touch: said.number("instructions_of_last_touch")?,
            instructions_without_tool: said.number("instructions_without_tool")?,
            contacts,
        }))
    }
}

/// What cutting costs.
#[derive(Debug, Clone, Serialize)]
pub struct Cut {
    /// The dearest tick in which cells split, and how many copies it made.
    pub instructions_per_tick_split: u64,
    pub copies_of_that_tick: u64,
    /// The dearest tick of the scene in which none did.
    pub instructions_per_tick_whole: u64,
    pub opened_faces: u64,
    pub copies: u64,
}

impl Cut {
    /// A further line of the table.
    fn line(&self) -> String {
        format!(
            "\n  cut: {} faces open, {} copies; tick at most {} with a split, of {} copies, {} without",
            self.opened_faces,
            self.copies,
            self.instructions_per_tick_split,
            self.copies_of_that_tick,
            self.instructions_per_tick_whole
        )
    }

    fn of(ready: &Ready, said: &Said) -> Result<Option<Self>> {
        if !ready.is_cut() {
            return Ok(None);
        }
        let copies = said.number("copies")?;
        ensure!(copies > 0, "the blade splits no cell");
        Ok(Some(Self {
            instructions_per_tick_split: said.number("instructions_per_tick_split")?,
            copies_of_that_tick: said.number("copies_of_that_tick")?,
            instructions_per_tick_whole: said.number("instructions_per_tick_whole")?,
            opened_faces: said.number("opened_faces")?,
            copies,
        }))
    }
}

/// Cycles of a tick on a Cortex-M7, estimated: one a instruction, as if what dual issue saves were
/// lost again to loads that wait and to branches; and for every link and sweep the stalls of one
/// square root and one division. Code and model in memory without wait states.
fn estimate(target: &Target, instructions: u64, links: usize, sweeps: u16) -> Option<u64> {
    let stalls = 2 * STALL_CYCLES * links as u64 * u64::from(sweeps);
    (target.name == "m7").then_some(instructions + stalls)
}

impl Figures {
    /// Puts together what the image said; fails where it differs from this machine's answer.
    pub fn new(
        target: &Target,
        ready: &Ready,
        tier: Tier,
        image: &Image,
        said: &Said,
        host: Answer,
    ) -> Result<Self> {
        let (links, sweeps) = (ready.model.links(), ready.settings().sweeps);
        let worst = said.number("instructions_per_tick_worst")?;
        let figures = Self {
            target: target.name,
            core: target.core,
            scene: ready.case.name,
            tier: tier.name(),
            scheme: ready.scene.scheme,
            cells: ready.model.cells(),
            links,
            coarse_functions: ready.model.coarse_functions(),
            sweeps,
            ticks: said.number("ticks")?,
            state_hash: format!("{:016x}", said.bits("state_hash")?),
            host_state_hash: format!("{:016x}", host.state_hash),
            digest: format!("{:016x}", said.bits("digest")?),
            host_digest: format!("{:016x}", host.digest),
            instructions_per_tick_worst: worst,
            instructions_per_sweep_worst: said.number("instructions_per_sweep_worst")?,
            instructions_per_tick_rest: said.number("instructions_per_tick_rest")?,
            touch: Touch::of(ready, said)?,
            cut: Cut::of(ready, said)?,
            sweeps_in_budget: said.number("sweeps_in_budget")?,
            sweeps_at_most: said.number("sweeps_at_most")?,
            cycles_per_tick_worst_estimate: estimate(target, worst, links, sweeps),
            flash_bytes: image.flash_bytes,
            ram_bytes: image.ram_bytes,
            stack_bytes: said.number("stack_bytes")?,
            model_bytes: ready.scene.image.len(),
            late_interrupts: said.number("late")?,
        };
        let name = format!("{} {} {}", figures.target, figures.scene, figures.tier);
        ensure!(figures.ticks == u64::from(ready.ticks), "{name}: {} ticks", figures.ticks);
        // REQ-BIT-01
        let (own, hosts) = (&figures.digest, &figures.host_digest);
        ensure!(
            own == hosts && figures.state_hash == figures.host_state_hash,
            "{name}: not the bits of this machine: state hash {} and {}, digest {own} and {hosts}",
            figures.state_hash,
            figures.host_state_hash
        );
        ensure!(said.number("moved_at_rest")? == 0, "{name}: an untouched body moved");
        ensure!(image.allocators.is_empty(), "{name}: allocates: {:?}", image.allocators);
        figures.hold_budget(ready, tier, said.bits("hash_in_budget")?).context(name)?;
        Ok(figures)
    }

    /// The tick against the clock: ended by it where the scheme can end after any sweep, and the
    /// bits of this machine for the sweeps that it made.
    fn hold_budget(&self, ready: &Ready, tier: Tier, hash: u64) -> Result<()> {
        let (made, at_most) = (self.sweeps_in_budget, self.sweeps_at_most);
        let is_ended = matches!(self.scheme, "track" | "predict");
        let is_right = if is_ended { (1..at_most).contains(&made) } else { made == at_most };
        ensure!(is_right, "{made} of {at_most} sweeps in half the instructions of all");
        let own = host::again(ready, tier, at_most.try_into()?, made.try_into()?)?;
        ensure!(own == hash, "after {made} sweeps: {hash:016x}, on this machine {own:016x}");
        Ok(())
    }

    /// Head of the table.
    pub fn head() -> String {
        format!(
            "{:5} {:23} {:>6} {:>7} {:>5} {:>3} {:>5} {:>16} {:>11} {:>11} {:>8} {:>9} {:>9} {:>7} {:>11}",
            "core",
            "scene, number",
            "cells",
            "links",
            "coarse_functions",
            "swp",
            "ticks",
            "state hash",
            "sweep worst",
            "tick worst",
            "rest",
            "flash",
            "RAM",
            "stack",
            "cycles est."
        )
    }

    /// Its line of the table.
    pub fn line(&self) -> String {
        let cycles = self.cycles_per_tick_worst_estimate;
        format!(
            "{:5} {:23} {:6} {:7} {:5} {:3} {:5} {} {:11} {:11} {:8} {:9} {:9} {:7} {:>11}",
            self.target,
            format!("{} {}", self.scene, self.tier),
            self.cells,
            self.links,
            self.coarse_functions,
            self.sweeps,
            self.ticks,
            self.state_hash,
            self.instructions_per_sweep_worst,
            self.instructions_per_tick_worst,
            self.instructions_per_tick_rest,
            self.flash_bytes,
            self.ram_bytes,
            self.stack_bytes,
            cycles.map_or(String::new(), |cycles| cycles.to_string())
        ) + &self.touch.as_ref().map_or(String::new(), Touch::line)
            + &self.cut.as_ref().map_or(String::new(), Cut::line)
    }
}
