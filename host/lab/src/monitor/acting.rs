//! What acts on a body from outside in a tick, and the largest force that it may give.
//!
//! **The bound of a force.** Held cells feel at most 2 k sqrt(W E), W being the weight of their links. A sample
//! of stiffness k that lies d deep pushes the tool by k d and stores k d^2 / 2. By Cauchy and Schwarz the force
//! of all is at most sqrt(2 K E), K being the sum of the stiffness of those in contact. Friction and grips pull
//! at a sample by f and store f^2 / (2 k) at least, so with them it is sqrt(4 K E). Without them K and E are
//! those of the samples in double precision, at the points where the force is taken, else what the tissue publishes.
//! In either case the level bounds E.

use chaincell_kernel::{Drive, Flags, Model, ProxyPose, TickOutput, ToolPose};

use super::contact::{ExactContact, Stored};
use crate::reference::vectors::{farthest, norm};
use chaincell_host::engine::Engine;

/// How far the tissue may go in a tick until triangles come in reach unseen [radii].
const COMING: f64 = 0.25;

/// The tick before.
#[derive(Debug, Clone)]
pub struct Before {
    pub pose: Option<ToolPose>,
    pub output: TickOutput,
    pub proxies: Vec<Option<ProxyPose>>,
    pub positions: Vec<[f64; 3]>,
    /// State hash after a bad sample.
    pub hash: Option<u64>,
}

/// Held cells.
#[derive(Debug, Clone)]
pub struct Held {
    /// Weight of the links between held and other cells.
    pub weight: f64,
    /// Whether the tool loads its cells with a current: the drive of a hold is that of its start.
    pub is_driven: bool,
}

/// Tools on a contact surface.
#[derive(Debug, Clone, Default)]
pub struct Tools {
    /// Whether the tools have friction, and whether one grips something or has just taken hold.
    pub has_friction: bool,
    pub grips: bool,
    pub acted: bool,
    /// Whether a tool has a half space: one that turns goes far unseen.
    pub is_endless: bool,
    /// Whether the list of triangles is full, and whether triangles in reach may be missing.
    pub is_full: bool,
    pub misses: bool,
    /// Ticks in which they were.
    pub missing: u64,
}

impl Held {
    /// Whether anything acted on held cells from outside in this tick. Taking hold and letting go do not.
    pub fn act(
        &mut self,
        drive: Drive,
        before: Option<&Before>,
        poses: &[ToolPose],
        output: &TickOutput,
    ) -> bool {
        let asked = drive == Drive::Current;
        self.is_driven = output.contacts > 0 && (self.is_driven || asked);
        let Some(Before { pose, output: before, .. }) = before else { return true };
        let has = |flag| output.flags.contains(flag) || before.flags.contains(flag);
        let in_one = |flag| output.flags.contains(flag) != before.flags.contains(flag);
        let moves =
            poses.first() != pose.as_ref() || has(Flags::MOTION_CLAMPED) || has(Flags::BAD_SAMPLE);
        let tool = self.is_driven || output.contacts > 0 && before.contacts > 0 && moves;
        tool || in_one(Flags::BAND_CLOSED)
    }

    /// Largest force of the held cells \[N\]; that of a late tick is an earlier one's.
    pub fn force_bound_n(&self, model: &Model<'_>, last: &Stored, output: &TickOutput) -> f64 {
        if output.flags.contains(Flags::LATE) {
            return f64::INFINITY;
        }
        // Forces of shapes follow from the rotations and shapes that the kernel keeps, with which the
        // energy is higher, up to the level.
        let level_j = if model.is_nodal() { f64::from(output.energy_j) } else { 0.0 };
        let stored_j = last.energy_j.max(level_j) + last.allowance_j;
        let stored = stored_j / f64::from(model.energy_unit_j());
        f64::from(model.force_unit_n()) * ((self.weight * stored).sqrt() + last.force_allowance)
    }
}

impl Tools {
    /// Whether anything acted from outside, tools that are engaged included; and the level before where
    /// they are and have stayed.
    pub fn act(
        &mut self,
        radius_min: f64,
        before: Option<&Before>,
        output: &TickOutput,
        proxies: &[Option<ProxyPose>],
        positions: &[[f64; 3]],
    ) -> (bool, Option<f64>) {
        let is_full = output.flags.contains(Flags::CONTACT_CAPACITY);
        let engaged = proxies.iter().any(Option::is_some);
        let Some(before) = before else {
            (self.is_full, self.misses) = (is_full, engaged);
            self.missing += u64::from(engaged);
            return (engaged, None);
        };
        let moved = before.proxies != proxies;
        let turn = |proxy: &Option<ProxyPose>| proxy.map(|proxy| proxy.orientation);
        let swings =
            self.is_endless && before.proxies.iter().zip(proxies).any(|(a, b)| turn(a) != turn(b));
        let comes = farthest(&before.positions, positions) >= COMING * radius_min;
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
        (engaged || was_engaged, stays.then_some(before.output.energy_j.into()))
    }

    /// The force of a tool that is nearest to its bound, and that bound \[N\].
    pub fn nearest(
        &self,
        engine: &mut Engine<'_>,
        exact: &ExactContact<'_>,
        (proxies, allowance_j): (&[Option<ProxyPose>], f64),
        output: &TickOutput,
    ) -> ([f64; 3], f64) {
        let is_late = output.flags.contains(Flags::LATE);
        let level_j = f64::from(output.energy_j) + allowance_j;
        let (mut nearest, mut part) = (([0.0; 3], 0.0), 0.0);
        for (tool, proxy) in proxies.iter().enumerate() {
            let of_tool = engine.tool_output(tool);
            let met = exact.met(tool, proxy.as_ref(), &engine.contact_positions(tool));
            let force_n: [f64; 3] = of_tool.force_n.cast::<f64>().into();
            let stiffness = f64::from(of_tool.stiffness_n_per_m);
            let bound_n = match (is_late || self.misses, self.has_friction || self.grips) {
                (true, _) => f64::INFINITY,
                (_, true) => (4.0 * stiffness * level_j).sqrt(),
                _ => {
                    (2.0 * met.stiffness_n_per_m * (met.energy_j + allowance_j).min(level_j)).sqrt()
                }
            };
            let length_n = norm(force_n);
            let own = if length_n > 0.0 { length_n / bound_n } else { 0.0 };
            // A number that is none is shown too.
            if own.partial_cmp(&part).is_none_or(std::cmp::Ordering::is_ge) {
                (nearest, part) = ((force_n, bound_n), own);
            }
        }
        nearest
    }
}

/// Weight of the links between the cells `held` (ascending) and others; of nodal shapes, twice what
/// the bound of the curvature gives a common move of them.
pub fn outer_weight(model: &Model<'_>, held: &[u16]) -> f64 {
    let is_held = |cell: usize| held.binary_search(&(cell as u16)).is_ok();
    if model.is_nodal() {
        let mut sum = 0.0;
        for &cell in held {
            model.each_of_bound_row(cell.into(), |other, element| {
                sum += if is_held(other) { 2.0 * f64::from(element) } else { 0.0 };
            });
        }
        return sum;
    }
    let outer = held.iter().flat_map(|&cell| model.neighbours(cell.into()));
    outer
        .filter(|&(_, other)| !is_held(other))
        .map(|(link, _)| f64::from(model.link_weight(link)))
        .sum()
}
