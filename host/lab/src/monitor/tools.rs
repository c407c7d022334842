//! Follows an engine under tools on a contact surface tick by tick.
//!
//! **The bound of a force.** A sample of stiffness k that lies d deep pushes the tool by k d and stores
//! k d^2 / 2. By Cauchy and Schwarz the force of all is at most sqrt(2 K E), K being the sum of the
//! stiffness of those in contact: 2 k sqrt(W E) of the contact alone. Friction and grips pull at a sample
//! by f and store f^2 / (2 k) at least, so with them it is sqrt(4 K E). Without them K and E are those of
//! the samples in double precision, else what the tissue publishes.

use chaincell_kernel::{Flags, Model, ProxyPose, TickOutput, ToolPart, ToolPose};

use super::checks::{Bounds, Certificate, Check, Checks, Failure, Seen, Worst, is_of_tissue};
use super::contact::{ExactContact, Stored};
use crate::reference::vectors::{farthest, minus, norm};
use chaincell_host::engine::Engine;
use chaincell_kernel::Budget;

/// How far the tissue may go in a tick until triangles come in reach unseen [radii].
const COMING: f64 = 0.25;
/// Rounding of a level that is counted again while tools rest [its part].
const LEVEL: f64 = 8.0 * f32::EPSILON as f64;
/// Rounding of the sum of the forces of all triangles [part of the sum of their lengths].
const SUM: f64 = 1e-4;

/// What the tick before left.
#[derive(Debug, Clone)]
struct Before {
    level_j: f64,
    proxies: Vec<Option<ProxyPose>>,
    positions: Vec<[f64; 3]>,
}

/// Ticks an engine with tools and checks each tick.
#[derive(Debug, Clone)]
pub struct ToolMonitor<'m> {
    model: Model<'m>,
    exact: ExactContact<'m>,
    /// Whether the tools have friction, and whether one may grip something.
    has_friction: bool,
    grips: bool,
    /// Energy before the first tick \[J\]; none until it is measured.
    start_j: Option<f64>,
    before: Option<Before>,
    /// Whether a tool has a half space: one that turns goes far unseen.
    is_endless: bool,
    /// Whether a tool took hold of something since.
    acted: bool,
    /// Whether the list of triangles is full, and whether triangles in reach may be missing.
    is_full: bool,
    misses: bool,
    /// Ticks in which they were.
    missing: u64,
    checks: Checks,
}

impl<'m> ToolMonitor<'m> {
    /// Of an engine with these tools and this coefficient of friction; `None` for a model without
    /// nodal shapes or contact surface.
    #[must_use]
    pub fn new(engine: &Engine<'m>, tools: &[Vec<ToolPart>], friction: f32) -> Option<Self> {
        let model = *engine.network().model();
        let saturation = f64::from(model.saturation());
        let certificate = Certificate::of(engine.scheme());
        Some(Self {
            model,
            exact: ExactContact::new(model, tools)?,
            has_friction: friction > 0.0,
            grips: false,
            start_j: None,
            before: None,
            is_endless: tools.iter().flatten().any(ToolPart::is_half_space),
            acted: false,
            is_full: false,
            misses: false,
            missing: 0,
            checks: Checks::new(Bounds { saturation, certificate }),
        })
    }

    /// Something other than the tools acts before the next tick: positions, settings, a reset.
    pub fn interfere(&mut self) {
        (self.start_j, self.before) = (None, None);
    }

    /// A tool grips what it touches; gives how many samples it holds.
    pub fn grip(&mut self, engine: &mut Engine<'m>, tool: usize) -> usize {
        self.acted = true;
        let held = engine.grip(tool);
        self.grips |= held > 0;
        held
    }

