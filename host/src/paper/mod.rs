//! `chaincell paper`: every result of the paper computed here, beside the method it improves on.

pub mod scaling;
pub mod section;
