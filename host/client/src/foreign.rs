//! Finds services that exist with messages of another type, by the type's name and size.

use std::mem::size_of;

use iceoryx2::prelude::{Config, ServiceName};
use iceoryx2::service::Service as _;
use iceoryx2::service::messaging_pattern::MessagingPattern;
use iceoryx2::service::static_config::message_type_details::TypeDetail;
use iceoryx2::service::static_config::messaging_pattern::MessagingPattern as Found;

use crate::error::{Error, Kind};
use crate::names::Ipc;

/// Returns the refusal of a publish-subscribe service whose messages are of another type than
/// `Payload`, whose name is `type_name`. `None` if they are of that type, or if there is no service.
pub(crate) fn refusal<Payload>(
    config: &Config,
    name: &ServiceName,
    type_name: &str,
) -> Option<Error> {
    let details = Ipc::details(name, config, MessagingPattern::PublishSubscribe);
    let details = details.ok().flatten()?;
    let Found::PublishSubscribe(found) = details.static_details.messaging_pattern() else {
        return None;
    };
    differs::<Payload>(name, &found.message_type_details().payload, type_name)
}

/// As [`refusal`], of a request-response service by the type of its requests.
pub(crate) fn request_refusal<Request>(
    config: &Config,
    name: &ServiceName,
    type_name: &str,
) -> Option<Error> {
    let details = Ipc::details(name, config, MessagingPattern::RequestResponse);
    let details = details.ok().flatten()?;
    let Found::RequestResponse(found) = details.static_details.messaging_pattern() else {
        return None;
    };
    differs::<Request>(name, &found.request_message_type_details().payload, type_name)
}

/// Returns the refusal if the type that was found differs by its name or size.
fn differs<Payload>(name: &ServiceName, found: &TypeDetail, type_name: &str) -> Option<Error> {
    let (theirs, bytes) = (found.type_name().to_string(), found.size());
    if theirs == type_name && bytes == size_of::<Payload>() {
        return None;
    }
    Some(Error::new(
        Kind::Version,
        format!(
            "service {name} carries {theirs} of {bytes} bytes, and this release speaks {type_name} of \
         {} bytes: a program of another release or make holds it; end it, or take another scene \
         with `scene` NAME",
            size_of::<Payload>()
        ),
    ))
}
