//! Reports about a model, printed as a table or as JSON.

use std::collections::BTreeMap;
use std::fmt;

use chaincell_kernel::image::{cutting, nodal};
use chaincell_kernel::{Contact, Loose};
use chaincell_kernel::{
    Dynamics, Euler, Head, Model, Predict, Rkl2, TearLimit, TermState, Track, array_bytes,
    cut_words, term_states,
};
use serde::Serialize;

use super::relaxation::RelaxationReport;
use crate::bake::tissue::{Band, BandSide};
use crate::bake::{Equivalent, Notes};
use crate::error::Result;
use crate::terminal;
use crate::words::length;

/// Contact cells that the RAM figures allow for, the default of the kernel's `Tissue`.
const CONTACTS: usize = 64;

/// Links of a cell.
#[derive(Debug, Serialize)]
struct Valence {
    min: usize,
    mean: f64,
    max: usize,
}

/// A quantity of the cells.
#[derive(Debug, Serialize)]
struct Spread {
    /// Of the body as a whole.
    mean: f64,
    min: f64,
    max: f64,
}

impl Spread {
    /// The modulus that links are like.
    fn of_links(&self) -> String {
        let Self { mean, min, max } = self;
        let of = "beyond their bands links are like tissue of Poisson's ratio 1/4";
        if *max > 1.001 * min {
            return format!("{mean:.0} Pa ({min:.0} to {max:.0} from cell to cell): {of}");
        }
        format!("{mean:.0} Pa: {of}")
    }
}

/// Figures of a model.
#[derive(Debug, Serialize)]
pub struct ModelReport {
    cells: usize,
    nodes: usize,
    links: usize,
    fixed: usize,
    surface: usize,
    valence: Valence,
    dimension: u32,
    parts: u32,
    step_bound: f32,
    coarse_functions: usize,
    alpha: f32,
    alpha_varies: bool,
    stiffness_n_per_m: f32,
    stiffness_varies: bool,
    /// Young's modulus \[Pa\] and Poisson's ratio of a body of nodal shapes, the means of its cells, before
    /// anything has relaxed.
    #[serde(skip_serializing_if = "Option::is_none")]
    young_pa: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    poisson: Option<f64>,
    /// Young's modulus \[Pa\] of the tissue that links with a contact surface are like.
    #[serde(skip_serializing_if = "Option::is_none")]
    equivalent_young_pa: Option<Spread>,
    /// The stretch below which shapes resist more.
    #[serde(skip_serializing_if = "Option::is_none")]
    stretch_min: Option<f32>,
    /// The stiffening bands.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    stiffening: Vec<Band>,
    /// A body whose stress relaxes.
    #[serde(skip_serializing_if = "Option::is_none")]
    relaxation: Option<RelaxationReport>,
    /// A body that can be cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    cutting: Option<Cutting>,
    /// Nodes of each named group.
    groups: BTreeMap<String, usize>,
    /// Smallest and largest coordinate of a cell \[m\].
    bounding_box_m: [[f32; 3]; 2],
    mean_link_m: f32,
    centre_m: [f32; 3],
    k_m: f32,
    r_x: f32,
    capacitance: f32,
    energy_max_j: f32,
    image_bytes: usize,
    ram_bytes: usize,
    /// None where the body's cells move singly, which `euler` and `rkl2` refuse.
    #[serde(skip_serializing_if = "Option::is_none")]
    ram_bytes_euler: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ram_bytes_rkl2: Option<usize>,
    ram_bytes_predict: usize,
    checksum: String,
}

/// The limit at which a body tears by itself.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
enum Tears {
    Toughness,
    Stretch(f32),
}

