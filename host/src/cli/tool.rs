//! Tools by their parts, as `--tool` names them.

use std::fmt;
use std::str::FromStr;

use chaincell_kernel::{FRICTION_MAX, Model, PARTS_MAX, TOOLS_MAX, ToolPart};

use crate::choice::by_text;
use crate::engine::Contact;
use crate::engine::tools::{is_unit, length_of};
use crate::error::{Error, Result};

/// Radius of a half space's edge unless it is given \[m\].
const HALF_SPACE_RADIUS_M: f32 = 0.01;

/// The parts of a tool, and the text that named them.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolSpec {
    /// As given.
    pub text: String,
    /// True for the sphere of `--contact probe:RADIUS`.
    is_probe: bool,
    parts: Vec<ToolPart>,
}

impl FromStr for ToolSpec {
    type Err = String;

    /// Reads `PART[+PART...]`, or says which part and field is wrong, and what to write.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts: Vec<&str> = text.split('+').collect();
        if parts.len() > PARTS_MAX {
            return Err(format!("{} parts: a tool has at most {PARTS_MAX}", parts.len()));
        }
        let parts = (1..).zip(parts).map(|(number, text)| {
            part(text).map_err(|why| format!("part {number} `{text}`: {why}"))
        });
        let parts = parts.collect::<std::result::Result<Vec<_>, String>>()?;
        check_edge(&parts)?;
        Ok(Self { text: text.to_owned(), is_probe: false, parts })
    }
}

impl ToolSpec {
    /// Its parts.
    #[must_use]
    pub fn parts(&self) -> &[ToolPart] {
        &self.parts
    }

    /// Returns true if it has a blade or scissors.
    pub fn is_blade(&self) -> bool {
        self.parts.iter().any(ToolPart::is_edge)
    }
}

impl fmt::Display for ToolSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

by_text!(ToolSpec);

fn part(text: &str) -> std::result::Result<ToolPart, String> {
    // Split KIND:SIZES@PLACE/TURN from its end.
    let (text, turn) = text.split_once('/').map_or((text, None), |(a, b)| (a, Some(b)));
    let (text, place) = text.split_once('@').map_or((text, None), |(a, b)| (a, Some(b)));
    let (kind, sizes) = text.split_once(':').map_or((text, None), |(a, b)| (a, Some(b)));
    let of = |form: &str| format!("write {kind}:{form} [m]");
    let shape = match (kind, sizes) {
        ("sphere", sizes) => {
            let [radius_m] = numbers(sizes).ok_or_else(|| of("RADIUS"))?;
            ToolPart::sphere(radius_m)
        }
        ("capsule", sizes) => {
            let [half_m, radius_m] = numbers(sizes).ok_or_else(|| of("HALF_LENGTH,RADIUS"))?;
            ToolPart::capsule(half_m, radius_m)
        }
        ("box", sizes) => {
            let [x, y, z, radius_m] = numbers(sizes).ok_or_else(|| of("HX,HY,HZ,RADIUS"))?;
            ToolPart::rounded_box([x, y, z], radius_m)
        }
        ("blade", sizes) => {
            let [length_m] = numbers(sizes).ok_or_else(|| of("LENGTH"))?;
            if length_m <= 0.0 {
                return Err(format!("the length {length_m} must be above 0 [m]"));
            }
            ToolPart::edge(0.5 * length_m)
        }
        ("scissors", sizes) => scissors(sizes)?,
        ("half-space", None) => ToolPart::half_space(HALF_SPACE_RADIUS_M),
        ("half-space", sizes) => {
            let [radius_m] = numbers(sizes).ok_or_else(|| of("RADIUS"))?;
            ToolPart::half_space(radius_m)
        }
        _ => {
            return Err("unknown kind: write sphere:R, capsule:HALF_LENGTH,R, box:HX,HY,HZ,R, blade:LENGTH, \
                        scissors:LENGTH or half-space"
                .to_owned());
        }
    };
    // Check the sizes.
    if shape.radius_m <= 0.0 && !shape.is_edge() {
        return Err(format!("the radius {} must be above 0 [m]", shape.radius_m));
    }
    if !shape.is_half_space() && shape.half_m.iter().any(|&half| half < 0.0) {
        return Err("a half length must be 0 or more [m]".to_owned());
    }
    // Put the part into the frame of its tool.
    let centre_m = place.map_or(Some([0.0; 3]), |place| numbers(Some(place)));
    let centre_m =
        centre_m.ok_or("behind @ stands the place in the tool's frame: write @X,Y,Z [m]")?;
    let orientation = turn.map_or(Ok(shape.orientation), orientation)?;
    Ok(ToolPart { centre_m, orientation, ..shape })
}

