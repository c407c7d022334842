//! Path files. A row of a path of one tool is its pose in a tick, `tick,x_m,y_m,z_m,engaged`; a path of
//! several tools has a row for each tool in each tick, with a column `tool` and an orientation. A further
//! column has the opening of scissors if there are any, and one more the sweeps of each tick if they were counted.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::Path;

use chaincell_kernel::{NOT_TURNED, OPENING_MAX, TOOLS_MAX, ToolPose};

use super::lines::each_line;
use crate::engine::motion::Pose;
use crate::engine::order::follows;
use crate::engine::tools::{is_unit, length_of};
use crate::error::{Error, Result};
use crate::input;
use crate::text::BYTE_ORDER_MARK;

/// First line of a path of one tool.
pub const HEADER: &str = "tick,x_m,y_m,z_m,engaged";
/// First line of a path of several tools.
pub const TOOLS_HEADER: &str = "tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged";
/// Behind both if the opening of scissors is given.
const OPENING: &str = ",opening_rad";
/// End of both if the sweeps of each tick were counted.
const SWEEPS: &str = ",sweeps";
/// Start of every header.
const FRONT: &str = "tick,";
/// Start of the headers of several tools.
const TOOLS_FRONT: &str = "tick,tool,";

/// Rules for the content of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rules {
    /// Ticks are consecutive, numbers are finite, `engaged` is 0 or 1.
    Strict,
    /// A recorded session may have any number, any `engaged` and any order of ticks.
    Recorded,
}

/// Sequences of poses, one per controller.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Paths {
    /// Number of tools; 0 for a path of one tool without an orientation and an opening.
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

    /// Returns true if scissors open in a row.
    #[must_use]
    pub fn opens(&self) -> bool {
        self.each.iter().flatten().any(|pose| pose.opening_turns_q16 > 0)
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
        let (tick, sweeps, engaged) = (first.tick, first.sweeps, first.engaged);
        poses.push(Pose { tick, position_m, engaged, sweeps });
        each.extend(rows.iter().map(|row| row.pose));
    }
}

/// A row of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    tick: u64,
    tool: usize,
    engaged: u32,
    pose: ToolPose,
    sweeps: Option<u16>,
}

/// Reads a path file of one tool or of several, depending on its header. A recorded session has a new
/// sequence after each repeated header, where another controller took over and numbered anew; other paths
/// have one.
///
/// # Errors
/// File, line and field of the first violation of the rules, and the remedy.
pub fn read(path: &Path, rules: Rules) -> Result<Paths> {
    let file = input::open(path).map_err(|why| Error::file("open path", path, why))?;
    parse(BufReader::new(file), &path.display().to_string(), rules)
}

/// Like [`read`], from any text; `name` replaces the file's name.
///
/// # Errors
/// As [`read`].
pub fn parse(text: impl BufRead, name: &str, rules: Rules) -> Result<Paths> {
    let mut paths = Paths { tools: 0, poses: vec![Vec::new()], each: vec![Vec::new()] };
    let mut header = String::new();
    let mut rows: Vec<Row> = Vec::new();
    each_line(text, name, |line, text| {
        let at_line = |why: String| Error::input(format!("{name}:{line}: {why}"));
        // The first line is the header.
        if line == 1 {
            header = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text).to_owned();
            return check_header(&header).map_err(at_line);
        }
        if text.starts_with(FRONT) && text != header {
            return Err(at_line(format!(
                "the header stands again as `{text}`; the first one is `{header}`"
            )));
        }
        // A repeated header starts the sequence of another controller.
        if text == header && rules == Rules::Recorded {
            end_tick(&mut paths, &mut rows).map_err(at_line)?;
            paths.poses.push(Vec::new());
            paths.each.push(Vec::new());
            return Ok(());
        }
        // A row of tool 0 starts a tick.
        let row = row(text, &header, rules).map_err(at_line)?;
        if row.tool == 0 {
            end_tick(&mut paths, &mut rows).map_err(at_line)?;
        }
        check(&paths, &rows, &row, rules).map_err(at_line)?;
        rows.push(row);
        Ok(())
    })?;
    // The text ends the last tick.
    end_tick(&mut paths, &mut rows).map_err(|why| Error::input(format!("{name}: {why}")))?;
    if paths.poses.iter().all(Vec::is_empty) {
        return Err(Error::input(format!(
            "{name}: no rows: a path has a header and a row for each tick, of several tools a row for \
             each tool and tick"
        )));
    }
    let is_whole = is_of_tools(&header) || has_opening(&header);
    Ok(if is_whole { paths } else { Paths::of(paths.poses) })
}

