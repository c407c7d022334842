//! Follows an engine tick by tick.

use chaincell_kernel::{
    Budget, Flags, HELD_TICKS_MAX, Model, PinError, ProxyPose, TickOutput, ToolPart, ToolPose,
    Unloading,
};

use super::acting::{Before, Held, Tools, outer_weight};
use super::checks::{Bounds, Certificate, Check, Checks, Failure, Seen, Worst, is_of_tissue};
use super::contact::{ExactContact, Stored};
use crate::reference::vectors::{minus, norm};
use chaincell_host::engine::{Arithmetic, Contact, Engine};

/// Rounding of a level that is counted again while tools rest [its part].
const LEVEL: f64 = 8.0 * f32::EPSILON as f64;
/// Rounding of a force that is clamped twice [its part].
const CLAMPED: f32 = 8.0 * f32::EPSILON;
/// Rounding of the sum of the forces of all triangles [part of the sum of their lengths].
const SUM: f64 = 1e-4;

/// Rounding of the energy of all pins [its part].
const SUM_OF_PINS: f64 = 64.0 * f32::EPSILON as f64;

/// Ticks an engine and checks each tick.
#[derive(Debug, Clone)]
pub struct Monitor<'m> {
    model: Model<'m>,
    exact: ExactContact<'m>,
    held: Held,
    tools: Tools,
    /// Square root of the energy that bands load into the links when they close \[J\].
    slack_root: f64,
    /// Energy before the first tick \[J\]; none until it is measured.
    start_j: Option<f64>,
    /// State hash at rest, until something moves the body.
    rest: Option<u64>,
    /// Last good first pose, and bad samples since; none until a good one comes.
    good: Option<(ToolPose, u32)>,
    before: Option<Before>,
    last: Stored,
    checks: Checks,
}

impl<'m> Monitor<'m> {
    /// Of an engine whose numbers these are.
    #[must_use]
    pub fn new(engine: &Engine<'m>, numbers: Arithmetic) -> Self {
        Self::of_contact(engine, numbers, engine.contact())
    }

    fn of_contact(engine: &Engine<'m>, numbers: Arithmetic, contact: &Contact) -> Self {
        let model = *engine.network().model();
        let (parts, friction): (&[Vec<ToolPart>], f32) = match contact {
            Contact::Cells(_) => (&[], 0.0),
            Contact::Tools { tools, friction } => (tools, *friction),
        };
        let exact = ExactContact::new(model, parts, numbers);
        let slack = (0..model.links()).map(|link| {
            let slack = f64::from(model.link_alpha(link)) * f64::from(model.rest_lengths()[link]);
            0.25 * f64::from(model.link_weight(link)) * slack * slack
        });
        let certificate =
            if exact.is_known() { Certificate::of(engine.scheme()) } else { Certificate::None };
        let saturation = f64::from(model.saturation());
        Self {
            model,
            held: Held { weight: outer_weight(&model, engine.contacts()), is_driven: false },
            tools: Tools {
                has_friction: friction > 0.0,
                is_endless: parts.iter().flatten().any(ToolPart::is_half_space),
                ..Tools::default()
            },
            slack_root: (slack.sum::<f64>() * f64::from(model.energy_unit_j())).sqrt(),
            exact,
            start_j: None,
            rest: None,
            good: None,
            before: None,
            last: Stored::default(),
            checks: Checks::new(Bounds { saturation, certificate }),
        }
    }

    /// The same without the checks of level and energy, for a model whose coarse level may be
    /// wrong: the kernel takes it as it is.
    #[must_use]
    pub fn without_certificate(mut self) -> Self {
        let saturation = f64::from(self.model.saturation());
        self.checks = Checks::new(Bounds { saturation, certificate: Certificate::None });
        self
    }

    /// The engine is at rest: it stays so until a tool moves it.
    pub fn rests(&mut self, engine: &mut Engine<'m>) {
        self.rest = Some(engine.state_hash());
    }

    /// Something other than the tool acts before the next tick: positions, settings, a reset.
    pub fn interfere(&mut self) {
        (self.start_j, self.rest, self.good, self.before) = (None, None, None, None);
    }

    /// A tool grips what it touches; gives how many samples it holds.
    pub fn grip(&mut self, engine: &mut Engine<'m>, tool: usize) -> usize {
        self.tools.acted = true;
        let held = engine.grip(tool);
        self.tools.grips |= held > 0;
        held
    }

    /// Pins the surface around a point, see [`Engine::pin_at`]; a body at rest stays so.
    ///
    /// # Errors
    /// The kernel's refusal.
    pub fn pin_at(
        &mut self,
        engine: &mut Engine<'m>,
        (point_m, radius_m): ([f32; 3], f32),
        stiffness_n_per_m: f32,
    ) -> Result<u16, PinError> {
        let pin = engine.pin_at(point_m, radius_m, stiffness_n_per_m)?;
        self.rest = self.rest.map(|_| engine.state_hash());
        Ok(pin)
    }

