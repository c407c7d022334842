//! `chaincell report`: speed against error, measured and written down.
//!
//! Every figure comes with the body and the tool that it was measured on. Times depend on the
//! machine and its load: compare ratios within one report. Sweeps and errors do not.
//!
//! | section of REPORT.md | question | numbers |
//! |---|---|---|
//! | A hand that moves | time a tick and error of the force for held cells under a hand's motions, every scheme of a list, two bodies | `report_hand.csv` |
//! | A tool that moves | time a tick and error of the force for tools pressed into a surface and drawn over it, bodies of both kinds | `report_tools.csv` |
//!
//! An error of the force is relative: to the exact force under a hand, to the largest force of the
//! motion under a tool. Which ticks count under a hand, and which are left out because the body
//! snaps from one equilibrium to another, is one rule: see [`snaps`]. `report_summary.json` has
//! every figure, the CSV files the rows of the tables.

pub mod collect;
pub mod embedded;
pub mod engine;
pub mod hand;
pub mod motions;
pub mod pictures;
pub mod scene;
pub mod setting;
pub mod snaps;
pub mod tables;
pub mod tools;
pub mod write;
