//! Path files: every error names line and field, every number reads back.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::io::{BufReader, Read};

use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::order::TICK_JUMP_MAX;
use chaincell_host::error::Result;
use chaincell_host::files::path::{HEADER, Rules, parse, to_text};
use proptest::prelude::*;

fn strict(text: &str) -> Result<Vec<Vec<Pose>>> {
    parse(text.as_bytes(), "p.csv", Rules::Strict).map(|paths| paths.poses)
}

fn error(text: &str) -> String {
    strict(text).unwrap_err().to_string()
}

#[test]
fn errors_name_line_and_field() {
    let rows = |rows: &str| error(&format!("{HEADER}\n{rows}"));
    for (text, wanted) in [
        ("5,0,0,0,0\n7,0,0,0,0\n", "p.csv:3: field tick 7: must be 6"),
        ("5,0,0,0,0\n5,0,0,0,0\n", "p.csv:3: field tick 5: must be 6"),
        ("0,0,NaN,0,0\n", "p.csv:2: field y_m `NaN`: must be finite"),
        ("0,0,0,1e39,0\n", "p.csv:2: field z_m `1e39`: must be finite"),
        ("0,0,0,a,0\n", "p.csv:2: field z_m `a`: must be a number"),
        ("0,0,0,0,2\n", "p.csv:2: field engaged `2`: must be 0 or 1"),
        ("0,0,0,0\n", "p.csv:2: 4 fields"),
        ("-1,0,0,0,0\n", "p.csv:2: field tick `-1`"),
        ("18446744073709551615,0,0,0,0\n0,0,0,0,0\n", "p.csv:3: field tick 0: must be"),
        ("", "p.csv: no rows"),
    ] {
        let got = rows(text);
        assert!(got.starts_with(wanted), "{got}");
    }
    assert!(error("tick,x,y,z,e\n").starts_with("p.csv:1: the header is"));
    assert!(error("").starts_with("p.csv: no rows"));
    let bytes: &[u8] = b"tick,x_m,y_m,z_m,engaged\n0,\xff,0,0,0\n";
    let binary = parse(bytes, "p.csv", Rules::Strict).unwrap_err().to_string();
    assert!(binary.starts_with("p.csv:2: not text"), "{binary}");
}

#[test]
fn line_ends_of_every_kind_are_read() {
    for end in ["\n", "\r\n", "\r"] {
        let text = [HEADER, "3,1,2,3,1", "4,1,2,3,1", ""].join(end);
        for bytes in [1, 7, 4096] {
            let text = BufReader::with_capacity(bytes, text.as_bytes());
            let poses = parse(text, "p.csv", Rules::Strict).unwrap().poses;
            assert_eq!((poses[0].len(), poses[0][1].tick), (2, 4), "{end:?} {bytes}");
        }
        let wrong = error(&[HEADER, "3,1,2,3,1", "4,x,2,3,1", ""].join(end));
        assert!(wrong.starts_with("p.csv:3: field x_m `x`"), "{end:?} {wrong}");
    }
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    assert_eq!(strict(&format!("\u{feff}{HEADER}\n3,1,2,3,1\n")).unwrap()[0][0].tick, 3);
}

#[test]
fn a_line_without_end_is_read_no_further_than_the_longest_line() {
    let row = |bytes: usize| format!("{HEADER}\n3,1,2,3,{:0>1$}\n", 1, bytes - 9);
    assert_eq!(strict(&row(4096)).unwrap()[0][0].engaged, 1);
    assert!(error(&row(4097)).starts_with("p.csv:2: the line has more than 4096 bytes: save"));
    let front = format!("{HEADER}\n");
    let endless = front.as_bytes().chain(BufReader::new(std::io::repeat(b'1')));
    let why = parse(endless, "p.csv", Rules::Recorded).unwrap_err().to_string();
    assert!(why.starts_with("p.csv:2: the line has more than 4096 bytes"), "{why}");
}

#[test]
fn a_count_that_goes_on_far_ahead_begins_a_sequence() {
    let pose = |tick| Pose { tick, ..Pose::default() };
    let end = 5 + TICK_JUMP_MAX;
    let back = parse(to_text([5, end, 2 * end].map(pose)).as_bytes(), "p.csv", Rules::Recorded);
    let lengths: Vec<usize> = back.unwrap().poses.iter().map(Vec::len).collect();
    assert_eq!(lengths, [2, 1]);
}

#[test]
fn a_controller_that_numbers_anew_begins_a_sequence() {
    let pose = |tick| Pose { tick, ..Pose::default() };
    let text = to_text([5, 6, 2, 3, 3].map(pose));
    let back = parse(text.as_bytes(), "p.csv", Rules::Recorded).unwrap().poses;
    let ticks: Vec<Vec<u64>> =
        back.iter().map(|poses| poses.iter().map(|pose| pose.tick).collect()).collect();
    assert_eq!(ticks, [vec![5, 6], vec![2, 3], vec![3]]);
    assert!(error(&text).starts_with("p.csv:4: "), "{}", error(&text));
}

proptest! {
    #[test]
    fn text_round_trips_every_bit(bits in prop::collection::vec(any::<[u32; 3]>(), 1..20)) {
        let poses: Vec<Pose> = (bits.iter().enumerate())
            .map(|(tick, bits)| Pose {
                tick: tick as u64,
                position_m: bits.map(|bits| Some(f32::from_bits(bits))
                    .filter(|x| !x.is_nan()).unwrap_or(f32::NAN)),
                engaged: bits[0],
                sweeps: (tick % 3 != 0).then_some(tick as u16),
            })
            .collect();
        let text = to_text(poses.iter().copied());
        let back = parse(text.as_bytes(), "p.csv", Rules::Recorded).unwrap().poses;
        let key = |pose: &Pose| {
            (pose.tick, pose.position_m.map(f32::to_bits), pose.engaged, pose.sweeps)
        };
        prop_assert!(back.iter().flatten().map(key).eq(poses.iter().map(key)));
    }

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut text = format!("{HEADER}\n").into_bytes();
        text.extend(bytes);
        let _ = parse(text.as_slice(), "p.csv", Rules::Strict);
    }
}
