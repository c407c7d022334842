//! `chaincell report`: speed against error, measured and written down.
//!
//! Every figure comes with the body and the tool that it was measured on. Times depend on the
//! machine and its load: compare ratios within one report. Sweeps and errors do not.
//!
//! | section of REPORT.md | question | numbers |
//! |---|---|---|
//! | Error against time | error and time a tick of every setting on one body; `track` in half a millisecond | `report_press.csv`, `report_time.csv` |
//! | A hand that moves | time a tick and error of the force for held cells under a hand's motions, every scheme of a list, two bodies | `report_hand.csv` |
//! | Model error | how far the exact equilibrium of links and nodal tissue, and the running kernel, are from finite elements | `report_model.csv`, `report_model_running.csv` |
//! | A measured specimen | force of a sheet of nodal shapes, with stiffening and without, beside a measured one | `report_specimen.csv` |
//! | Held cells, a moving probe, a load | error and time for each way in which a tool acts | `report_tools.csv` |
//! | The sweep | time of one sweep in its worst state, beside a plain loop | `report_summary.json` |
//! | Time to equilibrium | sweeps and time until a pressed cell is settled, beside mass-spring and position-based dynamics | `report_settle.csv` |
//! | A press by 3 mean link lengths | error of every scheme against the exact path of energy minima | `report_press.csv` |
//!
//! An error of the field is |u - `u_exact`| over |`u_exact`|, L2 over the cells; an error of the
//! force is relative to the exact force. Which ticks count, and which are left out because the body
//! snaps from one equilibrium to another, is one rule for all tables: see [`snaps`].
//! `report_summary.json` has every figure, the CSV files the rows of the tables.

pub mod collect;
pub mod embedded;
pub mod exact;
pub mod hand;
pub mod model;
pub mod motions;
pub mod pictures;
pub mod press;
pub mod scene;
pub mod setting;
pub mod settle;
pub mod snaps;
pub mod specimen;
pub mod tables;
pub mod tools;
pub mod worst;
pub mod write;
