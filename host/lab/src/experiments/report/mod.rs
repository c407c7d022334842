//! `chaincell report`: speed against error, measured and written down.

pub mod collect;
pub mod exact;
pub mod firmware;
pub mod flow;
pub mod growth;
pub mod machine;
pub mod numbers;
pub mod pareto;
pub mod pictures;
pub mod press;
pub mod quiet;
pub mod recommend;
pub mod scene;
pub mod setting;
pub mod settle;
pub mod tables;
pub mod tools;
pub mod worst;
pub mod write;