/// Cutting, with its share of the image.
#[derive(Debug, Serialize)]
struct Cutting {
    tetrahedra: usize,
    spare_cells: usize,
    /// The largest of all cells'.
    toughness_j_per_m2: f32,
    /// The smallest, where cells differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    toughness_min_j_per_m2: Option<f32>,
    /// The limit at which the body tears by itself: `toughness`, or the stretch.
    tears: Option<Tears>,
    /// The fate of loose pieces: `leave`, `freeze` or `drop`.
    loose: &'static str,
    /// Bytes of the sections of tetrahedra and of the numbers of spare cells.
    image_bytes: usize,
    /// Bytes that a tissue needs for cuts beside the model's `ram_bytes`.
    ram_bytes: usize,
}

impl Cutting {
    /// Reads the figures off a model; `None` for a body that cannot be cut.
    fn of(model: &Model<'_>) -> Option<Self> {
        let (tetrahedra, spare_cells) = (model.tetrahedra_to_cut(), model.spare_cells());
        let limit = model.tear_limit();
        let words = if limit.is_some() { cutting::TEARING_WORDS } else { cutting::WORDS };
        // Corners and stars of a tetrahedron, the starts of the cells, and the words of `CUTTING`.
        let sections = tetrahedra * (4 * size_of::<u16>() + 4 * size_of::<u32>())
            + (model.cells() + 1) * size_of::<u32>()
            + words * size_of::<u32>();
        // Rest position, two row starts, mobility, coarse entry and factor, and the numbers of a cell.
        let coarse = if model.coarse_functions() > 0 { 6 } else { 0 };
        let spare = spare_cells * (12 + 8 + 4 + coarse + nodal::CELL_ROWS * size_of::<f32>());
        // The toughness of each cell, where they differ.
        let largest = model.toughness_j_per_m2()?;
        let each = (0..model.body_cells()).filter_map(|cell| model.cell_toughness_j_per_m2(cell));
        let smallest = Some(each.fold(largest, f32::min)).filter(|&smallest| smallest < largest);
        let of_cells = smallest.map_or(0, |_| model.body_cells() * size_of::<f32>());
        Some(Self {
            tetrahedra,
            spare_cells,
            toughness_j_per_m2: largest,
            toughness_min_j_per_m2: smallest,
            tears: limit.map(|limit| match limit {
                TearLimit::Toughness => Tears::Toughness,
                TearLimit::Stretch(stretch) => Tears::Stretch(stretch),
            }),
            loose: match model.loose() {
                Loose::Leave => "leave",
                Loose::Freeze => "freeze",
                Loose::Drop => "drop",
            },
            image_bytes: sections + spare + of_cells,
            ram_bytes: cut_words(model) * size_of::<u32>(),
        })
    }
}

impl fmt::Display for Cutting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            tetrahedra,
            spare_cells,
            toughness_j_per_m2,
            toughness_min_j_per_m2,
            tears,
            loose,
            image_bytes,
            ram_bytes,
        } = self;
        write!(f, "{tetrahedra} tetrahedra at ")?;
        if let Some(smallest) = toughness_min_j_per_m2 {
            write!(f, "{smallest} to ")?;
        }
        write!(
            f,
            "{toughness_j_per_m2} J/m^2, {spare_cells} spare cells, {image_bytes} bytes of flash, {ram_bytes} of RAM"
        )?;
        match tears {
            None => {}
            Some(Tears::Toughness) => write!(f, ", tears by its toughness")?,
            Some(Tears::Stretch(stretch)) => write!(f, ", tears at a stretch of {stretch}")?,
        }
        if *loose == "leave" { Ok(()) } else { write!(f, ", loose pieces: {loose}") }
    }
}

