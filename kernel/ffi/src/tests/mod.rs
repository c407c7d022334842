//! The interface as C would call it, right and wrong.

mod bodies;
mod codes;
mod contacts;
mod cuts;
mod images;
mod pins;
mod pointers;
mod relaxed;
mod settings;
mod shapes;
mod sizes;
mod snapshot;
mod stage;
mod stress;
mod tool_storage;
mod tools;

use std::vec::Vec;

use chaincell_kernel::include_model;

use crate::{
    Code, Detail, Info, ModelStorage, Output, Room, Scheme, Settings, Tissue, ToolOutput, ToolPose,
};

/// `chaincell bake box:5x5x5x0.01 --coarse 2 --alpha 0.02 --lean`: fits every scheme.
static BOX: &[u8] = include_model!("../../../../tests/data/box5.chaincell");
/// `chaincell bake plane:9x9x0.01 --diagonals --lean`: no coarse functions.
static PLANE: &[u8] = include_model!("../../../../tests/data/plane9.chaincell");

/// `chaincell bake box:6x6x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 --contact-surface no`: nodal
/// shapes.
static SHAPES: &[u8] = include_model!("../../../../tests/data/tissue6.chaincell");

/// Bodies of both kinds, and three of their top's nodes.
static KINDS: [(&[u8], [u32; 3]); 2] = [(BOX, [64, 69, 89]), (SHAPES, [59, 63, 83])];

/// `chaincell bake box:5x5x5x0.01 --cells 30 --coarse none`: an embedded mesh.
static CELLS: &[u8] = include_model!("../../../../tests/data/box5_cells.chaincell");

/// Calls the interface with pointers that are good, null, or misaligned.
macro_rules! call {
    ($function:ident($($argument:expr),* $(,)?)) => {
        // SAFETY: what is neither null nor misaligned points to what the function asks for.
        unsafe { crate::$function($($argument),*) }
    };
}
use call;

/// A line of a processor's cache, as any tissue is aligned.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Block([u8; BLOCK]);

/// Bytes of a block.
const BLOCK: usize = 64;

/// Aligned storage of at least so many bytes, not zero before it is used.
fn storage(bytes: usize) -> Vec<Block> {
    std::vec![Block([0xA5; BLOCK]); bytes.div_ceil(BLOCK)]
}

/// Room for held cells alone.
fn holding(contacts: u32) -> Room {
    Room { contacts, ..Room::default() }
}

/// Bytes and alignment of a tissue; 0 where it has no size.
fn size_of_body(image: &[u8], scheme: i32, room: &Room) -> (Code, usize, usize) {
    let (mut bytes, mut align) = (0, 0);
    let model = model_of(image);
    let code = call!(chaincell_model_size(&model, scheme, room, &mut bytes, &mut align));
    (code, bytes, align)
}

/// Whether the body of an image is one of nodal shapes.
fn is_nodal(image: &[u8]) -> bool {
    chaincell_kernel::Model::from_bytes(image).unwrap().is_nodal()
}

/// The schemes that move a body.
fn schemes_of(image: &[u8]) -> impl Iterator<Item = Scheme> {
    let is_nodal = is_nodal(image);
    let moves_shapes = |scheme: &Scheme| matches!(scheme, Scheme::Track | Scheme::Predict);
    Scheme::ALL.into_iter().filter(move |scheme| !is_nodal || moves_shapes(scheme))
}

/// A validated model.
fn model_of(image: &[u8]) -> ModelStorage {
    let mut model = ModelStorage::EMPTY;
    let null = core::ptr::null_mut();
    let code = call!(chaincell_model_init(&mut model, image.as_ptr().cast(), image.len(), null));
    assert_eq!(code, Code::Ok);
    model
}

fn info_of(model: &ModelStorage) -> Info {
    let mut info = Info::default();
    assert_eq!(call!(chaincell_model_info(model, &mut info)), Code::Ok);
    info
}

fn settings_of(model: &ModelStorage, scheme: Scheme) -> Settings {
    let mut settings = Settings { drive: 1, ..Settings::default() };
    let code = call!(chaincell_settings_default(model, scheme as i32, &mut settings));
    assert_eq!(code, Code::Ok);
    settings
}

