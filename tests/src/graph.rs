//! Random bodies of 4 to 40 cells for property tests: stiffness over six decades, alpha from 0 to
//! 0.99, with and without hats; and their energy in double precision.

use chaincell_host::bake::{BakeOptions, HatSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_host::mesh::Mesh;
use chaincell_kernel::{Model, Network, Settings, ToolSample, Unloading};
pub use chaincell_lab::experiments::stress::{FIXED_RESOLUTION, energy_j};
use nalgebra::Vector3;
use proptest::prelude::*;

/// A random body: nodes, links, fixed nodes and what the bake needs.
#[derive(Debug, Clone)]
pub struct Case {
    /// Positions \[m\].
    pub nodes_m: Vec<[f64; 3]>,
    /// Links of nodes, lower first.
    pub links: Vec<[u32; 2]>,
    /// Fixed nodes, ascending.
    pub fixed: Vec<u32>,
    /// Half-width of the bands.
    pub alpha: f64,
    /// Stiffness of each node [N/m].
    pub stiffness_n_per_m: Vec<f64>,
    /// Distance of the hats in mean link lengths.
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
                Case { nodes_m, links, fixed, alpha, stiffness_n_per_m, hats, sweeps, tick_time }
            },
        )
    })
}

/// Whether all nodes keep a distance from each other, so that the body can be baked.
fn apart(nodes_m: &[[f64; 3]]) -> bool {
    let squared = |a: [f64; 3], b: [f64; 3]| (0..3).map(|x| (a[x] - b[x]).powi(2)).sum::<f64>();
    nodes_m.iter().enumerate().all(|(i, &a)| nodes_m[..i].iter().all(|&b| squared(a, b) > 1e-6))
}

impl Case {
    /// The baked body.
    #[must_use]
    pub fn image(&self, options: BakeOptions) -> ImageBytes {
        let mesh =
            Mesh { nodes_m: self.nodes_m.clone(), links: self.links.clone(), ..Mesh::default() };
        let options = BakeOptions {
            alpha: PerCell::Uniform(self.alpha),
            stiffness_n_per_m: PerCell::Each(self.stiffness_n_per_m.clone()),
            hats: self.hats.map_or(HatSpacing::None, HatSpacing::Links),
            colours: true,
            ..options
        };
        bake(&mesh, &self.fixed, &options).unwrap()
    }

    /// An engine whose tool holds the last node.
    #[must_use]
    pub fn engine<'m>(
        &self,
        image: &'m ImageBytes,
        scheme: Scheme,
        unloading: Unloading,
    ) -> Engine<'m> {
        self.engine_in(image, scheme, Arithmetic::F32, unloading).unwrap()
    }

    /// The same in other numbers; an error where they do not carry the body.
    ///
    /// # Errors
    /// As [`Engine::in_numbers`].
    pub fn engine_in<'m>(
        &self,
        image: &'m ImageBytes,
        scheme: Scheme,
        numbers: Arithmetic,
        unloading: Unloading,
    ) -> Result<Engine<'m>, chaincell_host::error::Error> {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let settings = Settings {
            step: model.step_max(),
            tick_time: self.tick_time * model.step_max(),
            unloading,
            ..scheme.settings(&model, self.sweeps)
        };
        let network = Network::new(model, settings).unwrap();
        // The last node is never fixed; the tool holds it.
        let last = self.nodes_m.len() as u32 - 1;
        let cell = model.input_id().iter().position(|&id| id == last).unwrap() as u16;
        Engine::in_numbers(network, scheme, numbers, &[cell])
    }
}

/// A tool sample.
#[must_use]
pub fn sample(position_m: [f32; 3], engaged: u32) -> ToolSample {
    ToolSample { position_m: Vector3::from(position_m), engaged }
}
