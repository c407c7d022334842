//! `chaincell paper`: every result of the paper computed here, beside the method it improves on.
//!
//! | experiment | result of the paper | files, `paper_` in front |
//! |---|---|---|
//! | [`plane`] | Fig. 4: the shape of a plane whose centre is displaced | `plane`, `profile_4`, `profile_8` |
//! | [`mechanics`] | Fig. 5: force over displacement, unloading, stress relaxation | one picture and one CSV file a curve and body |
//! | [`tissue`] | Fig. 5b and 5c for tissue that relaxes, beside measured curves | `fig5b_tissue`, `fig5c_tissue`, `tissue*` |
//! | [`liver`] | Fig. 6: the liver under a probe | `liver`, `liver_force`, `liver_press` |
//! | [`scaling`] | left open there: many elements to one cell | `scaling` |
//! | [`identified`] | left open there: the material parameters | `identified*` |
//!
//! `paper.html` begins with a table of the paper's results, each with what was computed here. Every
//! section then says on which body, with which tool and settings. `paper.json` holds the figures of
//! each section under its key, with units in the names; the CSV files hold the numbers of the
//! pictures. Only the times of ticks depend on the machine. The other method is traditional
//! `ChainMail`. Without reference data the generated organ stands in for the liver.

pub mod body;
pub mod identified;
pub mod liver;
pub mod mechanics;
pub mod plane;
mod press;
pub mod scaling;
pub mod tissue;

use super::page::Page;

/// The page, with every experiment in order.
pub static PAGE: Page = Page {
    name: "paper",
    title: "The paper's results, computed anew",
    intro: "J. Zhang, Y. Zhong, J. Smith, C. Gu: ChainMail based neural dynamics modeling of soft \
            tissue deformation for surgical simulation, Technology and Health Care, 2017. Every \
            picture, table and figure below was computed by the command named here. The other method \
            is traditional ChainMail, in the generalised form of Li and Brodlie, which on a lattice is \
            Gibson's. The numbers of the pictures are files in the folder of this page.",
    experiments: &[
        plane::section,
        mechanics::section,
        tissue::section,
        liver::section,
        scaling::section,
        identified::section,
    ],
};
