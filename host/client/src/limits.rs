//! Limits of a service, and the errors if it cannot be used, with the remedy.

use std::fmt::Debug;

use iceoryx2::prelude::ServiceName;

use crate::error::{Error, Kind};

/// Messages that a reader may leave unread before the oldest is lost.
pub const QUEUE_MESSAGES: usize = 1024;
/// One program of chaincell, and a free place for a bridge to another machine.
pub const PUBLISHERS_MAX: usize = 2;
/// chaincell's own reader, viewers, recorders, bridges.
pub const SUBSCRIBERS_MAX: usize = 8;
/// Processes that may have a service open.
pub const NODES_MAX: usize = 20;

/// Returns the refusal of a service that cannot be opened.
pub fn service_error(name: &ServiceName, why: impl Debug) -> Error {
    refusal(
        name,
        ("open", why),
        "a program that created it with other limits or types is still running: end it and start chaincell serve first",
    )
}

/// Returns the refusal of a service that cannot be connected to.
pub fn port_error(name: &ServiceName, why: impl Debug) -> Error {
    refusal(name, ("connect to", why), "end programs that use it")
}

fn refusal(name: &ServiceName, (what, why): (&str, impl Debug), remedy: &str) -> Error {
    let why = format!("{why:?}");
    let (kind, text) = if why.contains("ExceedsMax") {
        let text = format!(
            "service {name} has no place left: at most {NODES_MAX} programs, {PUBLISHERS_MAX} of them sending \
             and {SUBSCRIBERS_MAX} reading; end one of them"
        );
        (Kind::Full, text)
    } else {
        (Kind::Service, format!("cannot {what} service {name} ({why}); {remedy}"))
    };
    Error::new(kind, format!("{text}, or take another scene with `scene` NAME"))
}
