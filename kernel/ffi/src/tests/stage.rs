//! The output stage through the interface: the kernel's own, and every refusal.

use core::ptr::null;

use chaincell_kernel::stage::{Device, Stage, StageSettings as KernelSettings};
use chaincell_kernel::{Choice, Flags, TickOutput};

use super::{NO_OUTPUT, call, of_kernel, pose_at};
use crate::{Code, Output, StageNews, StageSettings, StageStorage, ToolOutput, ToolPose};

pub(super) fn settings(device: Device) -> StageSettings {
    let mut settings = StageSettings { coupling_n_per_m: -1.0, ..StageSettings::default() };
    assert_eq!(call!(chaincell_stage_default(device as i32, &mut settings)), Code::Ok);
    settings
}

pub(super) fn make(settings: &StageSettings) -> (Code, StageStorage) {
    let mut stage = StageStorage { opaque: [7; crate::STAGE_WORDS] };
    let code = call!(chaincell_stage_init(&mut stage, settings));
    (code, stage)
}

/// A spring of 900 N/m about the origin.
fn answer(tool: [f32; 3]) -> Output {
    let [x, y, z] = tool.map(|x| -900.0 * x);
    Output {
        tool: ToolOutput { force_n: [x, y, z], torque_n_m: [0.5, 0.0, 0.0], contacts: 1, flags: 0 },
        energy_j: 0.1,
        work_j: 0.0,
        stiffness_n_per_m: 900.0,
        sweeps: 4,
        relaxed_j: 0.002,
        force_error_n: 0.01,
        torque_error_n_m: 0.001,
    }
}

/// A sample to the stage, and the spring's answer back.
pub(super) fn pass(stage: &mut StageStorage, mut sample: ToolPose) -> Output {
    let (this, there) = (&raw const sample, &raw mut sample);
    assert_eq!(call!(chaincell_stage_sample(stage, this, null(), there)), Code::Ok);
    let (tissue, mut output) = (answer(sample.position_m), NO_OUTPUT);
    assert_eq!(call!(chaincell_stage_output(stage, &tissue, &mut output)), Code::Ok);
    output
}

/// Samples, a bad one, silence: the same bits as from the kernel's own stage.
#[test]
fn a_stage_is_the_kernels() {
    for &device in Device::ALL {
        let (code, mut stage) = make(&settings(device));
        assert_eq!(code, Code::Ok);
        let mut own = Stage::new(KernelSettings::for_device(device)).unwrap();
        for tick in 0..400_u16 {
            let mut output = NO_OUTPUT;
            if (250..320).contains(&tick) {
                let code = call!(chaincell_stage_output(&mut stage, null(), &mut output));
                assert_eq!(code, Code::Ok);
                assert_eq!(output, Output::of(&own.missed()), "{device:?} {tick}");
                continue;
            }
            let x = 1.0e-5 * f32::from(tick) * if tick == 200 { f32::NAN } else { 1.0 };
            let mut sample = pose_at([x, 0.5 * x, 0.0], 1);
            let own_sample = of_kernel(&sample);
            let (this, there) = (&raw const sample, &raw mut sample);
            assert_eq!(call!(chaincell_stage_sample(&mut stage, this, null(), there)), Code::Ok);
            let tool = own.sample(&own_sample);
            assert_eq!(
                sample.position_m.map(f32::to_bits),
                tool.position_m.data.0[0].map(f32::to_bits)
            );
            assert_eq!(sample.engaged, tool.engaged);
            let tissue = answer(if tick == 200 { [0.0; 3] } else { sample.position_m });
            let code = call!(chaincell_stage_output(&mut stage, &tissue, &mut output));
            assert_eq!(code, Code::Ok);
            let wanted = own.output(&TickOutput {
                force_n: tissue.tool.force_n.into(),
                energy_j: tissue.energy_j,
                work_j: tissue.work_j,
                stiffness_n_per_m: tissue.stiffness_n_per_m,
                contacts: tissue.tool.contacts,
                sweeps: 4,
                flags: Flags(tissue.tool.flags),
            });
            let torque_n_m = output.tool.torque_n_m;
            assert!(torque_n_m[0] <= 0.5 * own.share(), "{device:?} {tick}: {torque_n_m:?}");
            output.tool.torque_n_m = [0.0; 3];
            let Output { relaxed_j, force_error_n, torque_error_n_m, .. } = tissue;
            let of = Output::of(&wanted);
            let wanted = Output { relaxed_j, force_error_n, torque_error_n_m, ..of };
            assert_eq!(output, wanted, "{device:?} {tick}");
        }
    }
}

