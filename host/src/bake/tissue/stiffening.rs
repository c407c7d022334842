//! Sets of bands on the links of nodal shapes, which resist large strain.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use chaincell_kernel::Model;
use chaincell_kernel::image::kind;
use chaincell_kernel::number::two_float::LANES;
use serde::{Serialize, Serializer};

use super::shape::volume_m3;
use crate::bake::image::Sections;

/// The links that a band resists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BandSide {
    /// Shorter and longer ones.
    Both,
    /// Shorter ones alone.
    Short,
    /// Longer ones alone.
    Long,
}

impl BandSide {
    /// Its name; none for both sides.
    fn name(self) -> Option<&'static str> {
        match self {
            Self::Both => None,
            Self::Short => Some("short"),
            Self::Long => Some("long"),
        }
    }
}

/// A set of bands: links are springs while their length is outside the band. As text, `0.1=10000`, or
/// `short:0.035=22000` and `long:0.1=5000` of one side.
///
/// ```
/// # use chaincell_host::bake::tissue::{Band, BandSide};
/// let band: Band = "short:0.035=22000".parse()?;
/// assert_eq!((band.half_width, band.modulus_pa, band.side), (0.035, 22000.0, BandSide::Short));
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Half its width in rest lengths, from 0.01 to below 1.
    pub half_width: f64,
    /// Young's modulus that the set adds beyond it \[Pa\].
    pub modulus_pa: f64,
    /// The side on which it does.
    pub side: BandSide,
}

impl Band {
    /// Resists shorter and longer links.
    #[must_use]
    pub const fn new(half_width: f64, modulus_pa: f64) -> Self {
        Self { half_width, modulus_pa, side: BandSide::Both }
    }

    /// Returns the bands of a model, the narrowest first.
    #[must_use]
    pub fn of_model(model: &Model<'_>) -> Vec<Self> {
        // Single precision as it prints.
        let number = |x: f32| x.abs().to_string().parse().unwrap_or_default();
        let mut bands = Vec::new();
        model.each_stiffening(|half_width, modulus_pa| {
            let side = match (half_width < 0.0, modulus_pa < 0.0) {
                (true, _) => BandSide::Short,
                (_, true) => BandSide::Long,
                _ => BandSide::Both,
            };
            bands.push(Self { side, ..Self::new(number(half_width), number(modulus_pa)) });
        });
        bands
    }

    /// True if both resist the same links beyond the same half-width.
    #[must_use]
    pub fn repeats(&self, other: &Self) -> bool {
        let [one, two] = [self, other].map(|band| band.side);
        let is_shared = one == two || [one, two].contains(&BandSide::Both);
        is_shared && self.half_width as f32 == other.half_width as f32
    }

    /// Its numbers in the image: signs leave a side out.
    fn numbers(&self, unit_pa: f64) -> [f32; 2] {
        let (half_width, modulus) = (self.half_width as f32, (self.modulus_pa / unit_pa) as f32);
        match self.side {
            BandSide::Both => [half_width, modulus],
            BandSide::Short => [-half_width, modulus],
            BandSide::Long => [half_width, -modulus],
        }
    }
}

impl FromStr for Band {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "{text}: give HALF_WIDTH=PASCAL, as 0.1=10000, before it short: or long: for one side"
            )
        };
        let (side, numbers) = match text.trim().split_once(':') {
            Some(("short", rest)) => (BandSide::Short, rest),
            Some(("long", rest)) => (BandSide::Long, rest),
            Some(_) => return Err(wrong()),
            None => (BandSide::Both, text),
        };
        let (half_width, modulus_pa) = numbers.split_once('=').ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse().map_err(|_| wrong());
        Ok(Self { side, ..Self::new(number(half_width)?, number(modulus_pa)?) })
    }
}

impl fmt::Display for Band {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(side) = self.side.name() {
            write!(f, "{side}:")?;
        }
        write!(f, "{}={}", self.half_width, self.modulus_pa)
    }
}

/// Half-width and modulus, and the side of those that have one.
impl Serialize for Band {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let numbers = (self.half_width, self.modulus_pa);
        match self.side.name() {
            None => numbers.serialize(serializer),
            Some(side) => (numbers.0, numbers.1, side).serialize(serializer),
        }
    }
}

/// The bands of a body in the form of its image.
pub(super) struct Stiffening {
    /// Half-width and modulus \[units of stress\] of each set as the image has them, the narrowest first.
    sets: Vec<[f32; 2]>,
    /// Sum of the moduli of all sets that resist a link on the same side, the larger one of both sides.
    modulus: f32,
    /// 2 V / l0^2 of each link, in both directions.
    volumes: BTreeMap<[u32; 2], f32>,
}

impl Stiffening {
    /// Makes bands on the edges of `tetrahedra`, with moduli in units of `unit_pa`.
    pub fn new(bands: &[Band], unit_pa: f64, rest: &[[f64; 3]], tetrahedra: &[[u32; 4]]) -> Self {
        let mut bands = bands.to_vec();
        bands.sort_by(|a, b| a.half_width.total_cmp(&b.half_width));
        let sets = bands.iter().map(|band| band.numbers(unit_pa)).collect();
        let all_but = |side: BandSide| {
            let moduli = bands.iter().filter(|band| band.side != side);
            moduli.fold(0.0, |sum, band| sum + (band.modulus_pa / unit_pa) as f32)
        };
        let modulus = all_but(BandSide::Long).max(all_but(BandSide::Short));
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
        Self { sets, modulus, volumes }
    }

    /// Adds the weights of each cell's links to `sums`, by the kernel's arithmetic.
    pub fn add_weights(&self, sums: &mut [f32]) {
        if self.sets.is_empty() {
            return;
        }
        let mut around = vec![0.0_f32; sums.len()];
        for ([cell, _], volume) in &self.volumes {
            around[*cell as usize] += volume;
        }
        for (sum, around) in sums.iter_mut().zip(around) {
            *sum += self.modulus * around;
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
