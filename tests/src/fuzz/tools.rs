//! A whole session of tools on a contact surface: any tools and settings, then poses, grips, late ticks,
//! commands and other states in any order.

use arbitrary::{Result, Unstructured};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::Budget;
use chaincell_kernel::{Model, Network, Settings, ToolPart, ToolPose, Unloading};
use chaincell_lab::monitor::Monitor;

use super::bodies::tissue;
use super::tick;
use super::twins::Twins;

/// Most ticks of a session, and most sweeps of a tick.
const TICKS_MAX: usize = 60;
const SWEEPS_MAX: u16 = 4;
/// Sweeps that ticks make, in turn: some end early, some late, some are late.
const SWEEPS: [Option<u16>; 9] =
    [None, None, Some(0), None, Some(1), Some(0), Some(2), None, Some(u16::MAX)];

/// A session; what the bytes leave open is zero.
pub fn tools(data: &[u8]) {
    // Bytes that end early end the session.
    let _ = session(&mut Unstructured::new(data));
}

fn session(bytes: &mut Unstructured<'_>) -> Result<()> {
    let model = tissue(bytes.arbitrary()?);
    let scheme = *bytes.choose(&[Scheme::Predict, Scheme::Track])?;
    let friction = *bytes.choose(&[0.0, 0.3, 10.0, f32::NAN])?;
    let settings = settings(bytes, &model, scheme)?;
    let mut tools = Vec::new();
    for _ in 0..bytes.int_in_range(1..=3)? {
        let parts = bytes.int_in_range(1..=3)?;
        let mut parts = (0..parts).map(|_| part(bytes, &model)).collect::<Result<Vec<_>>>()?;
        if model.tetrahedra_to_cut() > 0 {
            parts.extend(edge(bytes, &model)?);
        }
        tools.push(parts);
    }
    let Ok(network) = Network::new(model, settings) else { return Ok(()) };
    let contact = Contact::Tools { tools: tools.clone(), friction };
    let new = || Engine::with_contact(network, scheme, Arithmetic::F32, contact.clone());
    let (Ok(engine), Ok(twin)) = (new(), new()) else { return Ok(()) };
    let monitor = Monitor::new(&engine, Arithmetic::F32);
    let (twins, left) = (Twins::new(engine, twin, bytes)?, TICKS_MAX);
    let poses = vec![ToolPose::at(model.centre_m().into(), 0); tools.len()];
    let is_endless = tools.iter().flatten().any(ToolPart::is_half_space);
    let mut session = Session { twins, monitor, poses, is_endless, left };
    while !bytes.is_empty() && session.left > 0 {
        session.step(bytes)?;
    }
    Ok(())
}

/// Near the defaults or of any bits.
fn settings(bytes: &mut Unstructured<'_>, model: &Model<'_>, scheme: Scheme) -> Result<Settings> {
    let mut settings = scheme.settings(model, bytes.int_in_range(1..=SWEEPS_MAX)?);
    settings.unloading =
        *bytes.choose(&[Unloading::Off, Unloading::Release, Unloading::Retreat])?;
    settings.max_tool_step_m = 1e3 * model.unit_m();
    let wild = bytes.arbitrary::<u8>()?;
    for (bit, place) in [(1, &mut settings.max_tool_step_m), (2, &mut settings.max_force_n)] {
        if wild & bit != 0 {
            *place = f32::from_bits(bytes.arbitrary()?);
        }
    }
    Ok(settings)
}

/// Of any kind, from a tenth of an edge to many of them, or of any bits.
fn part(bytes: &mut Unstructured<'_>, model: &Model<'_>) -> Result<ToolPart> {
    let unit_m = model.unit_m();
    let [kind, radius, x, y, z] = bytes.arbitrary::<[u8; 5]>()?;
    let radius_m = unit_m * (0.1 + f32::from(radius) * f32::from(radius) / 8192.0);
    let half_m = [x, y, z].map(|half| unit_m * f32::from(half) / 64.0);
    let mut part = match kind % 8 {
        0..=2 => ToolPart::sphere(radius_m),
        3 | 4 => ToolPart::capsule(half_m[2], radius_m),
        5 => ToolPart::half_space(radius_m),
        _ => ToolPart::rounded_box(half_m, radius_m),
    };
    if kind & 8 != 0 {
        part.centre_m = bytes.arbitrary::<[i8; 3]>()?.map(|way| unit_m * f32::from(way) / 64.0);
        part.orientation = orientation(bytes)?;
    }
    if kind & 240 == 240 {
        let [a, b, c, d] = <[u32; 4]>::map(bytes.arbitrary()?, f32::from_bits);
        (part.half_m, part.radius_m) = ([a, b, c], d);
    }
    Ok(part)
}

