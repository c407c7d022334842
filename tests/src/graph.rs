//! Random bodies of 4 to 40 cells for property tests, with and without a coarse level: of links, with
//! stiffness over six decades and alpha from 0 to 0.99, and of nodal shapes, with moduli over three.

use chaincell_host::bake::tissue::{Band, BandSide, STRETCH_MIN, Tissue};
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::Error;
use chaincell_host::mesh::Mesh;
use chaincell_kernel::{Model, Settings, ToolPose, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::{Monitor, Step, play};
use nalgebra::Vector3;
use proptest::prelude::*;

/// A random body with what the bake and the tick need.
#[derive(Debug, Clone)]
pub struct Case {
    /// Nodes, links and fixed nodes; the tool holds the last node, which is never fixed.
    pub shape: Shape,
    /// Half-width of the bands.
    pub alpha: f64,
    /// Stiffness of each node [N/m].
    pub stiffness_n_per_m: Vec<f64>,
    /// Nodal shapes in place of links: alpha is 0 then, and the stiffness without meaning.
    pub tissue: Option<Tissue>,
    /// Distance of the coarse basis functions in mean link lengths.
    pub coarse_functions: Option<f64>,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// Time a tick of the schemes that go by it, in steps.
    pub tick_time: f32,
}

/// Random cases, `floating` ones without fixed nodes.
pub fn case(floating: bool) -> impl Strategy<Value = Case> {
    (4_usize..40).prop_flat_map(move |n| {
        let nodes = prop::collection::vec(prop::array::uniform3(-0.1_f64..0.1), n)
            .prop_filter("nodes apart", |nodes| apart(nodes));
        let chords = prop::collection::vec((0..n as u32, 0..n as u32), 0..3 * n);
        let parents = prop::collection::vec(any::<prop::sample::Index>(), n - 1);
        let fixed = prop::collection::vec(0..n as u32 - 1, 1..3);
        let alpha = prop_oneof![Just(0.0), 0.0..0.99];
        let decades = prop::collection::vec(-3.0_f64..3.0, n);
        let coarse_functions = prop::option::of(1.0_f64..4.0);
        let rates = (prop_oneof![3 => 1_u16..5, 1 => 5_u16..16], 0.5_f32..40.0);
        (nodes, chords, parents, fixed, alpha, decades, (coarse_functions, rates)).prop_map(
            move |(
                nodes_m,
                chords,
                parents,
                mut fixed,
                alpha,
                decades,
                (coarse_functions, rates),
            )| {
                let tree = parents.iter().enumerate().map(|(i, parent)| {
                    let child = i as u32 + 1;
                    [parent.index(i + 1) as u32, child]
                });
                let chords = chords.into_iter().map(|(a, b)| [a.min(b), a.max(b)]);
                let mut links: Vec<[u32; 2]> = tree.chain(chords).filter(|[a, b]| a != b).collect();
                links.sort_unstable();
                links.dedup();
                fixed.sort_unstable();
                fixed.dedup();
                if floating {
                    fixed.clear();
                }
                let stiffness_n_per_m = decades.iter().map(|d| 10.0_f64.powf(*d)).collect();
                let (sweeps, tick_time) = rates;
                let shape = shape(nodes_m, links, fixed);
                let case = Case::new(shape, alpha, stiffness_n_per_m);
                Case { coarse_functions, sweeps, tick_time, ..case }
            },
        )
    })
}

/// Random tissue for n nodes: with the band of stretches and without, alike or varied, with up to two
/// bands that stiffen it.
fn tissue(nodes: usize) -> impl Strategy<Value = Tissue> {
    let decades = prop_oneof![Just(vec![0.0]), prop::collection::vec(-1.5_f64..1.5, nodes),];
    let ratios = prop_oneof![
        (0.0_f64..0.49).prop_map(|ratio| vec![ratio]),
        prop::collection::vec(0.0_f64..0.49, nodes),
    ];
    let stretch_min = prop::option::of(Just(STRETCH_MIN));
    let side = prop::sample::select(vec![BandSide::Both, BandSide::Short, BandSide::Long]);
    let bands = prop::collection::vec((0.01_f64..0.3, 0.1_f64..20.0, side), 0..3);
    (2.0_f64..6.0, decades, ratios, stretch_min, bands).prop_map(
        |(mean, decades, ratios, stretch_min, bands)| {
            let young_pa = decades.iter().map(|decade| 10.0_f64.powf(mean + decade)).collect();
            let band = |(half_width, part, side)| Band {
                half_width,
                modulus_pa: part * 10.0_f64.powf(mean),
                side,
            };
            let stiffening = bands.into_iter().map(band).collect();
            let tissue = Tissue::new(of_cells(young_pa), of_cells(ratios));
            Tissue { stretch_min, stiffening, ..tissue }
        },
    )
}

/// What node i has, at `to[i]`.
fn moved(values: &PerCell, to: &[usize]) -> PerCell {
    let PerCell::Each(old) = values else { return values.clone() };
    let mut new = old.clone();
    old.iter().zip(to).for_each(|(value, &to)| new[to] = *value);
    PerCell::Each(new)
}

/// One value for all cells, or one for each.
fn of_cells(values: Vec<f64>) -> PerCell {
    if values.len() == 1 { PerCell::Uniform(values[0]) } else { PerCell::Each(values) }
}

/// Random bodies of nodal shapes: boxes of 8 to 36 nodes with edges of random length, every node
/// moved.
fn shapes(floating: bool) -> impl Strategy<Value = Case> {
    (2_usize..4, 2_usize..4, 2_usize..5).prop_flat_map(move |(a, b, c)| {
        let nodes = a * b * c;
        let moved = prop::collection::vec(prop::array::uniform3(-0.1_f64..0.1), nodes);
        let apart_m = prop::array::uniform3(0.01_f64..0.05);
        let fixed = prop::collection::btree_set(0..nodes as u32 - 1, 1..5);
        let coarse_functions = prop::option::of(1.0_f64..4.0);
        (moved, apart_m, fixed, tissue(nodes), coarse_functions, 1_u16..5).prop_map(
            move |(moved, apart_m, fixed, tissue, coarse_functions, sweeps)| {
                // A spacing of 1 in every direction, before that of the case.
                let mut shape = Shape::generated(&format!("box:{a}x{b}x{c}x1")).unwrap();
                for (node, by) in shape.mesh.nodes_m.iter_mut().zip(moved) {
                    *node = std::array::from_fn(|axis| apart_m[axis] * (node[axis] + by[axis]));
                }
                shape.fixed = if floating { Vec::new() } else { fixed.into_iter().collect() };
                let shape = shape.holding(&[nodes as u32 - 1]);
                let case = Case::new(shape, 0.0, vec![1.0; nodes]);
                Case { tissue: Some(tissue), coarse_functions, sweeps, ..case }
            },
        )
    })
}

/// Random bodies of both kinds, each in one of these variants that moves it; `floating` ones without
/// fixed nodes.
pub fn body(floating: bool, variants: Vec<Variant>) -> impl Strategy<Value = (Case, Variant)> {
    let of_shapes: Vec<Variant> = variants.iter().copied().filter(Variant::takes_shapes).collect();
    prop_oneof![
        2 => (case(floating), prop::sample::select(variants)),
        1 => (shapes(floating), prop::sample::select(of_shapes)),
    ]
}

/// Schemes in single precision, without a coarse level but that of the model.
#[must_use]
pub fn singles(schemes: &[Scheme]) -> Vec<Variant> {
    schemes.iter().map(|&scheme| Variant::plain(scheme, Arithmetic::F32)).collect()
}

/// Options for both kinds of body: of links, and of nodal shapes of 5 kPa.
#[must_use]
pub fn kinds(options: &BakeOptions) -> [BakeOptions; 2] {
    let of = PerCell::Uniform;
    let tissue = Some(Tissue::new(of(5000.0), of(0.45)));
    let shapes = BakeOptions { tissue, alpha: of(0.0), ..options.clone() };
    [options.clone(), shapes]
}

/// Whether all nodes keep a distance from each other, so that the body can be baked.
fn apart(nodes_m: &[[f64; 3]]) -> bool {
    let squared = |a: [f64; 3], b: [f64; 3]| (0..3).map(|x| (a[x] - b[x]).powi(2)).sum::<f64>();
    nodes_m.iter().enumerate().all(|(i, &a)| nodes_m[..i].iter().all(|&b| squared(a, b) > 1e-6))
}

/// A body of these nodes \[m\] and links, the lower end of each first; the tool holds the last
/// node.
#[must_use]
pub fn shape(nodes_m: Vec<[f64; 3]>, links: Vec<[u32; 2]>, fixed: Vec<u32>) -> Shape {
    let last = nodes_m.len() as u32 - 1;
    Shape { mesh: Mesh { nodes_m, links, ..Mesh::default() }, fixed, held: vec![last] }
}

impl Case {
    /// A body of links without a coarse level, a sweep and a step a tick.
    #[must_use]
    pub fn new(shape: Shape, alpha: f64, stiffness_n_per_m: Vec<f64>) -> Self {
        let (tissue, coarse_functions, sweeps, tick_time) = (None, None, 1, 1.0);
        Self { shape, alpha, stiffness_n_per_m, tissue, coarse_functions, sweeps, tick_time }
    }

    /// The same with node i called `to[i]`.
    #[must_use]
    pub fn renumbered(&self, to: &[usize]) -> Self {
        let mut other = self.clone();
        let call = |id: u32| to[id as usize] as u32;
        for (from, &to) in to.iter().enumerate() {
            other.shape.mesh.nodes_m[to] = self.shape.mesh.nodes_m[from];
            other.stiffness_n_per_m[to] = self.stiffness_n_per_m[from];
        }
        let links = self.shape.mesh.links.iter().map(|link| {
            let [a, b] = link.map(call);
            [a.min(b), a.max(b)]
        });
        other.shape.mesh.links = links.collect();
        other.shape.mesh.links.sort_unstable();
        let mesh = &mut other.shape.mesh;
        mesh.triangles
            .iter_mut()
            .flatten()
            .chain(mesh.tetrahedra.iter_mut().flatten())
            .for_each(|id| *id = call(*id));
        other.shape.fixed = self.shape.fixed.iter().copied().map(call).collect();
        if let Some((new, old)) = other.tissue.as_mut().zip(self.tissue.as_ref()) {
            new.young_pa = moved(&old.young_pa, to);
            new.poisson = moved(&old.poisson, to);
        }
        other
    }

    /// What the case says to the bake.
    #[must_use]
    pub fn options(&self) -> BakeOptions {
        BakeOptions {
            alpha: PerCell::Uniform(self.alpha),
            stiffness_n_per_m: PerCell::Each(self.stiffness_n_per_m.clone()),
            coarse_basis: self.coarse_functions.map_or(BasisSpacing::None, BasisSpacing::Links),
            tissue: self.tissue.clone(),
            ..BakeOptions::default()
        }
    }

    /// The baked body.
    #[must_use]
    pub fn image(&self) -> ImageBytes {
        self.shape.bake(&self.options()).unwrap()
    }

    /// An engine whose tool holds the last node; an error where the body is outside the range of
    /// the numbers.
    ///
    /// # Errors
    /// As [`Variant::engine`].
    pub fn engine<'m>(
        &self,
        image: &'m ImageBytes,
        variant: Variant,
        unloading: Unloading,
    ) -> Result<Engine<'m>, Error> {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let contact = Contact::Cells(self.shape.cells(&model));
        self.engine_with(model, variant, contact, |settings| Settings { unloading, ..settings })
    }

    /// An engine with any contact under the case's step and tick time, its settings `change`d.
    ///
    /// # Errors
    /// As [`Variant::engine`].
    pub fn engine_with<'m>(
        &self,
        model: Model<'m>,
        variant: Variant,
        contact: Contact,
        change: impl FnOnce(Settings) -> Settings,
    ) -> Result<Engine<'m>, Error> {
        let step = model.step_max();
        let tick_time = self.tick_time * step;
        let of = |settings| change(Settings { step, tick_time, ..settings });
        variant.engine(model, contact, self.sweeps, of)
    }

    /// Plays steps on an image of the body, from a state or from rest.
    ///
    /// # Errors
    /// As [`Self::engine`].
    pub fn play<'m>(
        &self,
        image: &'m ImageBytes,
        variant: Variant,
        unloading: Unloading,
        state: Option<&[[f32; 3]]>,
        steps: impl IntoIterator<Item = Step>,
    ) -> Result<Monitor<'m>, Error> {
        play(|| self.engine(image, variant, unloading), variant.numbers, state, steps)
    }
}

/// That every tick which the monitor saw held what it must.
///
/// # Errors
/// The failures, for a property test.
pub fn holds(monitor: &Monitor<'_>) -> Result<(), TestCaseError> {
    prop_assert!(monitor.failures().is_empty(), "{:?}", monitor.failures());
    Ok(())
}

/// A tool sample.
#[must_use]
pub fn sample(position_m: [f32; 3], engaged: u32) -> ToolPose {
    ToolPose::at(Vector3::from(position_m), engaged)
}
