//! The same scene on this machine.

use anyhow::{Result, bail};
use chaincell_kernel::cell::Cell;
use chaincell_kernel::contact::Contact;
use chaincell_kernel::{Dynamics, Euler, GaussSeidel, Head, Rkl1, Rkl2, TissueMut, Track};
use chaincell_scenes::{Run, Tier, golden};
use fixed::types::I8F24;

use crate::case::Ready;

/// State hash after the last tick, and digest of all ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    pub state_hash: u64,
    pub digest: u64,
}

/// Plays the scene, and compares with the golden digest where there is one.
pub fn play(ready: &Ready, tier: Tier) -> Result<Answer> {
    let answer = match (ready.scene.scheme, tier) {
        ("track", Tier::F32) => run::<Track>(ready),
        ("euler", Tier::F32) => run::<Euler>(ready),
        ("rkl1", Tier::F32) => run::<Rkl1>(ready),
        ("rkl2", Tier::F32) => run::<Rkl2>(ready),
        ("gauss-seidel", Tier::F32) => run::<GaussSeidel>(ready),
        ("track", Tier::Fixed) => run::<Track<0, I8F24>>(ready),
        ("euler", Tier::Fixed) => run::<Euler<I8F24>>(ready),
        (scheme, tier) => bail!("no scheme {scheme} in {}", tier.name()),
    }?;
    if let Some(golden) = golden(ready.scene, tier, ready.ticks)
        && golden.digest != answer.digest
    {
        let (name, own, must) = (ready.case.name, answer.digest, golden.digest);
        bail!("{name}: this machine's digest is {own:016x}, the golden one {must:016x}");
    }
    Ok(answer)
}

fn run<D: Dynamics>(ready: &Ready) -> Result<Answer> {
    let (cells, held) = (ready.model.cells(), ready.scene.held.len());
    let tissue = TissueMut {
        head: &mut { Head::<D>::NEW },
        state: &mut vec![Cell::ZERO; cells],
        residual: &mut vec![Cell::ZERO; D::RESIDUALS * cells],
        own: &mut vec![Cell::ZERO; D::ARRAYS * cells],
        room: &mut vec![[0.0; 8]; D::room_octets(&ready.model, held)],
        contacts: &mut vec![Contact::NONE; held],
    };
    let mut run = Run::new(ready.scene, tissue)?;
    let mut state_hash = 0;
    run.play(ready.ticks, |_, hash| state_hash = hash);
    Ok(Answer { state_hash, digest: run.digest() })
}
