//! Pins: set, read, released, saved, and refused.

use super::tool_storage::{ROOM, placed};
use super::{call, hash, pose_at};
use crate::{Code, Detail, PIN_BYTES, PinOutput, Room, Scheme, ToolPart};

const PINS: Room = Room { pins: 300, ..ROOM };

const NOTHING: PinOutput = PinOutput {
    force_n: [0.0; 3],
    position_m: [0.0; 3],
    given_m: [0.0; 3],
    stiffness_n_per_m: 0.0,
    energy_j: 0.0,
    samples: 0,
};

#[test]
fn a_pin_bears_a_press_until_it_is_released() {
    let size = |room: &Room| super::size_of_body(super::tool_storage::SURFACE, 0, room).1;
    assert!((size(&PINS) - size(&ROOM)).abs_diff(300 * PIN_BYTES) < 32);
    let none = core::ptr::null_mut();
    for scheme in [Scheme::Track, Scheme::Predict] {
        let made = placed(scheme, &PINS);
        let (mut pin, mut detail) = (7, Detail::default());
        let top = [0.0_f32, 0.0, 0.030];
        let set = |radius_m: f32, stiffness: f32, pin: &mut u32, detail: &mut Detail| {
            call!(chaincell_pin_at(made.tissue, top.as_ptr(), radius_m, stiffness, pin, detail))
        };
        assert_eq!(set(0.006, f32::INFINITY, &mut pin, &mut detail), Code::PinTools);
        let ball = ToolPart {
            centre_m: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            half_m: [0.0; 3],
            radius_m: 0.004,
        };
        assert_eq!(call!(chaincell_choose_tools(made.tissue, &ball, &1, 1, 0.0, none)), Code::Ok);
        // What cannot be is refused, and nothing has changed.
        assert_eq!(set(0.0, f32::INFINITY, &mut pin, &mut detail), Code::PinValue);
        assert_eq!(set(1e-6, f32::INFINITY, &mut pin, &mut detail), Code::PinReach);
        assert!(detail.limit > 1e-6 && detail.limit < 0.01, "{detail:?}");
        assert_eq!(set(0.1, f32::INFINITY, &mut pin, &mut detail), Code::PinRoom);
        assert!(detail.needed > detail.available && detail.available == 300, "{detail:?}");
        let held = call!(chaincell_pin_held(made.tissue, 0, 1.0, &mut pin, &mut detail));
        assert_eq!((held, detail.position, pin), (Code::PinNothingHeld, 0, 7));
        assert_eq!(call!(chaincell_unpin(made.tissue, 0, 1)), Code::PinUnknown);
        let before = hash(made.tissue);
        assert_eq!((set(0.006, f32::INFINITY, &mut pin, &mut detail), pin), (Code::Ok, 0));
        assert_ne!(hash(made.tissue), before);
        for step in 0..=40_u16 {
            super::tick(made.tissue, pose_at([0.0, 0.0, 0.035 - 1e-4 * f32::from(step)], 1));
        }
        let mut output = NOTHING;
        assert_eq!(call!(chaincell_pin_force(made.tissue, pin, &mut output)), Code::Ok);
        assert!(output.force_n[2] < -0.01 && output.samples > 3, "{output:?}");
        assert!(output.stiffness_n_per_m > 100.0 && output.energy_j > 0.0, "{output:?}");
        let mut other = 0;
        let held = call!(chaincell_pin_held(made.tissue, 0, 5.0, &mut other, none));
        assert_eq!((held, other), (Code::Ok, 1));
        assert_eq!(call!(chaincell_unpin(made.tissue, pin, 65_536)), Code::Range);
        assert_eq!(call!(chaincell_unpin(made.tissue, pin, 3)), Code::Ok);
        for _ in 0..4 {
            super::tick(made.tissue, pose_at([0.0, 0.0, 0.031], 1));
        }
        assert_eq!(call!(chaincell_pin_force(made.tissue, pin, &mut output)), Code::PinUnknown);
        assert_eq!(call!(chaincell_pin_force(made.tissue, other, &mut output)), Code::Ok);
        assert_eq!(call!(chaincell_tissue_reset(made.tissue, none)), Code::Ok);
        assert_eq!(call!(chaincell_pin_force(made.tissue, other, &mut output)), Code::PinUnknown);
    }
    let without = placed(Scheme::Track, &ROOM);
    let mut output = NOTHING;
    assert_eq!(call!(chaincell_pin_force(without.tissue, 0, &mut output)), Code::PinRoom);
}
