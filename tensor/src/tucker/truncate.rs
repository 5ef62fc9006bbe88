//! HOSVD and its sequential and randomised forms.

use super::leading::{self, Leading, Want};
use super::model::Model;
use super::params::{Algorithm, Ranks, TuckerParams};
use super::unfold::{self, Element, Unfolding};
use ndarray::{Array2, ArrayD, ArrayViewD, Axis};
use prt_transfer::{Progress, Result};

/// An array, and what may be lost of it.
pub(super) struct Task<'a> {
    /// T, in C order.
    pub(super) tensor: ArrayViewD<'a, f32>,
    /// ‖T‖².
    pub(super) energy: f64,
    /// Of ‖T‖², what may be left out; of ranks that are given what counts as zero.
    pub(super) allowance: f64,
    pub(super) params: &'a TuckerParams,
    pub(super) progress: &'a dyn Progress,
}

/// A model, and whether all iterations converged.
pub(super) type Found = (Model, bool);

impl Task<'_> {
    /// What is wanted of a mode, that may lose so much.
    fn want(&self, mode: usize, tail: f64) -> Want {
        match &self.params.ranks {
            Ranks::Given(ranks) => Want { rank: ranks[mode].min(self.tensor.len_of(Axis(mode))), tail },
            Ranks::MaxError(_) => Want { rank: usize::MAX, tail },
        }
    }

    /// U_n are the leading vectors of each mode of T, and G = T ×_1 U_1ᵀ … ×_N U_Nᵀ. The squared error is at most the sum of the modes'
    /// tails.
    pub(super) fn hosvd(&self) -> Result<Found> {
        let share = self.allowance / self.tensor.ndim() as f64;
        let (mut factors, mut converged) = (Vec::new(), true);
        for mode in 0..self.tensor.ndim() {
            let x = Unfolding::new(&self.tensor, mode);
            let leading = leading::leading(&x, self.want(mode, share), self.params, mode, self.progress)?;
            factors.push(leading.vectors);
            converged &= leading.converged;
            self.progress.advance(1)?;
        }
        Ok((Model { core: unfold::project(self.tensor.view(), &factors, None), factors }, converged))
    }

    /// U_n are the leading vectors of a mode of what the modes before it left, T ×_1 U_1ᵀ … ×_(n-1) U_(n-1)ᵀ. Squared errors of modes
    /// add up, so that each may lose its share of what is left of the allowance.
    pub(super) fn sequential(&self, order: &[usize]) -> Result<Found> {
        let mut factors = vec![Array2::zeros((0, 0)); order.len()];
        let (mut left, mut rest, mut converged) = (self.energy, None::<ArrayD<f64>>, true);
        for (done, &mode) in order.iter().enumerate() {
            let lost = self.energy - left;
            let want = self.want(mode, (self.allowance - lost).max(0.0) / (order.len() - done) as f64);
            let (leading, next) = match &rest {
                None => self.step(self.tensor.view(), mode, want)?,
                Some(rest) => self.step(rest.view(), mode, want)?,
            };
            left = unfold::energy(&next.view());
            rest = Some(next);
            converged &= leading.converged;
            factors[mode] = leading.vectors;
            self.progress.advance(1)?;
        }
        Ok((Model { core: rest.expect("an array has a mode"), factors }, converged))
    }

    /// The factor of a mode, and the array in it.
    fn step<T: Element>(&self, tensor: ArrayViewD<T>, mode: usize, want: Want) -> Result<(Leading, ArrayD<f64>)> {
        if self.params.algorithm == Algorithm::Randomised
            && let Some(step) = self.sketched(tensor.view(), mode, want)?
        {
            return Ok(step);
        }
        let leading = leading::leading(&Unfolding::new(&tensor, mode), want, self.params, mode, self.progress)?;
        let next = unfold::product(tensor, mode, leading.vectors.view());
        Ok((leading, next))
    }

    /// B = Qᵀ X, and U = Q W where W are the leading left singular vectors of B (Halko, Martinsson and Tropp 2011, Algorithm 5.1).
    fn sketched<T: Element>(
        &self,
        tensor: ArrayViewD<T>,
        mode: usize,
        want: Want,
    ) -> Result<Option<(Leading, ArrayD<f64>)>> {
        let x = Unfolding::new(&tensor, mode);
        let energy = x.energy();
        for q in leading::range(&x, want, self.params, mode) {
            let b = unfold::product(tensor.view(), mode, q.view());
            let view = b.view();
            let b = Unfolding::new(&view, mode);
            let missing = (energy - b.energy()).max(0.0);
            if want.is_open() && missing > want.tail {
                continue;
            }
            let w = leading::direct(&b, Want { tail: (want.tail - missing).max(0.0), ..want })?.vectors;
            let vectors = unfold::times(q.view(), w.view());
            let next = unfold::product(view, mode, w.view());
            return Ok(Some((Leading { vectors, converged: true }, next)));
        }
        Ok(None)
    }
}
