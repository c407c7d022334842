//! Binary data of arrays: base64 in the text or appended, plain or in blocks compressed by zlib.

use std::borrow::Cow;
use std::cell::Cell;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::inflate::{TINFLStatus, decompress_to_vec_zlib_with_limit};
use roxmltree::Node;

use crate::error::Result;
use crate::mesh::FILE_BYTES_MAX;
use crate::mesh::bytes::{Bytes, shown};

/// Coding of a file's arrays.
pub(super) struct Coding<'a> {
    pub(super) little: bool,
    /// Bytes of a number in the head of an array.
    head: usize,
    zlib: bool,
    /// Bytes that the arrays may still unpack to.
    room: Cell<u64>,
    appended: Option<Appended<'a>>,
}

/// Data after the XML, from its first byte.
struct Appended<'a> {
    data: &'a [u8],
    raw: bool,
}

/// Bytes that any compressed file may unpack to, and the number of further bytes for each of its bytes:
/// connectivity shrinks to a fifth at most, even that of a regular grid.
const ROOM: u64 = 16 << 20;
const ROOM_EACH: u64 = 100;

/// Reason for which an array is refused.
const CUT: &str = "its data ends early; the file is cut off: save or copy it again";

impl<'a> Coding<'a> {
    /// Reads the coding from the outermost element of a file of `length` bytes; `behind` are the bytes
    /// after the tag of appended data.
    pub(super) fn of(
        root: Node,
        behind: Option<&'a [u8]>,
        length: u64,
        place: &mut Bytes,
    ) -> Result<Self> {
        place.return_to(root.range().start);
        let refuse = |name: &str, value: &str, read: &str| {
            Err(place.error(format!(
                "{name} '{}'; read are {read}: save the mesh with one of these",
                shown(value)
            )))
        };
        let little = match root.attribute("byte_order").unwrap_or("LittleEndian") {
            "LittleEndian" => true,
            "BigEndian" => false,
            other => return refuse("byte_order", other, "LittleEndian and BigEndian"),
        };
        let head = match root.attribute("header_type").unwrap_or("UInt32") {
            "UInt32" => 4,
            "UInt64" => 8,
            other => return refuse("header_type", other, "UInt32 and UInt64"),
        };
        let zlib = match root.attribute("compressor").unwrap_or("") {
            "" => false,
            "vtkZLibDataCompressor" => true,
            other => return refuse("compressor", other, "vtkZLibDataCompressor and none"),
        };
        let tag = root.children().find(|node| node.has_tag_name("AppendedData"));
        let raw = match tag.and_then(|tag| tag.attribute("encoding")).unwrap_or("raw") {
            "raw" => true,
            "base64" => false,
            other => return refuse("encoding", other, "raw and base64"),
        };
        // An underscore precedes the first byte.
        let data = behind.and_then(|behind| {
            let front = behind.iter().position(|byte| !byte.is_ascii_whitespace())?;
            behind.get(front..)?.strip_prefix(b"_")
        });
        let room = FILE_BYTES_MAX.min(length.saturating_mul(ROOM_EACH).saturating_add(ROOM));
        let appended = data.map(|data| Appended { data, raw });
        Ok(Self { little, head, zlib, room: Cell::new(room), appended })
    }

    /// Returns a number's bytes, lowest first, followed by zeros.
    fn widened(&self, bytes: &[u8]) -> [u8; 8] {
        let mut wide = [0; 8];
        for (at, byte) in bytes.iter().take(8).enumerate() {
            wide[if self.little { at } else { bytes.len() - 1 - at }] = *byte;
        }
        wide
    }

    /// Returns the data of an array: `count` numbers of `size` bytes each.
    pub(super) fn decode(
        &self,
        node: Node,
        name: &str,
        count: u64,
        size: u64,
        place: &Bytes,
    ) -> Result<Vec<u8>> {
        let refuse = |why: String| place.error(format!("array '{}': {why}", shown(name)));
        let wanted = count.saturating_mul(size);
        let decoded = self.stream(node).and_then(|stream| {
            if self.zlib { self.blocks(stream, wanted) } else { self.plain(stream, wanted) }
        });
        let bytes = decoded.map_err(refuse)?;
        if bytes.len() as u64 == wanted {
            return Ok(bytes);
        }
        Err(refuse(format!(
            "it has {} bytes where {count} numbers of {size} bytes are needed; the file is cut off or a \
             count is wrong: save or copy the mesh again",
            bytes.len()
        )))
    }

