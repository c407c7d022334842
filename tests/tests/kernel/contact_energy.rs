//! The certificate of contact on surfaces: the published level against the energy of tissue and tools in
//! double precision, over the samples of all triangles.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{
    Budget, Model, Network, ProxyPose, Settings, TickOutput, ToolPart, ToolPose, Unloading,
};
use chaincell_lab::monitor::contact::ExactContact;
use chaincell_lab::reference::vectors::farthest;
use chaincell_lab::states::State;

/// Height of the top of the block \[m\].
const TOP_M: f32 = 0.04;
/// Spacing of single precision.
const EPS: f64 = f32::EPSILON as f64;

/// A block on a fixed ground, 40 mm high and 48 mm wide, with edges of about 8 mm: of liver, or of links
/// with so much slack.
fn block(alpha: Option<f64>) -> ImageBytes {
    let mesh = load("box:7x7x6x0.008", &MeshOptions::default()).unwrap();
    let nodes = mesh.nodes_m.iter().enumerate();
    let ground: Vec<u32> =
        nodes.filter(|(_, x)| x[2] < 1e-6).map(|(node, _)| node as u32).collect();
    let of = PerCell::Uniform;
    let tissue = match alpha {
        None => Some(Tissue::new(of(5000.0), of(0.45))),
        Some(_) => None,
    };
    let alpha = of(alpha.unwrap_or(0.0));
    // Too near to the ground for coarse functions by itself.
    let coarse_basis = BasisSpacing::Links(2.5);
    let coarse_basis = if tissue.is_some() { BasisSpacing::BySize } else { coarse_basis };
    let options = BakeOptions { alpha, tissue, coarse_basis, ..Default::default() };
    bake(&mesh, &ground, &options).unwrap()
}

/// Blocks of each kind of tissue.
fn blocks() -> [(&'static str, ImageBytes); 3] {
    let kinds = [("shapes", None), ("links", Some(0.0)), ("slack links", Some(0.05))];
    kinds.map(|(name, alpha)| (name, block(alpha)))
}

/// How far the tissue may go in a tick until triangles come in reach unseen [radii].
const COMING: f64 = 0.25;

/// What the tick before left: level \[J\], proxies and positions.
type Before = (f64, Vec<Option<ProxyPose>>, Vec<[f64; 3]>);

/// An engine whose every tick is checked.
struct Followed<'m> {
    engine: Engine<'m>,
    exact: ExactContact<'m>,
    name: String,
    tick: u32,
    before: Option<Before>,
    /// Where links were.
    places: Vec<[f64; 3]>,
    /// Highest energy \[J\], ticks in contact, and level over energy of the last tick.
    highest_j: f64,
    touched: u32,
    ratio: f64,
    /// Ticks in which nothing outside moved.
    still: u32,
}

impl<'m> Followed<'m> {
    fn new(
        image: &'m ImageBytes,
        kind: &str,
        name: &str,
        tools: &[Vec<ToolPart>],
        (scheme, sweeps): (Scheme, u16),
    ) -> Self {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let settings = Settings::for_model(&model);
        let (unloading, max_tool_step_m) = (Unloading::Off, 10.0);
        let settings = Settings { sweeps, unloading, max_tool_step_m, ..settings };
        let network = Network::new(model, settings).unwrap();
        let contact = Contact::Tools { tools: tools.to_vec(), friction: 0.0 };
        let mut engine = Engine::with_contact(network, scheme, Arithmetic::F32, contact).unwrap();
        let exact = ExactContact::new(model, tools).unwrap();
        let name = format!("{kind} {name} {scheme:?} {sweeps}");
        let (highest_j, touched, ratio) = (0.0, 0, 1.0);
        let places = engine.positions();
        Self {
            engine,
            exact,
            name,
            tick: 0,
            before: None,
            places,
            highest_j,
            touched,
            ratio,
            still: 0,
        }
    }

    fn tick(&mut self, poses: &[ToolPose]) -> TickOutput {
        let output = self.engine.tick_by(poses, Budget::All);
        self.check(&output);
        output
    }

    /// A late tick of the first tool.
    fn late(&mut self, pose: &ToolPose) {
        let ToolPose { position_m, engaged, .. } = *pose;
        let output =
            self.engine.tick_by(&[ToolPose::at(position_m, engaged)], Budget::again(Some(0)));
        self.check(&output);
    }

