//! Text files that users write: bounded, without a byte order mark.

use std::io::Read;
use std::path::Path;

use crate::input;

/// What some editors put in front of UTF-8 text; it is passed over.
pub const BYTE_ORDER_MARK: &str = "\u{feff}";

/// Why a file that begins with `front` cannot be read, and the remedy, where it is gzip-compressed.
#[must_use]
pub fn gzip(front: &[u8]) -> Option<&'static str> {
    let is_gzip = front.starts_with(&[0x1f, 0x8b]);
    is_gzip.then_some("it is gzip-compressed: unpack it first with gunzip")
}

/// The text of a file of at most so many bytes.
///
/// # Errors
/// Why it cannot be read.
pub fn read(path: &Path, bytes_max: u64) -> Result<String, String> {
    of(input::open(path).map_err(|why| why.to_string())?, bytes_max)
}

/// The text of at most so many bytes that comes from a file or a pipe.
///
/// # Errors
/// Why it cannot be read.
pub fn of(from: impl Read, bytes_max: u64) -> Result<String, String> {
    let mut bytes = Vec::new();
    from.take(bytes_max.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|why| why.to_string())?;
    if let Some(why) = gzip(&bytes) {
        return Err(why.into());
    }
    if bytes.len() as u64 > bytes_max {
        return Err(format!("it has more than {} MiB, the limit", bytes_max >> 20));
    }
    let text = String::from_utf8(bytes).map_err(|_| "it is no UTF-8 text: save it as text")?;
    Ok(text.strip_prefix(BYTE_ORDER_MARK).map(str::to_owned).unwrap_or(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_read_without_its_mark_and_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let found = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read(&path, 8)
        };
        assert_eq!(found(b"1 2").unwrap(), "1 2");
        assert_eq!(found(b"\xef\xbb\xbf1 2").unwrap(), "1 2");
        assert_eq!(found(b"12345678").unwrap(), "12345678");
        for (bytes, why) in [
            (&b"123456789"[..], "more than 0 MiB"),
            (b"\xff\xfe", "no UTF-8 text"),
            (b"\x1f\x8b\x08\0", "gunzip"),
        ] {
            assert!(found(bytes).unwrap_err().contains(why), "{bytes:?}");
        }
        assert!(read(&folder.path().join("none"), 8).is_err());
    }
}
