//! Where the server of a scene records: attributes of a service that has no ports.

use std::ffi::OsString;
use std::fmt::Debug;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};

use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::event::EventCreateError;
use iceoryx2::service::port_factory::event;

use crate::error::{Error, Kind, Result};
use crate::names::{Ipc, SceneNames, recorded_scene};
use crate::services::{CLEAR_UP_LIMIT, Domain, SceneServices, service_error};

/// Keys of the attributes, each a part of the path in hexadecimal: iceoryx2 takes ASCII alone.
const KEYS: [&str; 8] =
    ["trace0", "trace1", "trace2", "trace3", "trace4", "trace5", "trace6", "trace7"];
/// Bytes of the path in one attribute, and in all.
const PART_BYTES: usize = 128;
const PATH_BYTES_MAX: usize = KEYS.len() * PART_BYTES;

/// A trace is shown while this lives.
///
/// ```
/// use chaincell_client::names::unique_scene;
/// use chaincell_client::recording;
/// use chaincell_client::services::{Domain, SceneServices};
///
/// let (name, domain) = (unique_scene("recorded"), Domain::default());
/// let scene = SceneServices::open(Some(&name), &domain)?;
/// let trace = std::env::current_exe()?.canonicalize()?; // stands for a trace
/// let shown = recording::show(&scene, &trace)?;
/// assert_eq!(recording::of(Some(&name), &domain)?, Some(trace.clone()));
/// assert_eq!(recording::scene_of(&trace, &domain)?, Some(Some(name)));
/// drop(shown);
/// assert_eq!(recording::scene_of(&trace, &domain)?, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Shown {
    _service: event::PortFactory<Ipc>,
}

/// Shows other processes the trace that the server of a scene writes.
///
/// # Errors
/// A path of more than 1,024 bytes; a trace that is not there; a service that cannot be made.
pub fn show(scene: &SceneServices, trace: &Path) -> Result<Shown> {
    let (name, attributes) = (scene.recording_name, attributes(trace)?);
    scene.further(move |node| {
        let create = || node.service_builder(&name).event().create_with_attributes(&attributes);
        // That of a killed server, whose place this one takes, is still there.
        let created = create().or_else(|why| match why {
            EventCreateError::AlreadyExists => {
                node.blocking_cleanup_dead_nodes(CLEAR_UP_LIMIT);
                create()
            }
            why => Err(why),
        });
        created.map(|service| Shown { _service: service }).map_err(|why| service_error(&name, why))
    })
}

/// The attributes that show a trace.
fn attributes(trace: &Path) -> Result<AttributeSpecifier> {
    let path = std::fs::canonicalize(trace).map_err(|why| Error::file("look at", trace, why))?;
    let bytes = path.as_os_str().as_bytes();
    if bytes.len() > PATH_BYTES_MAX {
        let text = format!("{}: a path of more than {PATH_BYTES_MAX} bytes", path.display());
        return Err(Error::new(Kind::Argument, text));
    }
    let failed =
        |why: &dyn Debug| Error::new(Kind::Service, format!("{}: {why:?}", path.display()));
    let mut all = AttributeSpecifier::new();
    for (key, part) in KEYS.iter().zip(bytes.chunks(PART_BYTES)) {
        let digits: String = part.iter().map(|byte| format!("{byte:02x}")).collect();
        let key = AttributeKey::new(key.as_bytes()).map_err(|why| failed(&why))?;
        let value = AttributeValue::new(digits.as_bytes()).map_err(|why| failed(&why))?;
        all = all.define(&key, &value).map_err(|why| failed(&why))?;
    }
    Ok(all)
}

/// The trace that the server of this scene writes, if it records. That of a killed server may be found until a program
/// opens a scene, which clears up after it.
///
/// # Errors
/// A scene name that is none; files of another user.
///
/// ```
/// use chaincell_client::recording;
/// use chaincell_client::services::Domain;
///
/// let trace = recording::of(Some("nobody-serves-it"), &Domain::default())?;
/// assert_eq!(trace, None);
/// # Ok::<(), chaincell_client::Error>(())
/// ```
pub fn of(scene: Option<&str>, domain: &Domain) -> Result<Option<PathBuf>> {
    let (name, config) = (SceneNames::new(scene)?.recording, looked_at(domain)?);
    let details = Ipc::details(&name, &config, MessagingPattern::Event);
    let details = details.map_err(|why| service_error(&name, why))?;
    Ok(details.and_then(|details| shown(&details)))
}

/// The scene whose server writes a trace, `Some(None)` for the unnamed one; `None` if no server writes it.
///
/// # Errors
/// Files of another user.
pub fn scene_of(trace: &Path, domain: &Domain) -> Result<Option<Option<String>>> {
    let config = looked_at(domain)?;
    let Ok(trace) = std::fs::canonicalize(trace) else { return Ok(None) };
    let mut found = None;
    let listed = Ipc::list(&config, |details| {
        let name = details.static_details.name().as_str();
        if let Some(scene) = recorded_scene(name)
            && shown(&details).as_ref() == Some(&trace)
        {
            found = Some(scene);
            return CallbackProgression::Stop;
        }
        CallbackProgression::Continue
    });
    let failed = |why| Error::new(Kind::Service, format!("cannot list the services: {why:?}"));
    listed.map_err(failed).map(|()| found)
}

/// The configuration of a domain that is looked at, with iceoryx2's log silent unless asked for.
fn looked_at(domain: &Domain) -> Result<Config> {
    set_log_level_from_env_or(LogLevel::Fatal);
    domain.config()
}

/// The trace that a service shows.
fn shown(details: &ServiceDetails<Ipc>) -> Option<PathBuf> {
    let attributes = details.static_details.attributes();
    let mut path = Vec::new();
    for key in KEYS {
        let key = AttributeKey::new(key.as_bytes()).ok()?;
        let Some(part) = attributes.key_value(&key, 0) else { break };
        let digits = str::from_utf8(part.as_bytes()).ok()?;
        for at in (0..digits.len()).step_by(2) {
            path.push(u8::from_str_radix(digits.get(at..at + 2)?, 16).ok()?);
        }
    }
    (!path.is_empty()).then(|| PathBuf::from(OsString::from_vec(path)))
}
