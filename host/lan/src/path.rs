//! Poses of a file: `tick,x_m,y_m,z_m,engaged`, a line for each tick, as `chaincell run` writes it.

use std::path::Path;

use chaincell_client::{Error, Kind, Result, ToolPose};

/// Columns of the file.
const HEADER: &str = "tick,x_m,y_m,z_m,engaged";

/// Reads a file of poses of one tool.
///
/// # Errors
/// No such file, other columns, or the first line that is no pose.
pub fn read(path: &Path) -> Result<Vec<ToolPose>> {
    let refused = |why: &dyn std::fmt::Display| {
        Error::new(Kind::Argument, format!("{}: {why}", path.display()))
    };
    parse(&std::fs::read_to_string(path).map_err(|why| refused(&why))?).map_err(|why| refused(&why))
}

/// Reads the text of a file of poses.
///
/// ```
/// use chaincell_lan::path::parse;
///
/// let poses = parse("tick,x_m,y_m,z_m,engaged\n0,0,0,0.01,0\n1,0,0,-0.002,1\n")?;
/// assert_eq!((poses[1].position_m[2], poses[1].engaged), (-0.002, 1)); // [m]
/// assert!(parse("0,0,0,0.01,0\n").is_err());
/// # Ok::<(), String>(())
/// ```
///
/// # Errors
/// Other columns, no poses, or the number of the first line that is no pose.
pub fn parse(text: &str) -> std::result::Result<Vec<ToolPose>, String> {
    let mut lines = text.lines().enumerate();
    let header = lines.next().map_or("", |(_, line)| line.trim());
    if header != HEADER {
        return Err(format!(
            "its columns are `{header}`, and not `{HEADER}`: `chaincell run` writes such a path.csv"
        ));
    }
    let filled = lines.filter(|(_, line)| !line.trim().is_empty());
    let poses: std::result::Result<Vec<ToolPose>, String> = filled
        .map(|(at, line)| pose(line).ok_or_else(|| format!("line {}: `{line}` is no pose", at + 1)))
        .collect();
    poses.and_then(
        |poses| if poses.is_empty() { Err("it has no poses".to_owned()) } else { Ok(poses) },
    )
}

fn pose(line: &str) -> Option<ToolPose> {
    let words: Vec<&str> = line.trim().split(',').collect();
    let [_, x, y, z, engaged] = words[..] else { return None };
    let position_m = [x.parse::<f32>().ok()?, y.parse().ok()?, z.parse().ok()?];
    let pose = ToolPose::at(position_m.into(), engaged.parse().ok()?);
    pose.is_good().then_some(pose)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_no_pose_is_named() {
        for bad in
            ["1,0,0,0", "1,0,0,0,2", "1,0,NaN,0,1", "1,0,inf,0,0", "1,a,0,0,0", "1,0,0,0,0,0"]
        {
            let said = parse(&format!("{HEADER}\n0,0,0,0,0\n\n{bad}\n")).unwrap_err();
            assert!(said.starts_with("line 4: `"), "{said}");
        }
        assert!(parse(HEADER).unwrap_err().contains("no poses"));
        assert!(parse("").unwrap_err().contains("chaincell run"));
    }
}