    /// One tick with so many sweeps, 0 for a late one, `None` for the settings' count; checked.
    pub fn tick(
        &mut self,
        engine: &mut Engine<'m>,
        poses: &[ToolPose],
        sweeps: Option<u16>,
    ) -> TickOutput {
        let known_j = self.start_j;
        let mut start_j = known_j.unwrap_or_else(|| {
            let proxies = self.proxies(engine);
            let start_j = self.exact.stored(&engine.positions(), &proxies).energy_j;
            self.checks.start(start_j);
            start_j
        });
        let output = engine.tick_by(poses, Budget::again(sweeps));
        // Kept rotations, friction and grips may store more: the first level knows.
        if known_j.is_none() {
            start_j = start_j.max(output.energy_j.into());
        }
        self.start_j = Some(start_j);
        let (positions, proxies) = (engine.positions(), self.proxies(engine));
        let stored = self.exact.stored(&positions, &proxies);
        self.answer(engine, &output);
        let (acts, near) = self.compare(&output, &proxies, &positions);
        let (force_n, force_bound_n) = self.nearest(engine, &output, &stored);
        let energy_max_j =
            f64::from(self.model.energy_max()) * f64::from(self.model.energy_unit_j());
        let level_j = f64::from(output.energy_j);
        self.checks.look(&Seen {
            level_j,
            energy_j: if self.misses { stored.tissue_j } else { stored.energy_j },
            allowance_j: stored.allowance_j,
            energy_max_j: start_j.max(energy_max_j),
            acts,
            force_n,
            force_bound_n,
            positions: &positions,
        });
        if let Some(last_j) = near {
            let most_j = last_j * (1.0 + LEVEL) + stored.allowance_j;
            self.hold(Check::Rise, level_j <= most_j, || {
                format!("level {level_j:e} J after {last_j:e} J under tools that stayed")
            });
        }
        self.before = Some(Before { level_j, proxies, positions });
        output
    }

    /// Notes a check that the caller made.
    pub fn hold(&mut self, check: Check, holds: bool, what: impl FnOnce() -> String) {
        self.checks.hold(check, holds, what);
    }

    /// The first failure of each check.
    #[must_use]
    pub fn failures(&self) -> &[Failure] {
        &self.checks.failures
    }

    /// How close the run came to its bounds.
    #[must_use]
    pub fn worst(&self) -> &Worst {
        &self.checks.worst
    }

    /// Ticks in which triangles in reach may have been missing: the tissue had come too far for the
    /// search, a half space turned, or the room was full. The contact's energy is not compared with the level then.
    #[must_use]
    pub fn missing(&self) -> u64 {
        self.missing
    }

    fn proxies(&self, engine: &mut Engine<'m>) -> Vec<Option<ProxyPose>> {
        (0..self.exact.tools()).map(|tool| engine.proxy_pose(tool)).collect()
    }

    /// Whether anything acted from outside, tools that are engaged included; and the level before where
    /// they are and have stayed.
    fn compare(
        &mut self,
        output: &TickOutput,
        proxies: &[Option<ProxyPose>],
        positions: &[[f64; 3]],
    ) -> (bool, Option<f64>) {
        let is_full = output.flags.contains(Flags::CONTACT_CAPACITY);
        let engaged = proxies.iter().any(Option::is_some);
        let Some(before) = &self.before else {
            (self.is_full, self.misses) = (is_full, engaged);
            self.missing += u64::from(engaged);
            return (true, None);
        };
        let moved = before.proxies != proxies;
        let turn = |proxy: &Option<ProxyPose>| proxy.map(|proxy| proxy.orientation);
        let swings =
            self.is_endless && before.proxies.iter().zip(proxies).any(|(a, b)| turn(a) != turn(b));
        let comes = farthest(&before.positions, positions) >= COMING * self.exact.radius_min();
        // Without a search the list stays as it is.
        self.is_full = is_full || (self.is_full && !moved);
        // What came into reach unseen counts from the next search on: the level rises there.
        let has_missed = self.misses;
        let still_misses = self.misses && output.flags.contains(Flags::LATE);
        self.misses = engaged && (self.is_full || comes || swings || still_misses);
        self.missing += u64::from(self.misses);
        let was_engaged = before.proxies.iter().any(Option::is_some);
        let finds = has_missed || self.misses;
        let stays = engaged && !moved && !finds && !self.has_friction && !self.acted;
        self.acted = false;
        (engaged || was_engaged, stays.then_some(before.level_j))
    }

    /// The force of a tool that is nearest to its bound, and that bound \[N\].
    fn nearest(
        &mut self,
        engine: &mut Engine<'m>,
        output: &TickOutput,
        stored: &Stored,
    ) -> ([f64; 3], f64) {
        let is_late = output.flags.contains(Flags::LATE);
        let level_j = f64::from(output.energy_j) + stored.allowance_j;
        let (mut nearest, mut part) = (([0.0; 3], 0.0), 0.0);
        for (tool, met) in stored.met.iter().enumerate() {
            let of_tool = engine.tool_output(tool);
            let force_n: [f64; 3] = of_tool.force_n.cast::<f64>().into();
            let stiffness = f64::from(of_tool.stiffness_n_per_m);
            let numbers = of_tool.torque_n_m.iter().chain([&of_tool.work_j]);
            let is_finite = stiffness.is_finite() && numbers.into_iter().all(|x| x.is_finite());
            self.hold(Check::Finite, is_finite, || format!("tool {tool}: {of_tool:?}"));
            let bound_n = match (is_late || self.misses, self.has_friction || self.grips) {
                (true, _) => f64::INFINITY,
                (_, true) => (4.0 * stiffness * level_j).sqrt(),
                _ => (2.0 * met.stiffness_n_per_m * (met.energy_j + stored.allowance_j)).sqrt(),
            };
            let length_n = of_tool.force_n.cast::<f64>().norm();
            let own = if length_n > 0.0 { length_n / bound_n } else { 0.0 };
            // A number that is none is shown too.
            if own.partial_cmp(&part).is_none_or(std::cmp::Ordering::is_ge) {
                (nearest, part) = ((force_n, bound_n), own);
            }
        }
        nearest
    }

