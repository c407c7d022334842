//! The judgement of a run by the program itself: every remark on whether a figure can be trusted, computed from
//! facts in one place, so that all commands print the same words.

mod mesh;
mod pace;

use chaincell_kernel::{Cutting, Model};
use serde::Serialize;

pub use mesh::MeshFit;
pub use pace::Pace;

use crate::engine::course::ToolCourse;
use crate::engine::place::bend_deg;
use crate::engine::untouched::Untouched;
use crate::engine::{Contact, Engine};
use crate::error::Result;
use crate::terminal;
use crate::words::length;

/// A tool is held back where the tissue stays behind it by this share of the depth, and by this length \[m\].
const HELD_SHARE: f64 = 0.05;
const HELD_M: f64 = 1e-4;
/// Angle of the surface from which on a default contact is at a corner or an edge \[degrees\].
const BEND_DEG: f64 = 40.0;

/// The remedy for a blade that feels nothing since cutting is off.
const CUT_OFF: &str =
    "cutting is off, so blades feel nothing: leave `--cut off` out, or `set cut=on`";

/// A judgement, for JSON and as some rows.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Judgement {
    /// How long a tick takes on this machine, compared with its period.
    pub pace: Option<Pace>,
    /// Edges of the surface compared with the radius of the tool.
    pub mesh: Option<MeshFit>,
    /// Depths of a tool that the tissue held back.
    pub held_back: Vec<HeldBack>,
    /// Numbers of the tools that never touched.
    pub untouched_tools: Vec<usize>,
    /// Angle of the surface at a default contact at a corner or an edge \[degrees\].
    pub corner_deg: Option<f64>,
    /// How near the first tool came that never touched.
    #[serde(skip)]
    nearest: Option<Untouched>,
    /// A remedy of the command's own where no tool touched.
    #[serde(skip)]
    remedy: Option<&'static str>,
    /// Number of tools.
    #[serde(skip)]
    tools: usize,
}

/// A tool that the tissue held back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeldBack {
    /// Number of the tool.
    pub tool: usize,
    /// Depth below the first contact along the force that the tool asked for \[m\].
    pub asked_m: f64,
    /// Depth at which the tissue met it then \[m\].
    pub reached_m: f64,
}

impl Judgement {
    /// Of a model that no tool has touched yet.
    pub fn of_model(model: &Model<'_>, pace: Option<Pace>, mesh: Option<MeshFit>) -> Self {
        Self { pace, mesh, corner_deg: corner_deg(model), ..Self::default() }
    }

    /// Of a body whose contact is chosen by default, where `is_default`.
    pub fn of_body(engine: &Engine<'_>, is_default: bool, pace: Option<Pace>) -> Self {
        let corner_deg = is_default.then(|| corner_deg(engine.network().model())).flatten();
        Self { pace, corner_deg, ..Self::default() }
    }

    /// Adds what the tools did to the body of an engine; `nearest` of a first tool that never touched.
    #[must_use]
    pub fn with_tools(
        self,
        engine: &Engine<'_>,
        tools: &[ToolCourse],
        nearest: Option<Untouched>,
    ) -> Self {
        let is_held = matches!(engine.contact(), Contact::Cells(_));
        let mesh = tools.first().and_then(|first| MeshFit::under(engine, first));
        let is_off =
            engine.network().settings().cut == Cutting::Off && engine.contact().has_blade();
        let remedy = self.remedy.or(is_off.then_some(CUT_OFF));
        let this = Self { mesh, remedy, ..self };
        if is_held { this } else { this.with_courses(tools, nearest) }
    }

    /// Adds what tools did to a body that is not known.
    #[must_use]
    pub fn with_courses(self, tools: &[ToolCourse], nearest: Option<Untouched>) -> Self {
        let untouched = tools.iter().enumerate().filter(|(_, of)| !of.has_touched);
        let held_back = tools.iter().enumerate().filter_map(|(tool, of)| {
            let (asked_m, reached_m) = (of.asked_m?, of.reached_m?);
            let behind_m = asked_m - reached_m;
            let is_held = behind_m > HELD_M && behind_m > HELD_SHARE * asked_m;
            is_held.then_some(HeldBack { tool, asked_m, reached_m })
        });
        Self {
            held_back: held_back.collect(),
            untouched_tools: untouched.map(|(tool, _)| tool).collect(),
            nearest,
            tools: tools.len(),
            ..self
        }
    }

    /// Adds what to do where no tool touched.
    #[must_use]
    pub fn with_remedy(self, remedy: Option<&'static str>) -> Self {
        Self { remedy, ..self }
    }

