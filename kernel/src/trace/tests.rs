//! A session on the plane, its trace written, damaged and played.

mod kinds;
mod tools;
mod versions;

use std::string::ToString;
use std::vec;
use std::vec::Vec;

use nalgebra::Vector3;
use proptest::prelude::*;

use super::*;
use crate::contact::pose::ToolPose;
use crate::model::Model;
use crate::solver::Track;
use crate::tick::budget::Budget;
use crate::tick::choice::Choice;
use crate::tick::choices::{Cutting, Drive, Unloading};
use crate::tick::hash::REVISION;
use crate::tick::settings::{Network, Settings};
use crate::tick::tissue::Tissue;

static PLANE: &[u8] = crate::include_model!("../../../tests/data/plane9.chaincell");
static OTHER: &[u8] = crate::include_model!("../../../tests/data/plane4.chaincell");
/// Input ids of the held cells.
const HELD: [u32; 3] = [31, 40, 49];
const TICKS: usize = 30;

fn model() -> Model<'static> {
    Model::from_bytes(PLANE).unwrap()
}

fn settings() -> Settings {
    let unloading = Unloading::Retreat;
    Settings { sweeps: 3, unloading, max_force_n: 0.7, ..Settings::for_model(&model()) }
}

/// Returns the input ids in the order of the model's cells, and the cells.
fn held() -> (Vec<u32>, Vec<u16>) {
    let mut cells: Vec<u16> = HELD.iter().map(|&id| model().cell_of_input(id).unwrap()).collect();
    cells.sort_unstable();
    (cells.iter().map(|&cell| model().input_id()[usize::from(cell)]).collect(), cells)
}

fn sample(tick: usize) -> ToolPose {
    let z = if tick == 11 { f32::NAN } else { -0.001 * tick as f32 };
    ToolPose::at(Vector3::new(0.0, -0.0, z), u32::from(tick < 24))
}

/// A tissue as at the beginning of the session.
fn begin(network: &Network<'_>, cells: &[u16]) -> Tissue<81, Track, 4> {
    let mut tissue = Tissue::new();
    tissue.reset(network).unwrap();
    tissue.choose_contacts(network, cells).unwrap();
    tissue
}

fn header() -> Header {
    Header::of::<Track>(&Network::new(model(), settings()).unwrap()).unwrap()
}

/// The session's ticks; every third without a hash.
fn session() -> Vec<Record> {
    let network = Network::new(model(), settings()).unwrap();
    let mut tissue = begin(&network, &held().1);
    (0..TICKS)
        .map(|tick| {
            let sample = sample(tick);
            tissue.tick(&network, &[sample], Budget::All);
            let hash = tissue.view().state_hash(&model());
            let state_hash = (tick % 3 != 2).then_some(hash);
            Record { state_hash, ..Record::of(1000 + 7 * tick as u64, sample) }
        })
        .collect()
}

fn written(header: &Header, ids: &[u32], records: &[Record]) -> Vec<u8> {
    let mut trace = vec![0xff; 5 * HEADER_BYTES];
    let (mut writer, bytes) = Writer::begin(header, ids, &mut trace).unwrap();
    assert_eq!(bytes, header.bytes(ids.len()));
    trace.truncate(bytes);
    records.iter().for_each(|record| trace.extend(writer.record(record)));
    trace
}

fn trace() -> Vec<u8> {
    written(&header(), &held().0, &session())
}

/// All bits of a record.
type Bits = (u64, [u32; 3], u32, [Option<u16>; 2], bool, Option<u64>);

fn bits(record: &Record) -> Bits {
    let position = record.sample.position_m.data.0[0].map(f32::to_bits);
    let Record { tick, sample, sweeps, ramp_restarted, delay_ticks, state_hash } = *record;
    (tick, position, sample.acting(), [sweeps, delay_ticks], ramp_restarted, state_hash)
}

/// Returns all records that a reader finds, and their end.
fn read(trace: &[u8]) -> Result<(Vec<Bits>, End), TraceError> {
    let mut found = Vec::new();
    let end = Reader::open(trace)?.records(|index, record| {
        assert_eq!(index as usize, found.len());
        found.push(bits(record));
        Ok::<(), ()>(())
    });
    Ok((found, end.unwrap()))
}

