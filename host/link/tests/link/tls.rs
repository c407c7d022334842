//! Sessions over TLS, with certificates of an authority that a test makes, and an access rule by their names.

use std::time::Duration;

use chaincell_link::settings::{Settings, check_connect};

use crate::certificates::Authority;
use crate::session::{Session, fake};
use crate::sides::{Follower, LONG, Network, ended, until};
use crate::{TICKS, same, whole};

/// A sender that shows a certificate and asks for none.
const SENDER: &str = r#"{ transport: { link: { tls: {
    listen_certificate: "theatre.pem", listen_private_key: "theatre.key",
} } } }"#;
/// A receiver that shows none.
const RECEIVER: &str =
    r#"{ transport: { link: { tls: { root_ca_certificate: "authority.pem" } } } }"#;
/// A receiver whose certificate is not there.
const LOST: &str = r#"{ transport: { link: { tls: {
    enable_mtls: true, connect_certificate: "lost.pem", connect_private_key_base64: "c2VjcmV0",
} } } }"#;

/// A configuration that stands in the guide, under the line that names its file.
fn guide(name: &str) -> String {
    let page = include_str!("../../../GUIDE.md");
    let begin = format!("```text\n// {name}");
    let (_, rest) = page.split_once(&begin).expect("the guide has it");
    let (lines, _) = rest.split_once("```").expect("it ends");
    format!("//{lines}")
}

#[test]
fn over_tls_a_session_is_followed_to_the_same_bits() {
    let Some(network) = Network::of("tls", "over_tls_a_session_is_followed_to_the_same_bits")
    else {
        return;
    };
    let authority = Authority::new();
    authority.sign("theatre");
    let sends = authority.config("sender.json5", SENDER);
    let receives = authority.config("receiver.json5", RECEIVER);
    let with = ["--config", receives.to_str().unwrap()];
    let mut session = Session::begin();
    // They wait for a sender: that nobody is there is no reason to end.
    let connect = vec![network.endpoint().into()];
    let settings = Settings { connect, config: Some(receives.clone()), ..Settings::default() };
    assert_eq!(check_connect(&settings.receiver().unwrap()), Ok(()));
    let follower = Follower::with(&network, "left", &with, LONG);
    let receiver = network.receive("left", &with);
    let with = ["--config", sends.to_str().unwrap()];
    let _sender = network.send(session.folder(), "left", &with);
    for played in 1..=3 {
        session.play(TICKS);
        follower.wait_for_ticks(played * TICKS);
    }
    let (folder, state_hash) = session.end();
    assert_eq!(same(follower.end(), &state_hash), 3 * TICKS);
    whole(&receiver.frames(), folder.path());
}

#[test]
fn who_trusts_another_authority_gets_nothing_and_hears_why() {
    let Some(network) =
        Network::of("tls", "who_trusts_another_authority_gets_nothing_and_hears_why")
    else {
        return;
    };
    let (authority, other) = (Authority::new(), Authority::new());
    authority.sign("theatre");
    let (folder, _trace) = fake(3);
    let sends = authority.config("sender.json5", SENDER);
    let _sender = network.send(folder.path(), "left", &["--config", sends.to_str().unwrap()]);
    let config = other.config("receiver.json5", RECEIVER);
    let with = ["--connect", network.endpoint(), "--config", config.to_str().unwrap()];
    let session = folder.path().to_str().unwrap();
    for args in [&["receive", "left"][..], &["send", session, "--name", "right"]] {
        let (code, said) = ended(&[args, &with].concat());
        assert_eq!(code, Some(2), "{args:?}: {said}");
        for part in [network.endpoint(), "invalid peer certificate", "root_ca_certificate"] {
            assert!(said.contains(part), "{args:?}, {part}: {said}");
        }
    }
    let follower = Follower::with(&network, "left", &with[2..], Duration::ZERO);
    let why = follower.end().expect_err("it gets nothing");
    assert!(why.contains("before the session began"), "{why}");
}

#[test]
fn an_access_rule_lets_one_certificate_through_and_no_other() {
    let Some(network) =
        Network::of("tls", "an_access_rule_lets_one_certificate_through_and_no_other")
    else {
        return;
    };
    let authority = Authority::new();
    for name in ["theatre", "far", "guest"] {
        authority.sign(name);
    }
    let sends = authority.config("theatre.json5", &guide("theatre.json5"));
    let far = authority.config("far.json5", &guide("far.json5"));
    let guest = authority.config("guest.json5", &guide("far.json5").replace("\"far.", "\"guest."));
    let nobody = authority.config("nobody.json5", RECEIVER);
    let mut session = Session::begin();
    let _sender = network.send(session.folder(), "left", &["--config", sends.to_str().unwrap()]);
    let [far, guest] = [&far, &guest].map(|config| ["--config", config.to_str().unwrap()]);
    let far = Follower::with(&network, "left", &far, LONG);
    let denied = Follower::with(&network, "left", &guest, Duration::ZERO);
    let guest = network.receive("left", &guest);
    session.play(TICKS);
    far.wait_for_ticks(TICKS);
    session.play(TICKS);
    let (_folder, state_hash) = session.end();
    assert_eq!(same(far.end(), &state_hash), 2 * TICKS);
    let parts = ["chaincell/left/records", "chaincell/left/ask", "access_control"];
    assert!(until("the receiver names the rule", || guest.times_said(&parts) > 0));
    assert_eq!(guest.stop(), []);
    let why = denied.end().expect_err("it gets nothing");
    assert!(why.contains("before the session began"), "{why}");
    // Without a certificate there is no connection.
    let config = nobody.to_str().unwrap();
    let (code, said) =
        ended(&["receive", "left", "--connect", network.endpoint(), "--config", config]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("connect_certificate"), "{said}");
}

#[test]
fn a_certificate_that_is_not_there_is_missed_and_no_key_is_shown() {
    let authority = Authority::new();
    let (folder, _trace) = fake(3);
    let session = folder.path().to_str().unwrap();
    let lost = authority.config("lost.json5", LOST);
    let with = ["tls/127.0.0.1:1", "--config", lost.to_str().unwrap()];
    for args in [
        &["receive", "left", "--connect"][..],
        &["send", session, "--name", "left", "--connect"],
        &["send", session, "--name", "left", "--listen"],
    ] {
        let (code, said) = ended(&[args, &with].concat());
        assert_eq!(code, Some(2), "{args:?}: {said}");
        assert!(said.contains("transport/link/tls") && !said.contains("c2VjcmV0"), "{said}");
    }
}