/// Returns true for a header of several tools.
fn is_of_tools(header: &str) -> bool {
    header.starts_with(TOOLS_FRONT)
}

/// Returns true for a header with the opening of scissors.
fn has_opening(header: &str) -> bool {
    header.strip_suffix(SWEEPS).unwrap_or(header).ends_with(OPENING)
}

/// Checks that the first line is a header.
fn check_header(header: &str) -> std::result::Result<(), String> {
    let wanted = if is_of_tools(header) { TOOLS_HEADER } else { HEADER };
    let front = header.strip_suffix(SWEEPS).unwrap_or(header);
    if front.strip_suffix(OPENING).unwrap_or(front) == wanted {
        return Ok(());
    }
    Err(format!(
        "the header is `{}`; it must be `{wanted}`, with `{OPENING}` behind it for scissors and then `{SWEEPS}` where the sweeps \
         are given",
        header.escape_debug().take(80).collect::<String>()
    ))
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
        (None, last) => in_order(last.map(|last| last.tick), row.tick, rules),
        _ => Ok(()),
    }
}

/// Parses a row.
fn row(text: &str, header: &str, rules: Rules) -> std::result::Result<Row, String> {
    // Take the fields apart; one tool has no number and no orientation.
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    let wanted = header.split(',').count();
    let wrong = || format!("{} fields; a row has {wanted}: {header}", fields.len());
    let (&[tick, ref front @ ..], true) = (fields.as_slice(), fields.len() == wanted) else {
        return Err(wrong());
    };
    let (tool, front) = match front {
        [tool, rest @ ..] if is_of_tools(header) => (Some(*tool), rest),
        rest => (None, rest),
    };
    let [x, y, z, front @ ..] = front else { return Err(wrong()) };
    let (turn, front) = match front {
        [qx, qy, qz, qw, rest @ ..] if tool.is_some() => (Some([qx, qy, qz, qw]), rest),
        rest => (None, rest),
    };
    let [engaged, front @ ..] = front else { return Err(wrong()) };
    let (opening, sweeps) = match front {
        [opening, rest @ ..] if has_opening(header) => (Some(*opening), rest),
        rest => (None, rest),
    };
    // Parse each.
    let tick = whole("tick", tick)?;
    let tool = tool.map_or(Ok(0), |tool| whole("tool", tool))?;
    let coordinate = |name: &str, text: &str| number((name, text, " [m]"), rules);
    let position_m = [coordinate("x_m", x)?, coordinate("y_m", y)?, coordinate("z_m", z)?];
    let mut orientation = NOT_TURNED;
    let names = ["qx", "qy", "qz", "qw"];
    for (place, (name, text)) in
        orientation.iter_mut().zip(names.into_iter().zip(turn.into_iter().flatten()))
    {
        *place = number((name, text, ""), rules)?;
    }
    if rules == Rules::Strict && !is_unit(orientation) {
        let size = length_of(orientation);
        return Err(format!(
            "fields qx to qw: a quaternion of length {size}, it must be 1 (no turn is 0,0,0,1)"
        ));
    }
    let engaged = engaged_of(engaged, rules)?;
    let pose = ToolPose { orientation, ..ToolPose::at(position_m.into(), engaged) };
    let pose = opening.map_or(Ok(pose), |opening| opened(pose, opening, rules))?;
    let tool = usize::try_from(tool).unwrap_or(usize::MAX);
    Ok(Row { tick, tool, engaged, pose, sweeps: sweeps_of(sweeps)? })
}

/// Parses a field that is a whole number.
fn whole(name: &str, text: &str) -> std::result::Result<u64, String> {
    text.parse().map_err(|_| format!("field {name} `{text}`: must be a whole number from 0"))
}

