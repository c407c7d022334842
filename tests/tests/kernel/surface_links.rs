//! A sphere on the triangles of a body of links.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, ContactSurface, ImageBytes, PerCell, bake};
use chaincell_host::engine::motion::Press;
use chaincell_host::engine::place::place;
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Flags, Network, Settings, ToolPose};
use chaincell_lab::monitor::{Step, play};
use chaincell_tests::bodies::{baked, model, nodal, under};

/// A body of links with a contact surface, as `bake SPEC --alpha ALPHA`.
fn links(spec: &str, alpha: f64) -> ImageBytes {
    baked(spec, &BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() })
}

fn engine(image: &ImageBytes, radius_m: f32, way: (Scheme, u16)) -> Engine<'_> {
    under(image, Contact::sphere(radius_m, 0.0), way, 0.01).unwrap()
}

/// Links under a moving tool need more than one sweep; held cells and bodies of shapes do not.
#[test]
fn the_fewest_sweeps_are_those_of_the_contact() {
    let image = links("box:5x5x5x0.008", 0.0);
    assert_eq!(engine(&image, 0.01, (Scheme::Predict, 9)).least_sweeps(), 4);
    assert_eq!(engine(&image, 0.01, (Scheme::Predict, 2)).least_sweeps(), 2);
    let network = Network::new(model(&image), Settings::for_model(&model(&image))).unwrap();
    assert_eq!(Engine::new(network, Scheme::Predict, &[7]).unwrap().least_sweeps(), 1);
    let shapes = nodal("box:5x5x5x0.008", 5000.0);
    assert_eq!(engine(&shapes, 0.01, (Scheme::Predict, 9)).least_sweeps(), 1);
}

const WAYS: [(Scheme, u16); 2] = [(Scheme::Track, 4), (Scheme::Predict, 2)];

/// Spheres of a quarter to a half of an edge, pressed in as deep as they are wide and far deeper.
// REQ-CON-06
#[test]
fn a_sphere_smaller_than_a_link_never_passes_without_force() {
    for spec in ["box:9x9x6x0.008", "organ:1000"] {
        for alpha in [0.0, 0.05] {
            let image = links(spec, alpha);
            for way in WAYS {
                for radius_m in [0.002_f32, 0.004] {
                    // With slack the surface gives way, and snaps; it still touches the sphere.
                    let least = if alpha > 0.0 { 0.0 } else { 0.3 };
                    let mut engine = engine(&image, radius_m, way);
                    let place = place(&model(&image), engine.contact(), None).unwrap();
                    let press = Press::new(place.touch_m, place.direction, 0.03, 1000).unwrap();
                    let (mut most, mut clamped) = (0.0_f32, false);
                    for tick in 100..500 {
                        let output = engine.tick(&press.pose(tick).into());
                        let force = output.force_n.norm();
                        most = most.max(force);
                        clamped |= output.flags.contains(Flags::MOTION_CLAMPED);
                        let what = format!("{spec} {alpha} {way:?} {radius_m} tick {tick}");
                        assert!(tick < 200 || force > least * most, "{what}: {force} of {most} N");
                        let is_plain = |x: &f32| x.is_finite() && x.to_bits() != 1 << 31;
                        assert!(output.force_n.iter().all(is_plain), "{what}: {output:?}");
                    }
                    let what = format!("{spec} {alpha} {way:?} {radius_m}");
                    assert!((clamped || alpha > 0.0) && most > 0.003, "{what}: {most} N");
                }
            }
        }
    }
}

/// Near a body and let go again: no force, no energy, and the rest shape to the last bit.
#[test]
fn untouched_it_stays_at_rest() {
    for alpha in [0.0, 0.05] {
        let image = links("box:9x9x6x0.008", alpha);
        for way in WAYS {
            let mut engine = engine(&image, 0.006, way);
            let rest = engine.state_hash();
            for tick in 0..60_u16 {
                // Less than a hundredth of a millimetre above the top.
                let position_m = [0.0, 0.0, 0.04 + 0.006_01].into();
                let engaged = u32::from(tick % 20 < 15);
                let output = engine.tick(&ToolPose::at(position_m, engaged));
                assert_eq!(engine.state_hash(), rest, "{alpha} {way:?} {tick}");
                let all = [output.energy_j, output.work_j].into_iter();
                assert!(all.chain(output.force_n.iter().copied()).all(|x| x.to_bits() == 0));
            }
        }
    }
}

/// A body in parts that a sphere presses, slides over and lets go, over and over: one thread and two, vector
/// unit and none.
#[test]
fn threads_give_the_same_bits_under_a_sphere() {
    let image = links("box:26x26x25x0.004", 0.0);
    assert!(model(&image).thread_parts().count() > 1);
    let steps = (0..56_u16).map(|tick| {
        let depth_m = 2.0e-4 * f32::from(tick.min(20));
        let aside_m = 2.0e-4 * (f32::from(tick) - 30.0);
        Step::at([aside_m, 0.001, 0.096 + 0.006 - depth_m], u32::from(tick < 50))
    });
    let new = || Ok(engine(&image, 0.006, (Scheme::Track, 2)));
    let monitor = play(new, Arithmetic::F32, None, steps).unwrap();
    assert!(monitor.failures().is_empty(), "{:?}", monitor.failures());
    assert!(monitor.worst().force_max_n > 0.05, "{:?}", monitor.worst());
}