    /// Returns the coded bytes from the begin of an array's data.
    fn stream<'b>(&'b self, node: Node<'b, '_>) -> std::result::Result<Stream<'b>, String> {
        let format = node.attribute("format").unwrap_or("");
        match (format, &self.appended) {
            ("binary", _) => {
                let text = node.text().unwrap_or("").trim();
                Ok(Stream { rest: without_blanks(text.as_bytes()), at: 0, raw: false, over: false })
            }
            ("appended", Some(Appended { data, raw })) => {
                let offset = node.attribute("offset").and_then(|text| text.trim().parse().ok());
                let rest = offset.and_then(|offset: usize| data.get(offset..));
                let rest = rest.ok_or("its offset lies behind the data; save the mesh again")?;
                Ok(Stream { rest: Cow::Borrowed(rest), at: 0, raw: *raw, over: false })
            }
            ("appended", None) => {
                Err("there is no AppendedData, or no '_' in front of it; the file is \
                                       cut off: save or copy it again"
                    .into())
            }
            _ => Err(format!(
                "format '{}'; ascii, binary and appended are read: save the mesh again",
                shown(format)
            )),
        }
    }

    fn number(&self, bytes: &[u8]) -> u64 {
        u64::from_le_bytes(self.widened(bytes))
    }

    /// Reads the number of bytes, then the bytes.
    fn plain(&self, mut stream: Stream, wanted: u64) -> std::result::Result<Vec<u8>, String> {
        self.claim(wanted, wanted)?;
        let mut ahead = stream.clone();
        let bytes = self.number(&ahead.take(self.head as u64)?);
        if bytes != wanted {
            return Err(format!(
                "it has {bytes} bytes where {wanted} are needed; a count is wrong: save the mesh again"
            ));
        }
        // The head is coded separately or together with the data.
        if !ahead.over {
            return ahead.take(bytes);
        }
        let mut both = stream.take(bytes.saturating_add(self.head as u64))?;
        both.drain(..self.head);
        Ok(both)
    }

    /// Subtracts an array's bytes from the remaining limit before any is unpacked.
    fn claim(&self, wanted: u64, unpacked: u64) -> std::result::Result<(), String> {
        if unpacked != wanted {
            return Err(format!(
                "its blocks have {unpacked} bytes where {wanted} are needed; the file is cut off or a count \
                 is wrong: save or copy the mesh again"
            ));
        }
        let room = self.room.get();
        let left = room.checked_sub(wanted).ok_or_else(|| {
            format!(
                "it unpacks to {wanted} bytes where a compressed file of this size has room for {room}; a \
                 count is wrong, or save the mesh without compression"
            )
        })?;
        self.room.set(left);
        Ok(())
    }

    /// Reads the number of blocks, the bytes of a block and of the last one, the compressed size of each,
    /// then the blocks.
    fn blocks(&self, mut stream: Stream, wanted: u64) -> std::result::Result<Vec<u8>, String> {
        let head = stream.take(3 * self.head as u64)?;
        let mut numbers = head.chunks_exact(self.head).map(|number| self.number(number));
        let mut number = || numbers.next().unwrap_or(0);
        let (count, each, last) = (number(), number(), number());
        self.claim(wanted, unpacked(count, each, last))?;
        let sizes = stream.take(count.saturating_mul(self.head as u64))?;
        let sizes: Vec<u64> = sizes.chunks_exact(self.head).map(|size| self.number(size)).collect();
        let total = sizes.iter().fold(0u64, |total, size| total.saturating_add(*size));
        let data = stream.take(total)?;
        let (mut rest, mut bytes) = (data.as_slice(), Vec::new());
        for size in sizes {
            let (block, behind) = rest.split_at(size as usize);
            rest = behind;
            // One byte more than wanted shows that there are too many.
            let most = (wanted + 1).saturating_sub(bytes.len() as u64);
            match decompress_to_vec_zlib_with_limit(block, most as usize) {
                Ok(unpacked) => bytes.extend(unpacked),
                Err(why) if why.status == TINFLStatus::HasMoreOutput => bytes.extend(why.output),
                Err(why) => {
                    return Err(format!("zlib: {why}; the file is damaged: save or copy it again"));
                }
            }
        }
        Ok(bytes)
    }
}

/// Returns the bytes of `count` blocks; a last one of 0 is as large as the others.
fn unpacked(count: u64, each: u64, last: u64) -> u64 {
    let full = count.saturating_mul(each);
    if last == 0 { full } else { full.saturating_sub(each).saturating_add(last) }
}

/// Coded bytes, read from the front.
#[derive(Clone)]
struct Stream<'a> {
    rest: Cow<'a, [u8]>,
    at: usize,
    raw: bool,
    /// True if the bytes taken last are coded together with the following ones.
    over: bool,
}

impl Stream<'_> {
    /// Takes the next bytes, which are coded together.
    fn take(&mut self, count: u64) -> std::result::Result<Vec<u8>, String> {
        let coded = if self.raw { count } else { count.div_ceil(3).saturating_mul(4) };
        let end = usize::try_from(coded).ok().and_then(|coded| self.at.checked_add(coded));
        let Some(part) = end.and_then(|end| self.rest.get(self.at..end)) else {
            return Err(CUT.into());
        };
        self.at += part.len();
        let bytes = if self.raw {
            part.to_vec()
        } else {
            let decoded = STANDARD.decode(part);
            let mut bytes = decoded.map_err(|why| format!("base64: {why}; save the mesh again"))?;
            self.over = bytes.len() as u64 > count;
            bytes.truncate(count as usize);
            bytes
        };
        if bytes.len() as u64 == count { Ok(bytes) } else { Err(CUT.into()) }
    }
}

fn without_blanks(text: &[u8]) -> Cow<'_, [u8]> {
    if text.iter().any(u8::is_ascii_whitespace) {
        text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect()
    } else {
        Cow::Borrowed(text)
    }
}
