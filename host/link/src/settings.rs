//! Configurations of zenoh that reach nothing but what they name.
//!
//! Discovery by multicast and gossip is off, a link that is silent for two seconds is closed and opened again. A
//! file in zenoh's own format is laid over that: it may turn on discovery, name certificates, limit access.

use std::net::IpAddr;
use std::path::{Path, PathBuf};

use chaincell_host::error::{Error, Result};
use serde_json::{Value, json};
use zenoh::{Config, Session, Wait};

/// Endpoint of a sender, and of a receiver that is told no other one.
pub const ENDPOINT: &str = "tcp/127.0.0.1:7447";
/// Silence after which a link counts as cut \[ms\].
const LEASE_MS: u32 = 2000;
/// Longest wait for a connection, after which the next attempt begins \[ms\]. The system repeats a lost request
/// later than that.
const CONNECT_MS: u32 = 1000;
/// The same of one attempt before a sender begins, which has no limit of its own \[ms\].
const FIRST_MS: u32 = 10_000;
/// The same of an attempt that ends soon \[ms\].
const HASTY_MS: u32 = 250;
/// Bytes that a link may hold back, four seconds of a session: a cut link ends before it is full, since zenoh then
/// stands still until the system has closed it.
const SEND_BYTES: u32 = 262_144;
/// First and largest pause between attempts of a link that was open \[ms\].
const AGAIN_MS: [u32; 2] = [200, 1000];
/// The last one of the settings that zenoh puts before the reason why certificates of this side are of no use; there
/// may be keys among them.
const LAST_SETTING: &str = "verify_name_on_connect=";
/// Parts of zenoh's reasons that waiting does not cure, with remedies.
const LASTING: [(&str, &str); 4] = [
    (
        "invalid peer certificate",
        "let `transport/link/tls/root_ca_certificate` of --config name the authority that signed it, and connect to a \
         name that stands in it",
    ),
    (
        "received fatal alert",
        "the other side wants a certificate that it trusts: let `connect_certificate`, `connect_private_key` and \
         `enable_mtls` of `transport/link/tls` in --config name one",
    ),
    ("Cannot create a new TLS", "look at `transport/link/tls` of --config"),
    (
        "not supported",
        "take tcp/HOST:PORT, or tls/HOST:PORT of a program that was built with --features tls",
    ),
];

/// Endpoints and further settings of one side.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// Endpoints at which it listens.
    pub listen: Vec<String>,
    /// Endpoints to which it connects.
    pub connect: Vec<String>,
    /// A configuration of zenoh, whose values come before those of this module.
    pub config: Option<PathBuf>,
    /// True if it may listen at other addresses than those of this machine.
    pub is_open: bool,
}

impl Settings {
    /// The configuration of a sender: a peer that listens on this machine, or connects to a router.
    ///
    /// # Errors
    /// An address that others reach; a file that cannot be read or is none.
    pub fn sender(&self) -> Result<Config> {
        for endpoint in &self.listen {
            if !self.is_open && !is_loopback(endpoint) {
                return Err(Error::input(format!(
                    "--listen {endpoint}: anyone who reaches this address could read the session; take {ENDPOINT}, \
                     and ssh to get there, or pass --open-to-network"
                )));
            }
        }
        let listen = if self.connect.is_empty() { vec![ENDPOINT] } else { vec![] };
        self.over(json!({ "mode": "peer", "listen": { "endpoints": listen } }))
    }

    /// The configuration of a receiver: a client, which connects and never listens.
    ///
    /// # Errors
    /// A file that cannot be read or is none.
    pub fn receiver(&self) -> Result<Config> {
        self.over(json!({
            "mode": "client",
            "listen": { "endpoints": [] },
            "connect": { "endpoints": [ENDPOINT], "timeout_ms": CONNECT_MS, "exit_on_failure": true },
        }))
    }

    /// Lays all that was told over the values of one side.
    fn over(&self, side: Value) -> Result<Config> {
        let [first_ms, most_ms] = AGAIN_MS;
        let mut all = json!({
            "connect": { "retry": { "period_init_ms": first_ms, "period_max_ms": most_ms } },
            "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
            "transport": { "link": {
                "tx": { "lease": LEASE_MS },
                "tcp": { "so_sndbuf": SEND_BYTES },
                "tls": { "so_sndbuf": SEND_BYTES },
            } },
        });
        lay_over(&mut all, side);
        if let Some(path) = &self.config {
            lay_over(&mut all, read(path)?);
        }
        for (part, endpoints) in [("listen", &self.listen), ("connect", &self.connect)] {
            if !endpoints.is_empty() {
                lay_over(&mut all, json!({ part: { "endpoints": endpoints } }));
            }
        }
        Config::from_json5(&all.to_string())
            .map_err(|why| Error::input(format!("zenoh's configuration: {why}")))
    }
}

