//! Every pointer of every function: null and misaligned.

use chaincell_kernel::Flags;

use super::{
    BLOCK, BOX, KINDS, NO_OUTPUT, call, hash, info_of, make, model_of, sample, settings_of, storage,
};
use crate::{Budget, Code, Detail, Info, ModelStorage, Room, Scheme, Settings, Tissue, ToolPose};

/// Null and, inside aligned memory, one byte beyond.
pub fn bad<T>(good: *const T) -> [(*mut T, Code); 2] {
    let beyond = good.cast_mut().wrapping_byte_add(1);
    [(core::ptr::null_mut(), Code::Null), (beyond, Code::Misaligned)]
}

// REQ-CIF-01
#[test]
fn of_the_model() {
    let mut model = model_of(BOX);
    let (mut info, mut word) = (Info::default(), 7);
    let detail = &mut Detail::default();
    let image = BOX.as_ptr().cast();
    for (bad, code) in bad(&model) {
        assert_eq!(call!(chaincell_model_init(bad, image, BOX.len(), detail)), code);
        assert_eq!(call!(chaincell_model_info(bad, &mut info)), code);
        assert_eq!(call!(chaincell_model_input_id(bad, 0, &mut word)), code);
        let mut settings = settings_of(&model, Scheme::Track);
        assert_eq!(call!(chaincell_settings_default(bad, 0, &mut settings)), code);
    }
    for (bad, code) in bad(&info) {
        assert_eq!(call!(chaincell_model_info(&model, bad)), code);
    }
    for (bad, code) in bad(&word) {
        assert_eq!(call!(chaincell_model_input_id(&model, 0, bad)), code);
    }
    let settings = settings_of(&model, Scheme::Track);
    for (bad, code) in bad(&settings) {
        assert_eq!(call!(chaincell_settings_default(&model, 0, bad)), code);
    }
    let [_, (misaligned, code)] = bad(detail);
    assert_eq!(call!(chaincell_model_init(&mut model, image, BOX.len(), misaligned)), code);
    let null = core::ptr::null();
    assert_eq!(call!(chaincell_model_init(&mut model, null, BOX.len(), detail)), Code::Null);
    assert_eq!(call!(chaincell_model_info(&model, &mut info)), Code::NotInitialised);
}

// REQ-CIF-01
#[test]
fn of_the_initialisation() {
    let model = model_of(BOX);
    let settings = settings_of(&model, Scheme::Track);
    let mut storage = storage(1 << 16);
    let there = storage.as_mut_ptr().cast::<Tissue>();
    let room = Room { contacts: 1, ..Room::default() };
    let init = |storage: *mut Tissue, model, settings, detail| {
        let (bytes, mut tissue) = (1 << 16, core::ptr::dangling_mut());
        #[rustfmt::skip]
        let code = call!(chaincell_tissue_init(
            storage.cast(), bytes, model, 0, &room, settings, &mut tissue, detail
        ));
        (code, tissue)
    };
    let none = core::ptr::null_mut();
    assert_eq!(init(there, &model, &settings, none), (Code::Ok, there));
    for (bad, code) in bad(there) {
        assert_eq!(init(bad, &model, &settings, none), (code, none.cast()));
    }
    let eight = there.wrapping_byte_add(8);
    assert_eq!(init(eight, &model, &settings, none), (Code::Misaligned, none.cast()));
    for (bad, code) in bad(&model) {
        assert_eq!(init(there, bad, &settings, none), (code, none.cast()));
    }
    for (bad, code) in bad(&settings) {
        assert_eq!(init(there, &model, bad, none), (code, none.cast()));
    }
    let [_, (misaligned, code)] = bad(&Detail::default());
    assert_eq!(init(there, &model, &settings, misaligned).0, code);
    let mut tissue = there;
    for (bad, code) in bad(&raw mut tissue) {
        #[rustfmt::skip]
        let got = call!(chaincell_tissue_init(
            there.cast(), 1 << 16, &model, 0, &room, &settings, bad, none
        ));
        assert_eq!(got, code);
    }
}

