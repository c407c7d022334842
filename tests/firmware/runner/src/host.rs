//! The same scene on this machine.

use anyhow::{Context, Result, bail};
use chaincell_kernel::Cell;
use chaincell_kernel::Choice;
use chaincell_kernel::Contact;
use chaincell_kernel::Team;
use chaincell_kernel::{
    Anchor, Budget, CoarseTouch, CutRoom, Dynamics, Euler, Head, Model, NearTriangle, Network,
    Predict, Rkl2, Settings, TermState, TermStates, TissueMut, ToolPose, ToolState, TouchArrays,
    TouchRoom, TouchState, Track, cut_words, term_states,
};
use chaincell_scenes::adverse::{self, AdverseError};
use chaincell_scenes::{Act, Run, RunError, Scene, Tier, golden};
use fixed::types::I8F24;

use crate::case::{Ready, STATES, Tool};

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

/// State hash after a tick from the worst state that ended after so many `sweeps`: links half too
/// long, the tool taking hold.
pub fn again(ready: &Ready, tier: Tier, at_most: u16, sweeps: u16) -> Result<u64> {
    stage(ready, tier, Again { at_most, sweeps })?
}

/// One tick anew.
struct Again {
    at_most: u16,
    sweeps: u16,
}

impl Act for Again {
    type Output = Result<u64>;

    fn act<D: Dynamics>(self, scene: &'static Scene, mut tissue: TissueMut<'_, D>) -> Result<u64> {
        let Self { at_most, sweeps } = self;
        let model = Model::from_bytes(scene.image)?;
        let tick_time = D::tick_time(&model, at_most);
        let settings = Settings { sweeps: at_most, tick_time, ..(scene.settings)(&model) };
        let network = Network::new(model, settings)?;
        let held = scene.held.iter().map(|&id| model.cell_of_input(id).context("no such cell"));
        let mut held = held.collect::<Result<Vec<u16>>>()?;
        held.sort_unstable();
        tissue.reset(&network)?;
        let mut sample = ToolPose::at([0.0; 3].into(), 1);
        match scene.tools() {
            None => tissue.choose_contacts(&network, &held)?,
            Some(tools) => {
                sample.position_m = tools.start_m[0].into();
                tissue.choose_tools(&network, tools.parts, tools.friction)?;
            }
        }
        let rest = (0..model.cells()).map(|cell| model.rest_position(cell));
        let [(_, scale), ..] = STATES;
        let state: Vec<[f32; 3]> = rest.map(|at| at.map(|x| x * scale)).collect();
        tissue.set_positions(&network, &state)?;
        tissue.tick(&network, &[sample], Budget::again(Some(sweeps)));
        Ok(tissue.state_hash(&model))
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
        ("predict", Tier::F32) => with::<Predict, A>(ready, act),
        ("euler", Tier::F32) => with::<Euler, A>(ready, act),
        ("rkl2", Tier::F32) => with::<Rkl2, A>(ready, act),
        ("track", Tier::Fixed) => with::<Track<0, I8F24>, A>(ready, act),
        ("euler", Tier::Fixed) => with::<Euler<I8F24>, A>(ready, act),
        (scheme, tier) => bail!("no scheme {scheme} in {}", tier.name()),
    })
}

fn with<D: Dynamics, A: Act>(ready: &Ready, act: A) -> A::Output {
    let (cells, held) = (ready.model.cells(), ready.scene.held.len());
    let mut states = vec![TermState::ZERO; term_states(ready.model.kept_states())];
    let mut words = vec![0; cut_words(&ready.model)];
    let tissue = TissueMut {
        head: &mut { Head::<D>::NEW },
        state: &mut vec![Cell::ZERO; cells],
        residual: &mut vec![Cell::ZERO; cells],
        own: &mut vec![Cell::ZERO; D::ARRAYS * cells],
        room: &mut vec![[0.0; 8]; D::room_blocks(&ready.model, held)],
        contacts: &mut vec![Contact::NONE; held],
        states: TermStates::new(&mut states),
        touch: TouchRoom::none(),
        cut: CutRoom::new(&mut words),
        team: Team::ALONE,
    };
    let Some(Tool { near, anchors, .. }) = ready.case.tool else {
        return act.act(ready.scene, tissue);
    };
    let (mut mobility, mut factors) = (vec![0.0; cells], vec![0.0; cells]);
    let (mut pulls, mut near) = (vec![Cell::ZERO; cells], vec![NearTriangle::NONE; near]);
    let (mut anchors, mut coarse) = (vec![Anchor::NONE; 2 * anchors], [CoarseTouch::NONE]);
    let (mut tools, mut state) = ([ToolState::NONE], [TouchState::AWAY]);
    let touch = TouchRoom::new(TouchArrays {
        mobility: &mut mobility,
        factors: &mut factors,
        pulls: &mut pulls,
        near: &mut near,
        anchors: &mut anchors,
        pins: &mut [],
        coarse: &mut coarse,
        tools: &mut tools,
        state: &mut state,
    });
    act.act(ready.scene, TissueMut { touch, ..tissue })
}
