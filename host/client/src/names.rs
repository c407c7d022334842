//! Scene names and the service names made of them.

use std::time::{SystemTime, UNIX_EPOCH};

use iceoryx2::prelude::{ServiceName, ipc_threadsafe};

use crate::error::{Error, Kind, Result};

/// Processes communicate in shared memory; two threads of a process may use a port.
pub type Ipc = ipc_threadsafe::Service;

/// Longest scene name \[bytes\].
pub const SCENE_BYTES_MAX: usize = 64;

/// The last parts of service names, which can't name a scene.
const RESERVED: [&str; 8] =
    ["state", "stress", "surface", "contacts", "command", "recording", "tools", "forces"];

/// The services of one scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneNames {
    /// Poses from the controller to the tissue, and the event that announces them.
    pub tools: ServiceName,
    /// Answers from the tissue to the controller, and the event that announces them.
    pub forces: ServiceName,
    /// States for viewers.
    pub state: ServiceName,
    /// Strain and stress for viewers.
    pub stress: ServiceName,
    /// The surface of a body that can be cut, for viewers.
    pub surface: ServiceName,
    /// Contacts for viewers.
    pub contacts: ServiceName,
    /// Commands to the tissue's process.
    pub command: ServiceName,
    /// Where the tissue's process records.
    pub recording: ServiceName,
    /// The scene's name in error messages.
    pub label: String,
}

impl SceneNames {
    /// Returns the names of the unnamed scene (`None`) or of a scene that `--scene` names.
    pub fn new(scene: Option<&str>) -> Result<Self> {
        let (prefix, label) = match scene {
            None => ("chaincell".to_owned(), "the unnamed scene".to_owned()),
            Some(name) => {
                check(name)?;
                (format!("chaincell/{name}"), format!("scene {name}"))
            }
        };
        Ok(Self {
            tools: service(&format!("{prefix}/tools"), scene)?,
            forces: service(&format!("{prefix}/forces"), scene)?,
            state: service(&format!("{prefix}/state"), scene)?,
            stress: service(&format!("{prefix}/stress"), scene)?,
            surface: service(&format!("{prefix}/surface"), scene)?,
            contacts: service(&format!("{prefix}/contacts"), scene)?,
            command: service(&format!("{prefix}/command"), scene)?,
            recording: service(&format!("{prefix}/recording"), scene)?,
            label,
        })
    }
}

impl SceneNames {
    /// Returns the names of all services.
    pub(crate) fn services(&self) -> Vec<String> {
        let Self { tools, forces, state, stress, surface, contacts, command, recording, .. } = self;
        let all = [tools, forces, state, stress, surface, contacts, command, recording];
        all.map(|name| name.as_str().to_owned()).into()
    }
}

/// Returns a scene name that no other run on this machine has.
#[must_use]
pub fn unique_scene(what: &str) -> String {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let nanoseconds = since_1970.map_or(0, |span| span.as_nanos());
    format!("{what}-{}-{nanoseconds:x}", std::process::id())
}

/// The scene of a service that shows where it is recorded, `Some(None)` for the unnamed one; `None` for any other
/// service.
pub(crate) fn recorded_scene(service: &str) -> Option<Option<String>> {
    let scene = service.strip_prefix("chaincell")?.strip_suffix("/recording")?;
    if scene.is_empty() {
        Some(None)
    } else {
        scene.strip_prefix('/').map(|name| Some(name.to_owned()))
    }
}

fn check(name: &str) -> Result<()> {
    let fault = if name.is_empty() {
        "is empty"
    } else if name.len() > SCENE_BYTES_MAX {
        "is longer than 64 bytes"
    } else if name.contains(['/', '\\']) {
        "contains a slash"
    } else if RESERVED.contains(&name) {
        "is the name of a service"
    } else if !name.bytes().all(|byte| byte.is_ascii_graphic()) {
        "contains a space, a control character or a letter outside ASCII"
    } else {
        return Ok(());
    };
    Err(refusal(name, fault))
}

fn refusal(name: &str, fault: &str) -> Error {
    let shown: String = name.escape_debug().take(SCENE_BYTES_MAX).collect();
    Error::new(
        Kind::Argument,
        format!(
            "`scene` \"{shown}\" {fault}; give 1 to {SCENE_BYTES_MAX} letters, digits, '-', '_' or \
         '.', for instance `scene` left-hand"
        ),
    )
}

fn service(name: &str, scene: Option<&str>) -> Result<ServiceName> {
    ServiceName::new(name)
        .map_err(|why| refusal(scene.unwrap_or_default(), &format!("is refused ({why})")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn services_carry_the_scene() {
        let unnamed = SceneNames::new(None).unwrap();
        assert_eq!(unnamed.tools.as_str(), "chaincell/tools");
        assert_eq!(unnamed.forces.as_str(), "chaincell/forces");
        let named = SceneNames::new(Some("left-hand")).unwrap();
        assert_eq!(named.tools.as_str(), "chaincell/left-hand/tools");
        assert_eq!(named.forces.as_str(), "chaincell/left-hand/forces");
        assert_eq!(named.state.as_str(), "chaincell/left-hand/state");
        assert_eq!(named.stress.as_str(), "chaincell/left-hand/stress");
        assert_eq!(named.surface.as_str(), "chaincell/left-hand/surface");
        assert_eq!(named.contacts.as_str(), "chaincell/left-hand/contacts");
        assert_eq!(named.command.as_str(), "chaincell/left-hand/command");
        assert!(SceneNames::new(Some(&"x".repeat(SCENE_BYTES_MAX))).is_ok());
    }

    #[test]
    fn unique_names_are_unique_and_valid() {
        let (one, two) = (unique_scene("cosim"), unique_scene("cosim"));
        assert_ne!(one, two);
        assert!(SceneNames::new(Some(&one)).is_ok());
    }

    #[test]
    fn refusals_name_the_option_and_the_remedy() {
        let long = "x".repeat(SCENE_BYTES_MAX + 1);
        let reserved = RESERVED;
        let bad = ["", &long, "a/b", "a\\b", "a\nb", "a b", "käfer"];
        for name in bad.into_iter().chain(reserved) {
            let error = SceneNames::new(Some(name)).unwrap_err();
            assert_eq!(error.kind(), Kind::Argument, "{name:?}");
            let text = error.to_string();
            assert!(text.contains("`scene`") && text.contains("give 1 to 64"), "{text}");
            assert!(!text.contains('\n'), "{text}");
        }
    }
}