/// The same configuration for an attempt to connect that ends soon, unless it has a limit of the user's.
///
/// # Errors
/// zenoh's, of a value that it does not take.
pub fn hasty(config: &Config) -> zenoh::Result<Config> {
    let mut hasty = config.clone();
    if config.get_json("connect/timeout_ms")? == CONNECT_MS.to_string() {
        hasty.insert_json5("connect/timeout_ms", &HASTY_MS.to_string())?;
    }
    Ok(hasty)
}

/// Tries each endpoint that is to be connected to once, those of TCP aside: who refuses a certificate refuses it
/// again. zenoh gives the reason to a peer, not to a client, which waits for a sender.
///
/// # Errors
/// Endpoints none of which a later attempt reaches, with the remedy.
pub fn check_connect(config: &Config) -> Result<()> {
    let listed = config.get_json("connect/endpoints").unwrap_or_default();
    // A list by modes or by groups of endpoints is not looked into.
    let endpoints: Vec<String> = serde_json::from_str(&listed).unwrap_or_default();
    let mut refused = Ok(());
    for endpoint in &endpoints {
        match refusal(config, endpoint).map_err(Error::check)? {
            Some(why) => refused = refused.and(Err(why)),
            None => return Ok(()),
        }
    }
    refused
}

/// Why no attempt reaches an endpoint; `None` if one does, or a later one may.
fn refusal(config: &Config, endpoint: &str) -> zenoh::Result<Option<Error>> {
    if endpoint.starts_with("tcp/") {
        return Ok(None);
    }
    let limit_ms = config.get_json("connect/timeout_ms")?.parse().ok().filter(|&ms| ms > 0);
    let mut once = config.clone();
    for (key, value) in [
        ("mode", json!("peer")),
        ("listen/endpoints", json!([])),
        ("scouting/multicast/enabled", json!(false)),
        ("connect/endpoints", json!([endpoint])),
        ("connect/timeout_ms", json!(limit_ms.unwrap_or(FIRST_MS))),
        ("connect/exit_on_failure", json!(true)),
        // Without a pause there is one attempt, whose reason is given.
        ("connect/retry", json!({ "period_init_ms": 0 })),
    ] {
        once.insert_json5(key, &value.to_string())?;
    }
    let why = match zenoh::open(once).wait() {
        Ok(session) => return session.close().wait().map(|()| None),
        Err(why) => reason(&why),
    };
    let refused = |remedy| Error::input(format!("cannot connect to {endpoint}: {why}: {remedy}"));
    Ok(remedy(&why).map(refused))
}

/// Opens zenoh.
///
/// # Errors
/// Endpoints that cannot be opened or reached, with their names.
pub fn open(config: &Config) -> Result<Session> {
    zenoh::open(config.clone()).wait().map_err(|why| {
        let named = |key| config.get_json(key).unwrap_or_default();
        let why = reason(&why);
        let remedy = remedy(&why).map(|remedy| format!(": {remedy}")).unwrap_or_default();
        Error::input(format!(
            "zenoh with listen {}, connect {}: {why}{remedy}",
            named("listen/endpoints"),
            named("connect/endpoints")
        ))
    })
}

/// zenoh's reason in its own words.
fn reason(why: &zenoh::Error) -> String {
    let why = why.to_string();
    let why = match why.rsplit_once(LAST_SETTING).and_then(|(_, why)| why.split_once(": ")) {
        Some((_, why)) => format!("Cannot create a new TLS link: {why}"),
        None => why,
    };
    // It names the line of its sources, which nobody here has.
    why.split(" at /").next().unwrap_or_default().to_owned()
}

/// The remedy of a reason that a later attempt has too.
fn remedy(why: &str) -> Option<&'static str> {
    LASTING.iter().find(|(part, _)| why.contains(part)).map(|(_, remedy)| *remedy)
}

/// Reads a configuration.
fn read(path: &Path) -> Result<Value> {
    let text = std::fs::read_to_string(path).map_err(|why| Error::file("read", path, why))?;
    json5::from_str(&text).map_err(|why| Error::file("read", path, why))
}

/// Lays one value over another: of objects each field, of all else the whole.
fn lay_over(under: &mut Value, over: Value) {
    match (under, over) {
        (Value::Object(under), Value::Object(over)) => {
            for (name, value) in over {
                lay_over(under.entry(name).or_insert(Value::Null), value);
            }
        }
        (under, over) => *under = over,
    }
}

