//! Bodies that a tool presses straight down, of links and of nodal shapes, each with three tools.

use chaincell_host::bake::tissue::{Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme, rest_m};
use chaincell_host::error::Error;
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Model, Network, Settings, TickOutput, ToolPart, ToolPose, Unloading};
use nalgebra::Vector3;

/// A generated body, fixed where its generator fixes it.
#[must_use]
pub fn baked(spec: &str, options: &BakeOptions) -> ImageBytes {
    let mesh = load(spec, &MeshOptions::default()).unwrap();
    bake(&mesh, &mesh.default_fixed, options).unwrap()
}

/// A generated body of nodal shapes of this modulus \[Pa\].
#[must_use]
pub fn nodal(spec: &str, young_pa: f64) -> ImageBytes {
    let tissue = Some(Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(0.45)));
    baked(spec, &BakeOptions { tissue, ..BakeOptions::default() })
}

/// The model of an image.
#[must_use]
pub fn model(image: &ImageBytes) -> Model<'_> {
    Model::from_bytes(image.as_bytes()).unwrap()
}

/// An engine under a contact whose tools go at most so far in a tick, without unloading.
///
/// # Errors
/// As [`Engine::with_contact`].
pub fn under(
    image: &ImageBytes,
    contact: Contact,
    (scheme, sweeps): (Scheme, u16),
    max_tool_step_m: f32,
) -> Result<Engine<'_>, Error> {
    let settings = Settings::for_model(&model(image));
    let unloading = Unloading::Off;
    let settings = Settings { sweeps, unloading, max_tool_step_m, ..settings };
    let network = Network::new(model(image), settings).unwrap();
    Engine::with_contact(network, scheme, Arithmetic::F32, contact)
}

/// A body, and what presses it.
pub struct Body {
    /// What it is.
    pub name: &'static str,
    image: ImageBytes,
    /// Where it is highest \[m\].
    top_m: Vector3<f64>,
    /// From there to the lowest cell \[m\].
    pub thickness_m: f64,
    tools: [Shape; 3],
}

/// A tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A sphere on the surface, of this radius \[m\].
    Sphere(f32),
    /// A capsule on the surface, lying: half its length and its radius \[m\].
    Capsule(f32, f32),
}

impl Shape {
    /// From the tool's place to the surface that it touches \[m\].
    fn radius_m(self) -> f64 {
        let (Self::Sphere(radius_m) | Self::Capsule(_, radius_m)) = self;
        radius_m.into()
    }

    fn contact(self) -> Contact {
        let tool = |part| Contact::Tools { tools: vec![vec![part]], friction: 0.0 };
        match self {
            Self::Sphere(radius_m) => tool(ToolPart::sphere(radius_m)),
            Self::Capsule(half_m, radius_m) => {
                let lying = [half_m, 0.0, 0.0];
                tool(ToolPart { half_m: lying, ..ToolPart::sphere(radius_m) })
            }
        }
    }
}

impl Body {
    fn new(name: &'static str, image: ImageBytes, tools: [Shape; 3]) -> Self {
        let model = model(&image);
        let cells = (0..model.cells()).map(|cell| Vector3::from(rest_m(&model, cell)));
        let mut by_height: Vec<Vector3<f64>> = cells.collect();
        by_height.sort_by(|a, b| a.z.total_cmp(&b.z));
        let (low, high) = (by_height[0].z, by_height[by_height.len() - 1].z);
        let upper: Vec<_> = by_height.iter().filter(|cell| cell.z > high - 1.0e-6).collect();
        let middle = upper.iter().copied().sum::<Vector3<f64>>() / upper.len() as f64;
        // Over a cell, not between four.
        let apart = |cell: &&&Vector3<f64>| (**cell - middle).norm();
        let nearest = upper.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let top_m = **nearest.unwrap();
        Self { name, image, top_m, thickness_m: high - low, tools }
    }

    /// Boxes of soft and of stiff links and an organ of links, a box and an organ of nodal shapes, all under
    /// tools on their surface.
    #[must_use]
    pub fn all() -> [Self; 5] {
        let links = |stiffness: f64| BakeOptions {
            stiffness_n_per_m: PerCell::Uniform(stiffness),
            coarse_basis: BasisSpacing::None,
            ..BakeOptions::default()
        };
        let spheres = [0.008, 0.012, 0.018].map(Shape::Sphere);
        let on = [Shape::Sphere(0.008), Shape::Sphere(0.014), Shape::Capsule(0.012, 0.008)];
        [
            Self::new("soft links", baked("box:9x9x6x0.008", &BakeOptions::default()), spheres),
            Self::new("stiff links", baked("box:9x9x4x0.005", &links(1000.0)), spheres),
            Self::new("organ of links", baked("organ:500", &links(300.0)), spheres),
            Self::new("box of 20 kPa", nodal("box:7x7x6x0.008", 2.0e4), on),
            Self::new("organ of 5 kPa", nodal("organ:500", 5.0e3), on),
        ]
    }

    /// A box of nodal shapes that relaxes to a third of its instantaneous modulus, in 0.1 s and in 2 s.
    #[must_use]
    pub fn relaxing() -> Self {
        let branches = [0.1, 2.0].map(|time_s| Branch { ratio: 1.0, time_s }).to_vec();
        let relaxation = Relaxation { branches, is_instant: true, device_hz: DEVICE_HZ };
        let tissue = Tissue::new(PerCell::Uniform(2.0e4), PerCell::Uniform(0.45));
        let tissue = Some(Tissue { relaxation: Some(relaxation), ..tissue });
        let image = baked("box:7x7x6x0.008", &BakeOptions { tissue, ..BakeOptions::default() });
        let on = [Shape::Sphere(0.008), Shape::Sphere(0.014), Shape::Capsule(0.012, 0.008)];
        Self::new("box that relaxes from 20 kPa", image, on)
    }

    /// One of its tools.
    #[must_use]
    pub fn tool(&self, tool: usize) -> Shape {
        self.tools[tool]
    }

    /// Where one of its tools begins to touch \[m\].
    #[must_use]
    pub fn touch_m(&self, tool: usize) -> Vector3<f64> {
        self.top_m + Vector3::new(0.0, 0.0, self.tools[tool].radius_m())
    }

    /// The body at rest under one of its tools: a tick of two sweeps for a sample.
    pub fn tissue(&self, tool: usize) -> impl FnMut(&ToolPose) -> TickOutput {
        self.tissue_by(tool, (Scheme::Predict, 2))
    }

    /// The same with a scheme and a number of sweeps.
    pub fn tissue_by(&self, tool: usize, by: (Scheme, u16)) -> impl FnMut(&ToolPose) -> TickOutput {
        let (contact, step_m) =
            (self.tools[tool].contact(), Settings::for_model(&model(&self.image)).max_tool_step_m);
        let mut engine = under(&self.image, contact, by, step_m).unwrap();
        move |sample| engine.tick(sample)
    }
}