impl ModelReport {
    /// Reads the figures off a model of `image_bytes` bytes.
    pub fn new(model: &Model<'_>, image_bytes: usize) -> Self {
        let valence = |cell| model.neighbours(cell).count();
        let valences = || (0..model.body_cells()).map(valence);
        let through_time = !model.moves_singly();
        Self {
            cells: model.body_cells(),
            nodes: nodes(model),
            links: model.links(),
            fixed: model.fixed().len(),
            surface: model.surface().len(),
            valence: Valence {
                min: valences().min().unwrap_or(0),
                mean: 2.0 * model.links() as f64 / model.body_cells() as f64,
                max: valences().max().unwrap_or(0),
            },
            dimension: model.dimension(),
            parts: model.parts(),
            step_bound: model.step_max(),
            coarse_functions: model.coarse_functions(),
            alpha: model.alpha(),
            alpha_varies: model.alpha_varies(),
            stiffness_n_per_m: model.stiffness_n_per_m(),
            stiffness_varies: model.weight_varies(),
            young_pa: mean(model, 0),
            poisson: mean(model, 1),
            equivalent_young_pa: Equivalent::of_model(model).map(|of| Spread {
                mean: of.body_pa,
                min: of.cells_pa.iter().copied().fold(f64::INFINITY, f64::min),
                max: of.cells_pa.iter().copied().fold(0.0, f64::max),
            }),
            stretch_min: model.stretch_min().filter(|least| *least > 0.0),
            stiffening: Band::of_model(model),
            groups: Notes::read(model).groups.into_iter().map(|(k, ids)| (k, ids.len())).collect(),
            relaxation: RelaxationReport::of(model),
            cutting: Cutting::of(model),
            bounding_box_m: bounding_box_m(model),
            mean_link_m: model.unit_m(),
            centre_m: model.centre_m(),
            k_m: model.saturation() * model.unit_m(),
            r_x: model.resistance(),
            capacitance: model.capacitance(),
            energy_max_j: model.energy_max() * model.energy_unit_j(),
            image_bytes,
            ram_bytes: ram_bytes::<Track>(model),
            ram_bytes_euler: through_time.then(|| ram_bytes::<Euler>(model)),
            ram_bytes_rkl2: through_time.then(|| ram_bytes::<Rkl2>(model)),
            ram_bytes_predict: ram_bytes::<Predict>(model),
            checksum: format!("{:08x}", model.checksum()),
        }
    }

    /// The bounding box, in mm below a metre.
    fn box_words(&self) -> String {
        let [low, high] = self.bounding_box_m;
        let is_small = low.iter().chain(&high).all(|x| x.abs() < 1.0);
        let (times, unit) = if is_small { (1e3, "mm") } else { (1.0, "m") };
        let side = |axis: usize| format!("{:.1} to {:.1}", times * low[axis], times * high[axis]);
        format!("x {}, y {}, z {} {unit}", side(0), side(1), side(2))
    }

    /// Returns true if stiffening bands stay elastic beside branches that relax.
    pub fn has_elastic_bands(&self) -> bool {
        self.relaxation.is_some() && !self.stiffening.is_empty()
    }

