//! Path files of several tools, with a row for each tool in each tick. Paths without a column `tool` are read
//! by [`path`].

use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::Path;

use chaincell_kernel::{TOOLS_MAX, ToolPose};

use super::path::{self, Rules, each_line, end_row, engaged_of, number, sweeps_of, whole};
use crate::engine::motion::Pose;
use crate::engine::order::follows;
use crate::engine::tools::{is_unit, length_of};
use crate::error::{Error, Result};
use crate::input;
use crate::text::BYTE_ORDER_MARK;

/// First line of a path of several tools.
pub const HEADER: &str = "tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged";
/// First line if the sweeps of each tick were counted.
pub const HEADER_WITH_SWEEPS: &str = "tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged,sweeps";
/// Start of both headers, which distinguishes them from a path of one tool.
const FRONT: &str = "tick,tool,";

/// Sequences of poses, one per controller.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Paths {
    /// Number of tools; 0 for a path of one tool without an orientation.
    pub tools: usize,
    /// Poses of each sequence; with several tools those of tool 0.
    pub poses: Vec<Vec<Pose>>,
    /// Poses of all tools in the same ticks, tick by tick.
    each: Vec<Vec<ToolPose>>,
}

impl Paths {
    /// Creates the paths of one tool.
    #[must_use]
    pub fn of(poses: Vec<Vec<Pose>>) -> Self {
        Self { tools: 0, poses, each: Vec::new() }
    }

    /// Returns the poses of all tools in a tick of a sequence; none for a path of one tool.
    #[must_use]
    pub fn each(&self, sequence: usize, tick: usize) -> &[ToolPose] {
        let each = self.each.get(sequence).map_or(&[][..], Vec::as_slice);
        each.get(tick * self.tools..(tick + 1) * self.tools).unwrap_or(&[])
    }

    /// Converts a path with coordinates in units of `unit_m` to metres.
    #[must_use]
    pub fn in_metres(mut self, unit_m: f64) -> Self {
        let metres = |x: f32| (f64::from(x) * unit_m) as f32;
        for pose in self.poses.iter_mut().flatten() {
            pose.position_m = pose.position_m.map(metres);
        }
        for pose in self.each.iter_mut().flatten() {
            pose.position_m = pose.position_m.map(metres);
        }
        self
    }

    /// Joins all sequences: returns the poses, and those of all tools in the same ticks.
    #[must_use]
    pub fn concat(self) -> (Vec<Pose>, Vec<ToolPose>) {
        (self.poses.concat(), self.each.concat())
    }

    /// Adds a tick to the last sequence.
    fn add(&mut self, rows: &[Row]) {
        let (Some(first), Some(poses), Some(each)) =
            (rows.first(), self.poses.last_mut(), self.each.last_mut())
        else {
            return;
        };
        let position_m = first.pose.position_m.into();
        let (tick, sweeps, engaged) = (first.tick, first.sweeps, first.pose.engaged);
        poses.push(Pose { tick, position_m, engaged, sweeps });
        each.extend(rows.iter().map(|row| row.pose));
    }
}

/// A row of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    tick: u64,
    tool: usize,
    pose: ToolPose,
    sweeps: Option<u16>,
}

/// Reads a path file of one tool or of several, depending on its header.
///
/// # Errors
/// File, line and field of the first violation of the rules, and the remedy.
pub fn read(file: &Path, rules: Rules) -> Result<Paths> {
    let name = file.display().to_string();
    let failed = |why: std::io::Error| Error::file("open path", file, why);
    let mut text = BufReader::new(input::open(file).map_err(failed)?);
    let front = text.fill_buf().map_err(failed)?;
    let mark = BYTE_ORDER_MARK.as_bytes();
    let front = front.strip_prefix(mark).unwrap_or(front);
    if front.starts_with(FRONT.as_bytes()) {
        return parse(text, &name, rules);
    }
    path::parse(text, &name, rules).map(Paths::of)
}

