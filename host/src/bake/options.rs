//! Options of the bake, and the check of their ranges.

use chaincell_kernel::Loose;
use chaincell_kernel::image::STIFFENING_MAX;

use super::coarse_basis::BasisSpacing;
use super::cutting::{Cuttable, TOUGHNESS, check_links};
use super::per_cell::PerCell;
use super::tissue::{Band, Relaxation, STRETCH_MIN, Tissue};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Refined};

/// Largest Poisson's ratio: above it, the rounding of the volume's stress hides that of the shear.
const POISSON_MAX: f64 = 0.495;
/// Name of the toughness as a table of tissues has it.
const TOUGHNESS_OPTION: &str = "toughness_j_per_m2";

/// Choice of a contact surface, which tools touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactSurface {
    /// If the mesh has triangles and the image is not lean.
    #[default]
    Auto,
    /// Yes; a mesh without triangles is refused.
    Yes,
    /// No: a tool can only hold cells.
    No,
}

/// Options of the bake.
#[derive(Debug, Clone, PartialEq)]
pub struct BakeOptions {
    /// Half-width of the band in rest lengths, in [0, 1).
    pub alpha: PerCell,
    /// Stiffness of a link \[N/m\].
    pub stiffness_n_per_m: PerCell,
    /// Branches of the links' tension, which fade: the stiffness is the long-term one, unless they say otherwise.
    /// Shapes have those of their tissue.
    pub link_relaxation: Option<Relaxation>,
    /// Nodal shapes in place of links; then alpha is 0, and the stiffness is not used.
    pub tissue: Option<Tissue>,
    /// Saturation K from the body's centre \[m\]; 4 times the largest coordinate if absent.
    pub saturation_m: Option<f64>,
    /// Cell resistance.
    pub resistance: f64,
    /// Cell capacitance C.
    pub capacitance: f64,
    /// Most energy that a tool may store in the body \[J\].
    pub energy_max_j: Option<f64>,
    /// The coarse level of `track`.
    pub coarse_basis: BasisSpacing,
    /// Leave out data that only a display or a vector unit needs.
    pub lean: bool,
    /// Choice of a contact surface, which tools touch.
    pub contact_surface: ContactSurface,
    /// A body of tetrahedra that can be cut.
    pub cuttable: Option<Cuttable>,
    /// Number of groups of nodes, each of them a cell; every node is a cell if absent.
    pub cells: Option<usize>,
}

impl BakeOptions {
    /// The same body on a mesh that was cut once.
    #[must_use]
    pub fn refined(&self, refined: &Refined) -> Self {
        let tissue = self.tissue.as_ref().map(|tissue| Tissue {
            young_pa: tissue.young_pa.refined(refined),
            poisson: tissue.poisson.refined(refined),
            ..tissue.clone()
        });
        let cuttable = self.cuttable.as_ref().map(|cuttable| Cuttable {
            toughness_j_per_m2: cuttable.toughness_j_per_m2.refined(refined),
            ..cuttable.clone()
        });
        Self {
            alpha: self.alpha.refined(refined),
            stiffness_n_per_m: self.stiffness_n_per_m.refined(refined),
            tissue,
            cuttable,
            ..self.clone()
        }
    }
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self {
            alpha: PerCell::Uniform(0.0),
            stiffness_n_per_m: PerCell::Uniform(20.0),
            link_relaxation: None,
            tissue: None,
            saturation_m: None,
            resistance: 1.0,
            capacitance: 1.0,
            energy_max_j: None,
            coarse_basis: BasisSpacing::BySize,
            lean: false,
            contact_surface: ContactSurface::Auto,
            cuttable: None,
            cells: None,
        }
    }
}

