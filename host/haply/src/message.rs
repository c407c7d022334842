//! The messages of the service: JSON in both directions.
//!
//! As described on Haply's pages "WebSocket Protocol" and "Control Commands" of version 3.5.x
//! (docs.haply.co/inverseSDK/service/realtime/websocket-protocol and .../control-commands), read in 2026-11:
//!
//! - On connecting the service sends a first message with all devices; from then on exactly one state for each
//!   message that it gets.
//! - A force is `{"inverse3":[{"device_id":ID,"commands":{"set_cursor_force":{"vector":{"x":,"y":,"z":}}}}]}`
//!   \[N\]. Programs for 3.1 to 3.4 on the same port write `values` in place of `vector`
//!   ([`ForceKey::Values`]); no page says which of both an older or newer service takes besides its own.
//! - A position is `inverse3[].state.cursor_position` \[m\], right-handed.
//! - A session names itself once, by `session.configure.profile.name`.
//! - A command counts once: a device whose commands stop "returns to idle". No page says after which time, so
//!   the last message of this program is always one of force zero.
//! - `status.ready` and `status.calibrated` are optional here: where one of them is false, there is no force.

use serde_json::{Value, json};

use crate::doubt::Doubt;

/// Name of the field that holds a force.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ForceKey {
    /// Service 3.5 and newer.
    #[default]
    Vector,
    /// Service 3.1 to 3.4.
    Values,
}

/// Returns the message that names this program.
#[must_use]
pub fn profile() -> Value {
    json!({"configure": {"profile": {"name": "chaincell"}}})
}

/// Returns the message of a force on the hand \[N\].
#[must_use]
pub fn force(device_id: &str, key: ForceKey, force_n: [f32; 3]) -> Value {
    let key = match key {
        ForceKey::Vector => "vector",
        ForceKey::Values => "values",
    };
    let [x, y, z] = force_n;
    let command = json!({key: {"x": x, "y": y, "z": z}});
    json!({"inverse3": [{"device_id": device_id, "commands": {"set_cursor_force": command}}]})
}

/// Returns the ids of the devices in a message, in its order.
///
/// # Errors
/// A text that is no message of the service.
pub fn devices(text: &str) -> Result<Vec<String>, Doubt> {
    let message: Value = serde_json::from_str(text).map_err(|_| Doubt::Malformed)?;
    let listed = message.get("inverse3").and_then(Value::as_array);
    let ids = listed.into_iter().flatten().map(|device| device["device_id"].as_str());
    let ids: Option<Vec<String>> = ids.map(|id| id.map(str::to_owned)).collect();
    if message.is_object() { ids.ok_or(Doubt::Malformed) } else { Err(Doubt::Malformed) }
}

/// Returns the position of a device \[m\].
///
/// ```
/// use chaincell_haply::doubt::Doubt;
/// use chaincell_haply::message::position;
///
/// let state = r#"{"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0,"y":-0.12,"z":0.15}}}]}"#;
/// assert_eq!(position(state, "049D"), Ok([0.0, -0.12, 0.15])); // [m]
/// assert_eq!(position(state, "04BA"), Err(Doubt::NoDevice));
/// ```
///
/// # Errors
/// A text that is no state, a state without the device, or a device that is not ready.
pub fn position(text: &str, device_id: &str) -> Result<[f32; 3], Doubt> {
    let message: Value = serde_json::from_str(text).map_err(|_| Doubt::Malformed)?;
    let listed = message.get("inverse3").and_then(Value::as_array).ok_or(Doubt::Malformed)?;
    let mut of_device = listed.iter().filter(|device| device["device_id"] == device_id);
    let device = of_device.next().ok_or(Doubt::NoDevice)?;
    if of_device.next().is_some() {
        return Err(Doubt::Malformed);
    }
    let status = &device["status"];
    if status["ready"] == false || status["calibrated"] == false {
        return Err(Doubt::NotReady);
    }
    let position_m = &device["state"]["cursor_position"];
    let mut read_m = [0.0; 3];
    for (to, axis) in read_m.iter_mut().zip(["x", "y", "z"]) {
        *to = position_m[axis].as_f64().ok_or(Doubt::Malformed)? as f32;
    }
    Ok(read_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(position: &str) -> String {
        format!(
            r#"{{"inverse3":[{{"device_id":"A","state":{{}}}},
                {{"device_id":"B","state":{{"cursor_position":{position}}},"status":{{"ready":true}}}}]}}"#
        )
    }

    #[test]
    fn what_is_no_state_is_a_doubt() {
        assert_eq!(position(&state(r#"{"x":1e-3,"y":2,"z":-3.5}"#), "B"), Ok([1e-3, 2.0, -3.5]));
        let bad = r#"{} null [0,0,0] {"x":0,"y":0} {"x":0,"y":0,"z":null} {"x":NaN,"y":0,"z":0}
            {"x":1e999,"y":0,"z":0} {"x":"0","y":0,"z":0}"#;
        for bad in bad.split_whitespace() {
            assert_eq!(position(&state(bad), "B"), Err(Doubt::Malformed), "{bad}");
        }
        assert_eq!(position(&state("{}"), "A"), Err(Doubt::Malformed));
        for bad in ["", "{", "[]", "0", r#"{"inverse3":{}}"#, r#"{"verse_grip":[]}"#] {
            assert_eq!(position(bad, "B"), Err(Doubt::Malformed), "{bad}");
        }
        let whole = state(r#"{"x":0.1,"y":0.2,"z":0.3}"#);
        for cut in 0..whole.len() {
            assert_eq!(position(&whole[..cut], "B"), Err(Doubt::Malformed), "{cut}");
        }
        assert_eq!(position(r#"{"inverse3":[]}"#, "B"), Err(Doubt::NoDevice));
        for flag in ["ready", "calibrated"] {
            let text = state(r#"{"x":0,"y":0,"z":0}"#)
                .replace(r#""ready":true"#, &format!(r#""{flag}":false"#));
            assert_eq!(position(&text, "B"), Err(Doubt::NotReady), "{flag}");
        }
    }

    #[test]
    fn devices_are_listed_in_order() {
        assert_eq!(devices(&state("{}")), Ok(vec!["A".to_owned(), "B".to_owned()]));
        assert_eq!(devices(r#"{"session_id":7}"#), Ok(Vec::new()));
        for bad in ["", "[]", r#"{"inverse3":[{}]}"#, r#"{"inverse3":[{"device_id":7}]}"#] {
            assert_eq!(devices(bad), Err(Doubt::Malformed), "{bad}");
        }
    }

    #[test]
    fn both_keys_are_written() {
        let message = force("A", ForceKey::Values, [1.0, 2.0, 3.0]);
        let command = &message["inverse3"][0]["commands"]["set_cursor_force"];
        assert_eq!(command, &json!({"values": {"x": 1.0, "y": 2.0, "z": 3.0}}));
    }
}
