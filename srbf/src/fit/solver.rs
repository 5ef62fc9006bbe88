//! The order of a fit: starts, stages, exchanges, the final coefficients.

use super::descent::{self, Free};
use super::exchange::exchange;
use super::greedy::Candidates;
use super::objective::solve;
use super::params::{FitParams, Solver, Starts};
use super::pyramid::Level;
use super::target::Target;
use super::{Fit, Stage, coefficients, coverage, curvature, starts};
use crate::light::ScatteredLight;
use crate::lobe::Lobe;
use ndarray::Array2;
use prt_transfer::random::Random;
use prt_transfer::{Progress, Result};

/// Each greedy stage has so many times the lobes of the one before it.
const GROWTH: f64 = 1.5;

/// The least that a stage adds: the first few lobes, on which the others build, come one by one.
const LEAST: usize = 1;

/// Stages before the last take this share of its steps.
const SHARE: usize = 3;

/// An alternation that gains less than this share of the error ends.
const LEAST_GAIN: f64 = 1e-4;

/// Steps of L-BFGS in one half of an alternation.
const HALF_STEPS: usize = 20;

/// A fit under way.
pub(super) struct Work<'a> {
    pub(super) params: &'a FitParams,
    progress: &'a dyn Progress,
    pub(super) random: Random,
    history: Vec<Stage>,
}

impl<'a> Work<'a> {
    pub(super) fn new(params: &'a FitParams, progress: &'a dyn Progress) -> Work<'a> {
        Work { params, progress, random: Random(params.seed), history: Vec::new() }
    }

    /// Lobes for a light, from none.
    pub(super) fn begin(&mut self, target: &Target) -> Result<Vec<Lobe>> {
        let Work { params: &FitParams { lobes: count, steps, exchanges, .. }, progress, .. } = *self;
        progress.start("fit lobes", (count + exchanges * count.div_ceil(4)) as u64);
        let bandwidths = self.params.bandwidths(target.texels);
        let mut lobes = match self.params.starts {
            Starts::Greedy => self.grow(target, bandwidths)?,
            Starts::Coverage => coverage::lobes(target, self.params.kernel, bandwidths, count),
            Starts::Random => starts::random(self.params.kernel, bandwidths, count, &mut self.random),
        };
        if self.params.starts != Starts::Greedy {
            self.record("start", target, &lobes);
            lobes = self.moved(target, &lobes, bandwidths, steps);
            self.record("grow", target, &lobes);
            progress.advance(count as u64)?;
        }
        self.exchange_all(target, lobes, bandwidths)
    }

    /// Lobes of a coarser light, moved on a finer one.
    pub(super) fn refine(&mut self, target: &Target, lobes: Vec<Lobe>) -> Result<Vec<Lobe>> {
        self.progress.start("refine lobes", 1);
        let bandwidths = self.params.bandwidths(target.texels);
        let lobes = self.moved(target, &lobes, bandwidths, self.params.steps);
        self.record("refine", target, &lobes);
        self.progress.advance(1)?;
        Ok(lobes)
    }

    /// Greedy stages.
    fn grow(&mut self, target: &Target, bandwidths: [f64; 2]) -> Result<Vec<Lobe>> {
        let FitParams { lobes: count, steps, kernel, .. } = *self.params;
        let candidates = Candidates::new(target, kernel, bandwidths);
        let mut lobes: Vec<Lobe> = Vec::new();
        while lobes.len() < count {
            let next = ((lobes.len() as f64 * GROWTH) as usize).max(lobes.len() + LEAST).min(count);
            let more = candidates.best(&solve(target, kernel, &lobes), next - lobes.len());
            if more.is_empty() {
                break;
            }
            self.progress.advance(more.len() as u64)?;
            lobes.extend(more);
            let steps = if lobes.len() == count { steps } else { steps.div_ceil(SHARE) };
            lobes = self.moved(target, &lobes, bandwidths, steps);
            self.record("grow", target, &lobes);
        }
        Ok(lobes)
    }

    fn exchange_all(&mut self, target: &Target, mut lobes: Vec<Lobe>, bandwidths: [f64; 2]) -> Result<Vec<Lobe>> {
        if self.params.exchanges == 0 {
            return Ok(lobes);
        }
        let candidates = Candidates::new(target, self.params.kernel, bandwidths);
        for round in 0..self.params.exchanges {
            lobes = exchange(self, target, &candidates, lobes, bandwidths, round);
            self.record("exchange", target, &lobes);
            self.progress.advance(self.params.lobes.div_ceil(4) as u64)?;
        }
        Ok(lobes)
    }

    /// Lobes after the solver's steps.
    pub(super) fn moved(&self, target: &Target, lobes: &[Lobe], bandwidths: [f64; 2], steps: usize) -> Vec<Lobe> {
        let kernel = self.params.kernel;
        match self.params.solver {
            Solver::GaussNewton => curvature::descend(target, kernel, lobes, bandwidths, steps),
            Solver::Lbfgs => descent::descend(target, kernel, lobes, bandwidths, Free::All, None, steps),
            Solver::Alternate => {
                let lobes = self.alternated(target, lobes, bandwidths, steps);
                if !self.params.joint {
                    return lobes;
                }
                descent::descend(target, kernel, &lobes, bandwidths, Free::All, None, steps)
            }
        }
    }

    /// The paper's steps 1 to 3.
    fn alternated(&self, target: &Target, lobes: &[Lobe], bandwidths: [f64; 2], rounds: usize) -> Vec<Lobe> {
        let kernel = self.params.kernel;
        let mut lobes = lobes.to_vec();
        let mut last = solve(target, kernel, &lobes);
        let mut error = last.error;
        for _ in 0..rounds {
            let coefficients = last.coefficients.clone();
            drop(last);
            let mut next = lobes.clone();
            for free in [Free::Centres, Free::Bandwidths] {
                next = descent::descend(target, kernel, &next, bandwidths, free, Some(&coefficients), HALF_STEPS);
            }
            lobes = next;
            last = solve(target, kernel, &lobes);
            let gain = error - last.error;
            error = last.error;
            if gain < LEAST_GAIN * error {
                break;
            }
        }
        drop(last);
        lobes
    }

    fn record(&mut self, name: &'static str, target: &Target, lobes: &[Lobe]) {
        let relative_squared_error = solve(target, self.params.kernel, lobes).error;
        self.history.push(Stage { name, texels: target.texels, lobes: lobes.len(), relative_squared_error });
    }

    /// The coefficients, and the error with all of every lobe.
    pub(super) fn finish(self, level: &Level, lobes: Vec<Lobe>, channels: usize) -> Result<Fit> {
        let kernel = self.params.kernel;
        let target = Target::new(&level.directions, &level.angles, &level.values, channels)?;
        let energy = level.energy();
        let solution = solve(&target, kernel, &lobes);
        let coefficients = match lobes.len() {
            0 => Array2::zeros((0, channels)),
            _ => coefficients(&solution, energy),
        };
        drop(solution);
        let light = ScatteredLight::new(kernel, lobes, coefficients)?;
        let (relative_squared_error, flux_error) = level.errors(&light, channels);
        Ok(Fit { light, relative_squared_error, flux_error, history: self.history })
    }
}
