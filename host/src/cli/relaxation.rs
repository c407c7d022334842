//! The report on a body that relaxes: its branches, its moduli in the end, and the memory that they take.

use chaincell_kernel::{Model, cut_words};
use serde::Serialize;

use crate::bake::tissue::Moduli;
use crate::error::Result;
use crate::terminal;

/// A branch in the image.
#[derive(Debug, Serialize)]
struct BranchReport {
    /// Shear modulus, or the stiffness of links, over the long-term one.
    ratio: f32,
    time_s: f32,
    /// Share of the instantaneous one.
    share: f32,
}

/// Branches of relaxation with what follows from them.
#[derive(Debug, Serialize)]
pub(super) struct RelaxationReport {
    branches: Vec<BranchReport>,
    /// Length of a tick for which they were baked \[s\].
    tick_s: f32,
    /// Means of the cells when all branches have relaxed; none in a body of links.
    long_term_young_pa: Option<f64>,
    long_term_poisson: Option<f64>,
    /// The part that is then left of the stiffness that the body has at once.
    left: f32,
    /// Bytes that a tissue needs for its memory beside the model's `ram_bytes`.
    ram_bytes: usize,
}

impl RelaxationReport {
    /// Reads the figures off a model; `None` for one that does not relax.
    pub fn of(model: &Model<'_>) -> Option<Self> {
        let fading: f32 = model.branches().map(|branch| branch.share).sum();
        let branches: Vec<_> = model
            .branches()
            .map(|branch| BranchReport {
                ratio: branch.share / (1.0 - fading),
                time_s: rounded(branch.time_s),
                share: branch.share,
            })
            .collect();
        let tick_s = model.branches().next()?.tick_s;
        // The means of the cells.
        let long_term = (0..model.body_cells()).filter_map(|cell| {
            let [young_pa, poisson] = model.elasticity(cell)?.map(f64::from);
            Some(Moduli { young_pa, poisson }.long_term(fading.into()))
        });
        let cells = model.body_cells() as f64;
        let [mut young_pa, mut poisson] = [0.0; 2];
        for moduli in long_term {
            young_pa += moduli.young_pa / cells;
            poisson += moduli.poisson / cells;
        }
        Some(Self {
            branches,
            tick_s,
            long_term_young_pa: model.is_nodal().then_some(young_pa),
            long_term_poisson: model.is_nodal().then_some(poisson),
            left: 1.0 - fading,
            ram_bytes: cut_words(model) * size_of::<u32>(),
        })
    }

    /// Rows of a table on standard output.
    pub fn print(&self) -> Result<()> {
        let row = |name: &str, value: String| terminal::say(format_args!("  {name:<14}{value}"));
        let (in_the_end, of) = match self.long_term_young_pa.zip(self.long_term_poisson) {
            Some((young_pa, poisson)) => {
                (format!("{young_pa:.0} Pa, Poisson's ratio {poisson:.3}"), "shear modulus")
            }
            None => (format!("{:.1} % of the first stiffness", 100.0 * self.left), "stiffness"),
        };
        let (ram_bytes, tick_ms) = (self.ram_bytes, 1e3 * self.tick_s);
        row("relaxed", format!("{in_the_end}; {ram_bytes} bytes of RAM, ticks of {tick_ms} ms"))?;
        for BranchReport { ratio, time_s, share } in &self.branches {
            let share = 100.0 * share;
            let relative = format!("{ratio:.3} times the relaxed {of}");
            row(
                "branch",
                format!("{relative}, {share:.1} % of the first one, fades in {time_s} s"),
            )?;
        }
        Ok(())
    }
}

/// The number of six digits nearest to a time, which the image has in ticks.
fn rounded(time_s: f32) -> f32 {
    format!("{time_s:.5e}").parse().unwrap_or(time_s)
}