fn play(trace: &[u8]) -> Result<Played, ReplayError> {
    let trace = Reader::open(trace).unwrap();
    let network = trace.header().network(model()).unwrap();
    let mut room = [0; 4];
    let mut tissue = begin(&network, trace.contact_cells(&model(), &mut room).unwrap());
    trace.play(|record| {
        tissue.tick(&network, &[record.sample], Budget::again(record.sweeps));
        tissue.view().state_hash(&model())
    })
}

// REQ-TRC-01
#[test]
fn a_session_is_read_as_written_and_played_to_the_same_bits() {
    let trace = trace();
    let reader = Reader::open(&trace).unwrap();
    assert_eq!(reader.header(), &header());
    assert_eq!(reader.contacts().collect::<Vec<_>>(), held().0);
    let wanted: Vec<_> = session().iter().map(bits).collect();
    assert_eq!(read(&trace), Ok((wanted, End::Complete)));
    assert_eq!(play(&trace), Ok(Played { ticks: 30, compared: 20, end: End::Complete }));
}

/// Compares with bytes that are assembled by hand from the format's table.
#[test]
fn the_bytes_are_those_of_the_table() {
    let trace = trace();
    let word = |at: usize| u32::from_le_bytes(*trace[at..].first_chunk().unwrap());
    let crc = |parts: &[&[u8]]| {
        let mut digest = CRC.digest();
        parts.iter().for_each(|part| digest.update(part));
        digest.finalize()
    };
    assert_eq!(trace[..8], *b"CHAINTRC");
    assert_eq!([word(8), word(12), word(16)], [5, 96, model().checksum()]);
    assert_eq!(trace[20..24], [0, 0, 1, 0]);
    let s = settings();
    let floats = [s.step, s.tick_time, s.max_tool_step_m, s.max_force_n].map(f32::to_bits);
    assert_eq!([word(24), word(44), word(48)], [3, 2, 0]);
    assert_eq!([28, 32, 36, 40].map(word), floats);
    assert_eq!([52, 56].map(word), [3, 0]);
    assert_eq!(word(60), crc(&[&trace[..60], &trace[64..96]]));
    let [major, minor, patch] = Origin::HERE.release.map(u32::from);
    assert_eq!([64, 68, 72, 76].map(word), [REVISION, major | minor << 16, patch, 0]);
    assert_eq!([80, 84, 88, 92].map(word), [held().0[0], held().0[1], held().0[2], 0]);
    let (at, record) = (96 + 4 * 48, session()[4]);
    assert_eq!(trace[at..at + 8], 1028_u64.to_le_bytes());
    assert_eq!([8, 12, 16].map(|by| word(at + by)), bits(&record).1);
    assert_eq!(word(at + 20), 1);
    assert_eq!(trace[at + 24..at + 32], record.state_hash.unwrap().to_le_bytes());
    assert_eq!(trace[at + 32..at + 36], [1, 0, 1, 0]);
    let place = [word(60).to_le_bytes(), 4_u32.to_le_bytes()].concat();
    assert_eq!([36, 40].map(|by| word(at + by)), [0, 0]);
    assert_eq!(word(at + 44), crc(&[&place, &trace[at..at + 44]]));
    assert_eq!(trace.len(), 96 + TICKS * 48);
}

// REQ-TRC-02
#[test]
fn cut_at_every_byte_it_is_read_up_to_the_last_whole_record() {
    let trace = trace();
    let front = header_bytes(HELD.len());
    let all: Vec<_> = session().iter().map(bits).collect();
    for cut in 0..trace.len() {
        let found = read(&trace[..cut]);
        if cut < front {
            let wanted = if cut == 0 { TraceError::Magic } else { TraceError::Truncated };
            assert_eq!(found, Err(wanted), "cut at {cut}");
            continue;
        }
        let (whole, part) = ((cut - front) / RECORD_BYTES, (cut - front) % RECORD_BYTES);
        let end = if part == 0 { End::Complete } else { End::Cut(whole as u32) };
        assert_eq!(found, Ok((all[..whole].to_vec(), end)), "cut at {cut}");
    }
}

