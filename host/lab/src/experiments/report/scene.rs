//! The bodies of the report, with the cells that are pressed and the way they are pressed.

use std::path::Path;

use chaincell_kernel::Model;

use super::setting::Setting;
use crate::reference::Npz;
use crate::reference::vectors::unit;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, Tissue, bake};
use chaincell_host::engine::contact::{automatic, inward};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{self, Mesh, MeshOptions};

/// A baked body with its contact.
pub struct Scene {
    /// Name in tables and files.
    pub name: &'static str,
    /// Where the body comes from.
    pub source: String,
    /// The model.
    pub image: ImageBytes,
    /// The same without the coarse level, where it has one.
    bare: Option<ImageBytes>,
    /// Cells that the tool holds, ascending.
    pub contacts: Vec<u16>,
    /// Unit vector along which they are pressed.
    pub direction: [f64; 3],
}

/// Which cells are pressed, and where to.
#[derive(Debug, Clone)]
pub enum Contact {
    /// What `--contact auto` takes, inwards.
    Auto,
    /// These input ids, along a direction.
    Nodes(Vec<u32>, [f64; 3]),
}

impl Contact {
    /// The cells, ascending, and a unit vector along which they are pressed.
    ///
    /// # Errors
    /// A node that is no cell; a body whose every cell is fixed.
    pub fn of(&self, model: &Model<'_>) -> Result<(Vec<u16>, [f64; 3])> {
        let (mut contacts, direction) = match self {
            Self::Auto => {
                let contacts = automatic(model)?;
                let direction = inward(model, &contacts);
                (contacts, direction)
            }
            Self::Nodes(nodes, direction) => {
                let cells = nodes.iter().map(|node| cell_of(model, *node));
                (cells.collect::<Result<_>>()?, *direction)
            }
        };
        contacts.sort_unstable();
        Ok((contacts, unit(direction)))
    }
}

/// Downwards.
pub const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