/// Parses a field that is a number, given by its name, text and unit.
fn number(
    (name, text, unit): (&str, &str, &str),
    rules: Rules,
) -> std::result::Result<f32, String> {
    let value: f32 =
        text.parse().map_err(|_| format!("field {name} `{text}`: must be a number{unit}"))?;
    if rules == Rules::Strict && !value.is_finite() {
        return Err(format!(
            "field {name} `{text}`: must be finite in single precision; to replay a recorded \
             session with bad poses use run with `recorded`"
        ));
    }
    Ok(value)
}

/// Parses the field `engaged`.
fn engaged_of(text: &str, rules: Rules) -> std::result::Result<u32, String> {
    let told = || format!("field engaged `{text}`: must be 0 or 1");
    let engaged: u32 = text.parse().map_err(|_| told())?;
    if rules == Rules::Strict && engaged > 1 { Err(told()) } else { Ok(engaged) }
}

/// Parses the field `opening_rad`, and returns the pose with it.
fn opened(pose: ToolPose, text: &str, rules: Rules) -> std::result::Result<ToolPose, String> {
    let opened = pose.with_opening_rad(number(("opening_rad", text, " [rad]"), rules)?);
    if rules == Rules::Strict && opened.opening_turns_q16 > OPENING_MAX {
        return Err(format!("field opening_rad `{text}`: must be 0 to 3.14159, half a turn [rad]"));
    }
    Ok(opened)
}

/// Parses the field `sweeps`, if there is one.
fn sweeps_of(fields: &[&str]) -> std::result::Result<Option<u16>, String> {
    match fields {
        [] | [""] => Ok(None),
        [text, ..] => text.parse().map(Some).map_err(|_| {
            format!("field sweeps `{text}`: must be from 0 to 65535, or empty for `--sweeps`")
        }),
    }
}

/// Checks that a tick may follow the last one.
fn in_order(last: Option<u64>, tick: u64, rules: Rules) -> std::result::Result<(), String> {
    match last {
        Some(last) if rules == Rules::Strict && Some(tick) != last.checked_add(1) => Err(format!(
            "field tick {tick}: must be {}, one above the tick before; to replay a recorded session \
             with lost poses use run with `recorded`",
            last.saturating_add(1)
        )),
        _ => Ok(()),
    }
}

/// Returns the text of a path file of one tool; its decimals read back as the same single-precision numbers.
/// Before a tick that does not continue the count, the header is repeated. There is a column `sweeps` if they
/// were counted in any tick.
#[must_use]
pub fn to_text(poses: impl IntoIterator<Item = Pose, IntoIter: Clone>) -> String {
    written(
        HEADER,
        poses.into_iter(),
        |pose| (pose.tick, pose.sweeps),
        |pose, text, end| {
            let [x, y, z] = pose.position_m;
            let _ = writeln!(text, "{},{x:?},{y:?},{z:?},{}{end}", pose.tick, pose.engaged);
        },
    )
}

/// Returns the text of a session's poses, in the same way as [`to_text`]; with `per_tick` tools, of those of
/// `tools`, one tick after the other, in place of the positions of `poses`.
#[must_use]
pub fn session_to_text(
    poses: impl IntoIterator<Item = Pose, IntoIter: Clone>,
    tools: &[ToolPose],
    per_tick: usize,
) -> String {
    if per_tick == 0 {
        return to_text(poses);
    }
    let each = poses.into_iter().zip(tools.chunks_exact(per_tick));
    tools_to_text(each.map(|(pose, tools)| (pose.tick, pose.sweeps, tools)))
}

/// Returns the text of a path of several tools, in the same way as [`to_text`].
#[must_use]
fn tools_to_text<'a>(
    ticks: impl IntoIterator<Item = (u64, Option<u16>, &'a [ToolPose]), IntoIter: Clone>,
) -> String {
    let head = |(tick, sweeps, _): &(u64, Option<u16>, &[ToolPose])| (*tick, *sweeps);
    let ticks = ticks.into_iter();
    // Openings are written if there is one.
    let opens = |pose: &ToolPose| pose.opening_turns_q16 > 0;
    let has_opening = ticks.clone().any(|(_, _, poses)| poses.iter().any(opens));
    let header = format!("{TOOLS_HEADER}{}", if has_opening { OPENING } else { "" });
    written(&header, ticks, head, |(tick, _, poses), text, end| {
        for (tool, pose) in poses.iter().enumerate() {
            let [x, y, z]: [f32; 3] = pose.position_m.into();
            let ([i, j, k, w], engaged) = (pose.orientation, pose.engaged);
            let _ =
                write!(text, "{tick},{tool},{x:?},{y:?},{z:?},{i:?},{j:?},{k:?},{w:?},{engaged}");
            if has_opening {
                let _ = write!(text, ",{:?}", pose.opening_rad());
            }
            let _ = writeln!(text, "{end}");
        }
    })
}

