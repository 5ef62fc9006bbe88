//! What an iteration did.

/// How a decomposition went.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The relative squared error of the model that `Hooi` starts from; of other algorithms that before slices are left out.
    pub start: f64,
    /// After each sweep of `Hooi`, before slices are left out for an error bound. Differences from ‖T‖², exact to 1e-14 or so.
    pub sweeps: Vec<f64>,
    /// False where the last sweep still lowered the error by more than the tolerance, or where singular vectors of an unfolding
    /// whose sides are both above 4096 were not found to 1e-6 of the energy left out.
    pub converged: bool,
    /// Sweeps in a row, at most, that lowered the error by more than the tolerance and less than ten times it.
    pub slow: usize,
}

/// Slow sweeps in a row that make a swamp.
const SWAMP: usize = 10;

impl Report {
    /// Whether `Hooi` crept: ten sweeps or more in a row each lowered the error by more than the tolerance, else it had ended, but
    /// by less than ten times the tolerance. What it found may be far from what a longer run finds.
    pub fn swamp(&self) -> bool {
        self.slow >= SWAMP
    }

    pub(super) fn start(error: f64) -> Report {
        Report { start: error, sweeps: Vec::new(), converged: false, slow: 0 }
    }

    /// A sweep; errors up to `rounding` are none.
    pub(super) fn add(&mut self, error: f64, tolerance: f64, rounding: f64, vectors_converged: bool) {
        let before = self.sweeps.last().copied().unwrap_or(self.start);
        self.sweeps.push(error);
        let fall = before - error;
        self.converged = vectors_converged && (fall <= tolerance * before || error <= rounding);
        let is_slow = |(before, error): (f64, f64)| {
            before - error > tolerance * before && before - error < 10.0 * tolerance * before && error > rounding
        };
        let all: Vec<f64> = std::iter::once(self.start).chain(self.sweeps.iter().copied()).collect();
        let run = all.windows(2).rev().take_while(|pair| is_slow((pair[0], pair[1]))).count();
        self.slow = self.slow.max(run);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swamp_is_ten_slow_sweeps_in_a_row() {
        let falls = |factors: &[f64]| {
            let mut report = Report::start(1.0);
            let mut error = 1.0;
            for factor in factors {
                error *= 1.0 - factor;
                report.add(error, 1e-4, 1e-13, true);
            }
            report
        };
        let swamp = falls(&[[0.3; 2].as_slice(), &[5e-4; 10], &[1e-5]].concat());
        assert!(swamp.swamp() && swamp.slow == 10 && swamp.converged && swamp.sweeps.len() == 13);
        let broken = falls(&[[5e-4; 9].as_slice(), &[0.3], &[5e-4; 9]].concat());
        assert!(!broken.swamp() && broken.slow == 9 && !broken.converged);
        assert!(falls(&[0.0]).converged && falls(&[1.0]).converged);
    }
}
