//! A run as text, for a target whose runs are compared on a workstation.
//!
//! ```text
//! scene NAME TIER
//! tick TICK STATE_HASH DIGEST          a line a tick, hexadecimal
//! cells TICK                           where asked for: the state after that tick
//! cell CELL X Y Z                      bits of the published position, hexadecimal
//! end TICKS DIGEST BYTES
//! ```
//!
//! [`write()`] gives it, [`check()`] plays the same scene here and names the first tick and cell
//! that differ. Several reports may stand one after the other; lines of other kinds (what a
//! firmware's console says besides) stand between two reports, not in one.

use core::fmt::{self, Write};
use core::str::Lines;

use chaincell_kernel::{Choice, Dynamics, TissueMut};

use crate::{Act, Difference, NO_ID, Run, Scene, Stepper, Tier, stage};

/// What to report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wish {
    /// Number type, for the first line.
    pub tier: Tier,
    /// Ticks to play.
    pub ticks: u32,
    /// Tick after which the cells are wanted too.
    pub cells_after: Option<u32>,
}

/// Plays a run that has just begun and writes its report.
///
/// # Errors
/// Those of the writer.
pub fn write(to: &mut dyn Write, run: &mut dyn Stepper, wish: Wish) -> fmt::Result {
    writeln!(to, "scene {} {}", run.scene().name, wish.tier.name())?;
    for tick in 0..wish.ticks {
        let state_hash = run.step();
        writeln!(to, "tick {tick} {state_hash:016x} {:016x}", run.digest())?;
        if wish.cells_after == Some(tick) {
            writeln!(to, "cells {tick}")?;
            for (cell, [x, y, z]) in (0..).map_while(|cell| Some((cell, run.cell_bits(cell)?))) {
                writeln!(to, "cell {cell} {x:08x} {y:08x} {z:08x}")?;
            }
        }
    }
    writeln!(to, "end {} {:016x} {}", wish.ticks, run.digest(), run.bytes())
}

/// What is wrong with a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault<'r> {
    /// No report in the text.
    Nothing,
    /// A scene or tier that is not known here.
    Scene(&'r str),
    /// The report of this scene stops before its end.
    Cut(&'static str),
    /// A line that does not belong where it stands.
    Line(&'static str, &'r str),
    /// The scene cannot be played here.
    Unplayable(&'static str),
    /// The run went another way.
    Differs {
        /// The scene.
        scene: &'static str,
        /// Where; without a cell also where the report has none for that tick.
        difference: Difference,
        /// Whether the report has the cells after that tick.
        with_cells: bool,
    },
}

impl fmt::Display for Fault<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => f.write_str("no report: it begins with a line `scene NAME TIER`"),
            Self::Scene(line) => write!(f, "`{line}`: no such scene here; see `golden list`"),
            Self::Cut(scene) => write!(f, "{scene}: the report stops before its line `end`"),
            Self::Line(scene, line) => write!(f, "{scene}: unexpected line `{line}`"),
            Self::Unplayable(scene) => write!(f, "{scene}: cannot be played here"),
            Self::Differs { scene, difference, with_cells: true } => {
                write!(f, "{scene}: {difference}")
            }
            Self::Differs { scene, difference: Difference { tick, .. }, with_cells: false } => {
                write!(
                    f,
                    "{scene}: first difference at tick {tick}; report its cells too, CELLS_AFTER {tick}"
                )
            }
        }
    }
}

impl core::error::Error for Fault<'_> {}

/// Plays all scenes of a text of reports here and compares; gives the number of ticks that agree.
///
/// Cells read as the workstation's first, then the report's.
///
/// # Errors
/// The first thing that is wrong.
pub fn check(text: &str) -> Result<u64, Fault<'_>> {
    let mut lines = text.lines();
    let mut ticks = 0;
    while let Some(line) = lines.next() {
        let Some(title) = line.strip_prefix("scene ") else { continue };
        let (name, tier) = title.split_once(' ').ok_or(Fault::Scene(line))?;
        let tier = Tier::from_name(tier);
        let outcome = stage(name, tier.ok_or(Fault::Scene(line))?, Compare(&mut lines));
        ticks += u64::from(outcome.ok_or(Fault::Scene(line))??);
    }
    if ticks > 0 { Ok(ticks) } else { Err(Fault::Nothing) }
}

/// A line of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Line {
    Tick(u32, u64, u64),
    Cells(u32),
    Cell(usize, [u64; 3]),
    End(u32, u64, u64),
}

impl Line {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_ascii_whitespace();
        let kind = words.next()?;
        let mut word = || words.next();
        let long = |word: &str| u64::from_str_radix(word, 16).ok();
        let parsed = match kind {
            "tick" => Self::Tick(word()?.parse().ok()?, long(word()?)?, long(word()?)?),
            "cells" => Self::Cells(word()?.parse().ok()?),
            "cell" => {
                let cell = word()?.parse().ok()?;
                let mut bits = || long(word()?);
                Self::Cell(cell, [bits()?, bits()?, bits()?])
            }
            "end" => Self::End(word()?.parse().ok()?, long(word()?)?, word()?.parse().ok()?),
            _ => return None,
        };
        words.next().is_none().then_some(parsed)
    }
}

/// One report against a run of its scene.
struct Compare<'l, 'r>(&'l mut Lines<'r>);

impl<'r> Act for Compare<'_, 'r> {
    type Output = Result<u32, Fault<'r>>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).map_err(|_| Fault::Unplayable(scene.name))?;
        while let Some(line) = self.0.next() {
            match Line::parse(line) {
                Some(Line::Tick(tick, state_hash, digest)) if tick == run.ticks() => {
                    let here = run.step();
                    if (here, run.digest()) != (state_hash, digest) {
                        return Err(differs(&run, tick, self.0));
                    }
                }
                // Where the hash agrees the cells do.
                Some(Line::Cells(_) | Line::Cell(..)) => {}
                Some(Line::End(ticks, digest, bytes))
                    if (ticks, digest, bytes) == (run.ticks(), run.digest(), run.bytes()) =>
                {
                    return Ok(ticks);
                }
                _ => return Err(Fault::Line(scene.name, line)),
            }
        }
        Err(Fault::Cut(scene.name))
    }
}

/// The first cell that differs after `tick`, from the lines behind it.
fn differs<'r>(run: &dyn Stepper, tick: u32, lines: &mut Lines<'r>) -> Fault<'r> {
    let with_cells = lines.next().and_then(Line::parse) == Some(Line::Cells(tick));
    let cells = lines.map_while(|line| match Line::parse(line) {
        Some(Line::Cell(cell, bits)) => Some((cell, bits)),
        _ => None,
    });
    let mut cells = cells.filter(|_| with_cells);
    let cell = cells.find_map(|(cell, there)| {
        let here = run.cell_bits(cell)?;
        (here != there).then_some((cell, run.input_id(cell).unwrap_or(NO_ID), [here, there]))
    });
    Fault::Differs { scene: run.scene().name, difference: Difference { tick, cell }, with_cells }
}
