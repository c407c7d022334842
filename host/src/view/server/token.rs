//! The secret that a page must know.

use std::fmt::{self, Write};
use std::hint::black_box;

use crate::error::{Error, Result};

/// Random bits of a token, in bytes.
const TOKEN_BYTES: usize = 16;

/// 128 random bits as 32 hexadecimal digits: in the fragment of the page's address, which browsers do not send.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// Draws a new one.
    ///
    /// # Errors
    /// A system without random numbers.
    pub fn new() -> Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)
            .map_err(|why| Error::check(format!("the system gives no random numbers: {why}")))?;
        let mut text = String::with_capacity(2 * TOKEN_BYTES);
        for byte in bytes {
            let _ = write!(text, "{byte:02x}");
        }
        Ok(Self(text))
    }

    /// Its digits.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Returns true if `given` is this token. The time does not depend on the place where they differ.
    #[must_use]
    pub fn is(&self, given: &str) -> bool {
        let (own, given) = (self.0.as_bytes(), given.as_bytes());
        let pairs = own.iter().zip(given);
        let differing = pairs.fold(0, |bits, (own, given)| black_box(bits | (own ^ given)));
        own.len() == given.len() && differing == 0
    }
}

/// Keeps the secret out of logs.
impl fmt::Debug for Token {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("Token(..)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_itself_alone_and_never_printed() {
        let (one, two) = (Token::new().unwrap(), Token::new().unwrap());
        assert!(one.is(one.text()) && !one.is(two.text()));
        let text = one.text().to_owned();
        assert!(text.len() == 32 && text.bytes().all(|byte| byte.is_ascii_hexdigit()));
        for wrong in ["", &text[..31], &format!("{text}0"), &text.to_uppercase().replace('0', "O")]
        {
            assert!(!one.is(wrong) || wrong == text, "{wrong}");
        }
        for at in 0..32 {
            let mut other = text.clone().into_bytes();
            other[at] ^= 1;
            assert!(!one.is(std::str::from_utf8(&other).unwrap()), "{at}");
        }
        assert_eq!(format!("{one:?}"), "Token(..)");
    }
}