    fn check(&mut self, output: &TickOutput) {
        let proxies: Vec<_> =
            (0..self.exact.tools()).map(|tool| self.engine.proxy_pose(tool)).collect();
        let positions = self.engine.positions();
        let exact = self.exact.stored(&positions, &proxies);
        let level_j = f64::from(output.energy_j);
        let name = format!("{} tick {}", self.name, self.tick);
        assert!(level_j.is_finite() && level_j >= 0.0, "{name}: {output:?}");
        // Links may go so far in a tick that triangles come in reach unseen: they count from the next
        // tick on.
        let is_seen = !self.exact.is_of_links()
            || farthest(&self.places, &positions) < COMING * self.exact.radius_min();
        self.places.clone_from(&positions);
        assert!(
            !is_seen || level_j + exact.allowance_j >= exact.energy_j,
            "{name}: {level_j:e} J below {exact:?}, {output:?} {proxies:?}"
        );
        if let Some((last_j, last, places)) = &self.before
            && *last == proxies
            && farthest(places, &positions) < COMING * self.exact.radius_min()
        {
            self.still += 1;
            let rounding_j = 8.0 * EPS * last_j + exact.allowance_j;
            assert!(level_j <= last_j + rounding_j, "{name}: {last_j:e} rises to {level_j:e} J");
        }
        self.before = Some((level_j, proxies, positions));
        self.tick += 1;
        self.highest_j = self.highest_j.max(exact.energy_j);
        self.touched += u32::from(output.contacts > 0 || output.force_n.norm() > 0.0);
        self.ratio = level_j / exact.energy_j.max(1e-12);
    }
}

fn pose(position_m: [f32; 3]) -> ToolPose {
    ToolPose::at(position_m.into(), 1)
}

/// About y by an angle \[rad\].
fn tilted(position_m: [f32; 3], angle: f32) -> ToolPose {
    let (sin, cos) = (0.5 * angle).sin_cos();
    ToolPose { orientation: [0.0, sin, 0.0, cos], ..pose(position_m) }
}

const WAYS: [(Scheme, u16); 3] = [(Scheme::Predict, 1), (Scheme::Predict, 4), (Scheme::Track, 2)];

#[test]
fn presses_slides_and_taps_stay_below_the_level() {
    let mut still = 0;
    for (kind, image) in blocks() {
        for way in WAYS {
            for radius_m in [0.002_f32, 0.008, 0.03] {
                let tools = [vec![ToolPart::sphere(radius_m)]];
                let at = |x_m: f32, depth_m: f32| [pose([x_m, 0.001, TOP_M + radius_m - depth_m])];
                let mut run =
                    Followed::new(&image, kind, &format!("slide {radius_m}"), &tools, way);
                for step in 0..40_u8 {
                    run.tick(&at(-0.01, 2.0e-4 * f32::from(step)));
                }
                for step in 0..40_u8 {
                    run.tick(&at(-0.01 + 5.0e-4 * f32::from(step), 0.008));
                }
                for _ in 0..40 {
                    run.tick(&at(0.01, 0.008));
                }
                assert!(run.touched > 100 && run.highest_j > 1e-6, "{}", run.highest_j);
                still += run.still;
                assert!(run.ratio < 1.01, "{}: level over energy {}", run.name, run.ratio);
                let mut run = Followed::new(&image, kind, &format!("tap {radius_m}"), &tools, way);
                for step in 0..120_u8 {
                    let depth_m = 0.006 * (0.35 * f32::from(step)).sin();
                    let mut at = at(0.0, depth_m);
                    at[0].engaged = u32::from(step % 29 > 2);
                    run.tick(&at);
                    if step % 5 == 0 {
                        run.late(&at[0]);
                    }
                }
            }
        }
    }
    assert!(still > 100, "{still}");
}