/// Returns true for an endpoint that only this machine reaches, as `tcp/127.0.0.1:7447`.
fn is_loopback(endpoint: &str) -> bool {
    let address = endpoint.split_once('/').map_or("", |(_, address)| address);
    let address = address.split(['?', '#']).next().unwrap_or_default();
    let host = address.rsplit_once(':').map_or("", |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

    use super::*;

    fn listening(endpoint: &str) -> Settings {
        Settings { listen: vec![endpoint.into()], ..Settings::default() }
    }

    #[test]
    fn nothing_but_this_machine_is_reached_unless_told() {
        for near in
            ["tcp/127.0.0.1:0", "tcp/[::1]:7447", "tcp/localhost:1", "tcp/127.0.0.1:1#iface=lo"]
        {
            assert!(listening(near).sender().is_ok(), "{near}");
        }
        for far in [
            "tcp/0.0.0.0:7447",
            "tcp/[::]:0",
            "tcp/theatre:7447",
            "tcp/10.0.0.1:7447",
            "tcp",
            "udp/:1",
        ] {
            let why = listening(far).sender().unwrap_err().to_string();
            assert!(why.contains("--open-to-network"), "{far}: {why}");
        }
        assert!(Settings { is_open: true, ..listening("tcp/0.0.0.0:7447") }.sender().is_ok());
        for config in [Settings::default().sender(), Settings::default().receiver()] {
            let config = config.unwrap();
            for discovery in ["scouting/multicast/enabled", "scouting/gossip/enabled"] {
                assert_eq!(config.get_json(discovery).unwrap(), "false");
            }
            assert_eq!(config.get_json("transport/link/tx/lease").unwrap(), "2000");
            for link in ["transport/link/tcp/so_sndbuf", "transport/link/tls/so_sndbuf"] {
                assert_eq!(config.get_json(link).unwrap(), SEND_BYTES.to_string());
            }
        }
        let receiver = Settings::default().receiver().unwrap();
        assert_eq!(receiver.get_json("listen/endpoints").unwrap(), "[]");
        assert_eq!(receiver.get_json("mode").unwrap(), "\"client\"");
    }

    #[test]
    fn a_limit_of_the_user_stays_in_a_hasty_attempt() {
        let limit = |config: &Config| config.get_json("connect/timeout_ms").unwrap();
        let mut config = Settings::default().receiver().unwrap();
        assert_eq!(limit(&hasty(&config).unwrap()), "250");
        config.insert_json5("connect/timeout_ms", "5000").unwrap();
        assert_eq!(limit(&hasty(&config).unwrap()), "5000");
    }

    #[test]
    fn an_endpoint_that_may_come_is_waited_for() {
        let checked = |connect: &[&str]| {
            let connect = connect.iter().map(|&endpoint| endpoint.into()).collect();
            let settings = Settings { connect, ..Settings::default() };
            check_connect(&settings.receiver().unwrap()).map_err(|why| why.to_string())
        };
        assert_eq!(checked(&["tcp/127.0.0.1:1"]), Ok(()));
        assert_eq!(checked(&["udp/127.0.0.1:1", "tcp/127.0.0.1:1"]), Ok(()));
        let why = checked(&["udp/127.0.0.1:1", "udp/127.0.0.1:2"]).unwrap_err();
        assert!(why.contains("udp/127.0.0.1:1") && why.contains("--features tls"), "{why}");
    }

    #[test]
    fn a_file_is_laid_over_and_options_over_that() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("link.json5");
        let text = "{ scouting: { multicast: { enabled: true } }, // told
            connect: { endpoints: ['tcp/10.0.0.1:7447'] } }";
        std::fs::write(&path, text).unwrap();
        let told = Settings { config: Some(path.clone()), ..Settings::default() };
        let config = told.receiver().unwrap();
        assert_eq!(config.get_json("scouting/multicast/enabled").unwrap(), "true");
        assert_eq!(config.get_json("scouting/gossip/enabled").unwrap(), "false");
        assert!(config.get_json("connect/endpoints").unwrap().contains("10.0.0.1"));
        let told = Settings { connect: vec!["tcp/10.0.0.2:1".into()], ..told };
        let endpoints = told.receiver().unwrap().get_json("connect/endpoints").unwrap();
        assert!(endpoints.contains("10.0.0.2") && !endpoints.contains("10.0.0.1"), "{endpoints}");
        for bad in ["{", "{ mood: 'peer' }"] {
            std::fs::write(&path, bad).unwrap();
            assert!(told.receiver().is_err(), "{bad}");
        }
    }
}
