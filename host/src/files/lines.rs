//! Lines of a text from outside, each of which has a bound.

use std::io::BufRead;

use crate::error::{Error, Result};
use crate::text::gzip;

/// Largest number of rows that is read: more than a day at 1 kHz.
const ROWS_MAX: u64 = 100_000_000;
/// Longest line that is read, with its end: a row of eleven numbers is much shorter.
const LINE_BYTES_MAX: usize = 4096;

/// Reads a text line by line. Calls `each` with the number of a line, from 1 on, and its text without the
/// line's end.
///
/// # Errors
/// A line that is too long, not text or compressed; too many lines; an error of `each`.
pub(super) fn each_line(
    mut text: impl BufRead,
    name: &str,
    mut each: impl FnMut(u64, &str) -> Result<()>,
) -> Result<()> {
    let mut bytes = Vec::new();
    for line in 1_u64.. {
        // Read the next line.
        bytes.clear();
        read_line(&mut text, &mut bytes)
            .map_err(|why| Error::input(format!("{name}:{line}: cannot read: {why}")))?;
        if bytes.is_empty() {
            break;
        }
        // Refuse a compressed file, a line that is too long, too many lines.
        if let (1, Some(why)) = (line, gzip(&bytes)) {
            return Err(Error::input(format!("{name}: {why}")));
        }
        if bytes.len() > LINE_BYTES_MAX {
            return Err(Error::input(format!(
                "{name}:{line}: the line has more than {LINE_BYTES_MAX} bytes: save it as CSV, one \
                 row a line"
            )));
        }
        if line > ROWS_MAX {
            return Err(Error::input(format!(
                "{name}:{line}: more than {ROWS_MAX} rows: split it"
            )));
        }
        // Pass the text on.
        let row = std::str::from_utf8(&bytes)
            .map_err(|_| Error::input(format!("{name}:{line}: not text: save it as CSV")))?;
        each(line, row.trim_end_matches(['\n', '\r']))?;
    }
    Ok(())
}

/// Reads a line with its end: a line feed, a carriage return, or both in a row. Stops one byte after the
/// longest line.
fn read_line(text: &mut impl BufRead, bytes: &mut Vec<u8>) -> std::io::Result<()> {
    while bytes.len() <= LINE_BYTES_MAX {
        let front = match text.fill_buf() {
            Err(why) if why.kind() == std::io::ErrorKind::Interrupted => continue,
            front => front?,
        };
        let is_split = bytes.last() == Some(&b'\r');
        if front.is_empty() || is_split && front[0] != b'\n' {
            break;
        }
        let end = if is_split {
            Some(0)
        } else {
            front.iter().position(|of| matches!(of, b'\n' | b'\r'))
        };
        let room = LINE_BYTES_MAX + 1 - bytes.len();
        let count = end.map_or(front.len(), |end| end + 1).min(room);
        bytes.extend_from_slice(&front[..count]);
        text.consume(count);
        if bytes.last() == Some(&b'\n') {
            break;
        }
    }
    Ok(())
}