    /// What the answer must be whatever the energy is.
    fn answer(&mut self, engine: &mut Engine<'m>, output: &TickOutput) {
        let numbers = output.force_n.iter().chain([&output.work_j, &output.stiffness_n_per_m]);
        let is_finite = numbers.into_iter().all(|x| x.is_finite());
        self.hold(Check::Finite, is_finite, || format!("{output:?}"));
        let most_n = f64::from(engine.network().settings().max_force_n);
        let force_n = output.force_n.cast::<f64>().norm();
        self.hold(Check::Force, force_n <= most_n, || {
            format!("{force_n:e} N, at most {most_n:e} N are set")
        });
        let safe = output.flags.contains(Flags::SAFE_STATE);
        let late = output.flags.contains(Flags::LATE);
        let touches = force_n == 0.0 || (!safe && (late || output.contacts > 0));
        self.hold(Check::Answer, is_of_tissue(output.flags) && touches, || format!("{output:?}"));
        // The contacts of each tool add up to its force.
        let tools = self.exact.tools();
        let mut sums = vec![([0.0; 3], 0.0); tools];
        for of in engine.contact_forces() {
            let force = [0, 1, 2].map(|axis| f64::from(of.normal_n[axis] + of.tangential_n[axis]));
            if let Some((sum, lengths)) = sums.get_mut(usize::from(of.tool)) {
                *sum = [0, 1, 2].map(|axis| sum[axis] + force[axis]);
                *lengths += norm(force);
            }
        }
        if late || safe || most_n.is_finite() {
            return;
        }
        for (tool, (sum, lengths)) in sums.into_iter().enumerate() {
            let own: [f64; 3] = engine.tool_output(tool).force_n.cast::<f64>().into();
            let off = norm(minus(own, sum));
            self.hold(Check::Answer, off <= SUM * lengths, || {
                format!("tool {tool}: force {own:?} N, its contacts add up to {sum:?} N")
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::bake::tissue::Tissue;
    use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
    use chaincell_host::engine::{Arithmetic, Contact, Scheme};
    use chaincell_host::mesh::{MeshOptions, load};
    use chaincell_kernel::{Network, Settings};

    fn block() -> ImageBytes {
        let mesh = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
        let tissue = Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45)));
        let options = BakeOptions { tissue, ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options).unwrap()
    }

    /// The checks that fail while a sphere of 12 mm goes 10 mm deep and stays, with this friction, and
    /// is taken for one of `radius_m` without any.
    fn failing(radius_m: f32, friction: f32) -> Vec<Check> {
        let image = block();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let network = Network::new(model, Settings::for_model(&model)).unwrap();
        let contact = Contact::Tools { tools: vec![vec![ToolPart::sphere(0.012)]], friction };
        let mut engine =
            Engine::with_contact(network, Scheme::Track, Arithmetic::F32, contact).unwrap();
        let taken = [vec![ToolPart::sphere(radius_m)]];
        let mut monitor = ToolMonitor::new(&engine, &taken, 0.0).unwrap();
        let [x, y, z] = model.centre_m();
        for tick in 0..60_u8 {
            let (down, aside) = (0.01 * f32::from(tick.min(20)) / 20.0, 0.0005 * f32::from(tick));
            let at = [x + aside, y + 0.001, z + 0.015 + 0.012 - down];
            monitor.tick(&mut engine, &[ToolPose::at(at.into(), 1)], None);
        }
        assert!(monitor.worst().force_max_n > 0.1 && monitor.missing() < 5);
        monitor.failures().iter().map(|failure| failure.check).collect()
    }

    #[test]
    fn a_tool_that_is_not_the_one_is_seen() {
        assert_eq!(failing(0.012, 0.0), []);
        assert!(failing(0.0125, 0.0).contains(&Check::Certified));
        assert!(failing(0.0115, 0.0).contains(&Check::Force));
        assert!(failing(0.012, 1.0).contains(&Check::Force));
    }
}
