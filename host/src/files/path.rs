//! Path files: one tool pose a row, `tick,x_m,y_m,z_m,engaged`.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::engine::motion::Pose;
use crate::error::{Error, Result};

/// First line of every path file.
pub const HEADER: &str = "tick,x_m,y_m,z_m,engaged";
/// Largest number of rows that is read: a day and a quarter at 1 kHz.
const ROWS_MAX: u64 = 100_000_000;

/// What a path may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rules {
    /// Ticks strictly consecutive, numbers finite, `engaged` 0 or 1.
    Strict,
    /// A recorded session: any number, any `engaged`, any order of ticks.
    Recorded,
}

/// Reads a path file: its sequences of poses, one unless the header stands again before a row of
/// a recorded session, where another controller took over and numbered anew.
///
/// # Errors
/// File, line and field of the first thing that breaks the rules, and the remedy.
pub fn read(path: &Path, rules: Rules) -> Result<Vec<Vec<Pose>>> {
    let file = File::open(path).map_err(|why| Error::file("open path", path, why))?;
    parse(BufReader::new(file), &path.display().to_string(), rules)
}

/// The same from any text; `name` stands for the file.
///
/// # Errors
/// As [`read`].
pub fn parse(mut text: impl BufRead, name: &str, rules: Rules) -> Result<Vec<Vec<Pose>>> {
    let mut sequences = Vec::new();
    let mut poses: Vec<Pose> = Vec::new();
    let mut bytes = Vec::new();
    for line in 1_u64.. {
        bytes.clear();
        let read = text
            .read_until(b'\n', &mut bytes)
            .map_err(|why| Error::input(format!("{name}:{line}: cannot read: {why}")))?;
        if read == 0 {
            break;
        }
        let row = std::str::from_utf8(&bytes)
            .map_err(|_| Error::input(format!("{name}:{line}: not text: save it as CSV")))?
            .trim_end_matches(['\n', '\r']);
        if line == 1 {
            if row.trim_start_matches('\u{feff}') != HEADER {
                return Err(Error::input(format!(
                    "{name}:1: the header is `{}`; it must be `{HEADER}`",
                    row.escape_debug().take(60).collect::<String>()
                )));
            }
        } else if row == HEADER && rules == Rules::Recorded {
            sequences.push(std::mem::take(&mut poses));
        } else if line > ROWS_MAX {
            return Err(Error::input(format!(
                "{name}:{line}: more than {ROWS_MAX} rows: split it"
            )));
        } else {
            let pose =
                pose(row, rules).map_err(|why| Error::input(format!("{name}:{line}: {why}")))?;
            follows(poses.last(), &pose, rules)
                .map_err(|why| Error::input(format!("{name}:{line}: {why}")))?;
            poses.push(pose);
        }
    }
    sequences.push(poses);
    if sequences.iter().all(Vec::is_empty) {
        return Err(Error::input(format!("{name}: no rows: a path has a header and a row a tick")));
    }
    Ok(sequences)
}

/// One row.
fn pose(row: &str, rules: Rules) -> std::result::Result<Pose, String> {
    let fields: Vec<&str> = row.split(',').map(str::trim).collect();
    let &[tick, x, y, z, engaged] = fields.as_slice() else {
        return Err(format!("{} fields; a row has 5: {HEADER}", fields.len()));
    };
    let tick =
        tick.parse().map_err(|_| format!("field tick `{tick}`: must be a whole number from 0"))?;
    let coordinate = |name: &str, text: &str| -> std::result::Result<f32, String> {
        let value: f32 =
            text.parse().map_err(|_| format!("field {name} `{text}`: must be a number [m]"))?;
        if rules == Rules::Strict && !value.is_finite() {
            return Err(format!(
                "field {name} `{text}`: must be finite in single precision; to replay a recorded \
                 session with bad poses use run with `recorded`"
            ));
        }
        Ok(value)
    };
    let position_m = [coordinate("x_m", x)?, coordinate("y_m", y)?, coordinate("z_m", z)?];
    let engaged_number: u32 =
        engaged.parse().map_err(|_| format!("field engaged `{engaged}`: must be 0 or 1"))?;
    if rules == Rules::Strict && engaged_number > 1 {
        return Err(format!("field engaged `{engaged}`: must be 0 or 1"));
    }
    Ok(Pose { tick, position_m, engaged: engaged_number })
}

/// Whether a row may stand behind the last.
fn follows(last: Option<&Pose>, pose: &Pose, rules: Rules) -> std::result::Result<(), String> {
    match last {
        Some(last) if rules == Rules::Strict && Some(pose.tick) != last.tick.checked_add(1) => {
            Err(format!(
                "field tick {}: must be {}, one above the row before; to replay a recorded session \
                 with lost poses use run with `recorded`",
                pose.tick,
                last.tick.saturating_add(1)
            ))
        }
        _ => Ok(()),
    }
}

/// The text of a path file; decimals that read back as the same single-precision numbers. Where a
/// tick is not above the one before, another controller took over: the header stands once more.
#[must_use]
pub fn to_text(poses: impl IntoIterator<Item = Pose>) -> String {
    let mut text = format!("{HEADER}\n");
    let mut last = None;
    for pose in poses {
        if last.is_some_and(|last| pose.tick <= last) {
            let _ = writeln!(text, "{HEADER}");
        }
        last = Some(pose.tick);
        let [x, y, z] = pose.position_m;
        let _ = writeln!(text, "{},{x:?},{y:?},{z:?},{}", pose.tick, pose.engaged);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn strict(text: &str) -> Result<Vec<Vec<Pose>>> {
        parse(text.as_bytes(), "p.csv", Rules::Strict)
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
    fn line_ends_of_either_kind_are_read() {
        assert_eq!(strict(&format!("{HEADER}\r\n3,1,2,3,1\r\n")).unwrap()[0][0].tick, 3);
    }

    #[test]
    fn a_controller_that_numbers_anew_begins_a_sequence() {
        let pose = |tick| Pose { tick, ..Pose::default() };
        let text = to_text([5, 6, 2, 3, 3].map(pose));
        let back = parse(text.as_bytes(), "p.csv", Rules::Recorded).unwrap();
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
                })
                .collect();
            let text = to_text(poses.iter().copied());
            let back = parse(text.as_bytes(), "p.csv", Rules::Recorded).unwrap();
            let key = |pose: &Pose| (pose.tick, pose.position_m.map(f32::to_bits), pose.engaged);
            prop_assert!(back.iter().flatten().map(key).eq(poses.iter().map(key)));
        }

        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let mut text = format!("{HEADER}\n").into_bytes();
            text.extend(bytes);
            let _ = parse(text.as_slice(), "p.csv", Rules::Strict);
        }
    }
}