/// What every function says of a tissue of 125 cells that is none.
fn all(tissue: *mut Tissue) -> [Code; 9] {
    all_of(BOX, 64, tissue)
}

/// The same of a tissue of an image with a node that may be chosen.
fn all_of(image: &'static [u8], id: u32, tissue: *mut Tissue) -> [Code; 9] {
    let model = model_of(image);
    let (settings, cells) = (settings_of(&model, Scheme::Track), info_of(&model).cells as usize);
    let (ids, mut position, mut word) = ([id], [0.0; 3], 0);
    let mut numbers = std::vec![0.0; 3 * cells];
    let none = core::ptr::null_mut();
    [
        call!(chaincell_tissue_reset(tissue, none)),
        call!(chaincell_change_settings(tissue, &settings, none)),
        call!(chaincell_choose_contacts(tissue, ids.as_ptr(), 1, none)),
        call!(chaincell_tick(tissue, &sample(0), 1, core::ptr::null(), &mut NO_OUTPUT.clone())),
        call!(chaincell_state_hash(tissue, &mut word)),
        call!(chaincell_position(tissue, id, &mut position)),
        call!(chaincell_positions(tissue, numbers.as_mut_ptr(), cells)),
        call!(chaincell_set_positions(tissue, numbers.as_ptr(), cells, none)),
        call!(chaincell_cut(tissue, core::ptr::null(), 0, core::ptr::null_mut(), none)),
    ]
}

// REQ-CIF-01
#[test]
fn of_the_tissue() {
    for (image, [id, ..]) in KINDS {
        let made = make(image, Scheme::Track, 40);
        let all = |tissue| all_of(image, id, tissue);
        for (bad, code) in bad(made.tissue) {
            assert_eq!(all(bad), [code; 9]);
        }
        assert_eq!(all(made.tissue.wrapping_byte_add(8)), [Code::Misaligned; 9]);
        // Within the storage, at its alignment: no tissue begins there.
        assert_eq!(all(made.tissue.wrapping_byte_add(64)), [Code::NotInitialised; 9]);
        // A body without memory for cuts.
        let [rest @ .., cut] = all(made.tissue);
        assert_eq!((rest, cut), ([Code::Ok; 8], Code::CutRoom));
    }
}

/// The calls in a wrong order: storage that no call has filled, and one object for the other.
// REQ-CIF-02
#[test]
fn what_was_not_initialised_is_refused() {
    let mut zeros = [super::Block([0; BLOCK]); 100];
    assert_eq!(all(zeros.as_mut_ptr().cast()), [Code::NotInitialised; 9]);
    assert_eq!(all(storage(6400).as_mut_ptr().cast()), [Code::NotInitialised; 9]);
    let mut info = Info::default();
    let empty = ModelStorage::EMPTY;
    assert_eq!(call!(chaincell_model_info(&empty, &mut info)), Code::NotInitialised);
    let made = make(BOX, Scheme::Track, 1);
    let not_a_model = made.tissue.cast();
    assert_eq!(call!(chaincell_model_info(not_a_model, &mut info)), Code::NotInitialised);
    #[repr(align(16))]
    struct Aligned(ModelStorage);
    let mut model = Aligned(model_of(BOX));
    let not_a_tissue = (&raw mut model.0).cast();
    assert_eq!(call!(chaincell_state_hash(not_a_tissue, &mut 0)), Code::NotInitialised);
}

