//! The bodies of report and paper, with the cells that are pressed and the way they are pressed.

use std::path::Path;

use chaincell_kernel::{Model, Settings, ToolPose};
use nalgebra::Vector3;

use crate::bodies::Variant;
use crate::reference::Npz;
use crate::reference::vectors::unit;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::contact::{automatic, inward};
use chaincell_host::engine::{self, Engine};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{self, Mesh, MeshOptions};

/// A tool that is away.
pub const RELEASED: ToolPose = ToolPose::at(Vector3::new(0.0, 0.0, 0.0), 0);
/// Downwards.
const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

/// A mesh with the place that is pressed.
pub struct Source {
    /// Name in tables and files.
    pub name: &'static str,
    /// Where the body comes from.
    pub words: String,
    /// The mesh.
    pub mesh: Mesh,
    fixed: Vec<u32>,
    contact: Contact,
}

/// Which cells are pressed, and where to.
enum Contact {
    /// What `--contact auto` takes, inwards.
    Auto,
    /// These input ids, along a direction.
    Nodes(Vec<u32>, [f64; 3]),
}

/// A baked body with its contact.
pub struct Scene {
    /// Name in tables and files.
    pub name: &'static str,
    /// Where the body comes from.
    pub source: String,
    image: ImageBytes,
    /// The same without the coarse level, where it has one.
    bare: Option<ImageBytes>,
    /// Cells that the tool holds, ascending.
    pub contacts: Vec<u16>,
    /// Unit vector along which they are pressed.
    pub direction: [f64; 3],
}

impl Contact {
    /// The cells, ascending, and a unit vector along which they are pressed.
    fn of(&self, model: &Model<'_>) -> Result<(Vec<u16>, [f64; 3])> {
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

impl Source {
    fn generated(name: &'static str, spec: &str, contact: Contact) -> Result<Self> {
        let mesh = mesh::load(spec, &MeshOptions::default())?;
        let (words, fixed) = (spec.to_owned(), mesh.default_fixed.clone());
        Ok(Self { name, words, mesh, fixed, contact })
    }

    /// The paper's plane, 21 x 21 cells, 10 mm apart, with 4 neighbours each or 8, its border fixed
    /// and its centre pressed.
    ///
    /// # Errors
    /// None for this plane.
    pub fn plane(diagonals: bool) -> Result<Self> {
        let mesh =
            mesh::load("plane:21x21x0.01", &MeshOptions { diagonals, ..MeshOptions::default() })?;
        let words = "plane of 21 x 21 cells".to_owned();
        let (fixed, contact) = (mesh.default_fixed.clone(), Contact::Nodes(vec![220], DOWN));
        Ok(Self { name: "plane", words, mesh, fixed, contact })
    }

    /// The generated organ, of about so many cells or as it comes, its part farthest from the fixed
    /// cells pressed.
    ///
    /// # Errors
    /// As the generator.
    pub fn organ(cells: Option<usize>) -> Result<Self> {
        match cells {
            Some(cells) => Self::generated("organ", &format!("organ:{cells}"), Contact::Auto),
            None => {
                let organ = Self::generated("organ", "organ", Contact::Auto)?;
                Ok(Self { words: "organ (generated)".to_owned(), ..organ })
            }
        }
    }

    /// The real liver, its patch of seven cells pressed along its normal.
    ///
    /// # Errors
    /// Reference data that cannot be read.
    pub fn liver(reference: &Path) -> Result<Self> {
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
        let contact = Contact::Nodes(sets.ids("patch")?, direction);
        let (words, fixed) = ("liver_5762".to_owned(), sets.ids("fixed")?);
        Ok(Self { name: "liver", words, mesh, fixed, contact })
    }

    /// The body with its links' bands.
    ///
    /// # Errors
    /// As the bake.
    pub fn with_alpha(&self, alpha: f64) -> Result<Scene> {
        self.bake(&BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() })
    }

    /// The body as these options make it.
    ///
    /// # Errors
    /// As the bake; a node to press that is no cell.
    pub fn bake(&self, options: &BakeOptions) -> Result<Scene> {
        let image = bake(&self.mesh, &self.fixed, options)?;
        let model = parse(&image)?;
        let without = BakeOptions { coarse_basis: BasisSpacing::None, ..options.clone() };
        let bare = (model.coarse_functions() > 0)
            .then(|| bake(&self.mesh, &self.fixed, &without))
            .transpose()?;
        let (contacts, direction) = self.contact.of(&model)?;
        let (name, source) = (self.name, self.words.clone());
        Ok(Scene { name, source, image, bare, contacts, direction })
    }
}

impl Scene {
    /// The model as a file has it.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.image.as_bytes()
    }

    /// The model.
    ///
    /// # Errors
    /// None for a scene that was made here.
    pub fn model(&self) -> Result<Model<'_>> {
        parse(&self.image)
    }

    /// An engine whose tool holds the cells and is not slowed down, with `sweeps` a tick.
    ///
    /// # Errors
    /// As [`Variant::unlimited`].
    pub fn engine(
        &self,
        variant: Variant,
        sweeps: u16,
        change: impl FnOnce(Settings) -> Settings,
    ) -> Result<Engine<'_>> {
        let model = parse(self.bare.as_ref().filter(|_| !variant.coarse).unwrap_or(&self.image))?;
        variant.unlimited(model, engine::Contact::Cells(self.contacts.clone()), sweeps, change)
    }
}

fn parse(image: &ImageBytes) -> Result<Model<'_>> {
    Model::from_bytes(image.as_bytes()).map_err(Error::check)
}

fn cell_of(model: &Model<'_>, node: u32) -> Result<u16> {
    let cell = model.cell_of_input(node);
    cell.ok_or_else(|| Error::check(format!("the body of the report has no node {node}")))
}