// REQ-STG-07
#[test]
fn every_setting_out_of_range_is_named() {
    let refused = |change: fn(&mut StageSettings), wanted: Code| {
        let mut settings = settings(Device::Falcon);
        change(&mut settings);
        let (code, mut stage) = make(&settings);
        assert_eq!(code, wanted);
        let code = call!(chaincell_stage_output(&mut stage, null(), &mut NO_OUTPUT.clone()));
        assert_eq!(code, if wanted == Code::Ok { Code::Ok } else { Code::NotInitialised });
    };
    refused(|s| (s.coupling, s.passivity) = (0, 0), Code::Ok);
    refused(|s| s.tick_s = 0.0, Code::StageTick);
    refused(|s| s.coupling_n_per_m = -1.0, Code::StageCoupling);
    refused(|s| s.coupling_n_per_m = 0.0, Code::StageCoupling);
    refused(|s| s.coupling_n_s_per_m = f32::NAN, Code::StageCoupling);
    refused(|s| s.device_damping_n_s_per_m = 2.0e6, Code::StagePassivity);
    refused(|s| s.delay_ticks = 16, Code::Ok);
    refused(|s| (s.delay_ticks, s.coupling) = (2, 0), Code::StagePassivity);
    refused(|s| s.delay_ticks = 17, Code::StagePassivity);
    refused(|s| s.delay_ticks = 256, Code::StagePassivity);
    refused(|s| s.max_slew_n_per_s = 0.0, Code::StageSlew);
    refused(|s| s.max_force_n = f32::NAN, Code::StageMaxForce);
    refused(|s| s.max_speed_m_per_s = -5.0, Code::StageMaxSpeed);
    refused(|s| s.ramp_ticks = 65_537, Code::StageTicks);
    refused(|s| s.watchdog_ticks = 60_001, Code::StageTicks);
    for device in [-1, 5, i32::MAX] {
        let mut settings = settings(Device::Touch);
        assert_eq!(call!(chaincell_stage_default(device, &mut settings)), Code::StageDevice);
    }
}

/// No news but those changed.
const NO_NEWS: StageNews = StageNews { delay_ticks: -1, restarts_ramp: 0, max_force_n: 0.0 };

