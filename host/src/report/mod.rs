//! `chaincell report`: speed against error, measured and written down.

pub mod collect;
pub mod exact;
pub mod flow;
pub mod growth;
pub mod machine;
pub mod pareto;
pub mod pictures;
pub mod press;
pub mod quiet;
pub mod scene;
pub mod settle;
pub mod tables;
pub mod worst;
pub mod write;

use clap::ValueEnum;

use crate::engine::Scheme;

/// Name of a scheme as in `--dynamics`.
#[must_use]
pub fn name(scheme: Scheme) -> String {
    scheme.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
}
