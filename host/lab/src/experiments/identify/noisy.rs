//! Targets made from known parameters: what the forward problem gives, with noise.

use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::forward::Predicted;
use super::target::{Target, rms};
use chaincell_host::error::{Error, Result};

/// The targets with the numbers `exact` and normal noise of `part` of each one's root mean square.
pub fn noisy(
    mut targets: Vec<Target>,
    exact: Predicted,
    part: f64,
    seed: u64,
) -> Result<Vec<Target>> {
    let mut random = Pcg64::seed_from_u64(seed);
    for (target, values) in targets.iter_mut().zip(exact) {
        let noise = Normal::new(0.0, part * rms(&values)).map_err(Error::check)?;
        for (into, value) in target.observed.iter_mut().zip(values) {
            *into = value + noise.sample(&mut random);
        }
    }
    Ok(targets)
}