    /// One tick with this number of sweeps, 0 for a late one, `None` for the settings' number; checked.
    pub fn tick(
        &mut self,
        engine: &mut Engine<'m>,
        poses: &[ToolPose],
        sweeps: Option<u16>,
    ) -> TickOutput {
        // Measure what the body stores before its first tick.
        let known_j = self.start_j;
        let mut start_j = known_j.unwrap_or_else(|| {
            let (positions, proxies) = (engine.positions(), self.proxies(engine));
            let start_j = self.exact.stored(&positions, &proxies, false).energy_j;
            self.checks.start(start_j);
            start_j
        });
        let output = engine.tick_by(poses, Budget::again(sweeps));
        // Kept rotations and shapes, friction and grips may store more than the exact energy has: the first
        // level bounds it.
        if known_j.is_none() && (self.model.is_nodal() || self.exact.tools() > 0) {
            start_j = start_j.max(output.energy_j.into());
        }
        self.start_j = Some(start_j);
        // Check the answer.
        let hash = self.accept(engine, poses, &output);
        self.answer(engine, &output);
        self.sweeps(engine, &output, sweeps);
        // Check the energy of the new state, and the force.
        let (positions, proxies) = (engine.positions(), self.proxies(engine));
        let closed = output.flags.contains(Flags::BAND_CLOSED);
        self.last = self.exact.stored(&positions, &proxies, closed);
        let (acts, near_j) = match self.exact.tools() {
            0 => {
                let (drive, before) = (engine.network().settings().drive, self.before.as_ref());
                (self.held.act(drive, before, poses, &output), None)
            }
            _ => {
                let (radius_min, before) = (self.exact.radius_min(), self.before.as_ref());
                self.tools.act(radius_min, before, &output, &proxies, &positions)
            }
        };
        self.stays(engine, &output, acts);
        let (force_n, bound_n) = match self.exact.tools() {
            0 => {
                let bound_n = self.held.force_bound_n(&self.model, &self.last, &output);
                (<[f32; 3]>::from(output.force_n).map(f64::from), bound_n)
            }
            _ => {
                let met = (&*proxies, self.last.allowance_j);
                self.tools.nearest(engine, &self.exact, met, &output)
            }
        };
        let force_bound_n = if self.exact.is_known() { bound_n } else { f64::INFINITY };
        // The pins' energy is the kernel's own, of the positions that are checked.
        let of_pins = engine.pins().into_iter().filter_map(|pin| engine.pin_output(pin));
        let pins_j: f64 = of_pins.map(|pin| f64::from(pin.energy_j)).sum();
        self.last.tissue_j += pins_j;
        self.last.energy_j += pins_j;
        self.last.allowance_j += SUM_OF_PINS * pins_j;
        let Stored { tissue_j, energy_j, allowance_j, .. } = self.last;
        self.checks.look(&Seen {
            level_j: output.energy_j.into(),
            energy_j: if self.tools.misses { tissue_j } else { energy_j },
            allowance_j,
            energy_max_j: self.energy_max_j(engine, start_j, closed),
            acts,
            force_n,
            force_bound_n,
            positions: &positions,
        });
        if let Some(last_j) = near_j {
            let (level_j, most_j) =
                (f64::from(output.energy_j), last_j * (1.0 + LEVEL) + allowance_j);
            self.hold(Check::Rise, level_j <= most_j, || {
                format!("level {level_j:e} J after {last_j:e} J under tools that stayed")
            });
        }
        let pose = poses.first().copied();
        self.before = Some(Before { pose, output, proxies, positions, hash });
        output
    }