// REQ-TRC-03
#[test]
fn no_changed_byte_goes_unseen() {
    let mut trace = trace();
    let front = header_bytes(HELD.len());
    let all: Vec<_> = session().iter().map(bits).collect();
    for at in 0..trace.len() {
        for flip in 1..=255 {
            trace[at] ^= flip;
            let found = read(&trace);
            if at < front {
                use TraceError::{Checksum, Magic, Version};
                assert!(matches!(found, Err(Magic | Version(_) | Checksum)), "{at}: {found:?}");
            } else {
                let record = (at - front) / RECORD_BYTES;
                let wanted = (all[..record].to_vec(), End::Damaged(record as u32));
                assert_eq!(found, Ok(wanted), "byte {at} by {flip:02x}");
            }
            trace[at] ^= flip;
        }
    }
}

// REQ-TRC-02
#[test]
fn memory_taken_beforehand_ends_where_its_zeros_begin() {
    let mut trace = trace();
    let whole = read(&trace).unwrap();
    let length = trace.len();
    for zeros in [1, RECORD_BYTES - 1, RECORD_BYTES, 5 * RECORD_BYTES + 3] {
        trace.resize(length + zeros, 0);
        assert_eq!(read(&trace), Ok(whole.clone()), "{zeros}");
    }
    // Zeros with other bytes after them are not the end.
    trace.push(1);
    assert_eq!(read(&trace).unwrap().1, End::Damaged(TICKS as u32));
}

// REQ-TRC-03
#[test]
fn records_hold_at_their_place_in_their_trace_alone() {
    let trace = trace();
    let front = header_bytes(HELD.len());
    let mut swapped = trace.clone();
    swapped[front..front + 2 * RECORD_BYTES].rotate_left(RECORD_BYTES);
    assert_eq!(read(&swapped).unwrap().1, End::Damaged(0));
    let settings = Settings { sweeps: 4, ..settings() };
    let mut remains = written(&Header { settings, ..header() }, &held().0, &session()[..10]);
    remains.extend(&trace[remains.len()..]);
    assert_eq!(read(&remains).unwrap().1, End::Damaged(10));
}

// REQ-TRC-04
#[test]
fn the_first_other_tick_is_named() {
    let mut records = session();
    // The record is sound but altered: in the replay the body moves differently from here on.
    records[17].sample.position_m.z -= 0.004;
    let refused = play(&written(&header(), &held().0, &records)).unwrap_err();
    // Record 17 has no hash.
    assert_eq!((refused.record, refused.tick), (18, 1126));
    assert!(refused.to_string().starts_with("tick 1126 (record 18) is the first"), "{refused}");
    let mut records = session();
    records[9].state_hash = Some(1);
    let refused = play(&written(&header(), &held().0, &records)).unwrap_err();
    let here = session()[9].state_hash.unwrap();
    assert_eq!(refused, ReplayError { record: 9, tick: 1063, recorded: 1, here });
}

/// Returns a trace with one word of its header changed and a checksum that matches.
fn reworded(at: usize, word: u32) -> Vec<u8> {
    let mut trace = trace();
    trace[at..at + 4].copy_from_slice(&word.to_le_bytes());
    let mut digest = CRC.digest();
    digest.update(&trace[..60]);
    digest.update(&trace[64..header_bytes(HELD.len())]);
    let crc = digest.finalize();
    trace[60..64].copy_from_slice(&crc.to_le_bytes());
    trace
}

