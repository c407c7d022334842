//! A strip of tissue that relaxes, in one dimension: the exact stress of a Prony series.
//!
//! The stress is E (e + sum of g q), where q' + q / tau = e' in each branch, from rest.

use chaincell_host::bake::tissue::Branch;

/// A linear strip whose stress relaxes.
#[derive(Debug, Clone, PartialEq)]
pub struct Prony {
    /// Long-term modulus, in the unit of the stress.
    pub modulus: f64,
    /// Branches with their modulus over the long-term one.
    pub branches: Vec<Branch>,
}

impl Prony {
    /// Returns the stress at a time from 0 on \[s\] under a strain that is 0 before time 0, and constant from then on.
    ///
    /// ```
    /// # use chaincell_host::bake::tissue::Branch;
    /// # use chaincell_lab::reference::prony::Prony;
    /// let strip = Prony { modulus: 100.0, branches: vec![Branch { ratio: 2.0, time_s: 0.5 }] };
    /// assert!((strip.step(0.1, 0.0) - 30.0).abs() < 1e-9);
    /// assert!((strip.step(0.1, 100.0) - 10.0).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn step(&self, strain: f64, time_s: f64) -> f64 {
        self.stress(strain, |of| strain * (-time_s / of.time_s).exp())
    }

    /// Returns the stress at a time from 0 on \[s\] under a strain that grows at a constant rate from time 0 \[1/s\].
    #[must_use]
    pub fn ramp(&self, rate_per_s: f64, time_s: f64) -> f64 {
        let strain = rate_per_s * time_s;
        self.stress(strain, |of| strain * left_of_ramp(time_s / of.time_s))
    }

    /// Returns the stress at a time from 0 on \[s\] under a sine of strain that begins at time 0, with the rise from
    /// rest.
    #[must_use]
    pub fn sine(&self, amplitude: f64, hz: f64, time_s: f64) -> f64 {
        let turns = std::f64::consts::TAU * hz;
        let (sine, cosine) = (turns * time_s).sin_cos();
        self.stress(amplitude * sine, |of| {
            let lag = turns * of.time_s;
            let steady = cosine + lag * sine;
            amplitude * lag / (1.0 + lag * lag) * (steady - (-time_s / of.time_s).exp())
        })
    }

    /// Returns the stress at each point of a strain that is linear between the points: times \[s\] in ascending
    /// order with their strains, two of the same time for a jump. The strip is at rest at the first one.
    #[must_use]
    pub fn path(&self, points: &[[f64; 2]]) -> Vec<f64> {
        let start = points.first().map_or(0.0, |point| point[1]);
        let mut held = vec![0.0; self.branches.len()];
        let mut stresses = vec![self.modulus * start; points.len().min(1)];
        for ends in points.windows(2) {
            let [[from_s, from], [to_s, to]] = [ends[0], ends[1]];
            let past_s = to_s - from_s;
            let mut sum = to;
            for (held, of) in held.iter_mut().zip(&self.branches) {
                let past = past_s / of.time_s;
                *held = *held * (-past).exp() + (to - from) * left_of_ramp(past);
                sum += of.ratio * *held;
            }
            stresses.push(self.modulus * sum);
        }
        stresses
    }

    fn stress(&self, strain: f64, held: impl Fn(&Branch) -> f64) -> f64 {
        let branches: f64 = self.branches.iter().map(|of| of.ratio * held(of)).sum();
        self.modulus * (strain + branches)
    }
}

/// Returns the share of a ramp of strain that a branch holds at its end, after a time in units of the branch's.
fn left_of_ramp(time: f64) -> f64 {
    if time > 0.0 { -(-time).exp_m1() / time } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip() -> Prony {
        let branches = [(0.5, 0.005), (2.0, 0.3), (1.0, 20.0)];
        let branches = branches.map(|(ratio, time_s)| Branch { ratio, time_s }).to_vec();
        Prony { modulus: 700.0, branches }
    }

    /// Largest difference of two courses over the largest of the second.
    fn error(found: &[f64], wanted: &[f64]) -> f64 {
        let peak = wanted.iter().fold(0.0_f64, |peak, x| peak.max(x.abs()));
        let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs());
        off.fold(0.0, f64::max) / peak
    }

    #[test]
    fn a_step_falls_from_all_moduli_to_the_long_term_one() {
        let strip = strip();
        assert!((strip.step(0.1, 0.0) - 70.0 * 4.5).abs() < 1e-10);
        assert!((strip.step(0.1, 1e4) - 70.0).abs() < 1e-10);
        // A branch alone falls to 1 / e in its time.
        let one = Prony { branches: vec![Branch { ratio: 3.0, time_s: 2.0 }], ..strip };
        let left = one.step(0.2, 2.0) / 140.0 - 1.0;
        assert!((left * std::f64::consts::E - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_ramp_is_the_sum_of_steps() {
        let strip = strip();
        for time_s in [0.01, 0.5, 40.0] {
            // Steps at the middle of each part of the time.
            let count = 20_000;
            let part_s = time_s / f64::from(count);
            let steps =
                (0..count).map(|at| strip.step(0.2 * part_s, part_s * (f64::from(at) + 0.5)));
            let sum: f64 = steps.sum();
            assert!((sum / strip.ramp(0.2, time_s) - 1.0).abs() < 1e-6, "{time_s}: {sum}");
        }
    }

    #[test]
    fn a_sine_is_that_of_a_fine_path() {
        let strip = strip();
        for hz in [0.1, 1.0, 10.0] {
            let points: Vec<[f64; 2]> = (0..40_000)
                .map(|at| {
                    let time_s = f64::from(at) * 1e-4 / hz;
                    [time_s, 0.03 * (std::f64::consts::TAU * hz * time_s).sin()]
                })
                .collect();
            let wanted: Vec<f64> = points.iter().map(|[t, _]| strip.sine(0.03, hz, *t)).collect();
            let error = error(&strip.path(&points), &wanted);
            assert!(error < 1e-6, "{hz} Hz: {error}");
        }
    }

    #[test]
    fn a_path_of_few_points_is_exact_for_ramps_holds_and_jumps() {
        let strip = strip();
        let stress = strip.path(&[[0.0, 0.0], [0.0, 0.1], [1.0, 0.1], [5.0, 0.1]]);
        let wanted = [0.0, strip.step(0.1, 0.0), strip.step(0.1, 1.0), strip.step(0.1, 5.0)];
        assert!(error(&stress, &wanted) < 1e-12, "{stress:?} {wanted:?}");
        let stress = strip.path(&[[0.0, 0.0], [2.0, 0.4], [2.5, 0.4], [9.0, 0.4]]);
        let wanted = [0.0, 2.0, 2.5, 9.0]
            .map(|t: f64| strip.ramp(0.2, t) - strip.ramp(0.2, (t - 2.0).max(0.0)));
        assert!(error(&stress, &wanted) < 1e-12, "{stress:?} {wanted:?}");
    }
}