/// A tissue with its storage.
struct Made {
    storage: Vec<Block>,
    tissue: *mut Tissue,
}

/// What came of an initialisation that asked for these.
fn try_make(
    image: &[u8],
    scheme: i32,
    contacts: u32,
    change: impl FnOnce(&mut Settings),
) -> (Code, Detail, Made) {
    let mut settings = settings_of(&model_of(image), Scheme::Track);
    change(&mut settings);
    let room = holding(contacts);
    let (_, bytes, _) = size_of_body(image, scheme, &room);
    let mut storage = storage(bytes.max(BLOCK));
    let there = (storage.as_mut_ptr(), bytes);
    let (code, detail, tissue) = init(there, image, (scheme, &room), &settings);
    (code, detail, Made { storage, tissue })
}

/// Initialises a tissue in so many bytes from a place on; the pointer is no tissue's unless written.
fn init(
    (storage, bytes): (*mut Block, usize),
    image: &[u8],
    (scheme, room): (i32, &Room),
    settings: &Settings,
) -> (Code, Detail, *mut Tissue) {
    let (model, mut tissue) = (model_of(image), core::ptr::dangling_mut());
    let mut detail = Detail::default();
    let code = call!(chaincell_tissue_init(
        storage.cast(),
        bytes,
        &model,
        scheme,
        room,
        settings,
        &mut tissue,
        &mut detail,
    ));
    (code, detail, tissue)
}

/// A tissue at rest.
fn make(image: &[u8], scheme: Scheme, contacts: u32) -> Made {
    let defaults = settings_of(&model_of(image), scheme);
    let (code, _, made) = try_make(image, scheme as i32, contacts, |s| *s = defaults);
    assert_eq!(code, Code::Ok);
    assert_eq!(made.tissue.cast_const().cast(), made.storage.as_ptr());
    made
}

/// One press, drag and release after the other.
fn sample(tick: u16) -> ToolPose {
    let at = f32::from(tick % 60);
    pose_at([0.0002 * at, 0.0001 * at, -0.0006 * at], u16::from(tick % 60 < 45))
}

/// A tool that is not turned.
fn pose_at(position_m: [f32; 3], engaged: u16) -> ToolPose {
    let orientation = chaincell_kernel::NOT_TURNED;
    ToolPose { position_m, orientation, engaged, opening_turns_q16: 0 }
}

/// A pose of the caller's as one of the kernel's.
fn of_kernel(pose: &ToolPose) -> chaincell_kernel::ToolPose {
    let &ToolPose { position_m, orientation, engaged, opening_turns_q16 } = pose;
    let position_m = position_m.into();
    chaincell_kernel::ToolPose { position_m, orientation, engaged, opening_turns_q16 }
}

const NO_OUTPUT: Output = Output {
    tool: ToolOutput { force_n: [f32::NAN; 3], torque_n_m: [f32::NAN; 3], contacts: 99, flags: 99 },
    energy_j: f32::NAN,
    work_j: f32::NAN,
    stiffness_n_per_m: f32::NAN,
    sweeps: 99,
    relaxed_j: f32::NAN,
    force_error_n: f32::NAN,
    torque_error_n_m: f32::NAN,
};

fn tick(tissue: *mut Tissue, sample: ToolPose) -> Output {
    let mut output = NO_OUTPUT;
    assert_eq!(call!(chaincell_tick(tissue, &sample, 1, core::ptr::null(), &mut output)), Code::Ok);
    output
}

fn hash(tissue: *const Tissue) -> u64 {
    let mut hash = 0;
    assert_eq!(call!(chaincell_state_hash(tissue, &mut hash)), Code::Ok);
    hash
}

fn choose(tissue: *mut Tissue, ids: &[u32]) -> (Code, Detail) {
    let mut detail = Detail::default();
    let code = call!(chaincell_choose_contacts(tissue, ids.as_ptr(), ids.len(), &mut detail));
    (code, detail)
}