/// Reads a path of several tools from any text; `name` replaces the file's name.
///
/// # Errors
/// As [`read`].
pub fn parse(text: impl BufRead, name: &str, rules: Rules) -> Result<Paths> {
    let mut paths = Paths { tools: 0, poses: vec![Vec::new()], each: vec![Vec::new()] };
    let mut header = String::new();
    let mut rows: Vec<Row> = Vec::new();
    each_line(text, name, |line, text| {
        let told = |why: String| Error::input(format!("{name}:{line}: {why}"));
        // The first line is the header.
        if line == 1 {
            header = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text).to_owned();
            return if header == HEADER || header == HEADER_WITH_SWEEPS {
                Ok(())
            } else {
                Err(told(format!(
                    "the header is `{}`; of several tools it must be `{HEADER}`, with `,sweeps` \
                     behind it where the sweeps are given",
                    header.escape_debug().take(80).collect::<String>()
                )))
            };
        }
        // A repeated header starts the sequence of another controller.
        if text == header && rules == Rules::Recorded {
            end_tick(&mut paths, &mut rows).map_err(told)?;
            paths.poses.push(Vec::new());
            paths.each.push(Vec::new());
            return Ok(());
        }
        // A row of tool 0 starts a tick.
        let row = row(text, &header, rules).map_err(told)?;
        if row.tool == 0 && !rows.is_empty() {
            end_tick(&mut paths, &mut rows).map_err(told)?;
        }
        check(&paths, &rows, &row, rules).map_err(told)?;
        rows.push(row);
        Ok(())
    })?;
    // The text ends the last tick.
    end_tick(&mut paths, &mut rows).map_err(|why| Error::input(format!("{name}: {why}")))?;
    if paths.tools == 0 {
        return Err(Error::input(format!(
            "{name}: no rows: a path has a header and a row for each tool and tick"
        )));
    }
    Ok(paths)
}

/// Checks that a tick has a row for each tool, and adds it to the path.
fn end_tick(paths: &mut Paths, rows: &mut Vec<Row>) -> std::result::Result<(), String> {
    let Some(first) = rows.first() else { return Ok(()) };
    if paths.tools == 0 {
        paths.tools = rows.len();
    }
    if rows.len() != paths.tools {
        return Err(format!(
            "tick {} has {} rows before this line, the first tick has {}: give each tick a row for \
             each tool, in order",
            first.tick,
            rows.len(),
            paths.tools
        ));
    }
    paths.add(rows);
    rows.clear();
    Ok(())
}

/// Checks that a row may follow the other ones of its tick, and the ticks before.
fn check(paths: &Paths, rows: &[Row], row: &Row, rules: Rules) -> std::result::Result<(), String> {
    if row.tool != rows.len() {
        return Err(format!(
            "field tool `{}`: must be {}, since each tick has every tool once, in order",
            row.tool,
            rows.len()
        ));
    }
    if row.tool >= TOOLS_MAX {
        return Err(format!("field tool `{}`: there are at most {TOOLS_MAX} tools", row.tool));
    }
    match (rows.first(), paths.poses.last().and_then(|poses| poses.last())) {
        (Some(first), _) if (first.tick, first.sweeps) != (row.tick, row.sweeps) => Err(format!(
            "tool {} has another tick or other sweeps than tool 0 above: give all rows of a tick \
             the same",
            row.tool
        )),
        (None, Some(last))
            if rules == Rules::Strict && Some(row.tick) != last.tick.checked_add(1) =>
        {
            Err(format!(
                "field tick {}: must be {}, one above the tick before; to replay a recorded session \
                 with lost poses use run with `recorded`",
                row.tick,
                last.tick.saturating_add(1)
            ))
        }
        _ => Ok(()),
    }
}

fn row(text: &str, header: &str, rules: Rules) -> std::result::Result<Row, String> {
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    let wanted = header.split(',').count();
    let (&[tick, tool, x, y, z, qx, qy, qz, qw, engaged, ref sweeps @ ..], true) =
        (fields.as_slice(), fields.len() == wanted)
    else {
        return Err(format!("{} fields; a row has {wanted}: {header}", fields.len()));
    };
    let coordinate = |name: &str, text: &str| number((name, text, " [m]"), rules);
    let position_m = [coordinate("x_m", x)?, coordinate("y_m", y)?, coordinate("z_m", z)?];
    let number = |name: &str, text: &str| number((name, text, ""), rules);
    let orientation = [number("qx", qx)?, number("qy", qy)?, number("qz", qz)?, number("qw", qw)?];
    if rules == Rules::Strict && !is_unit(orientation) {
        let size = length_of(orientation);
        return Err(format!(
            "fields qx to qw: a quaternion of length {size}, it must be 1 (no turn is 0,0,0,1)"
        ));
    }
    let engaged = engaged_of(engaged, rules)?;
    let pose = ToolPose { position_m: position_m.into(), orientation, engaged };
    let tool = usize::try_from(whole("tool", tool)?).unwrap_or(usize::MAX);
    Ok(Row { tick: whole("tick", tick)?, tool, pose, sweeps: sweeps_of(sweeps)? })
}