/// The edge of a blade, scissors, or neither.
fn edge(bytes: &mut Unstructured<'_>, model: &Model<'_>) -> Result<Option<ToolPart>> {
    let [kind, length] = bytes.arbitrary::<[u8; 2]>()?;
    let length_m = model.unit_m() * (0.1 + f32::from(length) / 64.0);
    Ok(match kind % 4 {
        0 | 1 => Some(ToolPart::edge(length_m)),
        2 => Some(ToolPart::scissors(length_m, 0.1 * length_m, 0.5 * length_m)),
        _ => None,
    })
}

/// Nearly a unit quaternion, or none.
fn orientation(bytes: &mut Unstructured<'_>) -> Result<[f32; 4]> {
    Ok(bytes.arbitrary::<[i8; 4]>()?.map(|x| f32::from(x) / 64.0))
}

struct Session<'m> {
    twins: Twins<'m>,
    monitor: Monitor<'m>,
    poses: Vec<ToolPose>,
    is_endless: bool,
    left: usize,
}

impl Session<'_> {
    fn step(&mut self, bytes: &mut Unstructured<'_>) -> Result<()> {
        match bytes.int_in_range(0..=9)? {
            0 => {
                let is_endless = self.is_endless;
                let pose = self.pose(bytes)?;
                let [a, b, c, d] = <[u32; 4]>::map(bytes.arbitrary()?, f32::from_bits);
                pose.position_m = [a, b, c].into();
                pose.orientation[3] = if is_endless { pose.orientation[3] } else { d };
                pose.engaged = bytes.arbitrary()?;
                self.tick(1);
            }
            1..=3 => {
                let model = *self.twins.engine.network().model();
                let (unit_m, centre_m) = (model.unit_m() / 24.0, model.centre_m());
                let is_endless = self.is_endless;
                let pose = self.pose(bytes)?;
                let way = bytes.arbitrary::<[i8; 3]>()?;
                let at = |axis: usize| centre_m[axis] + unit_m * f32::from(way[axis]);
                (pose.position_m, pose.engaged) = ([0, 1, 2].map(at).into(), 1);
                // Scissors open and close along the way.
                pose.opening_turns_q16 = u16::from(way[0].unsigned_abs()) << 6;
                // A half space that turns meets triangles that no search has seen.
                if bytes.arbitrary()? && !is_endless {
                    pose.orientation = orientation(bytes)?;
                }
                self.tick(bytes.int_in_range(1..=4)?);
            }
            4 => {
                self.pose(bytes)?.engaged = 0;
                self.tick(1);
            }
            5 => self.tick(bytes.int_in_range(1..=12)?),
            6 => self.grip(bytes.arbitrary::<u8>()?.into()),
            7 => {
                let (tool, ticks) = bytes.arbitrary::<(u8, u8)>()?;
                let (tool, ticks) = (usize::from(tool % 4), u16::from(ticks % 32));
                self.twins.both(|engine| engine.let_go(tool, ticks));
            }
            8 => {
                if self.twins.command(bytes.arbitrary()?, SWEEPS_MAX) {
                    self.monitor.interfere();
                }
            }
            _ => {
                self.twins.displace(bytes, 2)?;
                self.monitor.interfere();
            }
        }
        Ok(())
    }

    /// The pose of one of the tools; a tool beyond the poses has one again.
    fn pose(&mut self, bytes: &mut Unstructured<'_>) -> Result<&mut ToolPose> {
        let tool = usize::from(bytes.arbitrary::<u8>()?) % self.poses.len();
        Ok(&mut self.poses[tool])
    }

    fn tick(&mut self, times: usize) {
        for _ in 0..times.min(self.left) {
            self.left -= 1;
            let sweeps = SWEEPS[self.left % SWEEPS.len()];
            // Now and then the last tool has no pose.
            let given = self.poses.len() - usize::from(self.left % 11 == 3);
            let poses = self.poses.get(..given).unwrap_or_default();
            let output = tick(&mut self.monitor, &mut self.twins.engine, poses, sweeps);
            if let Some(twin) = &mut self.twins.twin {
                assert_eq!(twin.tick_by(poses, Budget::again(sweeps)), output);
                assert_eq!(twin.state_hash(), self.twins.engine.state_hash());
                for tool in 0..self.poses.len() {
                    assert_eq!(twin.tool_output(tool), self.twins.engine.tool_output(tool));
                }
            }
        }
    }

    fn grip(&mut self, tool: usize) {
        let held = self.monitor.grip(&mut self.twins.engine, tool % 4);
        if let Some(twin) = &mut self.twins.twin {
            assert_eq!(twin.grip(tool % 4), held);
        }
    }
}
