//! Limits, resets and rates of the stage between tissue and device.

use chaincell_kernel::stage::Device;
use nalgebra::Vector3;

use super::*;
use crate::bake::tissue::{Branch, Relaxation, Tissue};
use crate::bake::{BakeOptions, PerCell, bake};
use crate::engine::fixture::{engine, plane};
use crate::mesh::{MeshOptions, load};

/// A press of 40 mm, 1 mm per tick.
fn press(staged: &mut Staged<'_>) -> Vec<TickOutput> {
    let tick = |tick: u8| {
        let position_m = Vector3::new(0.0, 0.0, -1.0e-3 * f32::from(tick));
        staged.tick(&ToolPose::at(position_m, 1))
    };
    (0..=40).map(tick).collect()
}

#[test]
fn branches_baked_for_other_ticks_are_refused_with_both_rates() {
    let mesh = load("box:4x4x3x0.01", &MeshOptions::default()).unwrap();
    let of = PerCell::Uniform;
    let image = |device_hz| {
        let branches = vec![Branch { ratio: 1.0, time_s: 0.5 }];
        let relaxation = Some(Relaxation { branches, is_instant: false, device_hz });
        let tissue = Tissue { relaxation, ..Tissue::new(of(1000.0), of(0.45)) };
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options).unwrap()
    };
    for baked_hz in [300, 1000, 3000] {
        let image = image(baked_hz);
        for hz in [None, Some(300), Some(1000), Some(3000)] {
            let stage = hz.map(|hz: u16| StageSettings {
                tick_s: 1.0 / f32::from(hz),
                ..StageSettings::NONE
            });
            let begun = Staged::new(engine(&image), stage);
            let hz = hz.unwrap_or(1000);
            if u32::from(hz) == baked_hz {
                assert!(begun.is_ok(), "{hz}");
                continue;
            }
            let why = begun.err().unwrap().to_string();
            let remedy = format!("`device_hz` {baked_hz}, or bake it with `device_hz` {hz}");
            assert!(why.contains(&remedy), "{why}");
        }
    }
}

#[test]
fn a_reset_is_one_of_the_stage_too() {
    let image = plane();
    let settings = StageSettings { ramp_ticks: 50, ..StageSettings::for_device(Device::Omega) };
    let begin = || Staged::new(engine(&image), Some(settings)).unwrap();
    let mut staged = begin();
    let first = press(&mut staged);
    assert!(first[40].force_n.norm() > 0.0 && first != press(&mut staged));
    staged.command(&Command::Reset).unwrap();
    assert_eq!(press(&mut staged), first);
    assert_eq!(press(&mut begin()), first);
}

#[test]
fn what_the_device_gets_is_the_stages() {
    let image = plane();
    let mut plain = Staged::new(engine(&image), None).unwrap();
    let own = press(&mut plain);
    let largest_n = own[40].force_n.norm();
    let settings = StageSettings { max_force_n: 0.5 * largest_n, ..StageSettings::NONE };
    let mut staged = Staged::new(engine(&image), Some(settings)).unwrap();
    let shown = press(&mut staged);
    assert!(largest_n > 0.0 && shown.iter().all(|of| of.force_n.norm() <= 0.5 * largest_n));
    let tissue = |of: &TickOutput| (of.energy_j, of.work_j, of.contacts);
    assert!(shown.iter().map(tissue).eq(own.iter().map(tissue)));
    assert_eq!(staged.state_hash(), plain.state_hash());
}