// REQ-CIF-01
#[test]
fn of_the_answers() {
    let made = make(BOX, Scheme::Track, 1);
    let (word, position, numbers) = (0_u64, [0.0_f32; 3], [0.0_f32; 375]);
    let (ids, none) = ([64_u32; 2], core::ptr::null_mut());
    let settings = settings_of(&model_of(BOX), Scheme::Track);
    let before = hash(made.tissue);
    for (bad, code) in bad(&word) {
        assert_eq!(call!(chaincell_state_hash(made.tissue, bad)), code);
    }
    for (bad, code) in bad(&position) {
        assert_eq!(call!(chaincell_position(made.tissue, 64, bad)), code);
    }
    for (bad, code) in bad(numbers.as_ptr()) {
        assert_eq!(call!(chaincell_positions(made.tissue, bad, 125)), code);
        assert_eq!(call!(chaincell_set_positions(made.tissue, bad, 125, none)), code);
    }
    for (bad, code) in bad(&settings) {
        assert_eq!(call!(chaincell_change_settings(made.tissue, bad, none)), code);
    }
    for (bad, code) in bad(ids.as_ptr()) {
        assert_eq!(call!(chaincell_choose_contacts(made.tissue, bad, 1, none)), code);
        assert_eq!(call!(chaincell_choose_contacts(made.tissue, bad, 0, none)), Code::Ok);
    }
    let huge = call!(chaincell_choose_contacts(made.tissue, ids.as_ptr(), usize::MAX, none));
    assert_eq!(huge, Code::Range);
    let [_, (misaligned, code)] = bad(&Detail::default());
    assert_eq!(call!(chaincell_tissue_reset(made.tissue, misaligned)), code);
    assert_eq!(call!(chaincell_change_settings(made.tissue, &settings, misaligned)), code);
    assert_eq!(call!(chaincell_choose_contacts(made.tissue, ids.as_ptr(), 1, misaligned)), code);
    let set = call!(chaincell_set_positions(made.tissue, numbers.as_ptr(), 125, misaligned));
    assert_eq!(set, code);
    assert_eq!(hash(made.tissue), before);
}

/// A tick that cannot be leaves a force of zero behind, not an old one.
// REQ-FOR-05, REQ-CIF-03
#[test]
fn of_the_tick() {
    for (image, [id, ..]) in KINDS {
        let made = make(image, Scheme::Track, 1);
        let good = sample(0);
        let safe = crate::tick::SAFE;
        assert_eq!((safe.tool.force_n, safe.tool.flags), ([0.0; 3], Flags::SAFE_STATE.0));
        let tick = |tissue, sample: *const ToolPose| {
            let mut output = NO_OUTPUT;
            (call!(chaincell_tick(tissue, sample, 1, core::ptr::null(), &mut output)), output)
        };
        for (bad, code) in bad(made.tissue) {
            assert_eq!(tick(bad, &good), (code, safe));
        }
        for (bad, code) in bad(&good) {
            assert_eq!(tick(made.tissue, bad), (code, safe));
        }
        let output = NO_OUTPUT;
        for (bad, code) in bad(&output) {
            assert_eq!(call!(chaincell_tick(made.tissue, &good, 1, core::ptr::null(), bad)), code);
        }
        let budget = Budget {
            sweeps: 1,
            more: None,
            context: core::ptr::null_mut(),
            force_error_share: 0.0,
        };
        let beyond = (&raw const budget).wrapping_byte_add(1);
        let mut output = NO_OUTPUT;
        let code = call!(chaincell_tick(made.tissue, &good, 1, beyond, &mut output));
        assert_eq!((code, output), (Code::Misaligned, safe));
        // None of them was a tick: the first one takes hold at its own position.
        super::choose(made.tissue, &[id]);
        let (code, output) = tick(made.tissue, &sample(20));
        assert_eq!((code, output.tool.force_n, output.tool.contacts), (Code::Ok, [0.0; 3], 1));
    }
}

#[test]
fn null_asks_for_no_detail() {
    let (made, none) = (make(BOX, Scheme::Track, 1), core::ptr::null_mut());
    let settings = Settings { sweeps: 0, ..settings_of(&model_of(BOX), Scheme::Track) };
    let code = call!(chaincell_change_settings(made.tissue, &settings, none));
    assert_eq!(code, Code::SettingsSweeps);
}
