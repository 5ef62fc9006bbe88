//! How a light is fitted.

use crate::kernel::Kernel;
use prt_transfer::{Params, Result};

prt_transfer::choices! {
    /// Where lobes begin.
    pub enum Starts {
        /// In stages, each new lobe where it takes most of what those before it left over.
        Greedy = "greedy",
        /// The paper's: directions in the order of their radiance times the angle over which it hardly changes, each one marking those
        /// around it (section 5.3).
        Coverage = "coverage",
        /// Uniform over the sphere, bandwidths from spacing.
        Random = "random",
    }
}

prt_transfer::choices! {
    /// How lobes move.
    pub enum Solver {
        /// Damped Gauss-Newton steps with the coefficients eliminated (variable projection after Kaufman 1975).
        GaussNewton = "gauss-newton",
        /// Bounded L-BFGS with the coefficients eliminated.
        Lbfgs = "l-bfgs",
        /// The paper's: centres, bandwidths and coefficients in turn, each with the others fixed, by bounded L-BFGS and least squares.
        Alternate = "alternate",
    }
}

prt_transfer::params! {
    /// A light as a sum of scattered lobes: least squares over centres, bandwidths and coefficients.
    pub struct FitParams: "fit-light" {
        /// Lobes, 1 to 4096: each has two numbers for its centre, one bandwidth and a coefficient for each channel.
        lobes: usize = 162,
        /// The function of the angle: gaussian or abel-poisson.
        kernel: Kernel = Kernel::Gaussian,
        /// Where lobes begin: greedy, coverage (the paper's heuristic) or random.
        starts: Starts = Starts::Greedy,
        /// How they move: gauss-newton, l-bfgs or alternate (the paper's).
        solver: Solver = Solver::GaussNewton,
        /// Steps of the solver on all lobes: trials of gauss-newton, iterations of l-bfgs, rounds of alternate. Stages with fewer lobes take
        /// a third of them.
        steps: usize = 60,
        /// Rounds in which the lobes that matter least are moved to where the error is largest; a round that does not pay is undone.
        exchanges: usize = 16,
        /// Whether l-bfgs with the coefficients eliminated follows the alternation (the paper's step 4).
        joint: bool = false,
        /// The narrowest lobe's bandwidth; none takes that of a spread of half a texel, the mean over the sphere.
        max_bandwidth: Option<f64> = None,
        /// The widest lobe's bandwidth; none takes that of a spread of 1.2 rad.
        min_bandwidth: Option<f64> = None,
        /// Whether a light of more than 12,288 texels is first fitted at half its resolution.
        coarse: bool = true,
        /// Of random starts and of the lobes that are exchanged.
        seed: u64 = 1,
    }
}

/// Lobes of a fit, at most.
const MOST_LOBES: usize = 4096;

/// The spread of the widest lobes, rad.
const WIDEST: f64 = 1.2;

impl FitParams {
    /// Refuses what no fit can do.
    pub(super) fn check(&self) -> Result<()> {
        if !(1..=MOST_LOBES).contains(&self.lobes) {
            return Err(Self::refuse("lobes", self.lobes, format!("from 1 to {MOST_LOBES}")));
        }
        let [low, high] = self.kernel.bandwidths();
        for (name, value) in [("max_bandwidth", self.max_bandwidth), ("min_bandwidth", self.min_bandwidth)] {
            if let Some(value) = value.filter(|v| !(low..=high).contains(v)) {
                return Err(Self::refuse(name, value, format!("from {low} to {high} ({})", self.kernel_name())));
            }
        }
        if let (Some(least), Some(most)) = (self.min_bandwidth, self.max_bandwidth)
            && least > most
        {
            return Err(Self::refuse("min_bandwidth", least, format!("at most max_bandwidth, {most}")));
        }
        if self.joint && self.solver != Solver::Alternate {
            return Err(Self::refuse("joint", true, "false, except with solver=alternate: the others are joint"));
        }
        Ok(())
    }

    fn kernel_name(&self) -> String {
        prt_transfer::params::Value::show(&self.kernel)
    }

    /// The bandwidths between which lobes move, for a light of so many texels.
    pub(super) fn bandwidths(&self, texels: usize) -> [f64; 2] {
        let edge = (4.0 * std::f64::consts::PI / texels as f64).sqrt();
        let most = self.max_bandwidth.unwrap_or_else(|| self.kernel.bandwidth_of_spread((0.5 * edge).min(WIDEST)));
        let least = self.min_bandwidth.unwrap_or_else(|| self.kernel.bandwidth_of_spread(WIDEST));
        [least.min(most), most]
    }
}
