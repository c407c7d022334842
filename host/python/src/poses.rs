//! Poses in: of one tool or of several, in a tick or in all ticks of a run.

use chaincell_client::tools::TOOLS_MAX;
use chaincell_host::engine::tools::is_unit;
use chaincell_kernel::{OPENING_MAX, ToolPose};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};

use crate::arrays::{self, Values};
use crate::errors::Class;

/// A place, and a place with a turn x, y, z, w.
const PLACE: usize = 3;
const TURNED: usize = 7;
/// What a pose may be, for errors.
const FORMS: &str =
    "(3,): x, y, z [m]; (7,): with a quaternion x, y, z, w; (tools, 3) or (tools, 7)";

/// Whether tools act on the tissue.
#[derive(FromPyObject)]
pub(crate) enum Engaged<'py> {
    /// All or none.
    All(bool),
    /// One truth value for each.
    Each(Bound<'py, PyAny>),
}

/// The poses of a tick, tool 0 first.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    pub(crate) poses: Vec<ToolPose>,
    /// Whether the tick was given several tools, be it one of them.
    pub(crate) is_several: bool,
}

impl Tick {
    /// Of a pose, or an array of them, whether each is engaged, and how far its scissors are open.
    pub(crate) fn of(
        pose: &Bound<'_, PyAny>,
        engaged: &Engaged<'_>,
        opening_rad: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut tick = Self::closed(pose, engaged)?;
        let Some(given) = opening_rad else { return Ok(tick) };
        let (openings, count) = (arrays::reals("opening_rad", given)?, tick.poses.len());
        if !matches!(openings.shape[..], [] | [_]) || openings.values.len() != count {
            let wanted = if count == 1 { "() or (1,)".to_owned() } else { format!("({count},)") };
            return Err(openings.wrong_shape("opening_rad", &wanted));
        }
        for (tool, (pose, opening_rad)) in tick.poses.iter_mut().zip(openings.values).enumerate() {
            *pose = opened(*pose, opening_rad, &|| format!("tool {tool}"))?;
        }
        Ok(tick)
    }

    /// The same of closed scissors.
    fn closed(pose: &Bound<'_, PyAny>, engaged: &Engaged<'_>) -> PyResult<Self> {
        if let (Some(position_m), &Engaged::All(engaged)) = (plain(pose), engaged) {
            let poses = vec![checked(ToolPose::at(position_m.into(), engaged.into()), &|| {
                "the pose".into()
            })?];
            return Ok(Self { poses, is_several: false });
        }
        let given = parts(pose)?;
        let (count, width, is_several) = match given.shape[..] {
            [width] => (1, width, false),
            [count, width] => (count, width, true),
            _ => return Err(given.wrong_shape("pose", FORMS)),
        };
        if !matches!(width, PLACE | TURNED) || !(1..=TOOLS_MAX).contains(&count) {
            return Err(given.wrong_shape("pose", FORMS));
        }
        let engaged = match engaged {
            Engaged::All(all) => vec![*all; count],
            Engaged::Each(each) => {
                arrays::flags("engaged", each)?.one_each("engaged", count, "tool")?
            }
        };
        let each = given.values.chunks_exact(width).zip(engaged).enumerate();
        let poses = each.map(|(tool, (numbers, engaged))| {
            checked(pose_of(numbers, engaged), &|| format!("the pose of tool {tool}"))
        });
        Ok(Self { poses: poses.collect::<PyResult<_>>()?, is_several })
    }

