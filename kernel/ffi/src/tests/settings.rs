//! Settings: the kernel's defaults, and each one out of range.

use chaincell_kernel::{Arithmetic, Choice, Drive, Dynamics, Flags, Model, Rkl2, Unloading};

use super::{
    BOX, KINDS, SHAPES, call, choose, hash, make, model_of, sample, settings_of, tick, try_make,
};
use crate::{Code, Detail, Scheme, Settings};

/// The schemes of the header stand written out: each is one of the kernel's table.
#[test]
fn every_code_is_the_kernels() {
    for scheme in Scheme::ALL {
        let (of, number) = scheme.kernel();
        // A scheme in fixed point has a code of its own.
        let is_same = i32::from(of.code()) == scheme as i32;
        assert_eq!(is_same, number == Arithmetic::F32, "{scheme:?}");
    }
    let plain = Scheme::ALL.map(Scheme::kernel);
    for &scheme in chaincell_kernel::Scheme::ALL {
        assert!(plain.contains(&(scheme, Arithmetic::F32)), "{scheme:?}");
    }
}

#[test]
fn the_defaults_are_the_kernels() {
    let (storage, model) = (model_of(BOX), Model::from_bytes(BOX).unwrap());
    let kernel = chaincell_kernel::Settings::for_model(&model);
    for scheme in Scheme::ALL {
        let tick_time = match scheme {
            Scheme::Rkl2 => Rkl2::tick_time(&model, 4),
            _ => kernel.tick_time,
        };
        let wanted = chaincell_kernel::Settings { tick_time, ..kernel };
        assert_eq!(settings_of(&storage, scheme), wanted.plain());
    }
}

/// Checked at the initialisation, and when settings change.
#[track_caller]
fn refused(change: fn(&mut Settings), wanted: Code) {
    for (image, step_max) in
        [(BOX, 1.0 / 9.0), (SHAPES, Model::from_bytes(SHAPES).unwrap().step_max())]
    {
        let model = model_of(image);
        let mut settings = settings_of(&model, Scheme::Track);
        change(&mut settings);
        let limit = match wanted {
            Code::SettingsStep => step_max,
            Code::SettingsTickTime => 1.0e-12 * step_max,
            _ => 0.0,
        };
        let (code, detail, made) = try_make(image, 0, 1, change);
        assert_eq!((code, made.tissue.is_null()), (wanted, true));
        assert_eq!(detail, Detail { limit, ..Detail::default() });
        let made = make(image, Scheme::Track, 1);
        let mut detail = Detail::default();
        assert_eq!(call!(chaincell_change_settings(made.tissue, &settings, &mut detail)), wanted);
        assert_eq!(detail.limit, limit);
    }
}

// REQ-SET-01
#[test]
fn every_setting_out_of_range_is_named() {
    refused(|s| s.sweeps = 0, Code::SettingsSweeps);
    refused(|s| s.sweeps = 65_537, Code::SettingsSweeps);
    refused(|s| s.unloading = 3, Code::SettingsUnloading);
    refused(|s| s.unloading = -1, Code::SettingsUnloading);
    refused(|s| s.drive = 2, Code::SettingsDrive);
    refused(|s| s.drive = -1, Code::SettingsDrive);
    refused(|s| s.cut = 2, Code::SettingsCut);
    refused(|s| s.step *= 2.0, Code::SettingsStep);
    refused(|s| s.step = f32::NAN, Code::SettingsStep);
    refused(|s| s.tick_time = 0.0, Code::SettingsTickTime);
    refused(|s| s.tick_time = 1.0e-45, Code::SettingsTickTime);
    refused(|s| s.max_tool_step_m = f32::INFINITY, Code::SettingsMaxToolStep);
    refused(|s| s.max_force_n = -1.0, Code::SettingsMaxForce);
}

/// Changed settings count from the next tick on, refused ones never.
// REQ-SET-02
#[test]
fn settings_change_under_way() {
    let run = |(image, [id, ..]): (&'static [u8], [u32; 3]), sweeps: Option<u32>| {
        let made = make(image, Scheme::Track, 1);
        assert_eq!(choose(made.tissue, &[id]).0, Code::Ok);
        let mut settings = settings_of(&model_of(image), Scheme::Track);
        [0, 1, 2, 3].map(|at| {
            if let (2, Some(sweeps)) = (at, sweeps) {
                settings.sweeps = sweeps;
                let null = core::ptr::null_mut();
                call!(chaincell_change_settings(made.tissue, &settings, null));
            }
            tick(made.tissue, sample(10 * at));
            hash(made.tissue)
        })
    };
    for body in KINDS {
        let [plain, refused, changed] = [None, Some(0), Some(9)].map(|sweeps| run(body, sweeps));
        assert_eq!(plain, refused);
        assert_eq!(plain[..2], changed[..2]);
        assert!(plain[2] != changed[2] && plain[3] != changed[3]);
    }
}

/// All three ways of unloading reach the kernel.
#[test]
fn unloading_is_what_was_asked_for() {
    let flags = [Unloading::Off, Unloading::Release, Unloading::Retreat].map(|mode| {
        let (code, _, made) = try_make(BOX, 0, 1, |s| s.unloading = mode as i32);
        assert_eq!((code, choose(made.tissue, &[64]).0), (Code::Ok, Code::Ok));
        // Down, back, and let go.
        let ticks = [0, 10, 20, 30, 40, 2, 59];
        ticks.map(|at| tick(made.tissue, sample(at)).tool.flags & Flags::BAND_CLOSED.0 != 0)
    });
    assert_eq!(flags[0], [false; 7]);
    assert_eq!(flags[1], [false, false, false, false, false, false, true]);
    assert_eq!(flags[2], [false, false, false, false, false, true, true]);
}

/// Both drives reach the kernel: a held cell feels a force at once, a loaded one moves first.
#[test]
fn the_drive_is_what_was_asked_for() {
    let forces = [Drive::Position, Drive::Current].map(|drive| {
        let (code, _, made) = try_make(BOX, 0, 1, |s| {
            s.drive = drive as i32;
            s.sweeps = 200;
        });
        assert_eq!((code, choose(made.tissue, &[64]).0), (Code::Ok, Code::Ok));
        (0..40).fold([0.0; 3], |_, at| tick(made.tissue, sample(at)).tool.force_n)
    });
    // At equilibrium the links balance the load, 2 k times the displacement.
    let stiffness = Model::from_bytes(BOX).unwrap().stiffness_n_per_m();
    for (force, at) in forces[1].iter().zip(sample(39).position_m) {
        assert!((force + 2.0 * stiffness * at).abs() < 0.02 * stiffness * 0.01, "{forces:?}");
    }
    assert!(forces[0] != forces[1]);
}