impl Scene {
    fn new(
        name: &'static str,
        source: impl Into<String>,
        mesh: &Mesh,
        fixed: &[u32],
        contact: Contact,
        alpha: f64,
    ) -> Result<Self> {
        let options = BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() };
        Self::baked(name, source, mesh, fixed, contact, &options)
    }

    fn baked(
        name: &'static str,
        source: impl Into<String>,
        mesh: &Mesh,
        fixed: &[u32],
        contact: Contact,
        options: &BakeOptions,
    ) -> Result<Self> {
        let image = bake(mesh, fixed, options)?;
        let model = parse(&image)?;
        let without = BakeOptions { coarse_basis: BasisSpacing::None, ..options.clone() };
        let bare =
            (model.coarse_functions() > 0).then(|| bake(mesh, fixed, &without)).transpose()?;
        let (contacts, direction) = contact.of(&model)?;
        Ok(Self { name, source: source.into(), image, bare, contacts, direction })
    }

    /// The model.
    ///
    /// # Errors
    /// None for a scene that was made here.
    pub fn model(&self) -> Result<Model<'_>> {
        parse(&self.image)
    }

    /// The model for a setting: the same cells in the same order.
    ///
    /// # Errors
    /// As [`Self::model`].
    pub fn model_for(&self, setting: Setting) -> Result<Model<'_>> {
        parse(self.bare.as_ref().filter(|_| !setting.coarse).unwrap_or(&self.image))
    }

    /// The paper's plane, 21 x 21 cells, 10 mm apart, its centre pressed.
    ///
    /// # Errors
    /// As the bake.
    pub fn plane(diagonals: bool) -> Result<Self> {
        Self::plane_of(diagonals, 0.0)
    }

    /// The same with links that have a band.
    ///
    /// # Errors
    /// As the bake.
    pub fn plane_of(diagonals: bool, alpha: f64) -> Result<Self> {
        let spec = "plane:21x21x0.01";
        let mesh = mesh::load(spec, &MeshOptions { diagonals, ..MeshOptions::default() })?;
        let name = if diagonals { "plane8" } else { "plane4" };
        let links = if diagonals { "8 neighbours" } else { "4 neighbours" };
        let contact = Contact::Nodes(vec![220], DOWN);
        Self::new(name, format!("{spec}, {links}"), &mesh, &mesh.default_fixed, contact, alpha)
    }

    /// The generated organ, its part farthest from the fixed cells pressed.
    ///
    /// # Errors
    /// As the bake.
    pub fn organ() -> Result<Self> {
        let mesh = mesh::load("organ", &MeshOptions::default())?;
        Self::new("organ", "organ (generated)", &mesh, &mesh.default_fixed, Contact::Auto, 0.0)
    }

    /// A generated organ of another size.
    ///
    /// # Errors
    /// As the generator and the bake.
    pub fn organ_of(cells: usize) -> Result<Self> {
        Self::organ_with(cells, BasisSpacing::BySize)
    }

    /// The same with a coarse level of another spacing.
    ///
    /// # Errors
    /// As the generator and the bake.
    pub fn organ_with(cells: usize, spacing: BasisSpacing) -> Result<Self> {
        let spec = format!("organ:{cells}");
        let mesh = mesh::load(&spec, &MeshOptions::default())?;
        let options = BakeOptions { coarse_basis: spacing, ..BakeOptions::default() };
        Self::baked("organ", spec, &mesh, &mesh.default_fixed, Contact::Auto, &options)
    }

    /// A generated organ of nodal shapes: Young's modulus 5 kPa, Poisson's ratio 0.45.
    ///
    /// # Errors
    /// As the generator and the bake.
    pub fn organ_of_tissue(cells: usize) -> Result<Self> {
        let spec = format!("organ:{cells}");
        let mesh = mesh::load(&spec, &MeshOptions::default())?;
        let tissue = Tissue::new(PerCell::Uniform(5e3), PerCell::Uniform(0.45));
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        Self::baked("organ of shapes", spec, &mesh, &mesh.default_fixed, Contact::Auto, &options)
    }

    /// The real liver, its patch of seven cells pressed along its normal; one of them with
    /// `one_cell`.
    ///
    /// # Errors
    /// Reference data that cannot be read.
    pub fn liver(reference: &Path, one_cell: bool) -> Result<Self> {
        let path = reference.join("meshes/liver_5762.msh41.msh");
        if !path.is_file() {
            return Err(Error::input(format!(
                "reference data: there is no {}; name the folder that has it, or none for a \
                 generated organ",
                path.display()
            )));
        }
        let mesh = mesh::load(&path.to_string_lossy(), &MeshOptions::default())?;
        let mut sets = Npz::open(&reference.join("meshes/liver_5762.npz"))?;
        let direction = sets.vectors("dirn")?.first().copied().unwrap_or(DOWN);
        let nodes = sets.ids(if one_cell { "node" } else { "patch" })?;
        let contact = Contact::Nodes(nodes, direction);
        Self::new("liver", "liver_5762", &mesh, &sets.ids("fixed")?, contact, 0.0)
    }

    /// A body of the press test, with the depth of its press: a tenth of its height \[m\].
    ///
    /// # Errors
    /// Reference data that cannot be read.
    pub fn press(name: &'static str, reference: Option<&Path>) -> Result<(Self, f64)> {
        let Some(reference) = reference else { return Self::generated_press(name) };
        let mut data = Npz::open(&reference.join(format!("press/{name}.npz")))?;
        let height_m = data.reals("H")?.first().copied().unwrap_or_default();
        let mut links = data.rows("E")?;
        for link in &mut links {
            link.sort_unstable();
        }
        links.sort_unstable();
        let mesh = Mesh {
            nodes_m: data.vectors("X")?,
            tetrahedra: data.rows("T")?,
            links,
            ..Mesh::default()
        };
        let contact = Contact::Nodes(data.ids("press")?, DOWN);
        let source = format!("press/{name}.npz");
        let scene = Self::new(name, source, &mesh, &data.ids("bottom")?, contact, 0.0)?;
        Ok((scene, 0.1 * height_m))
    }

    /// A box of about the size of the press test's body.
    fn generated_press(name: &'static str) -> Result<(Self, f64)> {
        if name == "slab" {
            Self::press_of(name, [45, 32, 4], 0.0037)
        } else {
            Self::press_of(name, [25, 21, 11], 0.005)
        }
    }

    /// A body of the press test as a box of so many nodes along each axis.
    ///
    /// # Errors
    /// As the generator and the bake.
    pub fn press_of(
        name: &'static str,
        [nx, ny, nz]: [usize; 3],
        spacing_m: f64,
    ) -> Result<(Self, f64)> {
        let spec = format!("box:{nx}x{ny}x{nz}x{spacing_m}");
        let mesh = mesh::load(&spec, &MeshOptions::default())?;
        let middle = ((nx / 2 * ny + ny / 2) * nz + nz - 1) as u32;
        let contact = Contact::Nodes(vec![middle], DOWN);
        let height_m = (nz - 1) as f64 * spacing_m;
        let source = format!("{spec} (generated)");
        let scene = Self::new(name, source, &mesh, &mesh.default_fixed, contact, 0.0)?;
        Ok((scene, 0.1 * height_m))
    }
}

fn parse(image: &ImageBytes) -> Result<Model<'_>> {
    Model::from_bytes(image.as_bytes()).map_err(Error::check)
}

fn cell_of(model: &Model<'_>, node: u32) -> Result<u16> {
    let cell = model.cell_of_input(node);
    cell.ok_or_else(|| Error::check(format!("the body of the report has no node {node}")))
}
