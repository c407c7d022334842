//! A tissue whose force falls with depth, and that takes up cells which the hand did not pay for: the
//! hand feels it, and gets back no more than it has put in.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::stage::{Device, Stage, StageSettings};
use chaincell_kernel::{Flags, Model, Network, Settings, ToolPose};
use nalgebra::Vector3;

/// Deepest place of the probe's centre, and where it begins [m].
const DEEP_M: f32 = 0.0325;
const HIGH_M: f32 = 0.0525;
/// Ticks for which the tool stands engaged before it goes: the stage's ramp.
const STANDS: u32 = 300;

/// A path straight down and up again, at so much a tick, behind every device.
// REQ-STG-12
#[test]
fn a_press_that_softens_is_felt_and_gives_nothing_back_for_nothing() {
    let mesh = load("box:13x11x6x0.008", &MeshOptions::default()).unwrap();
    let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
    for device in [Device::Touch, Device::Premium, Device::Falcon, Device::Omega, Device::Sigma] {
        for step_m in [5.0e-6_f32, 2.0e-5, 1.0e-4] {
            let model = Model::from_bytes(image.as_bytes()).unwrap();
            let network = Network::new(model, Settings::for_model(&model)).unwrap();
            let contact = Contact::sphere(0.012, 0.0);
            let mut engine =
                Engine::with_contact(network, Scheme::Track, Arithmetic::F32, contact).unwrap();
            let mut stage = Stage::new(StageSettings::for_device(device)).unwrap();
            let ticks = ((HIGH_M - DEEP_M) / step_m) as u32;
            let (mut shown_n, mut tissue_n, mut softens, mut last_n) = (0.0, 0.0, false, 0.0_f32);
            let (mut got_j, mut paid_j, mut given) = (0.0_f64, 0.0_f64, 0.0_f64);
            for at in 0..2 * ticks + STANDS {
                let tick = at.saturating_sub(STANDS);
                let down = tick.min(2 * ticks - tick);
                let position_m = Vector3::new(0.0, 0.0, HIGH_M - step_m * down as f32);
                let tool = stage.sample(&ToolPose::at(position_m, 1));
                let answer = engine.tick(&tool);
                let output = stage.output(&answer);
                let way = f64::from(if at < STANDS {
                    0.0
                } else if tick < ticks {
                    -step_m
                } else {
                    step_m
                });
                got_j += given * way;
                paid_j = paid_j.min(got_j);
                given = output.force_n.z.into();
                assert!(
                    !output.flags.contains(Flags::FORCE_WITHHELD),
                    "{device:?} {step_m} {tick}"
                );
                let felt_n = answer.force_n.norm();
                if tick < ticks && felt_n > 0.02 && last_n > 0.02 {
                    assert!(output.force_n.norm() > 0.0, "{device:?} {step_m} {tick}");
                    shown_n += f64::from(output.force_n.norm());
                    tissue_n += f64::from(felt_n);
                    softens |= felt_n < 0.9 * last_n;
                }
                last_n = felt_n;
            }
            println!(
                "{device:?}, {step_m} m a tick: {:.3}, {got_j:.1e} of {paid_j:.1e} J",
                shown_n / tissue_n
            );
            assert!(shown_n >= 0.95 * tissue_n && tissue_n > 1.0, "{device:?} {step_m}");
            assert!(softens, "the force never falls: this is no test");
            assert!(got_j <= 5.0e-4, "{device:?} {step_m}: {got_j} J");
        }
    }
}
