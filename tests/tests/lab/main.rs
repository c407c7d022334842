//! The laboratory's commands, and its references against data computed elsewhere.

mod brain;
mod identify;
mod paper;
mod quick;
mod reference;
mod relaxation;
mod report;
mod sphere;
mod stress;