// REQ-TRC-05
#[test]
fn what_cannot_be_played_is_refused_with_its_reason() {
    let trace = trace();
    let reader = Reader::open(&trace).unwrap();
    let other = Model::from_bytes(OTHER).unwrap();
    let (recorded, given) = (model().checksum(), other.checksum());
    let refused = reader.header().network(other).unwrap_err();
    assert_eq!(refused, TraceError::Model { recorded, given });
    assert!(refused.to_string().contains("give the model of the recording"), "{refused}");
    let refused = reader.contact_cells(&model(), &mut [0; 2]).err();
    assert_eq!(refused, Some(TraceError::Contacts { needed: 3, room: 2 }));
    assert_eq!(read(b"tick,x_m"), Err(TraceError::Magic));
    // One of these has contact cells as well as tools.
    let words = [(44, 3), (48, 2), (24, 65_536), (56, 1), (72, 2 << 16), (72, 4 << 16), (76, 1)];
    for (at, word) in words {
        assert_eq!(read(&reworded(at, word)), Err(TraceError::Layout), "{at}");
    }
    // Unknown schemes and number types.
    for (scheme, number) in [(77, 1), (2, 9)] {
        let found = read(&reworded(20, scheme | number << 16));
        assert_eq!(found, Err(TraceError::Scheme(scheme as u16, number as u16)));
    }
    // A contact node that is no cell.
    let stranger = reworded(80, 4000);
    let refused = Reader::open(&stranger).unwrap().contact_cells(&model(), &mut [0; 4]).err();
    assert_eq!(refused, Some(TraceError::Contact(4000)));
    let drive = |trace: &[u8]| Reader::open(trace).unwrap().header().settings.drive;
    assert_eq!([drive(&trace), drive(&reworded(48, 1))], [Drive::Position, Drive::Current]);
    // Cutting off stands above the drive; a trace without that word has it on.
    let settings = |trace: &[u8]| Reader::open(trace).unwrap().header().settings;
    assert_eq!(settings(&trace).cut, Cutting::On);
    let off = settings(&reworded(48, 1 << 16 | 1));
    assert_eq!((off.drive, off.cut), (Drive::Current, Cutting::Off));
    let settings = Settings { cut: Cutting::Off, ..self::settings() };
    let bytes = written(&Header { settings, ..header() }, &held().0, &[]);
    assert_eq!(bytes[48..52], [0, 0, 1, 0]);
    assert_eq!(Reader::open(&bytes).unwrap().header().settings, settings);
    assert_eq!(Reader::open(&reworded(48, 2 << 16)).err(), Some(TraceError::Layout));
    // Settings that do not fit the model.
    let sweepless = reworded(24, 0);
    let refused = Reader::open(&sweepless).unwrap().header().network(model()).err();
    assert!(matches!(refused, Some(TraceError::Settings(_))), "{refused:?}");
}

#[test]
fn a_command_is_not_taken_for_a_sample() {
    let mut trace = trace();
    let at = header_bytes(HELD.len()) + 3 * RECORD_BYTES;
    trace[at + 32] = KIND_COMMAND as u8;
    let place = [&trace[60..64], &3_u32.to_le_bytes(), &trace[at..at + 44]].concat();
    let crc = CRC.checksum(&place);
    trace[at + 44..at + 48].copy_from_slice(&crc.to_le_bytes());
    let (records, end) = read(&trace).unwrap();
    assert_eq!((records.len(), end), (3, End::Kind(3, KIND_COMMAND)));
}

/// Returns all entries of a trace, ticks by their numbers.
fn entries(trace: &[u8]) -> (Vec<Result<u64, CommandRecord>>, End) {
    let mut found = Vec::new();
    let end = Reader::open(trace).unwrap().entries(|index, entry| {
        assert_eq!(index as usize, found.len());
        found.push(match entry {
            Entry::Tick(record) => Ok(record.tick),
            Entry::Command(command) => Err(*command),
            other => panic!("{other:?}"),
        });
        Ok::<(), ()>(())
    });
    (found, end.unwrap())
}