/// Checks the ranges of the options; an error names the option.
pub(super) fn check(mesh: &Mesh, options: &BakeOptions) -> Result<()> {
    let each = |name: &str, value: &PerCell, holds: fn(f64) -> bool, range: &str| match value {
        PerCell::Uniform(value) if holds(*value) => Ok(()),
        PerCell::Uniform(value) => Err(Error::input(format!("{name} {value}: must be {range}"))),
        PerCell::Each(values) if values.len() != mesh.nodes_m.len() => Err(Error::input(format!(
            "{name}: {} values for {} nodes; give one per node of the input",
            values.len(),
            mesh.nodes_m.len()
        ))),
        PerCell::Each(values) => match values.iter().position(|&value| !holds(value)) {
            Some(at) => Err(Error::input(format!(
                "{name}: value {} of node {at}: must be {range}",
                values[at]
            ))),
            None => Ok(()),
        },
    };
    // Values of links.
    let positive = |value: f64| value > 0.0 && (value as f32).is_normal();
    each("`alpha`", &options.alpha, |a| (0.0..1.0).contains(&(a as f32)), "in [0, 1)")?;
    let stiffness = "above 0 and finite [N/m]";
    each("`stiffness_n_per_m`", &options.stiffness_n_per_m, positive, stiffness)?;
    // Tissue.
    if let Some(tissue) = &options.tissue {
        each(&tissue.name("young_pa"), &tissue.young_pa, positive, "above 0 and finite [Pa]")?;
        let ratios = |nu: f64| (0.0..=POISSON_MAX).contains(&nu);
        each(&tissue.name("poisson"), &tissue.poisson, ratios, "from 0 to 0.495")?;
        let stretch = PerCell::Uniform(tissue.stretch_min.unwrap_or(STRETCH_MIN));
        let stretches = |least: f64| (0.01..=0.95).contains(&least);
        each("`stretch_min`", &stretch, stretches, "from 0.01 to 0.95, or none")?;
        check_stiffening(tissue)?;
        tissue.relaxation.as_ref().map_or(Ok(()), |of| of.check(&tissue.name("branches")))?;
        check_shapes(options)?;
    }
    if let Some(relaxation) = &options.link_relaxation {
        relaxation.check("`branches`")?;
        check_relaxing_links(options)?;
    }
    if let Some(cuttable) = &options.cuttable {
        let of_tissue = options.tissue.as_ref().map(|tissue| tissue.name(TOUGHNESS_OPTION));
        let name = of_tissue.unwrap_or_else(|| format!("`{TOUGHNESS_OPTION}`"));
        let range = "from 0.01 to 1e6 [J/m^2]; livers measure 76 to 225";
        each(&name, &cuttable.toughness_j_per_m2, |of| TOUGHNESS.contains(&of), range)?;
        cuttable.check()?;
        check_cuttable(mesh, options, cuttable)?;
    }
    // The coarse level and the scalars of the body.
    if let BasisSpacing::Links(spacing) = options.coarse_basis
        && !(1.0..=1e6).contains(&spacing)
    {
        return Err(Error::input(format!(
            "`coarse_basis` {spacing}: must be at least 1 mean link length"
        )));
    }
    for (name, value) in
        [("`saturation_m`", options.saturation_m), ("`energy_max_j`", options.energy_max_j)]
    {
        if let Some(value) = value.filter(|&value| !positive(value)) {
            return Err(Error::input(format!("{name} {value}: must be above 0 and finite")));
        }
    }
    for (name, value) in
        [("`resistance`", options.resistance), ("`capacitance`", options.capacitance)]
    {
        if !(1e-11..=1e11).contains(&value) {
            return Err(Error::input(format!("{name} {value}: must be from 1e-11 to 1e11")));
        }
    }
    Ok(())
}

/// Checks that there are at most six bands, each with a different width on its side.
fn check_stiffening(tissue: &Tissue) -> Result<()> {
    let (bands, name) = (&tissue.stiffening, tissue.name("stiffening"));
    if bands.len() > STIFFENING_MAX {
        let (given, most) = (bands.len(), STIFFENING_MAX);
        return Err(Error::input(format!("{name}: {given} bands, at most {most}")));
    }
    for (at, band) in bands.iter().enumerate() {
        let Band { half_width, modulus_pa, .. } = *band;
        if !(0.01..1.0).contains(&(half_width as f32)) {
            return Err(Error::input(format!(
                "{name}: half-width {half_width}: must be from 0.01 to below 1"
            )));
        }
        if !(1e-3..=1e12).contains(&modulus_pa) {
            return Err(Error::input(format!(
                "{name}: modulus {modulus_pa} of half-width {half_width}: must be from 1e-3 to \
                 1e12 [Pa]"
            )));
        }
        if bands[..at].iter().any(|other| other.repeats(band)) {
            return Err(Error::input(format!(
                "{name}: half-width {half_width} twice: add up the moduli"
            )));
        }
    }
    Ok(())
}

/// Checks that a body that can be cut does not relax, or is made of the links of its tetrahedra.
fn check_cuttable(mesh: &Mesh, options: &BakeOptions, cuttable: &Cuttable) -> Result<()> {
    let why = match &options.tissue {
        Some(Tissue { relaxation: Some(_), .. }) => {
            "`branches` with `cuttable`: a body that can be cut keeps no memory of its strain; leave one \
             out, of a `tissue` by giving none"
        }
        Some(_) => return Ok(()),
        None if mesh.tetrahedra.is_empty() => {
            "`cuttable`: the mesh has no tetrahedra, between which a cut opens faces; take a mesh that has, or leave \
             it out"
        }
        None if options.lean => {
            "`lean` with `cuttable`: a cut needs the links in slices; leave one out"
        }
        None if options.cells.is_some() => {
            "`cells` with `cuttable`: groups of nodes have no tetrahedra to part; leave one out"
        }
        None if cuttable.loose != Loose::Leave => {
            "`loose` with `cuttable`: a body of links leaves its loose pieces; leave it out, or make it of tissue, with \
             `young_pa`"
        }
        None => return check_links(mesh),
    };
    Err(Error::input(why))
}

/// Checks the options that links which relax exclude.
fn check_relaxing_links(options: &BakeOptions) -> Result<()> {
    for (name, is_asked, why) in [
        ("young_pa", options.tissue.is_some(), "shapes have the branches of their tissue"),
        ("lean", options.lean, "links that relax need their slices"),
        ("cells", options.cells.is_some(), "links of groups do not relax"),
        (
            "cuttable",
            options.cuttable.is_some(),
            "a body that can be cut keeps no memory of its strain",
        ),
    ] {
        if is_asked {
            return Err(Error::input(format!("`{name}` with `branches`: {why}; leave one out")));
        }
    }
    Ok(())
}

/// Checks the options that nodal shapes exclude.
fn check_shapes(options: &BakeOptions) -> Result<()> {
    for (name, is_asked, why) in [
        ("alpha", options.alpha != PerCell::Uniform(0.0), "shapes have no slack"),
        ("lean", options.lean, "shapes need the links in slices"),
        ("cells", options.cells.is_some(), "groups of nodes are joined by links alone"),
    ] {
        if is_asked {
            return Err(Error::input(format!("`{name}` with `young_pa`: {why}; leave one out")));
        }
    }
    Ok(())
}
