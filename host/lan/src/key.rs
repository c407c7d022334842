//! The key that both sides share, in a file that its owner alone may read.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use chaincell_client::error::{Error, Kind, Result};
use hmac_sha256::HMAC;

/// Random bytes of a new key, and the fewest of any.
pub const KEY_BYTES: usize = 32;
/// Most hexadecimal digits and line ends that are read of a file.
const TEXT_BYTES_MAX: u64 = 1024;

/// A shared key.
///
/// ```
/// use chaincell_lan::key::Key;
///
/// let key = Key::from_hex("c0ffee".repeat(11).as_str())?; // 33 bytes
/// assert_eq!(format!("{key:?}"), "Key"); // it is never printed
/// assert!(Key::from_hex("c0ffee").is_err()); // too few bytes
/// # Ok::<(), String>(())
/// ```
#[derive(Clone)]
pub struct Key {
    bytes: Vec<u8>,
}

impl Key {
    /// Reads hexadecimal digits.
    ///
    /// # Errors
    /// Another text, or fewer than 32 bytes.
    pub fn from_hex(text: &str) -> std::result::Result<Self, String> {
        let text = text.trim_ascii_end();
        let digits: Option<Vec<u32>> = text.chars().map(|digit| digit.to_digit(16)).collect();
        let digits = digits.filter(|digits| digits.len() % 2 == 0);
        let digits =
            digits.ok_or("it does not hold hexadecimal digits alone, two for each byte")?;
        let bytes: Vec<u8> = digits.chunks(2).map(|two| (16 * two[0] + two[1]) as u8).collect();
        if bytes.len() < KEY_BYTES {
            return Err(format!(
                "it has {} bytes, and at least {KEY_BYTES} are needed",
                bytes.len()
            ));
        }
        Ok(Self { bytes })
    }

    /// Reads a key file.
    ///
    /// # Errors
    /// No such file, one that others may read, or one without a key.
    pub fn read(path: &Path) -> Result<Self> {
        let place = path.display();
        let file = File::open(path).map_err(|why| {
            let text = format!("--key {place}: {why}; `chaincell-lan key {place}` makes one");
            Error::new(Kind::Argument, text)
        })?;
        let unreadable = |why| Error::new(Kind::Argument, format!("--key {place}: {why}"));
        let data = file.metadata().map_err(unreadable)?;
        if data.mode() & 0o077 != 0 {
            let text = format!(
                "--key {place}: others may read or write it (mode {:03o}); `chmod 600 {place}` mends \
                 that, and a new key is safer if it stood open",
                data.mode() & 0o777
            );
            return Err(Error::new(Kind::Permission, text));
        }
        let mut text = String::new();
        file.take(TEXT_BYTES_MAX).read_to_string(&mut text).map_err(unreadable)?;
        Self::from_hex(&text).map_err(|why| {
            let text = format!("--key {place}: {why}; `chaincell-lan key FILE` makes one");
            Error::new(Kind::Argument, text)
        })
    }

    /// Makes a key of 32 random bytes in a new file, which its owner alone may read.
    ///
    /// # Errors
    /// A file that stands there already, a folder that takes none, a system without random numbers.
    pub fn create(path: &Path) -> Result<()> {
        let place = path.display();
        let text = random::<KEY_BYTES>()?
            .iter()
            .fold(String::new(), |text, byte| format!("{text}{byte:02x}"));
        let file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path);
        file.and_then(|mut file| file.write_all(format!("{text}\n").as_bytes())).map_err(|why| {
            let remedy = match why.kind() {
                ErrorKind::AlreadyExists => "; remove it first, on both machines",
                _ => "",
            };
            Error::new(Kind::Argument, format!("{place}: {why}{remedy}"))
        })
    }

    /// Returns HMAC-SHA-256 of a text.
    #[must_use]
    pub fn code(&self, text: &[u8]) -> [u8; 32] {
        self.coded(text).finalize()
    }

    /// Returns true if this is the code of a text, in a time that does not depend on the code.
    #[must_use]
    pub fn is_code(&self, text: &[u8], code: &[u8; 32]) -> bool {
        self.coded(text).finalize_verify(code)
    }

    fn coded(&self, text: &[u8]) -> HMAC {
        let mut code = HMAC::new(&self.bytes);
        code.update(text);
        code
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key")
    }
}

/// Returns random bytes of the operating system.
///
/// # Errors
/// A system that has none.
pub fn random<const N: usize>() -> Result<[u8; N]> {
    let mut bytes = [0; N];
    let filled = getrandom::fill(&mut bytes);
    filled.map_err(|why| Error::new(Kind::Argument, format!("no random numbers: {why}")))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::fs::{Permissions, read_to_string, set_permissions, write};
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn a_key_file_is_its_owners_and_is_made_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lan.key");
        assert!(Key::read(&path).unwrap_err().to_string().contains("chaincell-lan key"));
        Key::create(&path).unwrap();
        assert_eq!(path.metadata().unwrap().mode() & 0o777, 0o600);
        let text = read_to_string(&path).unwrap();
        assert_eq!(text.len(), 2 * KEY_BYTES + 1);
        Key::read(&path).unwrap();
        assert!(Key::create(&path).unwrap_err().to_string().contains("remove it first"));
        assert_eq!(read_to_string(&path).unwrap(), text);
        for mode in [0o640, 0o604, 0o620] {
            set_permissions(&path, Permissions::from_mode(mode)).unwrap();
            let refused = Key::read(&path).unwrap_err();
            assert_eq!(refused.kind(), Kind::Permission, "{mode:o}");
            assert!(refused.to_string().contains("chmod 600"), "{refused}");
        }
        set_permissions(&path, Permissions::from_mode(0o400)).unwrap();
        Key::read(&path).unwrap();
        // Two keys differ.
        Key::create(&folder.path().join("other.key")).unwrap();
        assert_ne!(read_to_string(folder.path().join("other.key")).unwrap(), text);
    }

    /// Case 6 of RFC 4231.
    #[test]
    fn the_code_is_that_of_the_standard() {
        let key = Key::from_hex(&"aa".repeat(131)).unwrap();
        let code = key.code(b"Test Using Larger Than Block-Size Key - Hash Key First");
        let wanted = "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54";
        let hex: String = code.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, wanted);
        assert!(key.is_code(b"Test Using Larger Than Block-Size Key - Hash Key First", &code));
        assert!(!key.is_code(b"Test using Larger Than Block-Size Key - Hash Key First", &code));
    }

    #[test]
    fn what_is_no_key_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lan.key");
        for (text, said) in [
            ("", "0 bytes"),
            ("00ff", "2 bytes"),
            (&"0".repeat(63), "two for each byte"),
            (&"g".repeat(64), "hexadecimal"),
            (&"\u{e9}".repeat(64), "hexadecimal"),
        ] {
            write(&path, text).unwrap();
            set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
            let refused = Key::read(&path).unwrap_err().to_string();
            assert!(refused.contains(said) && refused.contains("--key "), "{refused}");
        }
    }
}
