//! Random bodies of 4 to 40 cells for property tests: stiffness over six decades, alpha from 0 to
//! 0.99, with and without a coarse level.

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::{Contact, Engine};
use chaincell_host::error::Error;
use chaincell_host::mesh::Mesh;
use chaincell_kernel::{Model, Settings, ToolSample, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::Monitor;
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
    /// Distance of the coarse basis functions in mean link lengths.
    pub hats: Option<f64>,
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
        let hats = prop::option::of(1.0_f64..4.0);
        let rates = (prop_oneof![3 => 1_u16..5, 1 => 5_u16..16], 0.5_f32..40.0);
        (nodes, chords, parents, fixed, alpha, decades, (hats, rates)).prop_map(
            move |(nodes_m, chords, parents, mut fixed, alpha, decades, (hats, rates))| {
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
                Case { shape, alpha, stiffness_n_per_m, hats, sweeps, tick_time }
            },
        )
    })
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
    /// What the case says to the bake.
    #[must_use]
    pub fn options(&self) -> BakeOptions {
        BakeOptions {
            alpha: PerCell::Uniform(self.alpha),
            stiffness_n_per_m: PerCell::Each(self.stiffness_n_per_m.clone()),
            coarse_basis: self.hats.map_or(BasisSpacing::None, BasisSpacing::Links),
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
pub fn sample(position_m: [f32; 3], engaged: u32) -> ToolSample {
    ToolSample { position_m: Vector3::from(position_m), engaged }
}
