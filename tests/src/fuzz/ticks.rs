//! A whole session: any body, scheme, number type, contact and settings, then samples, commands,
//! other settings and other states in any order.

use arbitrary::{Result, Unstructured};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::{Budget, Choice, Drive, Model, Network, Settings, ToolPose, Unloading};
use chaincell_lab::monitor::Monitor;

use super::twins::Twins;
use super::{bodies, tick};
use crate::graph::sample;

/// Most ticks of a session, and most sweeps of a tick.
const TICKS_MAX: usize = 80;
const SWEEPS_MAX: u16 = 6;

/// A session; what the bytes leave open is zero.
pub fn ticks(data: &[u8]) {
    // Bytes that end early end the session.
    let _ = session(&mut Unstructured::new(data));
}

fn session(bytes: &mut Unstructured<'_>) -> Result<()> {
    let model = bodies::model(bytes.arbitrary()?);
    let scheme = *bytes.choose(Scheme::ALL)?;
    let numbers = *bytes.choose(&[Arithmetic::F32, Arithmetic::Fixed])?;
    let contact = contact(bytes, &model)?;
    let settings = settings(bytes, &model, scheme)?;
    let Ok(network) = Network::new(model, settings) else { return Ok(()) };
    let new = || Engine::with_contact(network, scheme, numbers, contact.clone());
    let (Ok(engine), Ok(twin)) = (new(), new()) else { return Ok(()) };
    let mut session = Session {
        monitor: Monitor::new(&engine, numbers),
        twins: Twins::new(engine, twin, bytes)?,
        tool: sample(model.centre_m(), 0),
        left: TICKS_MAX,
    };
    while !bytes.is_empty() && session.left > 0 {
        session.step(bytes)?;
    }
    Ok(())
}

fn contact(bytes: &mut Unstructured<'_>, model: &Model<'_>) -> Result<Contact> {
    let count = bytes.int_in_range(1..=3)?;
    Ok(Contact::Cells(bodies::free_cells(model, bytes.arbitrary()?, count)))
}

/// Near the defaults or of any bits.
fn settings(bytes: &mut Unstructured<'_>, model: &Model<'_>, scheme: Scheme) -> Result<Settings> {
    let mut settings = scheme.settings(model, bytes.int_in_range(1..=SWEEPS_MAX)?);
    settings.unloading =
        *bytes.choose(&[Unloading::Release, Unloading::Off, Unloading::Retreat])?;
    settings.drive = *bytes.choose(&[Drive::Position, Drive::Current])?;
    let wild = bytes.arbitrary::<u8>()?;
    for (bit, place) in [
        (1, &mut settings.step),
        (2, &mut settings.tick_time),
        (4, &mut settings.max_tool_step_m),
        (8, &mut settings.max_force_n),
    ] {
        if wild & bit != 0 {
            *place = f32::from_bits(bytes.arbitrary()?);
        }
    }
    if wild & 16 != 0 {
        settings.step = model.step_max();
    }
    Ok(settings)
}

struct Session<'m> {
    twins: Twins<'m>,
    monitor: Monitor<'m>,
    tool: ToolPose,
    left: usize,
}

impl Session<'_> {
    fn step(&mut self, bytes: &mut Unstructured<'_>) -> Result<()> {
        match bytes.int_in_range(0..=7)? {
            0 => {
                let position_m = <[u32; 3]>::map(bytes.arbitrary()?, f32::from_bits);
                self.tick(sample(position_m, bytes.arbitrary()?), 1);
            }
            1 | 2 => {
                let unit_m = self.twins.engine.network().model().unit_m() / 16.0;
                let centre = self.twins.engine.network().model().centre_m();
                let way = bytes.arbitrary::<[i8; 3]>()?;
                let at = |axis: usize| centre[axis] + unit_m * f32::from(way[axis]);
                self.tick(sample([0, 1, 2].map(at), 1), 1);
            }
            3 => self.tick(ToolPose { engaged: 0, ..self.tool }, 1),
            4 => self.tick(self.tool, bytes.int_in_range(1..=12)?),
            5 => {
                if self.twins.command(bytes.arbitrary()?, SWEEPS_MAX) {
                    self.monitor.interfere();
                }
            }
            6 => self.other_settings(bytes)?,
            _ => {
                self.twins.displace(bytes, 3)?;
                self.monitor.interfere();
            }
        }
        Ok(())
    }

    fn tick(&mut self, tool: ToolPose, times: usize) {
        self.tool = tool;
        for _ in 0..times.min(self.left) {
            self.left -= 1;
            // Some ticks end early, and some are late.
            let sweeps = [None, None, Some(0), None, Some(1), Some(0), Some(2)][self.left % 7];
            let output = tick(&mut self.monitor, &mut self.twins.engine, &[tool], sweeps);
            if let Some(twin) = &mut self.twins.twin {
                assert_eq!(twin.tick_by(&[tool], Budget::again(sweeps)), output);
                assert_eq!(twin.state_hash(), self.twins.engine.state_hash());
            }
        }
    }

    /// Other settings from the next tick on, without the scheme's own rates.
    fn other_settings(&mut self, bytes: &mut Unstructured<'_>) -> Result<()> {
        let now = *self.twins.engine.network().settings();
        let model = *self.twins.engine.network().model();
        let other = settings(bytes, &model, Scheme::Track)?;
        let (step, tick_time, sweeps) = (now.step, now.tick_time, now.sweeps);
        self.monitor.interfere();
        self.twins.both(|engine| {
            let _ = engine.choose(Settings { step, tick_time, sweeps, ..other });
        });
        Ok(())
    }
}
