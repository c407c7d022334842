//! Stiffening bands in double precision: the energy of links that are outside their bands.

use std::collections::BTreeMap;

use super::nodal::volume_m3;
use super::vectors::{minus, norm};
use chaincell_host::bake::tissue::{Band, BandSide};
use chaincell_kernel::Model;

/// A link: its ends, its rest length, and the volume of the tetrahedra around it.
#[derive(Debug, Clone, PartialEq)]
struct Link {
    ends: [u16; 2],
    rest_length: f64,
    volume: f64,
}

/// The bands of a model, in its own units.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stiffening {
    /// With moduli in the model's unit of stress.
    bands: Vec<Band>,
    links: Vec<Link>,
}

impl Stiffening {
    /// Those of a model; none in most. It has to keep its tetrahedra.
    #[must_use]
    pub fn of_model(model: &Model<'_>) -> Self {
        let unit_pa = 2.0 * f64::from(model.stiffness_n_per_m()) / f64::from(model.unit_m());
        let in_units = |band: Band| Band { modulus_pa: band.modulus_pa / unit_pa, ..band };
        let bands: Vec<Band> = Band::of_model(model).into_iter().map(in_units).collect();
        if bands.is_empty() {
            return Self::default();
        }
        let rest: Vec<_> =
            (0..model.cells()).map(|cell| model.rest_position(cell).map(f64::from)).collect();
        let mut volumes: BTreeMap<[u16; 2], f64> = BTreeMap::new();
        for nodes in model.tetrahedra() {
            let volume = volume_m3(&rest, nodes.map(u32::from)).abs();
            for (a, &i) in nodes.iter().enumerate() {
                for &j in &nodes[a + 1..] {
                    *volumes.entry([i.min(j), i.max(j)]).or_insert(0.0) += volume;
                }
            }
        }
        let links = volumes.into_iter().map(|(ends, volume)| {
            let [i, j] = ends.map(usize::from);
            Link { ends, rest_length: norm(minus(rest[j], rest[i])), volume }
        });
        Self { bands, links: links.collect() }
    }

    /// Energy of each cell, half of that of each of its links.
    #[must_use]
    pub fn energies(&self, positions: &[[f64; 3]]) -> Vec<f64> {
        let mut energies = vec![0.0; positions.len()];
        for Link { ends, rest_length, volume } in &self.links {
            let [i, j] = ends.map(usize::from);
            let strain = norm(minus(positions[j], positions[i])) / rest_length - 1.0;
            let left_out = if strain > 0.0 { BandSide::Short } else { BandSide::Long };
            let bands = self.bands.iter().filter(|band| band.side != left_out);
            let squares = bands.map(|band| {
                let beyond = (strain.abs() - band.half_width).max(0.0);
                band.modulus_pa * beyond * beyond
            });
            let half = 0.25 * volume * squares.sum::<f64>();
            energies[i] += half;
            energies[j] += half;
        }
        energies
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Nodal;
    use chaincell_host::bake::tissue::{Band, Tissue};
    use chaincell_host::bake::{BakeOptions, PerCell, bake};
    use chaincell_host::engine::{Engine, Scheme};
    use chaincell_host::mesh::{MeshOptions, load};
    use chaincell_kernel::{Network, Settings, ToolPose};

    #[test]
    fn the_kernel_stores_what_the_bands_store() {
        let long = |half_width, modulus_pa| Band {
            side: BandSide::Long,
            ..Band::new(half_width, modulus_pa)
        };
        let short = Band { side: BandSide::Short, ..Band::new(0.02, 30_000.0) };
        stores(&[Band::new(0.05, 10_000.0), Band::new(0.15, 40_000.0)], 1.0);
        stores(&[short, long(0.02, 4_000.0), long(0.1, 40_000.0)], 1.0);
        stores(&[short, long(0.02, 4_000.0), long(0.1, 40_000.0)], -1.0);
    }

    /// A block pulled or pressed until its bands are taut: the kernel's energy is that of the positions, and
    /// its force what the energy rises by.
    fn stores(stiffening: &[Band], way: f64) {
        let mesh = load("box:5x5x5x0.01", &MeshOptions::default()).unwrap();
        let of = PerCell::Uniform;
        let tissue = Tissue { stiffening: stiffening.to_vec(), ..Tissue::new(of(5000.0), of(0.3)) };
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let (shapes, bands) =
            (Nodal::of_model(&model).unwrap().unwrap(), Stiffening::of_model(&model));
        let top = mesh.nodes_m.iter().enumerate().filter(|(_, x)| x[2] > 0.0399);
        let mut held: Vec<u16> =
            top.filter_map(|(node, _)| model.cell_of_input(node as u32)).collect();
        held.sort_unstable();
        let settings = Settings { sweeps: 8, ..Settings::for_model(&model) };
        let network = Network::new(model, settings).unwrap();
        let mut engine = Engine::new(network, Scheme::Track, &held).unwrap();
        let mut settled = |by_m: f64| {
            let position_m = [0.0, 0.0, (way * by_m) as f32].into();
            (0..400).map(|_| engine.tick(&ToolPose::at(position_m, 1))).last().unwrap();
            let output = engine.tick(&ToolPose::at(position_m, 1));
            let own: Vec<[f64; 3]> = engine.positions_m().into_iter().collect();
            (f64::from(output.energy_j), -way * f64::from(output.force_n[2]), own)
        };
        let (unit_m, centre_m) = (f64::from(model.unit_m()), model.centre_m().map(f64::from));
        let mut last: Option<[f64; 3]> = None;
        for by_m in [0.0, 0.004, 0.008, 0.0085, 0.012, 0.0125] {
            let (energy_j, force_n, at_m) = settled(by_m);
            let at: Vec<[f64; 3]> = at_m
                .iter()
                .map(|x| std::array::from_fn(|axis| (x[axis] - centre_m[axis]) / unit_m))
                .collect();
            let (soft, stiff) = (shapes.energies(&at), bands.energies(&at));
            let unit_j = f64::from(model.energy_unit_j());
            let (soft, stiff) =
                (soft.iter().sum::<f64>() * unit_j, stiff.iter().sum::<f64>() * unit_j);
            println!("{by_m}: {energy_j:.4e} J, {soft:.4e} + {stiff:.4e}, {force_n:.4} N");
            assert!((energy_j - soft - stiff).abs() <= 1e-3 * energy_j + 1e-12);
            assert!(by_m < 0.012 || stiff > soft, "the bands are taut");
            if let Some([before_m, before_j, before_n]) = last.filter(|last| by_m - last[0] < 6e-4)
            {
                let mean_n = (energy_j - before_j) / (by_m - before_m);
                assert!((2.0 * mean_n / (force_n + before_n) - 1.0).abs() < 5e-3, "{mean_n}");
            }
            last = Some([by_m, energy_j, force_n]);
        }
    }
}