/// Returns the text of ticks with their headers. `head` gives tick and sweeps; `rows` writes the rows of a
/// tick, each with the given end.
fn written<T>(
    header: &str,
    ticks: impl Iterator<Item = T> + Clone,
    head: impl Fn(&T) -> (u64, Option<u16>),
    rows: impl Fn(&T, &mut String, &str),
) -> String {
    let counted = ticks.clone().any(|tick| head(&tick).1.is_some());
    let header = format!("{header}{}\n", if counted { SWEEPS } else { "" });
    let mut text = header.clone();
    let mut last = None;
    for tick in ticks {
        let (number, sweeps) = head(&tick);
        if last.is_some_and(|last| !follows(last, number)) {
            text += &header;
        }
        last = Some(number);
        let end = match sweeps {
            _ if !counted => String::new(),
            None => ",".to_owned(),
            Some(sweeps) => format!(",{sweeps}"),
        };
        rows(&tick, &mut text, &end);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(z: f32, engaged: u32) -> ToolPose {
        let at = ToolPose::at([0.1, -0.0, z].into(), engaged);
        ToolPose { orientation: [0.0, 0.8, 0.0, 0.6], ..at }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let poses = [pose(0.3, 0), pose(0.31, 1), pose(0.32, 1), pose(0.33, 1)];
        for sweeps in [None, Some(3)] {
            let text = tools_to_text([(7, sweeps, &poses[..2]), (8, None, &poses[2..])]);
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
        // Scissors: any opening comes back.
        for counts in [1, 5215, 32767, 32768] {
            let open = poses.map(|pose| ToolPose { opening_turns_q16: counts, ..pose });
            let text = tools_to_text([(7, None, &open[..2]), (8, Some(2), &poses[2..])]);
            let found = parse(text.as_bytes(), "a.csv", Rules::Strict).unwrap();
            assert_eq!((found.each(0, 0), found.each(0, 1)), (&open[..2], &poses[2..]));
        }
        // Another controller, which starts at a lower tick.
        let text = tools_to_text([(7, None, &poses[..2]), (2, None, &poses[2..])]);
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
            let text = format!("{TOOLS_HEADER}\n{rows}");
            let why = parse(text.as_bytes(), "a.csv", Rules::Strict).unwrap_err().to_string();
            assert!(why.contains(wanted) && why.contains(line), "{rows}: {why}");
        }
        for (opening, wanted) in [
            ("-0.1", "must be 0 to 3.14159"),
            ("3.15", "must be 0 to 3.14159"),
            ("nan", "must be finite"),
            ("wide", "must be a number [rad]"),
        ] {
            let text = format!("{HEADER}{OPENING}\n0,0,0,0,1,{opening}\n");
            let why = parse(text.as_bytes(), "a.csv", Rules::Strict).unwrap_err().to_string();
            assert!(why.contains("field opening_rad `") && why.contains(wanted), "{why}");
        }
        let text = format!("{HEADER}{OPENING},sweeps\n0,0.1,0,0,1,0.5,3\n1,0.1,0,0,1,0.25,\n");
        let found = parse(text.as_bytes(), "a.csv", Rules::Strict).unwrap();
        let pose = ToolPose::at([0.1, 0.0, 0.0].into(), 1);
        assert_eq!((found.tools, found.each(0, 0)), (1, &[pose.with_opening_rad(0.5)][..]));
        assert_eq!((found.poses[0][0].sweeps, found.poses[0][1].sweeps), (Some(3), None));
        let why = parse("tick,tool,x\n".as_bytes(), "a.csv", Rules::Strict).unwrap_err();
        assert!(why.to_string().contains("it must be `tick,tool,x_m"), "{why}");
    }
}
