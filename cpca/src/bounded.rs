//! The smallest model whose decoded error keeps a bound.
//!
//! Components are bought where they save most for their bytes until the tails of the spectra keep the bound (error equals the tail
//! energies, paper §4.1). What rounding and narrow numbers add is measured on the stored model, and the tails give way to it.

use crate::codec::Task;
use crate::encoded::EncodedCpca;
use crate::engine::{Bargain, Engine, Plan};
use crate::params::Mode;
use prt_transfer::samples::Samples;
use prt_transfer::{Progress, Result, TransferMatrix};
use rayon::prelude::*;

/// What came of a bound.
pub(crate) enum Bounded {
    Kept(Box<EncodedCpca>),
    /// The least error that could be had.
    Missed(f64),
}

/// Times that the tails give way.
const ATTEMPTS: usize = 8;
/// Sweeps while the number of clusters is looked for.
const TRIAL_SWEEPS: usize = 6;
/// Numbers of clusters are doubled until so many in turn are dearer than the best.
const PATIENCE: usize = 2;
/// Most components for which clusters are refined by approximation error.
const MOST_REFINED: usize = 16;
/// Eigenvalues of larger matrices are not computed while the number of clusters is looked for.
const MOST_EIGENVALUES: usize = 3000;

pub(crate) fn bounded(
    task: &Task,
    matrix: &TransferMatrix,
    samples: &Samples,
    bound: f64,
    progress: &dyn Progress,
) -> Result<Bounded> {
    let engine = Engine::new(samples.lent(), progress)?;
    let total = energy(samples);
    let mut allowed = bound * total;
    let plan = planned(task, &engine, samples, allowed, progress)?;
    progress.start("cluster", plan.steps());
    let mut bargain = engine.search_down_to(&plan, allowed)?;
    let mut least = f64::INFINITY;
    for _ in 0..ATTEMPTS {
        let encoded = task.stored(samples, matrix, &bargain.clustering, progress)?;
        let (error, whole) = task.norm.error_of(&encoded, matrix)?;
        if error <= bound * whole {
            return Ok(Bounded::Kept(Box::new(encoded)));
        }
        least = least.min(error / whole);
        // In the samples' scale: what is there beside the tails, and a little more.
        let besides = (error / whole * total - bargain.left).max(0.0);
        let give = 1.1 * besides.max(1e-6 * allowed);
        if allowed == 0.0 {
            break;
        }
        allowed = (bound * total - give).min(allowed - give * 0.1).max(0.0);
        bargain = engine.bargain(bargain.clustering.groups, &plan, allowed)?;
    }
    Ok(Bounded::Missed(least))
}

/// The plan with a number of clusters, and of components to refine them by.
fn planned(task: &Task, engine: &Engine, samples: &Samples, allowed: f64, progress: &dyn Progress) -> Result<Plan> {
    let trial = |clusters: usize| -> Result<Bargain> {
        let plan = Plan { clusters, mode: Mode::Static, sweeps: TRIAL_SWEEPS.min(task.plan.sweeps), ..task.plan };
        engine.search_down_to(&plan, allowed)
    };
    let best = match task.clusters {
        Some(clusters) if task.plan.mode == Mode::Static => return Ok(Plan { clusters, ..task.plan }),
        Some(clusters) => trial(clusters)?,
        None => {
            let mut numbers =
                (0..=16).map(|power| 1usize << power).take_while(|k| *k == 1 || *k <= samples.count() / 2);
            progress.start("number of clusters", 17);
            let (mut best, mut dearer) = (None::<Bargain>, 0);
            while let Some(clusters) = numbers.next().filter(|_| dearer < PATIENCE) {
                progress.advance(1)?;
                if (samples.count() / clusters).min(samples.dimension()) > MOST_EIGENVALUES {
                    continue;
                }
                let found = trial(clusters)?;
                if best.as_ref().is_none_or(|best| found.bytes < best.bytes) {
                    (best, dearer) = (Some(found), 0);
                } else {
                    dearer += 1;
                }
            }
            best.map_or_else(|| trial(samples.count().max(1)), Ok)?
        }
    };
    let components = best.weights.div_ceil(samples.count().max(1)).clamp(1, MOST_REFINED);
    Ok(Plan { clusters: best.clustering.groups.len(), components, ..task.plan })
}

/// Of all samples.
fn energy(samples: &Samples) -> f64 {
    let sums: Vec<f64> = samples.values().par_chunks(1 << 16).map(prt_transfer::samples::square).collect();
    sums.iter().sum()
}
