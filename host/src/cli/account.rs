//! The account of energy of a run with tools on the surface of a body that can be cut, or that relaxes.

use std::fmt;

use serde::Serialize;

use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::error::Result;
use crate::terminal;

/// Where the energy went that tools gave a body.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct AccountReport {
    /// Energy that the tools gave the body, less what it gave back to them \[J\].
    given_j: f64,
    /// Energy that the body stores at the end \[J\].
    stored_j: f64,
    /// The rest: neither stored, nor relaxed, nor used to part the tissue \[J\].
    dissipated_j: f64,
    /// Work that parted the tissue \[J\]; `None` for a body that cannot be cut.
    #[serde(skip)]
    cut_j: Option<f64>,
    /// Energy that branches have relaxed \[J\]; `None` for an elastic body.
    #[serde(skip)]
    relaxed_j: Option<f64>,
}

impl AccountReport {
    /// The account at the end, of the energy that the tools have given in all ticks, see
    /// [`TissueMut::given_j`](chaincell_kernel::TissueMut::given_j), and of that which the body stores; `None` for a
    /// run that holds cells, and for a body that neither can be cut nor relaxes.
    pub fn of([given_j, stored_j]: [f64; 2], tissue: &mut Staged<'_>) -> Option<Self> {
        let is_of_tools = tissue.tools() > 0;
        let engine = tissue.engine_mut();
        let cut_j = engine.can_be_cut().then(|| f64::from(engine.cut_output().work_j));
        let relaxed_j = engine.relaxed_j().map(f64::from);
        let is_kept = is_of_tools && (cut_j.is_some() || relaxed_j.is_some());
        let used_j = cut_j.unwrap_or(0.0) + relaxed_j.unwrap_or(0.0);
        let dissipated_j = given_j - stored_j - used_j;
        is_kept.then_some(Self { given_j, stored_j, dissipated_j, cut_j, relaxed_j })
    }
}

impl fmt::Display for AccountReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { given_j, stored_j, dissipated_j, cut_j, relaxed_j } = self;
        write!(f, "{:.3} mJ of the tools: {:.3} stored", 1e3 * given_j, 1e3 * stored_j)?;
        if let Some(cut_j) = cut_j {
            write!(f, ", {:.3} parted the tissue", 1e3 * cut_j)?;
        }
        if let Some(relaxed_j) = relaxed_j {
            write!(f, ", {:.3} relaxed", 1e3 * relaxed_j)?;
        }
        write!(f, ", {:.3} dissipated", 1e3 * dissipated_j)
    }
}

/// Prints an account, its name in a column of this width.
pub fn tell_account(width: usize, account: Option<&AccountReport>) -> Result<()> {
    account.map_or(Ok(()), |of| terminal::say(format_args!("  {:<width$}{of}", "energy")))
}
