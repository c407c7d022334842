//! How many cells of the organ fit a millisecond.

/// Instructions of a millisecond: 480 MHz at one instruction a cycle.
const PER_MILLISECOND: f64 = 480_000.0;
/// Sweeps a tick that are asked about.
const SWEEPS: [u32; 3] = [1, 2, 4];

/// One size measured.
pub struct Size {
    pub cells: usize,
    /// Instructions of a tick of one sweep, and of every further sweep, in the worst state.
    pub tick: u64,
    pub sweep: u64,
}

/// A line for each number of sweeps; `sizes` ascending.
pub fn lines(sizes: &[Size]) -> Vec<String> {
    SWEEPS.iter().map(|&sweeps| line(sizes, sweeps)).collect()
}

fn line(sizes: &[Size], sweeps: u32) -> String {
    let cost = |size: &Size| size.tick as f64 + f64::from(sweeps - 1) * size.sweep as f64;
    let points: Vec<(f64, f64)> = sizes.iter().map(|s| (s.cells as f64, cost(s))).collect();
    // The pair around the millisecond, or the nearest one.
    let pair = points.windows(2).find(|pair| pair[1].1 >= PER_MILLISECOND);
    let Some([(a, low), (b, high)]) = pair.or(points.windows(2).last()) else {
        return "too few sizes".into();
    };
    let cells = a + (PER_MILLISECOND - low) * (b - a) / (high - low);
    let measured = (*low..=*high).contains(&PER_MILLISECOND);
    let how = if measured { "interpolated" } else { "extrapolated" };
    let plural = if sweeps == 1 { "sweep" } else { "sweeps" };
    format!("track, {sweeps} {plural} a tick: {cells:.0} cells in 480,000 instructions, {how}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_two_sizes() {
        let sizes = [(100, 120_000, 100_000), (500, 600_000, 500_000)];
        let sizes = sizes.map(|(cells, tick, sweep)| Size { cells, tick, sweep });
        let lines = lines(&sizes);
        assert!(lines[0].contains(" 400 cells") && lines[0].contains("interpolated"), "{lines:?}");
        assert!(lines[2].contains(" 114 cells") && lines[2].contains("interpolated"), "{lines:?}");
    }
}
