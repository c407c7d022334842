//! The force on a tool in the course of a run, as charts.

use nalgebra::Vector3;

use super::chart::{Axis, Chart, Style};
use crate::words::rate;

/// Most points of a curve: of more the lowest and the highest of each few are drawn.
const POINTS_MAX: usize = 4000;

/// Forces and positions of the first tool, tick by tick.
#[derive(Debug, Clone, Default)]
pub struct ForceCurve {
    ticks: Vec<Tick>,
}

#[derive(Debug, Clone, Copy)]
struct Tick {
    tick: u64,
    position_m: Vector3<f64>,
    force_n: Vector3<f64>,
    touches: bool,
}

impl ForceCurve {
    /// Adds a tick: the tool's position \[m\], the force on it \[N\], and whether it had a contact.
    pub fn add(&mut self, tick: u64, position_m: [f32; 3], force_n: [f32; 3], touches: bool) {
        let [position_m, force_n] =
            [position_m, force_n].map(|of| Vector3::from(of.map(f64::from)));
        self.ticks.push(Tick { tick, position_m, force_n, touches });
    }

    /// Force over time, of ticks at a rate \[Hz\].
    #[must_use]
    pub fn over_time(&self, hz: u32) -> Chart {
        let time_s = |tick: u64| tick as f64 / f64::from(hz);
        let points: Vec<[f64; 2]> =
            self.ticks.iter().map(|of| [time_s(of.tick), of.force_n.norm()]).collect();
        let (x, y) =
            (Axis::linear(&format!("time at {} [s]", rate(hz))), Axis::linear("force [N]"));
        Chart::new("Force on the tool over time", x, y).series("", Style::Line, &thin(&points))
    }

    /// Force over the depth below the first contact, along the largest force: until the deepest place, and
    /// after it. Empty where there is no force.
    #[must_use]
    pub fn over_depth(&self) -> Chart {
        let (x, y) = (
            Axis::linear("depth below the first contact, along the largest force [mm]"),
            Axis::linear("force [N]"),
        );
        let chart = Chart::new("Force on the tool over depth", x, y);
        let points = self.depths();
        let by_depth =
            |(_, a): &(usize, &[f64; 2]), (_, b): &(usize, &[f64; 2])| a[0].total_cmp(&b[0]);
        let Some((deepest, _)) = points.iter().enumerate().max_by(by_depth) else { return chart };
        chart.series("pressing", Style::Line, &thin(&points[..=deepest])).series(
            "retreating",
            Style::Dashed,
            &thin(&points[deepest..]),
        )
    }

    /// Depth \[mm\] and force \[N\] from the first contact on.
    fn depths(&self) -> Vec<[f64; 2]> {
        let sizes = self.ticks.iter().map(|of| of.force_n);
        let largest = sizes.max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let outward = largest.and_then(|force| force.try_normalize(1e-30));
        let first = self.ticks.iter().position(|of| of.touches);
        let (Some(outward), Some(first)) = (outward, first) else { return Vec::new() };
        let origin = self.ticks[first].position_m;
        let depth = |of: &Tick| -1e3 * (of.position_m - origin).dot(&outward);
        self.ticks[first..].iter().map(|of| [depth(of), of.force_n.norm()]).collect()
    }
}

/// The points, or of each few that follow one another the lowest and the highest.
fn thin(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if points.len() <= POINTS_MAX {
        return points.to_vec();
    }
    let few = points.len().div_ceil(POINTS_MAX / 2);
    let ends = points.chunks(few).flat_map(|few| {
        let by_force = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
        let least = few.iter().enumerate().min_by(|a, b| by_force(&a.1, &b.1));
        let most = few.iter().enumerate().max_by(|a, b| by_force(&a.1, &b.1));
        let mut ends: Vec<(usize, &[f64; 2])> = least.into_iter().chain(most).collect();
        ends.sort_by_key(|(at, _)| *at);
        ends.into_iter().map(|(_, point)| *point)
    });
    ends.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Down along x by 8 mm and back: the depth begins at the contact, the force is there once a way.
    #[test]
    fn depth_begins_at_the_first_contact() {
        let mut curve = ForceCurve::default();
        for tick in 0..20_u8 {
            let down = f32::from(tick.min(20 - tick));
            let force = (down - 2.0).max(0.0);
            let position_m = [1e-3 * down, 0.5, -0.25];
            curve.add(tick.into(), position_m, [-0.1 * force, 0.0, 0.0], force > 0.0);
        }
        let depths = curve.depths();
        let deepest = depths.iter().map(|point| point[0]).fold(0.0, f64::max);
        assert!((deepest - 7.0).abs() < 1e-4, "{deepest}");
        assert!(depths[0][0].abs() < 1e-12 && (depths[0][1] - 0.1).abs() < 1e-6, "{depths:?}");
        let drawn = curve.over_depth().draw();
        assert!(drawn.svg.contains(">pressing<") && drawn.svg.contains(">retreating<"));
        assert_eq!(drawn.left_out + curve.over_time(500).draw().left_out, 0);
        assert!(curve.over_time(500).draw().svg.contains("time at 500 Hz"));
    }

    #[test]
    fn without_a_force_there_is_an_empty_chart() {
        let mut curve = ForceCurve::default();
        curve.add(0, [0.0; 3], [0.0; 3], false);
        assert!(curve.over_depth().draw().svg.contains("depth below"));
    }

    #[test]
    fn long_curves_keep_their_peaks() {
        let points: Vec<[f64; 2]> =
            (0..50_000).map(|at| [f64::from(at), if at == 31_234 { 9.0 } else { 1.0 }]).collect();
        let thinned = thin(&points);
        assert!(thinned.len() <= POINTS_MAX + 2 && thinned.contains(&[31_234.0, 9.0]));
    }
}
