//! Traces of sessions: read, written again to the same bytes, played.

use std::path::Path;

use chaincell_host::files::recording;
use chaincell_kernel::tick::hash::REVISION;
use chaincell_kernel::trace::{Command, End, Entry, HEADER_BYTES, RECORD_BYTES, Reader, Writer};
use crc::{CRC_32_ISO_HDLC, Crc};

use super::bodies;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// Bytes in front of the revision, the checksum the last four.
const COMMON_BYTES: usize = 64;
/// Bytes of an output stage's settings.
const STAGE_BYTES: usize = 48;
/// Most sweeps a tick, most contacts and most records of a trace that is played.
const SWEEPS_MAX: u16 = 8;
const CONTACTS_MAX: usize = 64;
const RECORDS_MAX: u32 = 48;

/// A trace as it is, then with checksums set right and of a model that is here.
pub fn trace(data: &[u8]) {
    read(data);
    if data.len() >= HEADER_BYTES {
        read(&mended(data));
    }
}

fn word(data: &[u8], at: usize) -> u32 {
    data[at..].first_chunk().map_or(0, |word| u32::from_le_bytes(*word))
}

fn put(data: &mut [u8], at: usize, word: u32) {
    data[at..at + 4].copy_from_slice(&word.to_le_bytes());
}

/// With the header's length, model, revision and checksum, and those of the records.
fn mended(data: &[u8]) -> Vec<u8> {
    let mut trace = data.to_vec();
    let most = (data.len() - HEADER_BYTES) / 4;
    let contacts = (word(data, 52) as usize).min(most).min(CONTACTS_MAX);
    let front = HEADER_BYTES + if data[74] & 1 != 0 { STAGE_BYTES } else { 0 };
    let bytes = (front + 4 * contacts).next_multiple_of(8);
    trace.resize(trace.len().max(bytes), 0);
    put(&mut trace, 12, bytes as u32);
    put(&mut trace, 52, contacts as u32);
    put(&mut trace, COMMON_BYTES, REVISION);
    put(&mut trace, 16, chosen(word(data, 16)).checksum());
    let seed = {
        let mut digest = CRC.digest();
        digest.update(&trace[..COMMON_BYTES - 4]);
        digest.update(&trace[COMMON_BYTES..bytes]);
        digest.finalize()
    };
    put(&mut trace, COMMON_BYTES - 4, seed);
    for (index, record) in (0_u32..).zip(trace[bytes..].chunks_exact_mut(RECORD_BYTES)) {
        let mut digest = CRC.digest();
        digest.update(&seed.to_le_bytes());
        digest.update(&index.to_le_bytes());
        digest.update(&record[..RECORD_BYTES - 4]);
        put(record, RECORD_BYTES - 4, digest.finalize());
    }
    trace
}

/// The model of this checksum, else one that the checksum picks.
fn chosen(checksum: u32) -> chaincell_kernel::Model<'static> {
    let count = bodies::images().len() as u8;
    let all = (0..count).map(bodies::model);
    let pick = checksum.to_le_bytes()[0];
    all.into_iter()
        .find(|model| model.checksum() == checksum)
        .unwrap_or_else(|| bodies::model(pick))
}

fn read(data: &[u8]) {
    let Ok(trace) = Reader::open(data) else { return };
    let written = Written::of(&trace);
    // What stands in it once more, byte by byte, whatever else the padding held.
    let again = Reader::open(&written.bytes).unwrap();
    assert!(again.contacts().eq(trace.contacts()));
    let again = Written::of(&again);
    assert!(again.bytes == written.bytes && again.end == End::Complete);
    if written.records <= RECORDS_MAX && written.sweeps <= SWEEPS_MAX {
        play(&trace);
    }
}

/// What was read of a trace, written anew.
struct Written {
    bytes: Vec<u8>,
    records: u32,
    /// Most that are asked for.
    sweeps: u16,
    end: End,
}

impl Written {
    fn of(trace: &Reader<'_>) -> Self {
        let ids: Vec<u32> = trace.contacts().collect();
        let mut bytes = vec![0; trace.header().bytes(ids.len())];
        let (mut writer, _) = Writer::begin(trace.header(), &ids, &mut bytes).unwrap();
        let (mut records, mut sweeps) = (0, trace.header().settings.sweeps);
        let end = trace.entries(|_, entry| {
            records += 1;
            match entry {
                Entry::Part(record) => bytes.extend(writer.part(record).as_flattened()),
                Entry::Pose(record) => bytes.extend(writer.pose(record)),
                Entry::Tick(record) => bytes.extend(writer.record(record)),
                Entry::Command(record) => {
                    if let Command::Sweeps(asked) = record.command {
                        sweeps = sweeps.max(asked);
                    }
                    bytes.extend(writer.command(record));
                }
            }
            Ok::<(), ()>(())
        });
        Self { bytes, records, sweeps, end: end.unwrap() }
    }
}

fn play(trace: &Reader<'_>) {
    let model = chosen(trace.header().model);
    let Ok((mut tissue, ..)) = recording::tissue(trace, Path::new("fuzz.trace"), model) else {
        return;
    };
    let mut played = recording::Played::default();
    let _ =
        recording::play(trace, &mut tissue, recording::Start::default(), &mut played, |_, _| true);
    assert!(played.compared <= played.ticks + played.commands);
}