// REQ-STG-17
#[test]
fn news_are_the_stages() {
    let (_, mut stage) = make(&settings(Device::Falcon));
    let sample = |tick: u16| pose_at([1.0e-4 * f32::from(tick), 0.0, 0.0], 1);
    let mut tell = |tick: u16, news: StageNews| {
        let mut pose = sample(tick);
        let (this, there) = (&raw const pose, &raw mut pose);
        let code = call!(chaincell_stage_sample(&mut stage, this, &news, there));
        let (tissue, mut output) = (answer(pose.position_m), NO_OUTPUT);
        if code == Code::Ok {
            assert_eq!(call!(chaincell_stage_output(&mut stage, &tissue, &mut output)), Code::Ok);
        }
        (code, -output.tool.force_n[0], output.tool.torque_n_m[0])
    };
    for bad in [-1.0, f32::NAN] {
        let news = StageNews { max_force_n: bad, ..NO_NEWS };
        assert_eq!(tell(0, news).0, Code::StageMaxForce);
    }
    let limited = StageNews { max_force_n: 0.5, ..NO_NEWS };
    assert_eq!(tell(0, limited).0, Code::Ok);
    let sizes: std::vec::Vec<f32> = (1..200).map(|at| tell(at, NO_NEWS).1).collect();
    assert!(sizes.iter().all(|&size| size <= 0.5) && sizes[198] > 0.49, "{sizes:?}");
    assert_eq!(tell(200, NO_NEWS).2, 0.5);
    // The torque goes along the ramp of the force.
    let (_, force_n, torque_n_m) = tell(201, StageNews { restarts_ramp: 1, ..NO_NEWS });
    assert!(force_n <= 0.01 && torque_n_m < 0.1, "{force_n} {torque_n_m}");
    // A longer delay than the settings': a weaker coupling.
    let mut own = Stage::new(KernelSettings::for_device(Device::Falcon)).unwrap();
    let (_, mut stage) = make(&settings(Device::Falcon));
    for tick in 0..300 {
        let mut pose = sample(tick);
        own.delayed(9);
        let wanted = own.sample(&of_kernel(&pose));
        let (this, there) = (&raw const pose, &raw mut pose);
        let news = StageNews { delay_ticks: 9, ..NO_NEWS };
        assert_eq!(call!(chaincell_stage_sample(&mut stage, this, &news, there)), Code::Ok);
        assert_eq!(pose.position_m, <[f32; 3]>::from(wanted.position_m), "tick {tick}");
        let tissue = answer(pose.position_m);
        own.output(&crate::stage::answer_of(&tissue));
        let code = call!(chaincell_stage_output(&mut stage, &tissue, &mut NO_OUTPUT.clone()));
        assert_eq!(code, Code::Ok);
    }
    let (mut pose, news) = (sample(0), NO_NEWS);
    let odd = (&raw const news).wrapping_byte_add(1);
    let (there, none) = (&raw mut pose, core::ptr::null_mut::<StageStorage>());
    assert_eq!(call!(chaincell_stage_sample(&mut stage, there, odd, there)), Code::Misaligned);
    assert_eq!(call!(chaincell_stage_sample(none, there, &news, there)), Code::Null);
}

/// Null and misaligned, and storage without a stage: refused, and the force is 0.
// REQ-STG-07
#[test]
fn bad_pointers_give_no_force() {
    let (_, mut stage) = make(&settings(Device::Touch));
    let mut empty = StageStorage::EMPTY;
    let mut sample = pose_at([0.0; 3], 1);
    let tissue = answer([1.0; 3]);
    let nowhere = core::ptr::null_mut::<StageStorage>();
    let beyond = (&raw mut stage).wrapping_byte_add(1);
    let is_safe = |output: &Output| {
        output.tool.force_n == [0.0; 3] && output.tool.flags == Flags::SAFE_STATE.0
    };
    for (bad, code) in
        [(nowhere, Code::Null), (beyond, Code::Misaligned), (&raw mut empty, Code::NotInitialised)]
    {
        let mut output = NO_OUTPUT;
        assert_eq!(call!(chaincell_stage_output(bad, &tissue, &mut output)), code);
        assert!(is_safe(&output));
        output = NO_OUTPUT;
        assert_eq!(call!(chaincell_stage_output(bad, null(), &mut output)), code);
        assert!(is_safe(&output));
        let there = &raw mut sample;
        assert_eq!(call!(chaincell_stage_sample(bad, there, null(), there)), code);
        if code != Code::NotInitialised {
            assert_eq!(call!(chaincell_stage_init(bad, &settings(Device::Touch))), code);
        }
    }
    let (odd, nothing) =
        ((&raw const tissue).wrapping_byte_add(1), core::ptr::null_mut::<Output>());
    let mut output = NO_OUTPUT;
    assert_eq!(call!(chaincell_stage_output(&mut stage, odd, &mut output)), Code::Misaligned);
    assert!(is_safe(&output));
    assert_eq!(call!(chaincell_stage_output(&mut stage, &tissue, nothing)), Code::Null);
    assert_eq!(call!(chaincell_stage_output(&mut stage, null(), nothing)), Code::Null);
    let (of, to) = (null::<ToolPose>(), core::ptr::null_mut::<ToolPose>());
    assert_eq!(call!(chaincell_stage_sample(&mut stage, of, null(), &raw mut sample)), Code::Null);
    assert_eq!(
        call!(chaincell_stage_sample(&mut stage, &raw const sample, null(), to)),
        Code::Null
    );
    assert_eq!(call!(chaincell_stage_init(&mut stage, null())), Code::Null);
    assert_eq!(call!(chaincell_stage_default(0, core::ptr::null_mut())), Code::Null);
}
