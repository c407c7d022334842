//! Calls in the wrong order and with the wrong pointers. Tests with a server are in `tests/tests/session/client`.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use super::*;

fn text(pointer: *const c_char) -> String {
    // SAFETY: texts of the library end with a 0.
    unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned()
}

fn misaligned<T>(value: &mut T) -> *mut T {
    std::ptr::from_mut(value).wrapping_byte_add(1)
}

const POSE: chaincell_client::ToolPose = chaincell_client::ToolPose::AWAY;

#[test]
fn every_number_has_a_text() {
    for &(code, ..) in Code::ALL {
        assert!(!text(chaincell_client_error_text(code as i32)).is_empty());
    }
    for code in [i32::MIN, -1000, 1000, i32::MAX] {
        assert_eq!(text(chaincell_client_error_text(code)), "unknown code");
    }
}

/// The header's initialiser is the client's default.
#[test]
fn the_default_options_are_the_clients() {
    let Options { role, wait, server_wait_ns, watchdog_ms, ramp_ms } =
        chaincell_client::Options::default().into();
    assert_eq!((role, wait), (Role::Controller as i32, WaitMode::Hybrid as i32));
    let said = format!(
        "{{CHAINCELL_CLIENT_ROLE_CONTROLLER, CHAINCELL_CLIENT_WAIT_HYBRID, UINT64_C({server_wait_ns}), \
         {watchdog_ms}, {ramp_ms}}}"
    );
    assert!(include_str!("../include/chaincell_client.h").contains(&said), "{said}");
}

#[test]
fn pointers_are_checked_before_anything_else() {
    let mut options = Options::from(chaincell_client::Options::default());
    let mut handle: Handle = 7;
    let mut shown = [Shown::default(); 2];
    // SAFETY: pointers are null, misaligned or good.
    unsafe {
        let options = misaligned(&mut options);
        let name = c"nobody".as_ptr();
        assert_eq!(chaincell_client_open(VERSION, name, null(), null_mut()), Code::Null);
        assert_eq!(chaincell_client_open(VERSION, name, options, &mut handle), Code::Misaligned);
        assert_eq!(handle, 0, "what was refused is no handle");
        let odd = misaligned(&mut shown[0]);
        assert_eq!(chaincell_client_step(1, &POSE, 1, 0, null_mut()), Code::Null);
        assert_eq!(chaincell_client_step(1, &POSE, 1, 0, odd), Code::Misaligned);
        assert_eq!(chaincell_client_try_receive(1, null_mut()), Code::Null);
        assert_eq!(chaincell_client_state(1, null_mut()), Code::Null);
        assert_eq!(chaincell_client_contacts(1, null_mut()), Code::Null);
        let pin =
            |point_m: *const f32| chaincell_client_pin_at(1, point_m, 0.006, 50.0, 0, null_mut());
        assert_eq!(pin(null()), Code::Null);
        let mut point_m = [0.0_f32; 3];
        assert_eq!(pin(misaligned(&mut point_m[0])), Code::Misaligned);
    }
}

#[test]
fn poses_that_cannot_be_are_not_read() {
    // SAFETY: nothing is read where the count or the pointer is bad.
    unsafe {
        for count in [0, 9, usize::MAX, usize::MAX / 32 + 1] {
            assert_eq!(step::read_poses(null(), count).unwrap_err(), Code::Pose, "{count}");
        }
        assert_eq!(step::read_poses(null(), 1).unwrap_err(), Code::Null);
    }
}

#[test]
fn a_handle_that_is_none_is_refused_everywhere_and_nothing_is_felt() {
    let mut shown = Shown { tick: 7, ..Shown::default() };
    shown.tools[0].force_n = [1.0; 3];
    let (mut state, mut contacts, mut tick) = (State::NONE, Contacts::NONE, 9);
    let point_m = [0.0_f32; 3];
    for handle in [0, 1, 64, 65, u64::MAX] {
        // SAFETY: pointers are good.
        unsafe {
            assert_eq!(chaincell_client_step(handle, &POSE, 1, 0, &mut shown), Code::Closed);
            assert_eq!(shown, Shown::default());
            assert_eq!(chaincell_client_send(handle, &POSE, 1, &mut tick), Code::Closed);
            assert_eq!(tick, 0);
            assert_eq!(chaincell_client_try_receive(handle, &mut shown), Code::Closed);
            assert_eq!(chaincell_client_state(handle, &mut state), Code::Closed);
            assert_eq!(chaincell_client_contacts(handle, &mut contacts), Code::Closed);
            assert_eq!(chaincell_client_command(handle, 1, 0, 0.0, 0, null_mut()), Code::Closed);
            let pin = chaincell_client_pin_at(handle, point_m.as_ptr(), 1.0, 1.0, 0, null_mut());
            assert_eq!(pin, Code::Closed);
        }
        assert_eq!(chaincell_client_release(handle), Code::Closed);
        assert_eq!(chaincell_client_close(handle), Code::Closed);
    }
}

#[test]
fn why_a_call_was_refused_is_that_of_the_last_one() {
    let said = |code: Code| text(chaincell_client_error_text(code as i32));
    // SAFETY: pointers are null or good.
    let pose = || unsafe {
        assert_eq!(chaincell_client_send(1, &POSE, 1, misaligned(&mut 0_u64)), Code::Misaligned);
        step::read_poses(null(), 9)
    };
    assert!(pose().is_err());
    assert!(said(Code::Pose).starts_with("a pose that is no pose"), "it is not the call's yet");
    assert_eq!(handles::guarded(|| pose().map(|_| Code::Ok)), Code::Pose);
    assert_eq!(said(Code::Pose), "poses of 9 tools: give those of 1 to 8");
    assert!(said(Code::Held).starts_with("what was taken last"), "another code is another text");
    assert_eq!(chaincell_client_release(0), Code::Closed);
    assert!(said(Code::Pose).starts_with("a pose that is no pose"));
    assert!(said(Code::Closed).starts_with("no client has this handle"));
}

#[test]
fn what_cannot_be_opened_says_why() {
    let mut handle: Handle = 7;
    let default = Options::from(chaincell_client::Options::default());
    let mut refused = |version: u32, scene: &CStr, options: Options| {
        // SAFETY: pointers are good, the text ends with a 0.
        let code = unsafe { chaincell_client_open(version, scene.as_ptr(), &options, &mut handle) };
        assert_eq!(handle, 0);
        (code, text(chaincell_client_error_text(code as i32)))
    };
    let (code, why) = refused(VERSION + 1, c"nobody", default);
    assert!(code == Code::Version && why.contains("of one release"), "{why}");
    for name in [c"a b".to_owned(), c"".to_owned(), c"tools".to_owned(), c"\xff".to_owned()] {
        let (code, why) = refused(VERSION, &name, default);
        assert!(code == Code::Argument && why.contains("give 1 to 64"), "{why}");
    }
    let long = std::ffi::CString::new("x".repeat(100_000)).unwrap();
    assert!(refused(VERSION, &long, default).1.contains("longer than 64"));
    for options in [
        Options { role: 2, ..default },
        Options { role: -1, ..default },
        Options { wait: 3, ..default },
        Options { watchdog_ms: 60_001, ..default },
        Options { ramp_ms: u32::MAX, ..default },
    ] {
        let (code, why) = refused(VERSION, c"nobody", options);
        assert!(code == Code::Argument && why.contains('`'), "{why}");
    }
}