#[test]
fn jumps_through_the_body_stay_below_the_level() {
    for (kind, image) in blocks() {
        for way in WAYS {
            for part in [
                ToolPart::sphere(0.002),
                ToolPart::sphere(0.012),
                ToolPart::sphere(0.1),
                ToolPart::capsule(0.01, 0.004),
                ToolPart::rounded_box([0.006, 0.004, 0.003], 0.002),
                ToolPart::half_space(0.004),
            ] {
                let mut run =
                    Followed::new(&image, kind, &format!("jump {part:?}"), &[vec![part]], way);
                let mut random = 7_u32;
                let mut at = tilted([0.0, 0.0, 0.1], 0.0);
                // A half space turns by half a radius a tick at the farthest point of the surface.
                let stays = if part.is_half_space() { 40 } else { 6 };
                for step in 0..25 * stays {
                    if step % stays == 0 {
                        let mut next = || {
                            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                            (random >> 8) as f32 / 16_777_216.0 - 0.5
                        };
                        at = tilted(
                            [0.09 * next(), 0.09 * next(), 0.03 + 0.15 * next()],
                            6.0 * next(),
                        );
                        at.engaged = u32::from(step % (7 * stays) < 6 * stays);
                    }
                    run.tick(&[at]);
                }
                assert!(run.touched > 10, "{}: {}", run.name, run.touched);
            }
        }
    }
}

/// Far from its pivot a small turn of a half space is a long way.
#[test]
fn a_half_space_that_turns_stays_below_the_level() {
    let image = block(None);
    for way in WAYS {
        let tools = [vec![ToolPart::half_space(0.004)]];
        let mut run = Followed::new(&image, "shapes", "turning half space", &tools, way);
        for step in 0..240_u16 {
            // Upside down over the body, its frame 0.1 m aside: by 0.3 into the body, back, and away.
            let angle = [0.0, 0.3, 0.0, -0.3][usize::from(step / 60 % 4)];
            let at = tilted([-0.1, 0.0, TOP_M + 0.02], std::f32::consts::PI + angle);
            run.tick(&[at]);
        }
        assert!(run.touched > 20, "{}: {}", run.name, run.touched);
    }
}

#[test]
fn tools_together_stay_below_the_level() {
    for (kind, image) in blocks() {
        let jaw = vec![
            ToolPart::capsule(0.008, 0.002),
            ToolPart { centre_m: [0.015, 0.0, 0.0], ..ToolPart::sphere(0.012) },
        ];
        for way in WAYS {
            let tools = [jaw.clone(), vec![ToolPart::rounded_box([0.01, 0.003, 0.003], 0.002)]];
            let mut run = Followed::new(&image, kind, "two tools", &tools, way);
            for step in 0..160_u16 {
                let turned = 0.02 * f32::from(step);
                let aside_m = 2.0e-4 * f32::from(step);
                let z = TOP_M + 0.012 - 0.012 * (0.05 * f32::from(step)).sin();
                let mut first = tilted([-0.015 + aside_m, 0.002, z], turned);
                first.engaged = u32::from(step % 50 < 44);
                run.tick(&[first, tilted([0.015 - aside_m, -0.004, z - 0.006], -turned)]);
            }
            for _ in 0..40 {
                run.tick(&[]);
            }
            // Where they take hold within the block they wait.
            assert!(run.touched > 60, "{}: {}", run.name, run.touched);
        }
    }
}

#[test]
fn from_hard_states_it_stays_below_the_level() {
    for (kind, image) in blocks() {
        let states = [
            State::Inverted,
            State::Mirrored,
            State::Flattened,
            State::Stretched,
            State::HalfCoincident,
            State::Shaken,
            State::Scattered(10.0),
        ];
        for way in WAYS {
            for state in states {
                for part in [ToolPart::sphere(0.01), ToolPart::rounded_box([0.01; 3], 0.003)] {
                    let name = format!("{state:?} {part:?}");
                    let mut run = Followed::new(&image, kind, &name, &[vec![part]], way);
                    let at = tilted([0.0, 0.001, 0.5 * TOP_M], 0.4);
                    run.tick(&[at]);
                    let positions = state.positions(run.engine.network().model(), 3);
                    run.engine.set_positions(&positions).unwrap();
                    run.before = None;
                    for step in 0..60_u8 {
                        // What the terms of tissue do to such a state is not looked at here.
                        run.before = None;
                        run.tick(&[if step < 30 { at } else { tilted([0.01, 0.0, TOP_M], 0.0) }]);
                    }
                }
            }
        }
    }
}
