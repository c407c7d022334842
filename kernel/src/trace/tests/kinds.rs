//! Headers with an output stage, ticks without a sample, and records that were not finished.

use super::*;
use crate::stage::{Coupling, Passivity, StageSettings};

/// Returns settings with every part present and all numbers different.
fn stage() -> StageSettings {
    StageSettings {
        tick_s: 0.5e-3,
        coupling: Some(Coupling { stiffness_n_per_m: 900.0, damping_n_s_per_m: 0.75 }),
        passivity: Some(Passivity { device_damping_n_s_per_m: 0.125, delay_ticks: 1 }),
        max_slew_n_per_s: 300.0,
        max_force_n: 3.25,
        max_speed_m_per_s: 4.0,
        ramp_ticks: 200,
        watchdog_ticks: 20,
    }
}

fn staged(stage: StageSettings) -> Vec<u8> {
    written(&Header { stage: Some(stage), ..header() }, &held().0, &session()[..4])
}

// REQ-TRC-01
#[test]
fn a_stage_is_read_as_written() {
    let whole = stage();
    let coupling = StageSettings { passivity: None, ..whole };
    let passivity = StageSettings { coupling: None, ..whole };
    for stage in [whole, coupling, passivity, StageSettings::NONE] {
        let trace = staged(stage);
        let reader = Reader::open(&trace).unwrap();
        assert_eq!(reader.header(), &Header { stage: Some(stage), ..header() });
        assert_eq!(reader.contacts().collect::<Vec<_>>(), held().0);
        assert_eq!(*reader.header().output_stage().unwrap().unwrap().settings(), stage);
        let (records, end) = read(&trace).unwrap();
        assert_eq!((records.len(), end), (4, End::Complete));
    }
    let plain = trace();
    assert_eq!(Reader::open(&plain).unwrap().header().output_stage(), Ok(None));
}

#[test]
fn the_bytes_of_a_stage_are_those_of_the_table() {
    let trace = staged(stage());
    let word = |at: usize| u32::from_le_bytes(*trace[at..].first_chunk().unwrap());
    assert_eq!([8, 12, 52].map(word), [5, 144, 3]);
    assert_eq!([84, 96, 104, 120, 124].map(word), [1, 1, 1, 200, 20]);
    assert_eq!(trace[74..76], [1, 0]);
    let floats = [0.5e-3, 900.0, 0.75, 0.125, 300.0, 3.25, 4.0_f32].map(f32::to_bits);
    assert_eq!([80, 88, 92, 100, 108, 112, 116].map(word), floats);
    assert_eq!([128, 132, 136, 140].map(word), [held().0[0], held().0[1], held().0[2], 0]);
    assert_eq!(trace.len(), 144 + 4 * 48);
}

// REQ-TRC-03
#[test]
fn no_changed_byte_of_a_stage_goes_unseen_and_no_cut() {
    let mut trace = staged(stage());
    for at in 0..144 {
        assert!(matches!(read(&trace[..at]), Err(TraceError::Truncated | TraceError::Magic)));
        for flip in 1..=255 {
            trace[at] ^= flip;
            use TraceError::{Checksum, Magic, Version};
            let found = read(&trace);
            assert!(matches!(found, Err(Magic | Version(_) | Checksum)), "{at} {flip}: {found:?}");
            trace[at] ^= flip;
        }
    }
}

/// A checksum that matches does not make invalid settings valid.
// REQ-TRC-05
#[test]
fn a_stage_that_contradicts_itself_is_refused() {
    for (at, word) in [(84, 2), (84, 0), (96, 0), (88, 1), (104, 256), (116, 0x7FC0_0000)] {
        let none = (at == 88).then_some(StageSettings::NONE);
        let mut trace = staged(none.unwrap_or(stage()));
        trace[at..at + 4].copy_from_slice(&u32::to_le_bytes(word));
        let crc = {
            let mut digest = CRC.digest();
            digest.update(&trace[..60]);
            digest.update(&trace[64..144]);
            digest.finalize()
        };
        trace[60..64].copy_from_slice(&crc.to_le_bytes());
        assert_eq!(Reader::open(&trace).err(), Some(TraceError::Layout), "{word} at {at}");
    }
}

/// A killed writer may have stored any part of its last record, except for the checksum.
// REQ-TRC-02
#[test]
fn a_record_that_was_not_finished_is_a_cut() {
    let whole = trace();
    let at = whole.len() - RECORD_BYTES;
    let all: Vec<_> = session().iter().map(bits).collect();
    for behind in [0, 1, RECORD_BYTES, 3 * RECORD_BYTES] {
        for stored in 0..44 {
            for (from, to) in [(0, stored), (stored, 44)] {
                let mut trace = whole.clone();
                trace[at..].fill(0);
                trace[at + from..at + to].copy_from_slice(&whole[at + from..at + to]);
                trace.resize(at + RECORD_BYTES + behind, 0);
                let nothing = trace[at..].iter().all(|&byte| byte == 0);
                let last = TICKS - 1;
                let end = if nothing { End::Complete } else { End::Cut(last as u32) };
                assert_eq!(read(&trace), Ok((all[..last].to_vec(), end)), "{from}..{to}");
                if !nothing && behind > 0 {
                    // With other bytes after it, the record is damaged.
                    *trace.last_mut().unwrap() = 1;
                    assert_eq!(read(&trace).unwrap().1, End::Damaged(last as u32));
                }
            }
        }
    }
}

/// A release without grips and pins does not know kind 5, and takes no such record for another command.
#[test]
fn commands_to_a_tool_are_of_a_kind_of_their_own() {
    let stiffness_n_per_m = f32::INFINITY;
    let grips = [
        Command::Grip { tool: 3 },
        Command::LetGo { tool: 3, ticks: 40 },
        Command::Pin { tool: 3, stiffness_n_per_m: 20.0 },
        Command::Unpin { pin: 7, ticks: 20 },
        Command::PinAt { point_m: [0.1, -0.2, 0.3], radius_m: 0.01, stiffness_n_per_m },
    ];
    for command in grips.into_iter().chain([Command::Reset]) {
        let mut trace = vec![0; header_bytes(HELD.len())];
        let (mut writer, _) = Writer::begin(&header(), &held().0, &mut trace).unwrap();
        let record = CommandRecord { tick: 1000, command, state_hash: Some(9) };
        trace.extend(writer.record(&session()[0]));
        let at = trace.len();
        trace.extend(writer.command(&record));
        let is_of_tool = grips.contains(&command);
        let (own, other) = if is_of_tool { (5, 2) } else { (2, 5) };
        assert_eq!(u16::from_le_bytes([trace[at + 32], trace[at + 33]]), own);
        let wanted = (vec![Ok(1000), Err(record)], End::Complete);
        assert_eq!(entries(&trace), wanted);
        assert_eq!(read(&trace).unwrap().1, End::Kind(1, own));
        trace[at + 32] = other as u8;
        let place = [&trace[60..64], &1_u32.to_le_bytes(), &trace[at..at + 44]].concat();
        let crc = CRC.checksum(&place);
        trace[at + 44..at + 48].copy_from_slice(&crc.to_le_bytes());
        assert_eq!(entries(&trace), (vec![Ok(1000)], End::Kind(1, other)));
    }
}
