//! Sets of bands on the links of nodal shapes, which resist large strain.

use std::collections::BTreeMap;

use chaincell_kernel::image::kind;
use chaincell_kernel::number::two_float::LANES;

use super::shape::volume_m3;
use crate::bake::image::Sections;

/// A set of bands: links are springs while their length is outside the band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Half its width in rest lengths, from 0.01 to below 1.
    pub half_width: f64,
    /// Young's modulus that the set adds beyond it \[Pa\].
    pub modulus_pa: f64,
}

/// The bands of a body in the form of its image.
pub(super) struct Stiffening {
    /// Half-width and modulus \[units of stress\] of each set, the narrowest first.
    sets: Vec<[f32; 2]>,
    /// 2 V / l0^2 of each link, in both directions.
    volumes: BTreeMap<[u32; 2], f32>,
}

impl Stiffening {
    /// Makes bands on the edges of `tetrahedra`, with moduli in units of `unit_pa`.
    pub fn new(bands: &[Band], unit_pa: f64, rest: &[[f64; 3]], tetrahedra: &[[u32; 4]]) -> Self {
        let mut bands = bands.to_vec();
        bands.sort_by(|a, b| a.half_width.total_cmp(&b.half_width));
        let sets = bands.iter().map(|band| [band.half_width, band.modulus_pa / unit_pa]);
        let mut around: BTreeMap<[u32; 2], f64> = BTreeMap::new();
        for nodes in tetrahedra.iter().filter(|_| !bands.is_empty()) {
            let volume = volume_m3(rest, *nodes);
            for a in 0..4 {
                for b in a + 1..4 {
                    let ends = [nodes[a].min(nodes[b]), nodes[a].max(nodes[b])];
                    *around.entry(ends).or_insert(0.0) += volume;
                }
            }
        }
        let mut volumes = BTreeMap::new();
        for ([i, j], volume) in around {
            let squared: f64 =
                rest[i as usize].iter().zip(rest[j as usize]).map(|(a, b)| (a - b) * (a - b)).sum();
            let value = (2.0 * volume / squared) as f32;
            volumes.extend([([i, j], value), ([j, i], value)]);
        }
        Self { sets: sets.map(|set| set.map(|x| x as f32)).collect(), volumes }
    }

    /// Adds the weights of each cell's links to `sums`, by the kernel's arithmetic.
    pub fn add_weights(&self, sums: &mut [f32]) {
        if self.sets.is_empty() {
            return;
        }
        let modulus = self.sets.iter().fold(0.0_f32, |sum, [_, modulus]| sum + modulus);
        let mut around = vec![0.0_f32; sums.len()];
        for ([cell, _], volume) in &self.volumes {
            around[*cell as usize] += volume;
        }
        for (sum, around) in sums.iter_mut().zip(around) {
            *sum += modulus * around;
        }
    }

    /// Adds the sections; `slices` and `ids` are the starts and the other ends of the slices.
    pub fn push(&self, sections: &mut Sections, slices: &[u32], ids: &[u16]) {
        if self.sets.is_empty() {
            return;
        }
        let sets: Vec<u32> = self.sets.iter().flatten().map(|value| value.to_bits()).collect();
        sections.push(kind::STIFFENING, &sets);
        let mut values = vec![0.0_f32; ids.len()];
        for (slice, groups) in slices.windows(2).enumerate() {
            for at in LANES * groups[0] as usize..LANES * groups[1] as usize {
                let ends = [(slice * LANES + at % LANES) as u32, u32::from(ids[at])];
                values[at] = self.volumes.get(&ends).copied().unwrap_or(0.0);
            }
        }
        sections.push(kind::STIFFENING_SLOTS, &values);
    }
}
