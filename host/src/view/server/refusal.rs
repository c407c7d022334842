//! Refusals of a request: status and words.

/// A refused request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Refusal {
    /// Status and its name in HTTP.
    pub(super) status: &'static str,
    /// The reason in words, with the remedy.
    pub(super) text: &'static str,
}

impl Refusal {
    pub(super) const BAD_REQUEST: Self =
        Self { status: "400 Bad Request", text: "this is no request of HTTP/1.1" };
    pub(super) const FOREIGN_ORIGIN: Self = Self {
        status: "403 Forbidden",
        text: "another page asks: open the address that chaincell view has printed",
    };
    pub(super) const WRONG_TOKEN: Self = Self {
        status: "403 Forbidden",
        text: "the token is missing or wrong: open the whole address that chaincell view has printed",
    };
    pub(super) const NOT_FOUND: Self =
        Self { status: "404 Not Found", text: "there is nothing of this name" };
    pub(super) const WRONG_METHOD: Self =
        Self { status: "405 Method Not Allowed", text: "this address takes another method" };
    pub(super) const TOO_SLOW: Self =
        Self { status: "408 Request Timeout", text: "the request was not complete in time" };
    pub(super) const LENGTH_REQUIRED: Self =
        Self { status: "411 Length Required", text: "send the body with its length" };
    pub(super) const BODY_TOO_LARGE: Self =
        Self { status: "413 Content Too Large", text: "the body is larger than 4 kB" };
    pub(super) const WRONG_HOST: Self = Self {
        status: "421 Misdirected Request",
        text: "this server is 127.0.0.1 alone: open the address that chaincell view has printed",
    };
    pub(super) const NO_UPGRADE: Self =
        Self { status: "426 Upgrade Required", text: "this address is a WebSocket of version 13" };
    pub(super) const HEAD_TOO_LARGE: Self = Self {
        status: "431 Request Header Fields Too Large",
        text: "the head is larger than 16 kB: clear the browser's cookies of 127.0.0.1",
    };
}