/// Returns the text of a path of several tools, in the same way as [`path::to_text`].
#[must_use]
pub fn to_text<'a>(
    ticks: impl IntoIterator<Item = (u64, Option<u16>, &'a [ToolPose]), IntoIter: Clone>,
) -> String {
    let ticks = ticks.into_iter();
    let counted = ticks.clone().any(|(_, sweeps, _)| sweeps.is_some());
    let header = if counted { HEADER_WITH_SWEEPS } else { HEADER };
    let mut text = format!("{header}\n");
    let mut last = None;
    for (tick, sweeps, poses) in ticks {
        if last.is_some_and(|last| !follows(last, tick)) {
            let _ = writeln!(text, "{header}");
        }
        last = Some(tick);
        for (tool, pose) in poses.iter().enumerate() {
            let [x, y, z]: [f32; 3] = pose.position_m.into();
            let [i, j, k, w] = pose.orientation;
            let engaged = pose.engaged;
            let _ =
                write!(text, "{tick},{tool},{x:?},{y:?},{z:?},{i:?},{j:?},{k:?},{w:?},{engaged}");
            end_row(&mut text, counted, sweeps);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(z: f32, engaged: u32) -> ToolPose {
        ToolPose { position_m: [0.1, -0.0, z].into(), orientation: [0.0, 0.8, 0.0, 0.6], engaged }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let poses = [pose(0.3, 0), pose(0.31, 1), pose(0.32, 1), pose(0.33, 1)];
        for sweeps in [None, Some(3)] {
            let text = to_text([(7, sweeps, &poses[..2]), (8, None, &poses[2..])]);
            let found = parse(text.as_bytes(), "a.csv", Rules::Strict).unwrap();
            assert_eq!(
                (found.tools, found.each(0, 0), found.each(0, 1)),
                (2, &poses[..2], &poses[2..])
            );
            assert_eq!(found.poses[0][0].sweeps, sweeps);
            assert_eq!((found.poses[0][1].tick, found.poses[0][1].position_m[2]), (8, 0.32));
            let metres = found.in_metres(0.001);
            assert_eq!(metres.poses[0][1].position_m[2], 0.00032);
            assert_eq!(metres.each(0, 1)[0].position_m[2], 0.00032);
        }
        // Another controller, which starts at a lower tick.
        let text = to_text([(7, None, &poses[..2]), (2, None, &poses[2..])]);
        let found = parse(text.as_bytes(), "a.csv", Rules::Recorded).unwrap();
        assert_eq!((found.poses.len(), found.each(1, 0)), (2, &poses[2..]));
    }

    #[test]
    fn the_first_fault_is_told_with_its_line() {
        let good = "1,0,0,0,0,0,0,0,1,1\n1,1,0,0,0,0,0,0,1,1\n";
        for (rows, line, wanted) in [
            ("", "", "no rows"),
            ("1,0,0,0,0,0,0,0,1\n", ":2:", "9 fields; a row has 10"),
            ("1,1,0,0,0,0,0,0,1,1\n", ":2:", "field tool `1`: must be 0"),
            ("1,0,0,0,nan,0,0,0,1,1\n", ":2:", "must be finite"),
            ("1,0,0,0,0,0,0,0,2,1\n", ":2:", "length 2"),
            ("1,0,0,0,0,0,0,0,1,2\n", ":2:", "must be 0 or 1"),
            (&format!("{good}2,0,0,0,0,0,0,0,1,1\n3,0,0,0,0,0,0,0,1,1\n"), ":5:", "1 rows before"),
            (&format!("{good}2,0,0,0,0,0,0,0,1,1\n"), "", "tick 2 has 1 rows"),
            (&format!("{good}3,0,0,0,0,0,0,0,1,1\n"), ":4:", "field tick 3: must be 2"),
            ("1,0,0,0,0,0,0,0,1,1\n2,1,0,0,0,0,0,0,1,1\n", ":3:", "another tick"),
        ] {
            let text = format!("{HEADER}\n{rows}");
            let why = parse(text.as_bytes(), "a.csv", Rules::Strict).unwrap_err().to_string();
            assert!(why.contains(wanted) && why.contains(line), "{rows}: {why}");
        }
        let why = parse("tick,tool,x\n".as_bytes(), "a.csv", Rules::Strict).unwrap_err();
        assert!(why.to_string().contains("it must be `tick,tool,x_m"), "{why}");
    }
}
