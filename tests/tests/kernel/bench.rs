//! A body that can be cut, in memory of its own.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{
    Anchor, Budget, Cell, CoarseTouch, Contact, CutError, CutOutput, CutRoom, Dynamics, Head,
    Model, NearTriangle, Network, PinSample, Team, TermState, TermStates, TickOutput, TissueMut,
    ToolOutput, ToolPart, ToolPose, ToolState, TouchArrays, TouchRoom, TouchState, Track,
    cut_words, term_states,
};

/// Slots for triangles in reach of tools, and for samples that friction holds.
const NEAR: usize = 512;
const ANCHORS: usize = 2 * 2048;
/// Samples that pins hold.
const PINNED: usize = 512;

/// Memory for contact on the surface.
struct Surface {
    numbers: [Vec<f32>; 2],
    pulls: Vec<Cell>,
    near: Vec<NearTriangle>,
    anchors: Vec<Anchor>,
    pins: Vec<PinSample>,
    coarse: [CoarseTouch; 1],
    tools: Vec<ToolState>,
    state: [TouchState; 1],
}

impl Surface {
    fn new(cells: usize, tools: usize) -> Self {
        Self {
            numbers: [vec![0.0; cells], vec![0.0; cells]],
            pulls: vec![Cell::ZERO; cells],
            near: vec![NearTriangle::NONE; NEAR],
            anchors: vec![Anchor::NONE; ANCHORS],
            pins: vec![PinSample::NONE; PINNED],
            coarse: [CoarseTouch::NONE],
            tools: vec![ToolState::NONE; tools],
            state: [TouchState::AWAY],
        }
    }

    fn room(&mut self) -> TouchRoom<'_> {
        let [mobility, factors] = &mut self.numbers;
        TouchRoom::new(TouchArrays {
            mobility,
            factors,
            pulls: &mut self.pulls,
            near: &mut self.near,
            anchors: &mut self.anchors,
            pins: &mut self.pins,
            coarse: &mut self.coarse,
            tools: &mut self.tools,
            state: &mut self.state,
        })
    }
}

/// A tissue that can be cut, with its network.
pub struct Bench<'a, D: Dynamics<Number = f32> = Track> {
    pub network: Network<'a>,
    pub head: Head<D>,
    pub state: Vec<Cell>,
    residual: Vec<Cell>,
    own: Vec<Cell>,
    room: Vec<[f32; 8]>,
    contacts: Vec<Contact>,
    states: Vec<TermState>,
    surface: Option<Surface>,
    /// Memory for cuts.
    pub words: Vec<u32>,
}

impl<'a, D: Dynamics<Number = f32>> Bench<'a, D> {
    /// A body at rest whose tool holds the cells of these nodes.
    pub fn holding(network: Network<'a>, nodes: &[u32]) -> Self {
        let model = *network.model();
        let mut held: Vec<u16> =
            nodes.iter().map(|&node| model.cell_of_input(node).unwrap()).collect();
        held.sort_unstable();
        let blocks = D::room_blocks(&model, nodes.len());
        let mut bench = Self::at_rest(network, nodes.len(), blocks, None);
        bench.view().choose_contacts(&network, &held).unwrap();
        bench
    }

    /// A body at rest under tools.
    pub fn under(network: Network<'a>, tools: &[&[ToolPart]], friction: f32) -> Self {
        let model = *network.model();
        let surface = Surface::new(model.cells(), tools.len());
        let mut bench = Self::at_rest(network, 0, D::tool_blocks(&model), Some(surface));
        bench.view().choose_tools(&network, tools, friction).unwrap();
        bench
    }

    /// Words of the memory for cuts are not 0 before the reset.
    fn at_rest(network: Network<'a>, held: usize, blocks: usize, surface: Option<Surface>) -> Self {
        let model = *network.model();
        let cells = model.cells();
        let mut bench = Self {
            network,
            head: Head::NEW,
            state: vec![Cell::ZERO; cells],
            residual: vec![Cell::ZERO; cells],
            own: vec![Cell::ZERO; D::ARRAYS * cells],
            room: vec![[0.0; 8]; blocks],
            contacts: vec![Contact::NONE; held],
            states: vec![TermState::ZERO; term_states(model.kept_states())],
            surface,
            words: vec![0xAAAA_AAAA; cut_words(&model)],
        };
        bench.view().reset(&network).unwrap();
        bench
    }

    pub fn view(&mut self) -> TissueMut<'_, D> {
        TissueMut {
            head: &mut self.head,
            state: &mut self.state,
            residual: &mut self.residual,
            own: &mut self.own,
            room: &mut self.room,
            contacts: &mut self.contacts,
            states: TermStates::new(&mut self.states),
            touch: self.surface.as_mut().map_or_else(TouchRoom::none, Surface::room),
            cut: CutRoom::new(&mut self.words),
            team: Team::ALONE,
        }
    }

    pub fn model(&self) -> Model<'a> {
        *self.network.model()
    }

    /// A tick with the tool at a place, or of held cells moved by so much.
    pub fn tick(&mut self, place_m: [f32; 3]) -> TickOutput {
        self.tick_all(&[place_m])
    }

    /// A tick with each tool at a place.
    pub fn tick_all(&mut self, places_m: &[[f32; 3]]) -> TickOutput {
        let network = self.network;
        let poses: Vec<ToolPose> =
            places_m.iter().map(|place| ToolPose::at((*place).into(), 1)).collect();
        self.view().tick(&network, &poses, Budget::All)
    }

    /// A late tick.
    pub fn late(&mut self, place_m: [f32; 3]) -> TickOutput {
        let network = self.network;
        self.view().tick(&network, &[ToolPose::at(place_m.into(), 1)], Budget::LATE)
    }

    /// Answer to a tool.
    pub fn tool(&mut self, tool: usize) -> ToolOutput {
        let network = self.network;
        self.view().tool_output(&network, tool)
    }

    /// Energy that the tools gave the body in the last tick \[J\].
    pub fn given_j(&mut self) -> f32 {
        let network = self.network;
        self.view().given_j(&network)
    }

    pub fn open(&mut self, (tetrahedron, corner): (usize, usize)) -> Result<bool, CutError> {
        let network = self.network;
        self.view().open_face(&network, tetrahedron, corner)
    }

    pub fn cuts(&mut self) -> CutOutput {
        let network = self.network;
        self.view().cut_output(&network)
    }

    pub fn hash(&mut self) -> u64 {
        let model = self.model();
        self.view().state_hash(&model)
    }

    pub fn is_finite(&self) -> bool {
        self.state.iter().flat_map(|cell| cell.xyz()).all(f32::is_finite)
    }
}
