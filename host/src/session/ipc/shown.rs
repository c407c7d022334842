//! The ports of a program that shows a session of another place on a scene: viewers find states, contacts and
//! poses. It answers no pose and sends no force.

use chaincell_kernel::ToolPose;
use iceoryx2::port::publisher::Publisher;

use super::contacts::{ContactPublisher, ContactsHeader};
use super::payload::StateHeader;
use super::services::{Ipc, SHOW_PORT, SceneServices};
use super::serving::SERVE_PORT;
use super::state::StatePublisher;
use super::stress::{StressHeader, StressPublisher};
use super::surface::SurfacePublisher;
use super::tools::ToolPoses;
use crate::engine::Engine;
use crate::engine::tissue::TissueEngine;
use crate::error::Result;

/// Publishers of the data that viewers of a session read.
#[derive(Debug)]
pub struct ShowPorts {
    state: Option<StatePublisher>,
    stress: Option<StressPublisher>,
    surface: Option<SurfacePublisher>,
    contacts: Option<ContactPublisher>,
    /// Holds the scene too: no server begins on it.
    poses: Publisher<Ipc, ToolPoses, ()>,
}

impl ShowPorts {
    /// Opens the ports for the states, stresses, surfaces and contacts of a tissue, sent at most `hz` times a second,
    /// 0 for never.
    ///
    /// # Errors
    /// A server or another follower on the scene; a rate out of range; too little memory.
    pub fn open(scene: &SceneServices, engine: &mut Engine<'_>, hz: u32) -> Result<Self> {
        scene.refuse_second(&scene.forces, SERVE_PORT, None, "serve")?;
        scene.refuse_second(&scene.tools, SHOW_PORT, None, "follow")?;
        let poses = scene.publisher(&scene.tools, SHOW_PORT, "follow")?;
        let id = poses.id();
        let nodes = engine.node_count();
        let state = (hz > 0).then(|| StatePublisher::open(scene, nodes, hz)).transpose()?;
        let stressed = engine.stressed_cells().filter(|_| hz > 0);
        let stress =
            stressed.map(|cells| StressPublisher::open(scene, (nodes, cells), hz)).transpose()?;
        let surface = engine.surface_rows().filter(|_| hz > 0);
        let surface = surface.map(|most| SurfacePublisher::open(scene, most, hz)).transpose()?;
        let with_contacts = hz > 0 && engine.contact().tools() > 0;
        let contacts = with_contacts.then(|| ContactPublisher::open(scene, hz)).transpose()?;
        // Two that started at the same time see each other now.
        scene.refuse_second(&scene.tools, SHOW_PORT, Some(id), "follow")?;
        scene.refuse_second(&scene.forces, SERVE_PORT, None, "serve")?;
        scene.take_memory()?;
        Ok(Self { state, stress, surface, contacts, poses })
    }

    /// Notes that the tissue has changed.
    pub fn changed(&mut self) {
        if let Some(state) = &mut self.state {
            state.feed.changed();
        }
        if let Some(stress) = &mut self.stress {
            stress.changed();
        }
        if let Some(surface) = &mut self.surface {
            surface.feed.changed();
        }
        if let Some(contacts) = &mut self.contacts {
            contacts.feed.changed();
        }
    }

    /// Sends what is due: the poses of the tick, its state, its contacts; and the stresses, after some calls.
    pub fn show(
        &mut self,
        now_ns: u64,
        header: StateHeader,
        poses: &[ToolPose],
        tissue: &mut dyn TissueEngine,
    ) {
        let StateHeader { tick, ticks_answered, flags, .. } = header;
        // The state, and of a body that can be cut the surface.
        let Self { state, surface, .. } = self;
        let has_state = state.as_mut().is_some_and(|state| state.feed.is_due(now_ns, true));
        let has_surface = surface.as_mut().is_some_and(|of| of.feed.is_due(now_ns, true));
        if has_state || has_surface {
            // A viewer looks for the poses of a state when it has come. One that misses them shows no tool.
            let _ = self.poses.send_copy(ToolPoses::of(tick, 0, poses));
            let header = StateHeader { state_hash: tissue.state_hash(), ..header };
            if let Some(state) = state.as_mut().filter(|_| has_state) {
                state.send(header, tissue);
            }
            if let Some(surface) = surface.as_mut().filter(|_| has_surface) {
                surface.send(header, tissue);
            }
        }
        if let Some(stress) = &mut self.stress {
            let model_checksum = tissue.model_checksum();
            let header = StressHeader { tick, model_checksum, ..StressHeader::default() };
            // No limit is watched here, so there is no warning.
            let _ = stress.step(header, tissue, true);
        }
        if let Some(contacts) = &mut self.contacts
            && contacts.feed.is_due(now_ns, true)
        {
            contacts.send(ContactsHeader { tick, ticks_answered, contacts: 0, flags }, tissue);
        }
    }
}
