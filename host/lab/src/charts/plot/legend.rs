//! The legend, to the right of the frame: plotters' own would cover the data.

use super::canvas::{self, Area, Place, TEXT};
use super::draw::{GAP, line, markers};
use super::{Chart, SIZE_PX, Style};
use chaincell_host::error::Result;

/// Length of the sample of a line, and the largest width of the legend \[px\].
const SAMPLE: i32 = 64;
const LEGEND: i32 = SIZE_PX.0 as i32 / 3;

/// An entry: number and style of the series, the label's lines.
type Entry = ((usize, Style), Vec<String>);

/// What stands to the right of the frame: plotters' own legend covers the data.
pub(super) struct Legend {
    entries: Vec<Entry>,
    /// With the gap to the frame \[px\].
    pub width: i32,
}

impl Legend {
    pub fn new(area: &Area<'_>, chart: &Chart) -> Result<Self> {
        let series = chart.series.iter().enumerate();
        let all = series
            .map(|(at, series)| ((at, series.style), series.label.as_str()))
            .filter(|(_, label)| !label.is_empty());
        let (mut entries, mut widest) = (Vec::new(), 0);
        for (sample, label) in all {
            // A text that cannot be measured takes a line of its own.
            let width =
                |text: &str| canvas::measure(area, text, TEXT).map_or(LEGEND, |size| size.0);
            let lines = wrap(label, LEGEND - SAMPLE - 2 * GAP, width);
            widest = lines.iter().map(|line| width(line)).fold(widest, i32::max);
            entries.push((sample, lines));
        }
        let width = if entries.is_empty() { 0 } else { GAP + SAMPLE + GAP + widest };
        Ok(Self { entries, width })
    }

    /// Draws it beside the frame's upper right corner.
    pub fn draw(&self, area: &Area<'_>, (right, top): Place) -> Result<()> {
        let (left, mut top) = (right + GAP, top);
        for (sample, lines) in &self.entries {
            let middle = top + TEXT / 2;
            let ends = [(left, middle), (left + SAMPLE, middle)];
            let centre = (left + SAMPLE / 2, middle);
            let (at, style) = *sample;
            line(area, &ends, style, at)?;
            markers(area, &[centre], style, at)?;
            for words in lines {
                canvas::text(area, words, TEXT, (left + SAMPLE + GAP, top + TEXT / 2))?;
                top += TEXT + 4;
            }
            top += GAP;
        }
        Ok(())
    }
}

/// Breaks a text at its spaces into lines of at most `wide`, measured by `width_of`.
fn wrap(text: &str, wide: i32, width_of: impl Fn(&str) -> i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width_of(&format!("{line} {word}")) <= wide => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_at_spaces() {
        let width = |text: &str| text.len() as i32;
        assert_eq!(wrap("one two three", 7, width), ["one two", "three"]);
        assert_eq!(wrap("unbreakable", 3, width), ["unbreakable"]);
    }
}