/// Scissors of a length, an offset and a mouth: a tenth and a half of the length unless they are given.
fn scissors(sizes: Option<&str>) -> std::result::Result<ToolPart, String> {
    let form = "write scissors:LENGTH, scissors:LENGTH,OFFSET or scissors:LENGTH,OFFSET,MOUTH [m]";
    // Read one to three numbers.
    let found = match sizes.map_or(0, |sizes| sizes.split(',').count()) {
        1 => numbers(sizes).map(|[length_m]| [length_m, 0.1 * length_m, 0.5 * length_m]),
        2 => numbers(sizes).map(|[length_m, offset_m]| [length_m, offset_m, 0.5 * length_m]),
        _ => numbers(sizes),
    };
    let [length_m, offset_m, mouth_m] = found.ok_or(form)?;
    // Check them.
    for (name, size_m) in [("length", length_m), ("offset", offset_m), ("mouth", mouth_m)] {
        if size_m <= 0.0 {
            return Err(format!("the {name} {size_m} must be above 0 [m]"));
        }
    }
    if !(1e-3 * length_m..length_m).contains(&offset_m) {
        return Err(format!(
            "the offset {offset_m} must be below the length {length_m} [m], and a thousandth of it at least"
        ));
    }
    Ok(ToolPart::scissors(length_m, offset_m, mouth_m))
}

/// Refuses parts behind a blade, another blade among them.
fn check_edge(parts: &[ToolPart]) -> std::result::Result<(), String> {
    match parts.iter().position(ToolPart::is_edge) {
        Some(at) if at + 1 < parts.len() => Err(format!(
            "part {} is a blade: a tool has one, as its last part, or scissors; write the other parts before \
             it, or give --tool once more",
            at + 1
        )),
        _ => Ok(()),
    }
}

/// A unit quaternion x,y,z,w.
fn orientation(text: &str) -> std::result::Result<[f32; 4], String> {
    let found =
        numbers(Some(text)).ok_or("behind / stands the turn, a unit quaternion: write /X,Y,Z,W")?;
    if !is_unit(found) {
        let size = length_of(found);
        return Err(format!(
            "the quaternion behind / has length {size}, it must be 1 (no turn is 0,0,0,1)"
        ));
    }
    Ok(found)
}

/// The sphere that `--contact probe:RADIUS` stands for; `None` for any other contact.
///
/// # Errors
/// A radius that cannot be.
pub fn probe(contact: &str) -> Result<Option<ToolSpec>> {
    if contact == "probe" {
        return Err(Error::input("--contact probe: give its radius [m], as in probe:0.012"));
    }
    let Some(radius) = contact.strip_prefix("probe:") else { return Ok(None) };
    if radius.parse::<f32>().is_err() {
        return Err(Error::input(format!(
            "--contact {contact}: {radius:?} is no radius [m], as in probe:0.012"
        )));
    }
    let sphere = format!("sphere:{radius}").parse::<ToolSpec>();
    sphere.map(|sphere| Some(ToolSpec { is_probe: true, ..sphere })).map_err(|_| {
        Error::input(format!("--contact {contact}: the radius must be above 0 and finite [m]"))
    })
}

/// N finite numbers with commas between.
fn numbers<const N: usize>(text: Option<&str>) -> Option<[f32; N]> {
    let numbers: Option<Vec<f32>> =
        text?.split(',').map(|x| x.trim().parse().ok().filter(|x: &f32| x.is_finite())).collect();
    numbers?.try_into().ok()
}

