//! How far the ends of a link may stray from their offset at rest.

use chaincell_host::error::{Error, Result};

/// Bounds of every link: along its offset at rest and across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    compression: f64,
    extension: f64,
    shear: f64,
}

impl Limits {
    /// Ends keep their offset at rest.
    pub const RIGID: Self = Self { compression: 1.0, extension: 1.0, shear: 0.0 };

    /// `a_min` and `a_max`, the least and the largest offset along an axis, and `b`, the largest
    /// shear across it, as fractions of the offset at rest.
    pub fn new(compression: f64, extension: f64, shear: f64) -> Result<Self> {
        let holds = (0.0..=1.0).contains(&compression)
            && (1.0..f64::INFINITY).contains(&extension)
            && (0.0..f64::INFINITY).contains(&shear);
        if !holds {
            return Err(Error::input(format!(
                "limits of a chain {compression}, {extension}, {shear}: compression must be in \
                 [0, 1], extension at least 1, shear at least 0"
            )));
        }
        Ok(Self { compression, extension, shear })
    }

    /// What stands for the network's band (Eq. 5-6): 1 - alpha, 1 + alpha, shear alpha.
    ///
    /// The band leaves a link alpha of its length along its direction and is free across it, where
    /// a chain needs a bound: it is given the same freedom there.
    pub fn of_alpha(alpha: f64) -> Result<Self> {
        if !(0.0..1.0).contains(&alpha) {
            return Err(Error::input(format!("alpha {alpha} of a chain: must be in [0, 1)")));
        }
        Self::new(1.0 - alpha, 1.0 + alpha, alpha)
    }

    /// Least and largest offset per axis for an offset D at rest: `[a_min D - b S, a_max D + b S]`,
    /// S the sum of the other two |D|, the ends the other way round where D is negative.
    ///
    /// For a link along an axis these are Gibson's: min and max along it, shear across it.
    pub fn region(&self, rest: [f64; 3]) -> [[f64; 2]; 3] {
        let size = rest.map(f64::abs);
        std::array::from_fn(|axis| {
            let (short, long) = (self.compression * rest[axis], self.extension * rest[axis]);
            let shear = self.shear * (size[(axis + 1) % 3] + size[(axis + 2) % 3]);
            [short.min(long) - shear, short.max(long) + shear]
        })
    }
}