/// As [`chaincell_host::bake::Equivalent`] says: a harder body meets a probe more stiffly.
#[test]
fn contact_is_as_stiff_as_the_links_are() {
    let stiffness = |k: f64| {
        let stiffness_n_per_m = PerCell::Uniform(k);
        let options = BakeOptions { stiffness_n_per_m, ..BakeOptions::default() };
        let image = baked("box:5x5x5x0.01", &options);
        let mut sum = 0.0;
        model(&image).each_contact_triangle(0.01, |_, of| sum += of);
        sum
    };
    let ratio = stiffness(60.0) / stiffness(20.0);
    assert!((ratio - 3.0).abs() < 1e-4, "{ratio}");
}

/// A sphere that stands still in the tissue feels a steady force, on links and on shapes.
// REQ-FOR-06
#[test]
fn a_tool_at_rest_feels_a_steady_force() {
    const DEPTH_M: f32 = 0.004;
    let of_links = links("box:9x9x5x0.01", 0.0);
    let of_shapes = nodal("box:9x9x5x0.01", 5000.0);
    for (image, share) in [(of_links, 1.0e-3), (of_shapes, 2.5e-3)] {
        for way in WAYS {
            let mut engine = engine(&image, 0.012, way);
            let force_n = |tick: u16, engine: &mut Engine<'_>| {
                let depth_m = DEPTH_M * f32::from(tick.min(200)) / 200.0;
                let position_m = [0.001, 0.002, 0.04 + 0.012 - depth_m];
                engine.tick(&ToolPose::at(position_m.into(), 1)).force_n
            };
            let all: Vec<_> = (0..700).map(|tick| force_n(tick, &mut engine)).collect();
            let peak_n = all.iter().map(|force| force.norm()).fold(0.0, f32::max);
            assert!(peak_n > 0.01, "{way:?}: {peak_n} N");
            let step_n = |two: &[nalgebra::Vector3<f32>]| (two[1] - two[0]).norm();
            let largest_n = all[300..].windows(2).map(step_n).fold(0.0, f32::max);
            assert!(largest_n < share * peak_n, "{way:?}: {largest_n} N of {peak_n} N");
        }
    }
}

/// A plane, groups of nodes and a lean image have a contact surface too: a sphere that is pressed in is held
/// back, more the deeper it goes, and let go of it has no force.
// REQ-ENE-09
#[test]
fn planes_groups_and_lean_bodies_press_back() {
    let yes = ContactSurface::Yes;
    let grouped = BakeOptions { cells: Some(120), ..BakeOptions::default() };
    let lean = BakeOptions { lean: true, contact_surface: yes, ..BakeOptions::default() };
    for (spec, options) in [
        ("plane:11x11x0.01", BakeOptions::default()),
        ("box:11x11x5x0.01", grouped),
        ("box:9x9x5x0.01", lean),
    ] {
        let image = baked(spec, &options);
        let model = model(&image);
        assert!(model.has_contact_surface(), "{spec}");
        let (contact, ticks) = (Contact::sphere(0.015, 0.0), 400);
        let place = place(&model, &contact, None).unwrap();
        for way in WAYS {
            let mut engine = engine(&image, 0.015, way);
            let press = Press::new(place.touch_m, place.direction, 0.008, ticks).unwrap();
            let (mut last_n, mut deepest_n) = (0.0_f32, 0.0_f32);
            for pose in press.poses() {
                let output = engine.tick(&ToolPose::from(pose));
                assert!(!output.flags.contains(Flags::STARTS_INSIDE), "{spec}: {output:?}");
                last_n = output.force_n.norm();
                deepest_n = deepest_n.max(last_n);
            }
            assert!(deepest_n > 0.002 && deepest_n < 10.0, "{spec} {way:?}: {deepest_n} N");
            assert_eq!(last_n, 0.0, "{spec} {way:?}");
        }
    }
}

/// The triangles between groups stand once each, and those within one are none.
#[test]
fn triangles_of_groups_join_three_of_them() {
    let options = BakeOptions { cells: Some(60), ..BakeOptions::default() };
    let image = baked("box:9x9x5x0.01", &options);
    let triangles = model(&image).triangles();
    let sorted = triangles.iter().map(|corners| {
        let mut corners = *corners;
        corners.sort_unstable();
        assert!(corners[0] < corners[1] && corners[1] < corners[2], "{corners:?}");
        corners
    });
    let each: std::collections::BTreeSet<[u16; 3]> = sorted.collect();
    assert!(each.len() == triangles.len() && triangles.len() > 40, "{}", triangles.len());
}

/// Without triangles there is none, and a lean image has one only where it is asked for.
// REQ-CON-05
#[test]
fn what_has_no_contact_surface_says_why() {
    let no = BakeOptions { contact_surface: ContactSurface::No, ..BakeOptions::default() };
    let lean = BakeOptions { lean: true, ..BakeOptions::default() };
    for options in [no, lean] {
        let image = baked("box:4x4x4x0.01", &options);
        let refused = under(&image, Contact::sphere(0.01, 0.0), (Scheme::Track, 4), 0.01);
        let said = refused.map(drop).unwrap_err().to_string();
        assert!(said.contains("no contact surface") && said.contains("contact_surface"), "{said}");
    }
    let mut mesh = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
    mesh.triangles.clear();
    let options = BakeOptions { contact_surface: ContactSurface::Yes, ..BakeOptions::default() };
    let said = bake(&mesh, &mesh.default_fixed, &options).unwrap_err().to_string();
    assert!(said.contains("`contact_surface` yes: the mesh has no triangles"), "{said}");
    let grouped = BakeOptions { cells: Some(3), ..options };
    let mesh = load("organ:300", &MeshOptions::default()).unwrap();
    let said = bake(&mesh, &mesh.default_fixed, &grouped).unwrap_err().to_string();
    assert!(said.contains("`contact_surface` yes: no triangle joins three groups"), "{said}");
}