    /// A table on standard output; those rows too that only firmware and the method's parameters need,
    /// where `is_full`.
    pub fn print(&self, is_full: bool) -> Result<()> {
        let row = |name: &str, value: String| terminal::say(format_args!("  {name:<14}{value}"));
        let rare = |name: &str, value: String| if is_full { row(name, value) } else { Ok(()) };
        let varies = |varies: bool| if varies { " (mean; stored per link)" } else { "" };
        // Print the network.
        row(
            "cells",
            format!("{}, {} fixed, {} on the surface", self.cells, self.fixed, self.surface),
        )?;
        if self.nodes != self.cells {
            row("nodes", format!("{}, carried along by the cells", self.nodes))?;
        }
        if !self.groups.is_empty() {
            let groups = self.groups.iter().map(|(name, nodes)| format!("{name} ({nodes} nodes)"));
            row("groups", groups.collect::<Vec<_>>().join(", "))?;
        }
        row("links", self.links.to_string())?;
        rare(
            "valence",
            format!("{} to {}, mean {:.1}", self.valence.min, self.valence.max, self.valence.mean),
        )?;
        rare("grid", format!("{} D, {} part(s)", self.dimension, self.parts))?;
        rare("coarse", format!("{} basis functions of the coarse level", self.coarse_functions))?;
        // Print its size.
        row("box", self.box_words())?;
        row("mean link", length(self.mean_link_m.into()))?;
        // Print the material.
        let alpha = format!("{}{}", self.alpha, varies(self.alpha_varies));
        if self.young_pa.is_some() {
            rare("alpha", alpha)?
        } else {
            row("alpha", alpha)?
        }
        if let (Some(young_pa), Some(poisson)) = (self.young_pa, self.poisson) {
            row(
                "tissue",
                format!("{young_pa:.0} Pa, Poisson's ratio {poisson:.3} (nodal shapes)"),
            )?;
            let band = match self.stretch_min {
                Some(least) => format!("band below a stretch of {least}"),
                None => "no band of stretches".to_owned(),
            };
            row("shapes", band)?;
            self.relaxation.as_ref().map_or(Ok(()), |of| of.print())?;
            self.stiffening.iter().try_for_each(|band| row("stiffening", stiffening(band)))?;
        } else {
            row(
                "stiffness",
                format!("{} N/m{}", self.stiffness_n_per_m, varies(self.stiffness_varies)),
            )?;
            self.relaxation.as_ref().map_or(Ok(()), |of| of.print())?;
        }
        if let Some(of) = &self.equivalent_young_pa {
            row("equivalent", of.of_links())?;
        }
        // Print the bounds of state, step and energy, and the memory that image and tissue take.
        rare("saturation", format!("{} from the centre", length(self.k_m.into())))?;
        rare("step bound", format!("{:.5} (euler, dimensionless time a sweep)", self.step_bound))?;
        rare("energy bound", format!("{:.4} J", self.energy_max_j))?;
        self.cutting.as_ref().map_or(Ok(()), |of| row("cutting", of.to_string()))?;
        row("flash", format!("{} bytes", self.image_bytes))?;
        for (name, bytes) in [
            ("track", Some(self.ram_bytes)),
            ("predict", Some(self.ram_bytes_predict)),
            ("euler", self.ram_bytes_euler),
            ("rkl2", self.ram_bytes_rkl2),
        ] {
            bytes.map_or(Ok(()), |bytes| rare("RAM", format!("{bytes} bytes ({name})")))?;
        }
        row("checksum", self.checksum.clone())
    }
}

/// Smallest and largest coordinate of a cell \[m\].
fn bounding_box_m(model: &Model<'_>) -> [[f32; 3]; 2] {
    let [mut low, mut high] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for cell in 0..model.body_cells() {
        let at = model.rest_position(cell).into_iter().zip(model.centre_m());
        for ((x, centre_m), (low, high)) in at.zip(low.iter_mut().zip(&mut high)) {
            let x = x * model.unit_m() + centre_m;
            (*low, *high) = (low.min(x), high.max(x));
        }
    }
    [low, high]
}

/// The mean of a number of the tissue around each cell.
fn mean(model: &Model<'_>, number: usize) -> Option<f64> {
    let each = (0..model.body_cells()).map(|cell| Some(f64::from(model.elasticity(cell)?[number])));
    Some(each.sum::<Option<f64>>()? / model.body_cells() as f64)
}

/// Nodes of the input that have a position.
fn nodes(model: &Model<'_>) -> usize {
    let embedded = (0..model.fine_nodes()).filter(|&node| model.fine_rest(node).is_some()).count();
    embedded.max(model.body_cells())
}

/// RAM of a tissue with room for a model's cells and the default number of contacts [bytes].
fn ram_bytes<D: Dynamics>(model: &Model<'_>) -> usize {
    const { assert!(size_of::<Contact>() == 16) };
    let (cells, contacts) = (model.cells(), CONTACTS.min(model.cells()));
    let arrays = array_bytes::<D>(cells, contacts, D::room_blocks(model, contacts));
    let states = term_states(model.kept_states()) * size_of::<TermState>();
    size_of::<Head<D>>().next_multiple_of(16) + arrays + states
}
/// A band in words.
fn stiffening(band: &Band) -> String {
    let strain = match band.side {
        BandSide::Both => "a strain",
        BandSide::Short => "a compression",
        BandSide::Long => "an extension",
    };
    format!("{:.0} Pa beyond {strain} of {}", band.modulus_pa, band.half_width)
}