#[test]
fn commands_stand_between_the_ticks() {
    let mut trace = vec![0; header_bytes(HELD.len())];
    let (mut writer, _) = Writer::begin(&header(), &held().0, &mut trace).unwrap();
    let (pause, step) = (Command::Pause, Command::MaxToolStepM(0.002));
    let commands = [
        CommandRecord { tick: 1000, command: pause, state_hash: Some(u64::MAX - 1) },
        CommandRecord { tick: 1000, command: step, state_hash: None },
    ];
    trace.extend(writer.record(&session()[0]));
    commands.iter().for_each(|command| trace.extend(writer.command(command)));
    trace.extend(writer.record(&session()[1]));
    let wanted = vec![Ok(1000), Err(commands[0]), Err(commands[1]), Ok(1007)];
    assert_eq!(entries(&trace), (wanted, End::Complete));
    let words = [20, 24, 28].map(|by| header_bytes(HELD.len()) + 2 * RECORD_BYTES + by - 12);
    let word = |at: usize| u32::from_le_bytes(*trace[at..].first_chunk().unwrap());
    assert_eq!(words.map(word), [4, 3, 0.002_f32.to_bits()]);
    // A reader of samples stops there, and a reader of all entries at a command that it does not know.
    assert_eq!(read(&trace).unwrap().1, End::Kind(1, KIND_COMMAND));
    let at = header_bytes(HELD.len()) + RECORD_BYTES;
    trace[at + 8] = 77;
    let place = [&trace[60..64], &1_u32.to_le_bytes(), &trace[at..at + 44]].concat();
    let crc = CRC.checksum(&place);
    trace[at + 44..at + 48].copy_from_slice(&crc.to_le_bytes());
    assert_eq!(entries(&trace), (vec![Ok(1000)], End::Kind(1, KIND_COMMAND)));
}

#[test]
fn every_scheme_and_number_has_a_code_of_its_own() {
    use crate::solver::{Euler, Predict, Rkl2};
    use fixed::types::I8F24;
    let network = Network::new(model(), settings()).unwrap();
    let all = [
        Header::of::<Euler>(&network),
        Header::of::<Track<40>>(&network),
        Header::of::<Rkl2>(&network),
        Header::of::<Euler<I8F24>>(&network),
        Header::of::<Predict<40>>(&network),
    ];
    let codes = all.map(|header| header.map(|of| (of.scheme.code(), of.number.code())).unwrap());
    assert_eq!(codes, [(1, 1), (0, 1), (3, 1), (1, 2), (7, 1)]);
    assert!(all[3].unwrap().is_of::<Euler<I8F24>>() && !all[3].unwrap().is_of::<Euler>());
}

#[test]
fn a_header_needs_its_room() {
    let mut room = [0; 96];
    assert!(Writer::begin(&header(), &HELD, &mut room[..95]).is_none());
    assert!(Writer::begin(&header(), &HELD, &mut room).is_some());
    assert!(Writer::begin(&header(), &vec![0; 70_000], &mut vec![0; 300_000]).is_none());
}

proptest! {
    // REQ-TRC-01, REQ-COS-12
    #[test]
    fn every_bit_of_a_record_comes_back(
        words in prop::collection::vec((any::<u64>(), any::<[u32; 4]>(), prop::option::of(prop_oneof![any::<u64>(), Just(0), Just(1 << 32)]), prop::option::of(any::<u16>()), prop::option::of(0_u16..=1000), any::<bool>()), 0..9),
    ) {
        let records: Vec<Record> = words
            .iter()
            .map(|&(tick, [x, y, z, engaged], state_hash, sweeps, delay_ticks, ramp_restarted)| {
                let position_m = Vector3::from([x, y, z].map(f32::from_bits));
                let sample = ToolPose::at(position_m, 0).with_acting(engaged);
                Record { tick, sample, sweeps, ramp_restarted, delay_ticks, state_hash }
            })
            .collect();
        let (found, end) = read(&written(&header(), &HELD, &records)).unwrap();
        prop_assert_eq!(end, End::Complete);
        prop_assert!(found.iter().copied().eq(records.iter().map(bits)));
    }

    // REQ-TRC-05
    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), at in 0_usize..200) {
        let _ = read(&bytes);
        let mut trace = trace();
        trace.truncate(at + bytes.len());
        let end = trace.len().min(at + bytes.len());
        trace[at.min(end)..end].copy_from_slice(&bytes[..end - at.min(end)]);
        let _ = read(&trace);
    }
}