    /// The same for the ticks of a run.
    pub(crate) fn path(
        path: &Bound<'_, PyAny>,
        engaged: Option<&Bound<'_, PyAny>>,
        opening_rad: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Self>> {
        let wanted = "(ticks, 3), (ticks, 7), (ticks, tools, 3) or (ticks, tools, 7)";
        let given = arrays::reals("path", path)?;
        let (ticks, count, width, is_several) = match given.shape[..] {
            [ticks, width] => (ticks, 1, width, false),
            [ticks, count, width] => (ticks, count, width, true),
            _ => return Err(given.wrong_shape("path", wanted)),
        };
        if !matches!(width, PLACE | TURNED) || !(1..=TOOLS_MAX).contains(&count) {
            return Err(given.wrong_shape("path", wanted));
        }
        let engaged = engaged_on(engaged, ticks, count)?;
        let of_tick = given.values.chunks_exact(count * width).zip(engaged.chunks_exact(count));
        let tick = |(tick, (numbers, engaged)): (usize, (&[f64], &[bool]))| {
            let each = numbers.chunks_exact(width).zip(engaged).enumerate();
            let poses = each.map(|(tool, (numbers, engaged))| {
                checked(pose_of(numbers, *engaged), &|| {
                    let tool = if is_several { format!(", tool {tool}") } else { String::new() };
                    format!("`path`, tick {tick}{tool}")
                })
            });
            Ok(Self { poses: poses.collect::<PyResult<_>>()?, is_several })
        };
        let mut path = of_tick.enumerate().map(tick).collect::<PyResult<Vec<Self>>>()?;
        let Some(given) = opening_rad else { return Ok(path) };
        let openings = arrays::reals("opening_rad", given)?;
        let per_tick = match openings.shape[..] {
            [one] if one == ticks => 1,
            [first, second] if [first, second] == [ticks, count] => count,
            _ => {
                let wanted = format!("({ticks},) or ({ticks}, {count})");
                return Err(openings.wrong_shape("opening_rad", &wanted));
            }
        };
        for (at, (tick, openings)) in
            path.iter_mut().zip(openings.values.chunks_exact(per_tick)).enumerate()
        {
            // A value of a tick is that of all its tools.
            for (pose, opening_rad) in tick.poses.iter_mut().zip(openings.iter().cycle()) {
                *pose = opened(*pose, *opening_rad, &|| format!("tick {at}"))?;
            }
        }
        Ok(path)
    }
}

/// The place of a usual pose: three numbers of Python in a list or a tuple, or an array of three floats.
fn plain(pose: &Bound<'_, PyAny>) -> Option<[f32; 3]> {
    if let Ok(list) = pose.cast::<PyList>() {
        return three(list.iter());
    }
    if let Ok(tuple) = pose.cast::<PyTuple>() {
        return three(tuple.iter());
    }
    if !pose.is_exact_instance_of::<PyArray1<f64>>() {
        return None;
    }
    let array = pose.cast::<PyArray1<f64>>().ok()?.try_readonly().ok()?;
    let place = <[f64; 3]>::try_from(array.as_slice().ok()?).ok()?;
    Some(place.map(|x| x as f32))
}

/// Three numbers that are floats or whole.
fn three<'py>(items: impl ExactSizeIterator<Item = Bound<'py, PyAny>>) -> Option<[f32; 3]> {
    let mut place = [0.0; PLACE];
    if items.len() != PLACE {
        return None;
    }
    for (x, item) in place.iter_mut().zip(items) {
        if !item.is_instance_of::<PyFloat>() && !item.is_exact_instance_of::<PyInt>() {
            return None;
        }
        *x = item.extract::<f64>().ok()? as f32;
    }
    Some(place)
}

/// The numbers of a pose, or of a place and a quaternion apart.
fn parts(pose: &Bound<'_, PyAny>) -> PyResult<Values<f64>> {
    let pair = pose.cast::<PyTuple>().ok().filter(|pair| pair.len() == 2);
    let Some(pair) = pair else { return arrays::reals("pose", pose) };
    let place = arrays::reals("pose", &pair.get_item(0)?)?;
    let turn = arrays::reals("pose", &pair.get_item(1)?)?;
    if place.shape == [PLACE] && turn.shape == [TURNED - PLACE] {
        let values = [place.values, turn.values].concat();
        return Ok(Values { values, shape: vec![TURNED] });
    }
    arrays::reals("pose", pose)
}

/// Of 3 numbers or 7.
fn pose_of(numbers: &[f64], engaged: bool) -> ToolPose {
    let at = |index: usize| numbers.get(index).map(|x| *x as f32);
    let place = [0, 1, 2].map(|axis| at(axis).unwrap_or(f32::NAN));
    let none = ToolPose::at(place.into(), engaged.into());
    let [x, y, z, w] = none.orientation;
    ToolPose {
        orientation: [(3, x), (4, y), (5, z), (6, w)].map(|(i, of)| at(i).unwrap_or(of)),
        ..none
    }
}

/// The pose with this opening, or why it is none.
fn opened(pose: ToolPose, opening_rad: f64, name: &dyn Fn() -> String) -> PyResult<ToolPose> {
    let opened = pose.with_opening_rad(opening_rad as f32);
    if opened.opening_turns_q16 <= OPENING_MAX {
        return Ok(opened);
    }
    let text = format!("`opening_rad` {opening_rad} of {}: must be 0 to pi [rad]", name());
    Err(Class::Pose.error(text))
}

/// A pose, or why it is none.
fn checked(pose: ToolPose, name: &dyn Fn() -> String) -> PyResult<ToolPose> {
    if !pose.position_m.iter().all(|x| x.is_finite()) {
        let text = format!(
            "{}: its position {:?} is not finite; give three numbers in metres",
            name(),
            <[f32; 3]>::from(pose.position_m)
        );
        return Err(Class::Pose.error(text));
    }
    if is_unit(pose.orientation) {
        return Ok(pose);
    }
    let text = format!(
        "{}: its orientation {:?} is no unit quaternion x, y, z, w; 0, 0, 0, 1 is not turned",
        name(),
        pose.orientation
    );
    Err(Class::Pose.error(text))
}

/// Whether each tool is engaged on each tick; a value of a tick is that of all its tools.
fn engaged_on(
    engaged: Option<&Bound<'_, PyAny>>,
    ticks: usize,
    count: usize,
) -> PyResult<Vec<bool>> {
    let Some(given) = engaged else { return Ok(vec![true; ticks * count]) };
    let flags = arrays::flags("engaged", given)?;
    match flags.shape[..] {
        [one] if one == ticks => Ok(flags.values.iter().flat_map(|&is| vec![is; count]).collect()),
        [first, second] if [first, second] == [ticks, count] => Ok(flags.values),
        _ => Err(flags.wrong_shape("engaged", &format!("({ticks},) or ({ticks}, {count})"))),
    }
}
