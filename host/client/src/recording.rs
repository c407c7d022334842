//! Where the server of a scene records: an attribute of a service that has no ports.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::event::EventCreateError;
use iceoryx2::service::port_factory::event;

use crate::error::{Error, Kind, Result};
use crate::names::{Ipc, SceneNames, recorded_scene};
use crate::services::{CLEAR_UP_LIMIT, Domain, SceneServices, service_error};

/// Key of the attribute.
const KEY: &str = "trace";
/// Longest path of a trace \[bytes\].
const PATH_BYTES_MAX: usize = 256;

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
/// A path of more than 256 bytes; a service that cannot be made.
pub fn show(scene: &SceneServices, trace: &Path) -> Result<Shown> {
    let name = scene.recording_name;
    let failed = |why: &dyn std::fmt::Debug| Error::new(Kind::Service, format!("{name}: {why:?}"));
    let path = std::fs::canonicalize(trace).map_err(|why| failed(&why))?;
    let bytes = path.as_os_str().as_bytes();
    if bytes.len() > PATH_BYTES_MAX {
        let text = format!("{}: a path of more than {PATH_BYTES_MAX} bytes", path.display());
        return Err(Error::new(Kind::Service, text));
    }
    let value = AttributeValue::new(bytes).map_err(|why| failed(&why))?;
    let key = AttributeKey::new(KEY.as_bytes()).map_err(|why| failed(&why))?;
    scene.further(move |node| {
        let attributes = AttributeSpecifier::new().define(&key, &value);
        let attributes = attributes.map_err(|why| Error::new(Kind::Service, format!("{why}")))?;
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

/// The trace that the server of this scene writes, if it records. A killed server's may still be found.
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
    set_log_level_from_env_or(LogLevel::Fatal);
    let name = SceneNames::new(scene)?.recording;
    let details = Ipc::details(&name, &domain.config()?, MessagingPattern::Event);
    let details = details.map_err(|why| service_error(&name, why))?;
    Ok(details.and_then(|details| shown(&details)))
}

/// The scene whose server writes a trace, `Some(None)` for the unnamed one; `None` if no server writes it.
///
/// # Errors
/// Files of another user.
pub fn scene_of(trace: &Path, domain: &Domain) -> Result<Option<Option<String>>> {
    set_log_level_from_env_or(LogLevel::Fatal);
    let Ok(trace) = std::fs::canonicalize(trace) else { return Ok(None) };
    let mut found = None;
    let listed = Ipc::list(&domain.config()?, |details| {
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

/// The trace that a service shows.
fn shown(details: &ServiceDetails<Ipc>) -> Option<PathBuf> {
    let key = AttributeKey::new(KEY.as_bytes()).ok()?;
    let value = details.static_details.attributes().key_value(&key, 0)?;
    Some(PathBuf::from(OsStr::from_bytes(value.as_bytes())))
}
