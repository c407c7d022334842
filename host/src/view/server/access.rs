//! Who may ask: the checks of every request.

use super::refusal::Refusal;
use super::request::Request;
use super::token::Token;

/// Name of the WebSocket's protocol; the token is a second one in the request.
pub(super) const PROTOCOL: &str = "chaincell";

/// The port and the secret of a server.
#[derive(Debug)]
pub(super) struct Access {
    pub(super) port: u16,
    pub(super) token: Token,
}

impl Access {
    /// Checks that a request was meant for this server, and that no other page made it.
    ///
    /// # Errors
    /// Another host: a name of the internet that was bent to this machine. A foreign origin, `null` too.
    pub(super) fn check_place(&self, request: &Request) -> Result<(), Refusal> {
        let host = request.field("host")?.unwrap_or_default();
        if !self.is_own(host) {
            return Err(Refusal::WRONG_HOST);
        }
        match request.field("origin")? {
            None => Ok(()),
            Some(origin) if origin.strip_prefix("http://").is_some_and(|of| self.is_own(of)) => {
                Ok(())
            }
            Some(_) => Err(Refusal::FOREIGN_ORIGIN),
        }
    }

    /// Checks the token in the field `Authorization`.
    ///
    /// # Errors
    /// A missing or wrong one.
    pub(super) fn check_bearer(&self, request: &Request) -> Result<(), Refusal> {
        let given = request.field("authorization")?.unwrap_or_default();
        self.check(given.strip_prefix("Bearer "))
    }

    /// Checks the token among the protocols of a WebSocket.
    ///
    /// # Errors
    /// A missing or wrong one, or no protocol `chaincell` before it.
    pub(super) fn check_protocols(&self, request: &Request) -> Result<(), Refusal> {
        let given = request.field("sec-websocket-protocol")?.unwrap_or_default();
        let (protocol, token) = given.split_once(',').unwrap_or_default();
        self.check((protocol.trim() == PROTOCOL).then(|| token.trim()))
    }

    fn check(&self, given: Option<&str>) -> Result<(), Refusal> {
        let is_known = given.is_some_and(|given| self.token.is(given));
        if is_known { Ok(()) } else { Err(Refusal::WRONG_TOKEN) }
    }

    fn is_own(&self, host: &str) -> bool {
        let own = |name: &str| host == format!("{name}:{}", self.port);
        own("127.0.0.1") || own("localhost")
    }
}