    /// The remarks, each with the name of its row.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let mut rows = Vec::new();
        rows.extend(self.pace.as_ref().map(|pace| ("pace", pace.to_string())));
        rows.extend(self.mesh.as_ref().map(|mesh| ("mesh", mesh.to_string())));
        rows.extend(self.held_back.iter().map(|held| ("depth", self.held_words(held))));
        let words = self.untouched_words();
        rows.extend(
            words.map(|words| ("contact", format!("{words}; {}", self.untouched_remedy()))),
        );
        rows.extend(self.corner_deg.map(|bend| ("place", corner_words(bend))));
        rows
    }

    /// Prints the rows, their names in a column of this width.
    pub fn print(&self, width: usize) -> Result<()> {
        self.rows()
            .iter()
            .try_for_each(|(name, words)| terminal::say(format_args!("  {name:<width$}{words}")))
    }

    fn held_words(&self, held: &HeldBack) -> String {
        let HeldBack { tool, asked_m, reached_m } = *held;
        let (asked, reached) = (length(asked_m), length(reached_m));
        let of = if self.tools > 1 { format!("tool {tool}: ") } else { String::new() };
        format!(
            "{of}asked {asked}, held back at {reached}: the tissue stops the tool, and the force stays what \
             it is there; press less deep, or take a larger tool or a finer mesh (`chaincell info --probe \
             RADIUS` says how deep a sphere comes)"
        )
    }

    fn untouched_words(&self) -> Option<String> {
        if let Some(nearest) = &self.nearest {
            return Some(nearest.to_string());
        }
        let numbers: Vec<String> = self.untouched_tools.iter().map(ToString::to_string).collect();
        match (&numbers[..], self.tools) {
            ([], _) => None,
            (_, 1) => Some("the tool never touched the body".into()),
            ([one], _) => Some(format!("tool {one} never touched the body")),
            (all, _) => Some(format!("tools {} never touched the body", all.join(", "))),
        }
    }

    /// Returns the remedy for a tool that did not touch.
    fn untouched_remedy(&self) -> &'static str {
        match (self.remedy, &self.nearest) {
            (Some(remedy), _) => remedy,
            (None, Some(Untouched { nearest_m: None, .. })) => {
                "a pose that acts on the body has `engaged` 1"
            }
            (None, Some(Untouched { began_inside: true, .. })) => "begin outside of the body",
            (None, Some(Untouched { is_inside: true, .. })) => {
                "press deeper, or bake a finer mesh: a tool is felt at points of the triangles, which it can pass \
                 between by a share of an edge"
            }
            _ => "bring it nearer: `chaincell info MODEL` has the extent of the body",
        }
    }
}

/// Angle of the surface at the default contact, where that is at a corner or an edge.
fn corner_deg(model: &Model<'_>) -> Option<f64> {
    bend_deg(model).filter(|bend| *bend > BEND_DEG)
}

fn corner_words(bend_deg: f64) -> String {
    format!(
        "the default contact is at a corner or an edge, where the surface bends by {bend_deg:.0} degrees: hold \
         others with --contact cells:SELECTOR, or press elsewhere with --touch-m and --direction of `run` and \
         `control`"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(asked_m: f64, reached_m: f64) -> ToolCourse {
        let depths = (Some(asked_m), Some(reached_m));
        ToolCourse {
            has_touched: true,
            asked_m: depths.0,
            reached_m: depths.1,
            ..Default::default()
        }
    }

    fn said(tools: &[ToolCourse]) -> String {
        let rows = Judgement::default().with_courses(tools, None).rows();
        rows.iter().map(|(name, words)| format!("{name}: {words}\n")).collect()
    }

    #[test]
    fn a_tool_held_back_is_said_with_both_depths_and_a_remedy() {
        let text = said(&[course(0.01, 0.0073)]);
        let begin = "depth: asked 10.0 mm, held back at 7.30 mm: the tissue stops the tool";
        assert!(text.starts_with(begin) && text.contains("finer mesh"), "{text}");
        assert_eq!(said(&[course(0.01, 0.0098)]), "");
        assert!(
            said(&[course(0.01, 0.01), course(0.02, 0.01)]).starts_with("depth: tool 1: asked")
        );
    }

    #[test]
    fn tools_that_never_touched_are_named() {
        let never = ToolCourse::default();
        let touched = course(0.01, 0.01);
        let words = |subject: &str| {
            let remedy = "bring it nearer: `chaincell info MODEL` has the extent of the body";
            format!("contact: {subject} never touched the body; {remedy}\n")
        };
        assert_eq!(said(&[never]), words("the tool"));
        assert_eq!(said(&[touched, never]), words("tool 1"));
        assert_eq!(said(&[never, touched, never]), words("tools 0, 2"));
        assert_eq!(said(&[touched]), "");
        let nearest = Some(Untouched {
            nearest_m: Some(0.0041),
            tick: Some(7),
            is_inside: false,
            began_inside: false,
        });
        let rows = Judgement::default().with_courses(&[never], nearest).rows();
        assert!(rows[0].1.contains("nearest 4.1 mm at tick 7"), "{rows:?}");
    }

    #[test]
    fn a_corner_is_said_with_what_to_do() {
        let rows = Judgement { corner_deg: Some(54.7), ..Judgement::default() }.rows();
        assert!(rows[0].1.contains("bends by 55 degrees") && rows[0].1.contains("--touch-m"));
    }
}
