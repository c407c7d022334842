//! `chaincell paper`: every result of the paper computed here, beside the method it improves on.

pub mod body;
pub mod choices;
pub mod identified;
pub mod mechanics;
pub mod methods;
pub mod profile;
pub mod scaling;
pub mod section;
