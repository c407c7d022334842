//! The same scene on this machine.

use anyhow::{Result, bail};
use chaincell_kernel::Cell;
use chaincell_kernel::Choice;
use chaincell_kernel::Contact;
use chaincell_kernel::{
    Dynamics, Euler, GaussSeidel, Head, Rkl1, Rkl2, TermState, TermStates, TissueMut, Track,
};
use chaincell_scenes::adverse::{self, AdverseError};
use chaincell_scenes::{Act, Run, RunError, Scene, Tier, golden};
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
    let answer = stage(ready, tier, Play(ready.ticks))??;
    if let Some(golden) = golden(ready.scene, tier, ready.ticks)
        && golden.digest != answer.digest
    {
        let (name, own, must) = (ready.case.name, answer.digest, golden.digest);
        bail!("{name}: this machine's digest is {own:016x}, the golden one {must:016x}");
    }
    Ok(answer)
}

/// Endures the hard states: the digest after each.
pub fn endure(ready: &Ready, tier: Tier) -> Result<Vec<(&'static str, u64)>> {
    Ok(stage(ready, tier, Endure)??)
}

/// The scene.
struct Play(u32);

impl Act for Play {
    type Output = Result<Answer, RunError>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue)?;
        let mut state_hash = 0;
        run.play(self.0, |_, hash| state_hash = hash);
        Ok(Answer { state_hash, digest: run.digest() })
    }
}

/// The hard states.
struct Endure;

impl Act for Endure {
    type Output = Result<Vec<(&'static str, u64)>, AdverseError>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let (mut room, mut digests) = (vec![[0.0; 3]; scene.cells], vec![]);
        adverse::endure(scene, tissue, &mut room, |state, digest| digests.push((state, digest)))?;
        Ok(digests)
    }
}

/// Gives `act` the scene with a tissue for it.
fn stage<A: Act>(ready: &Ready, tier: Tier, act: A) -> Result<A::Output> {
    Ok(match (ready.scene.scheme, tier) {
        ("track", Tier::F32) => with::<Track, A>(ready, act),
        ("euler", Tier::F32) => with::<Euler, A>(ready, act),
        ("rkl1", Tier::F32) => with::<Rkl1, A>(ready, act),
        ("rkl2", Tier::F32) => with::<Rkl2, A>(ready, act),
        ("gauss-seidel", Tier::F32) => with::<GaussSeidel, A>(ready, act),
        ("track", Tier::Fixed) => with::<Track<0, I8F24>, A>(ready, act),
        ("euler", Tier::Fixed) => with::<Euler<I8F24>, A>(ready, act),
        (scheme, tier) => bail!("no scheme {scheme} in {}", tier.name()),
    })
}

fn with<D: Dynamics, A: Act>(ready: &Ready, act: A) -> A::Output {
    let (cells, held) = (ready.model.cells(), ready.scene.held.len());
    let mut states = vec![TermState::REST; cells];
    let tissue = TissueMut {
        head: &mut { Head::<D>::NEW },
        state: &mut vec![Cell::ZERO; cells],
        residual: &mut vec![Cell::ZERO; D::RESIDUALS * cells],
        own: &mut vec![Cell::ZERO; D::ARRAYS * cells],
        room: &mut vec![[0.0; 8]; D::room_blocks(&ready.model, held)],
        contacts: &mut vec![Contact::NONE; held],
        states: TermStates::new(&mut states),
    };
    act.act(ready.scene, tissue)
}