/// The tools on a model.
///
/// # Errors
/// More tools than there may be, a model without a contact surface, a blade on one that cannot be cut, a part
/// larger than the body's own bound, a coefficient of friction out of range.
pub fn tools(specs: &[ToolSpec], friction: Option<f32>, model: &Model<'_>) -> Result<Contact> {
    // Check the tools as a whole.
    if specs.len() > TOOLS_MAX {
        return Err(Error::input(format!(
            "--tool is given {} times: there are at most {TOOLS_MAX} tools",
            specs.len()
        )));
    }
    if !model.has_contact_surface() {
        return Err(Error::input(
            "a tool touches the surface of a body, and this model has none: bake it from a mesh with \
             triangles or tetrahedra (a lean one with --contact-surface yes), or hold cells with \
             --contact cells:SELECTOR",
        ));
    }
    let blade = specs.iter().find(|spec| spec.is_blade());
    if let Some(blade) = blade.filter(|_| model.tetrahedra_to_cut() == 0) {
        return Err(Error::input(format!(
            "--tool {}: a blade cuts, and this model cannot be cut: bake it with --cuttable, which needs \
             tetrahedra",
            blade.text
        )));
    }
    let friction = friction.unwrap_or(0.0);
    if !(0.0..=FRICTION_MAX).contains(&friction) {
        return Err(Error::input(format!("--friction {friction}: must be 0 to {FRICTION_MAX}")));
    }
    // Check the sizes of the parts against the body.
    let most_m = model.saturation() * model.unit_m();
    for spec in specs {
        let ToolSpec { text, is_probe, parts } = spec;
        let half = |part: &ToolPart| if part.is_half_space() { [0.0; 3] } else { part.half_m };
        let sizes = parts.iter().flat_map(|part| [[part.radius_m; 3], part.centre_m, half(part)]);
        if let Some(size_m) = sizes.flatten().find(|size_m| size_m.abs() > most_m) {
            let given = match is_probe {
                true => format!("--contact {}", text.replace("sphere", "probe")),
                false => format!("--tool {text}"),
            };
            return Err(Error::input(format!(
                "{given}: {size_m} m is more than {most_m} m, the body's own bound (--k-m of \
                 bake)"
            )));
        }
    }
    let tools = specs.iter().map(|spec| spec.parts.clone()).collect();
    Ok(Contact::Tools { tools, friction })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spec_names_parts_with_place_and_turn() {
        let text = "sphere:0.01+capsule:0.02,0.004@0,0,0.03/0,0.6,0,0.8+box:0.01,0.02,0.03,0.002\
            +half-space+half-space:0.005+blade:0.03@0,0,-0.01/0,0,1,0";
        let found = text.parse::<ToolSpec>().unwrap();
        assert_eq!(found.text, text);
        let capsule = ToolPart {
            centre_m: [0.0, 0.0, 0.03],
            orientation: [0.0, 0.6, 0.0, 0.8],
            ..ToolPart::capsule(0.02, 0.004)
        };
        let edge = ToolPart {
            centre_m: [0.0, 0.0, -0.01],
            orientation: [0.0, 0.0, 1.0, 0.0],
            ..ToolPart::edge(0.015)
        };
        let wanted = [
            ToolPart::sphere(0.01),
            capsule,
            ToolPart::rounded_box([0.01, 0.02, 0.03], 0.002),
            ToolPart::half_space(0.01),
            ToolPart::half_space(0.005),
            edge,
        ];
        assert_eq!(found.parts, wanted);
        assert_eq!("sphere:0.01/0,0,0,1@0,0,0".parse::<ToolSpec>(), Err(
            "part 1 `sphere:0.01/0,0,0,1@0,0,0`: behind / stands the turn, a unit quaternion: write \
             /X,Y,Z,W"
                .to_owned()
        ));
    }

    #[test]
    fn a_bad_spec_is_told_by_its_part() {
        for (text, wanted) in [
            ("", "unknown kind"),
            ("ball:0.1", "unknown kind"),
            ("sphere", "write sphere:RADIUS"),
            ("sphere:0.1,0.2", "write sphere:RADIUS"),
            ("sphere:nan", "write sphere:RADIUS"),
            ("sphere:0", "above 0"),
            ("sphere:-1", "above 0"),
            ("capsule:0.1", "write capsule:HALF_LENGTH,RADIUS"),
            ("capsule:-0.1,0.01", "0 or more"),
            ("box:1,2,3", "write box:HX,HY,HZ,RADIUS"),
            ("half-space:x", "write half-space:RADIUS"),
            ("blade", "write blade:LENGTH"),
            ("blade:0.1,0.2", "write blade:LENGTH"),
            ("blade:0", "above 0"),
            ("blade:-0.1", "above 0"),
            ("blade:0.1@1", "write @X,Y,Z"),
            ("scissors", "write scissors:LENGTH,"),
            ("scissors:0.1,0.01,0.05,1", "write scissors:LENGTH,"),
            ("scissors:0.1,wide", "write scissors:LENGTH,"),
            ("scissors:0", "the length 0 must be above 0"),
            ("scissors:0.1,-0.01", "the offset -0.01 must be above 0"),
            ("scissors:0.1,0.01,0", "the mouth 0 must be above 0"),
            ("scissors:0.1,0.1", "must be below the length 0.1"),
            ("scissors:0.1,1e-30", "a thousandth of it at least"),
            ("sphere:0.1@1,2", "write @X,Y,Z"),
            ("sphere:0.1/0,0,1", "write /X,Y,Z,W"),
            ("sphere:0.1/0,0,0,2", "has length 2"),
        ] {
            let text = format!("sphere:0.01+{text}");
            let why = text.parse::<ToolSpec>().unwrap_err();
            assert!(why.starts_with("part 2 `") && why.contains(wanted), "{text}: {why}");
        }
        let behind = "blade:0.01+sphere:0.01".parse::<ToolSpec>().unwrap_err();
        assert!(behind.starts_with("part 1 is a blade: a tool has one, as its last"), "{behind}");
        for (text, [length_m, offset_m, mouth_m]) in [
            ("scissors:0.04", [0.04, 0.004, 0.02]),
            ("scissors:0.04,0.005", [0.04, 0.005, 0.02]),
            ("scissors:0.04,0.005,0.01", [0.04, 0.005, 0.01]),
        ] {
            let found = text.parse::<ToolSpec>().unwrap();
            assert_eq!(found.parts, [ToolPart::scissors(length_m, offset_m, mouth_m)]);
            assert!(found.is_blade());
        }
        let nine = ["sphere:0.01"; 9].join("+");
        assert!(nine.parse::<ToolSpec>().unwrap_err().contains("at most 8"));
    }
}