    /// Energy of the last tick's state in double precision, and how far rounding may move it \[J\].
    #[must_use]
    pub fn stored(&self) -> &Stored {
        &self.last
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
    /// search, a half space turned, or the list was full. The contact's energy is not compared with the level
    /// then.
    #[must_use]
    pub fn missing(&self) -> u64 {
        self.tools.missing
    }

    fn proxies(&self, engine: &mut Engine<'m>) -> Vec<Option<ProxyPose>> {
        (0..self.exact.tools()).map(|tool| engine.proxy_pose(tool)).collect()
    }

    /// Checks what follows bad samples: the last good one for [`HELD_TICKS_MAX`] ticks, then the safe state,
    /// in which no bit changes. Returns the state hash after a bad sample.
    fn accept(
        &mut self,
        engine: &mut Engine<'m>,
        poses: &[ToolPose],
        output: &TickOutput,
    ) -> Option<u64> {
        let is_good = !poses.is_empty() && poses.iter().all(ToolPose::is_good);
        if let (true, Some(&pose)) = (is_good, poses.first()) {
            self.good = Some((pose, 0));
        } else if let Some((_, bad)) = &mut self.good {
            *bad += 1;
        }
        let hash = (!is_good).then(|| engine.state_hash());
        let Some((_, bad)) = self.good else { return hash };
        let has = |flag| output.flags.contains(flag);
        let is_safe = bad > HELD_TICKS_MAX;
        let known = has(Flags::BAD_SAMPLE) != is_good && has(Flags::SAFE_STATE) == is_safe;
        self.hold(Check::Safe, known, || format!("{bad} bad samples: {output:?}"));
        let Some(before) = &self.before else { return hash };
        let (contacts, frozen) = (before.output.contacts, before.hash);
        let stays = is_good || self.exact.tools() > 0 || output.contacts == contacts;
        let is_frozen = !is_safe || frozen == hash;
        self.hold(Check::Safe, stays && is_frozen, || {
            format!("{bad} bad samples: {contacts} contacts before, {output:?}, frozen {is_frozen}")
        });
        hash
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
        if self.exact.tools() > 0 {
            // An edge has no contacts.
            let is_whole = !late && !safe && most_n.is_infinite() && !has_edge(engine.contact());
            return self.contacts_add_up(engine, is_whole);
        }
        let away = self.good.is_some_and(|(pose, _)| pose.engaged == 0);
        let is_held = output.contacts as usize <= self.model.cells();
        let is_free = !away || (force_n == 0.0 && output.contacts == 0);
        self.hold(Check::Answer, is_held && is_free, || format!("{output:?}"));
    }

    /// The contacts of each tool add up to its force, which is finite.
    fn contacts_add_up(&mut self, engine: &mut Engine<'m>, is_whole: bool) {
        let mut sums = vec![([0.0; 3], 0.0); self.exact.tools()];
        for of in engine.contact_forces() {
            let all = [of.position_m, of.normal_n, of.tangential_n];
            let is_finite = all.as_flattened().iter().all(|x| x.is_finite());
            self.hold(Check::Finite, is_finite, || format!("{of:?}"));
            let force = [0, 1, 2].map(|axis| f64::from(of.normal_n[axis] + of.tangential_n[axis]));
            if let Some((sum, lengths)) = sums.get_mut(usize::from(of.tool)) {
                *sum = [0, 1, 2].map(|axis| sum[axis] + force[axis]);
                *lengths += norm(force);
            }
        }
        for (tool, (sum, lengths)) in sums.into_iter().enumerate() {
            let of_tool = engine.tool_output(tool);
            let numbers = of_tool.force_n.iter().chain(&of_tool.torque_n_m);
            let numbers = numbers.chain([&of_tool.work_j, &of_tool.stiffness_n_per_m]);
            let is_finite = numbers.into_iter().all(|x| x.is_finite());
            self.hold(Check::Finite, is_finite, || format!("tool {tool}: {of_tool:?}"));
            let force_n: [f64; 3] = of_tool.force_n.cast::<f64>().into();
            let off = norm(minus(force_n, sum));
            self.hold(Check::Answer, !is_whole || off <= SUM * lengths, || {
                format!("tool {tool}: force {force_n:?} N, its contacts add up to {sum:?} N")
            });
        }
    }

    /// As many sweeps as are asked for, none in the safe state; a late tick repeats the force.
    fn sweeps(&mut self, engine: &Engine<'_>, output: &TickOutput, asked: Option<u16>) {
        let most = engine.network().settings().sweeps;
        let asked = asked.filter(|_| engine.is_anytime()).map_or(most, |asked| asked.min(most));
        let is_late = output.flags.contains(Flags::LATE);
        let made = if output.flags.contains(Flags::SAFE_STATE) {
            output.sweeps == 0 && !is_late
        } else {
            // Where the level is unknown it has to be found first.
            is_late == (output.sweeps == 0)
                && (output.sweeps == asked || asked == 0 && output.sweeps == 1)
        };
        self.hold(Check::Sweeps, made, || format!("{asked} sweeps are asked for: {output:?}"));
        let Some((before, (pose, _))) = self.before.as_ref().zip(self.good) else { return };
        if is_late && self.exact.tools() == 0 {
            let kept_n = f32::from(u8::from(pose.engaged == 1)) * before.output.force_n;
            // A force that is clamped is rounded down anew.
            let is_clamped = output.flags.contains(Flags::FORCE_CLAMPED);
            let off_n = if is_clamped { CLAMPED * kept_n.norm() } else { 0.0 };
            let kept = (output.force_n - kept_n).norm() <= off_n;
            self.hold(Check::Sweeps, kept, || format!("late, {kept_n} N before: {output:?}"));
        }
    }

    /// A body at rest stays as it was to the last bit while nothing moves it.
    fn stays(&mut self, engine: &mut Engine<'m>, output: &TickOutput, acts: bool) {
        let Some(rest) = self.rest else { return };
        // Taking hold of cells does not act.
        let takes_hold = self.before.is_none() && self.exact.tools() == 0;
        if self.held.is_driven || acts && !takes_hold {
            self.rest = None;
            return;
        }
        let nothing = output.force_n.norm() == 0.0 && output.energy_j.to_bits() == 0;
        let same = nothing && engine.state_hash() == rest;
        self.hold(Check::Rest, same, || {
            format!("force {}, level {:e} J", output.force_n, output.energy_j)
        });
    }

    /// Largest energy that a tool may load: bands that close load their own slack.
    fn energy_max_j(&self, engine: &Engine<'_>, start_j: f64, closed: bool) -> f64 {
        let may_close = closed || engine.network().settings().unloading != Unloading::Off;
        let slack_root = if may_close { self.slack_root } else { 0.0 };
        let unit_j = f64::from(self.model.energy_unit_j());
        let most_j = start_j.max(f64::from(self.model.energy_max()) * unit_j);
        (most_j.sqrt() + slack_root).powi(2)
    }
}

/// Returns true if a tool has an edge that cuts.
fn has_edge(contact: &Contact) -> bool {
    let Contact::Tools { tools, .. } = contact else { return false };
    tools.iter().flatten().any(ToolPart::is_edge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::bake::tissue::Tissue;
    use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
    use chaincell_host::engine::Scheme;
    use chaincell_host::mesh::{MeshOptions, load};
    use chaincell_kernel::{Network, Settings};

    fn block() -> ImageBytes {
        let mesh = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
        let tissue = Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45)));
        let options = BakeOptions { tissue, ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options).unwrap()
    }

    /// A sphere without friction, or with.
    fn sphere(radius_m: f32, friction: f32) -> Contact {
        Contact::Tools { tools: vec![vec![ToolPart::sphere(radius_m)]], friction }
    }

    /// The checks that fail while a sphere of 12 mm goes 10 mm deep and stays, with this friction, and
    /// is taken for one of `radius_m` without any.
    fn failing(radius_m: f32, friction: f32) -> Vec<Check> {
        let image = block();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let network = Network::new(model, Settings::for_model(&model)).unwrap();
        let contact = sphere(0.012, friction);
        let mut engine =
            Engine::with_contact(network, Scheme::Track, Arithmetic::F32, contact).unwrap();
        let taken = sphere(radius_m, 0.0);
        let mut monitor = Monitor::of_contact(&engine, Arithmetic::F32, &taken);
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

    /// The checks that fail in a tick after the engine alone did something between two ticks.
    fn after(between: impl Fn(&mut Engine<'_>), pose: ToolPose, sweeps: Option<u16>) -> Vec<Check> {
        let image = block();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let network = Network::new(model, Settings::for_model(&model)).unwrap();
        let free = (0..model.cells() as u16).rfind(|&cell| !model.is_fixed(cell)).unwrap();
        let mut engine = Engine::new(network, Scheme::Track, &[free]).unwrap();
        let mut monitor = Monitor::new(&engine, Arithmetic::F32);
        monitor.rests(&mut engine);
        monitor.tick(&mut engine, &[ToolPose::at([0.0; 3].into(), 1)], None);
        between(&mut engine);
        monitor.tick(&mut engine, &[pose], sweeps);
        monitor.failures().iter().map(|failure| failure.check).collect()
    }

    #[test]
    fn what_the_engine_does_alone_is_seen() {
        let [still, bad] = [0.0, f32::NAN].map(|z| ToolPose::at([0.0, 0.0, z].into(), 1));
        let pressed = ToolPose::at([0.0, 0.0, -0.001].into(), 1);
        assert_eq!(after(|_| (), still, None), []);
        assert_eq!(after(|_| (), pressed, Some(0)), []);
        let press = |engine: &mut Engine<'_>| {
            engine.tick(&pressed);
        };
        assert!(after(press, still, None).contains(&Check::Rest));
        assert!(after(press, pressed, Some(0)).contains(&Check::Sweeps));
        let bad_ticks = |engine: &mut Engine<'_>| {
            (0..10).for_each(|_| {
                engine.tick(&bad);
            });
        };
        assert_eq!(after(|_| (), bad, None), []);
        assert!(after(bad_ticks, bad, None).contains(&Check::Safe));
    }
}
