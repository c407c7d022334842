//! The estimated error of a force belongs to the tissue's force: where a stage answers another one it is not known.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::ImageBytes;
use chaincell_host::engine::staged::Staged;
use chaincell_host::engine::tissue::TissueEngine;
use chaincell_host::engine::{Contact, Scheme, rest_m};
use chaincell_kernel::stage::{Device, StageSettings};
use chaincell_kernel::{Budget, ToolPart, ToolPose};
use chaincell_tests::bodies::{model, nodal, under};
use nalgebra::Vector3;

/// Radius of the tools, and the height of the body \[m\].
const RADIUS_M: f32 = 0.012;
const TOP_M: f32 = 0.04;
/// Ticks of a press, and of a ramp that it begins in.
const TICKS: u16 = 200;
const RAMP_TICKS: u16 = 60;

fn body() -> ImageBytes {
    nodal("box:9x5x6x0.008", 2.0e4)
}

fn staged(image: &ImageBytes, contact: Contact, settings: StageSettings) -> Staged<'_> {
    let engine = under(image, contact, (Scheme::Predict, 2), 0.01).unwrap();
    Staged::new(engine, Some(settings)).unwrap()
}

/// Depth in a tick: the tool begins to touch within the ramp, and moves to and fro at 2.8 mm \[m\].
fn depth_m(tick: u16) -> f32 {
    let tick = f32::from(tick);
    (tick * 6.0e-5 - 2.0e-4).min(2.8e-3) + 2.0e-4 * (0.1 * tick).sin()
}

/// Forces with contact by what is said of their error.
#[derive(Debug, Default)]
struct Count {
    known: u32,
    unknown: u32,
    torques_unknown: u32,
    largest_n: f32,
}

/// Two tools press; an error has to be known where the answered force is the tissue's, and nowhere else.
fn tools(image: &ImageBytes, settings: StageSettings) -> Count {
    let tools = vec![vec![ToolPart::sphere(RADIUS_M)]; 2];
    let mut staged = staged(image, Contact::Tools { tools, friction: 0.0 }, settings);
    let [x, y, _] = model(image).centre_m();
    let mut count = Count::default();
    for tick in 0..TICKS {
        let pose = |aside: f32| {
            let z = TOP_M + RADIUS_M - depth_m(tick);
            ToolPose::at(Vector3::new(x + aside, y, z), 1)
        };
        let _ = staged.tick_by(&[pose(-0.02), pose(0.02)], Budget::All);
        for tool in 0..2 {
            let felt = staged.felt(tool);
            let tissue_n = staged.engine_mut().tool_output(tool).force_n;
            let own = staged.engine_mut().force_error_n(tool);
            let is_own = Vector3::from(felt.force_n) == tissue_n;
            assert_eq!(felt.force_error_n, own.filter(|_| is_own), "{tick}: {felt:?}");
            assert_eq!(staged.force_error_n(tool), felt.force_error_n);
            let own_n_m = staged.engine_mut().torque_error_n_m(tool);
            assert!(felt.torque_error_n_m.is_none() || felt.torque_error_n_m == own_n_m);
            count.known += u32::from(felt.force_error_n.is_some());
            count.unknown += u32::from(own.is_some() && felt.force_error_n.is_none());
            count.torques_unknown +=
                u32::from(own_n_m.is_some() && felt.torque_error_n_m.is_none());
            count.largest_n = count.largest_n.max(tissue_n.norm());
        }
    }
    count
}

#[test]
fn the_error_of_a_tools_force_is_that_of_the_force_answered() {
    let image = body();
    let plain = tools(&image, StageSettings::NONE);
    assert!(plain.known > 200 && plain.unknown == 0, "{plain:?}");
    assert_eq!(plain.torques_unknown, 0);
    // On the ramp.
    let ramp = StageSettings { ramp_ticks: RAMP_TICKS, ..StageSettings::NONE };
    let ramped = tools(&image, ramp);
    assert!(ramped.known > 200 && ramped.unknown > 20, "{ramped:?}");
    assert!(ramped.torques_unknown > 20, "{ramped:?}");
    // Under the clamp, which shortens no torque.
    let max_force_n = 0.5 * plain.largest_n;
    let clamped = tools(&image, StageSettings { max_force_n, ..StageSettings::NONE });
    assert!(clamped.known > 10 && clamped.unknown > 100, "{clamped:?}");
    assert_eq!(clamped.torques_unknown, 0);
    // Behind the slew limit: a hundredth of the largest force in a tick.
    let max_slew_n_per_s = 10.0 * plain.largest_n;
    let slewed = tools(&image, StageSettings { max_slew_n_per_s, ..StageSettings::NONE });
    assert!(slewed.known > 50 && slewed.unknown > 20, "{slewed:?}");
    // Under the coupling of a device, whose spring makes the force.
    let coupled = tools(&image, StageSettings::for_device(Device::Omega));
    assert!(coupled.unknown > 200 && coupled.known < coupled.unknown / 10, "{coupled:?}");
}

#[test]
fn the_error_of_held_cells_is_that_of_the_force_answered() {
    let image = body();
    let body = model(&image);
    let height_m = |cell: usize| rest_m(&body, cell)[2];
    let highest = (0..body.cells()).max_by(|&a, &b| height_m(a).total_cmp(&height_m(b))).unwrap();
    let held = || Contact::Cells(vec![highest as u16]);
    let ramp = StageSettings { ramp_ticks: RAMP_TICKS, ..StageSettings::NONE };
    let mut plain = staged(&image, held(), StageSettings::NONE);
    let mut ramped = staged(&image, held(), ramp);
    let (mut known, mut unknown) = (0, 0);
    for tick in 0..TICKS {
        let pose = ToolPose::at(Vector3::new(0.0, 0.0, -1.0e-5 * f32::from(tick)), 1);
        let [own, answered] = [&mut plain, &mut ramped].map(|staged| staged.tick(&pose).force_n);
        let [error_n, shown_n] = [&mut plain, &mut ramped].map(|staged| staged.force_error_n(0));
        assert_eq!(shown_n, error_n.filter(|_| answered == own), "{tick}");
        known += u32::from(shown_n.is_some());
        unknown += u32::from(error_n.is_some() && shown_n.is_none());
    }
    assert!(known > 100 && unknown > 30, "{known} known, {unknown} not");
}
