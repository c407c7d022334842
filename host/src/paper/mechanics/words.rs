//! x
use super::Results;
use crate::report::tables::Table;
pub fn text(_b: &[Results]) -> Vec<String> { Vec::new() }
pub fn tables(_b: &[Results]) -> Vec<(String, Table)> { Vec::new() }
