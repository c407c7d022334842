//! The output stage's settings in a header.

use super::error::TraceError;
use crate::number::kept::{Kept, Pass};
use crate::stage::StageSettings;

/// Words of the settings.
const WORDS: usize = StageSettings::FIELDS.len();
/// Bytes of the settings, between the fixed part of the header and the contact cells.
pub(super) const STAGE_BYTES: usize = 4 * WORDS;

/// Returns the settings as words, field by field.
pub(super) fn words(settings: &StageSettings) -> [u32; WORDS] {
    let mut bytes = [0; STAGE_BYTES];
    let mut copy = *settings;
    copy.keep(&mut Pass::write(&mut bytes));
    bytemuck::cast::<_, [u32; WORDS]>(bytes).map(u32::from_le)
}

/// Reads the settings from these bytes, `None` if there are none. The stage checks their ranges.
pub(super) fn read(bytes: &[u8]) -> Result<Option<StageSettings>, TraceError> {
    if bytes.is_empty() {
        return Ok(None);
    }
    let mut settings = StageSettings::BLANK;
    let mut pass = Pass::read(bytes);
    settings.keep(&mut pass);
    // Fields of absent parts must be zero.
    let written = words(&settings);
    let is_same =
        written.iter().zip(bytes.chunks_exact(4)).all(|(word, bytes)| word.to_le_bytes() == bytes);
    match pass.end() {
        Ok(STAGE_BYTES) if is_same => Ok(Some(settings)),
        _ => Err(TraceError::Layout),
    }
}
