//! Core and factors in the making.

use super::leading::{self, Want};
use super::unfold::{self, Unfolding};
use ndarray::{Array2, ArrayD, Axis};
use prt_transfer::Result;

/// T ≈ G ×_1 U_1 … ×_N U_N.
#[derive(Clone, Debug)]
pub(super) struct Model {
    /// G, R_1 x … x R_N.
    pub(super) core: ArrayD<f64>,
    /// U_n, I_n x R_n.
    pub(super) factors: Vec<Array2<f64>>,
}

impl Model {
    /// Nothing: ranks of 0.
    pub(super) fn empty(shape: &[usize]) -> Model {
        let factors = shape.iter().map(|&size| Array2::zeros((size, 0))).collect();
        Model { core: ArrayD::zeros(vec![0; shape.len()]), factors }
    }

    /// ‖G‖², which is ‖T̃‖².
    pub(super) fn energy(&self) -> f64 {
        unfold::energy(&self.core.view())
    }

    /// Turns factors inside of their spans so that the slices of the core in each mode are orthogonal and descend in norm, as
    /// those of a HOSVD (De Lathauwer et al. 2000a, Theorem 2): by the sequential HOSVD of the core itself. All modes together
    /// lose `allowance` at most; where that is more than rounding, slices are orthogonal in the last mode only. Of each column the
    /// element of largest magnitude is positive.
    pub(super) fn turn(&mut self, allowance: f64) -> Result<()> {
        let (modes, start) = (self.factors.len(), self.energy());
        for mode in 0..modes {
            let left = (allowance - (start - self.energy())).max(0.0);
            let want = Want { rank: usize::MAX, tail: left / (modes - mode) as f64 };
            let view = self.core.view();
            let mut w = leading::direct(&Unfolding::new(&view, mode), want)?.vectors;
            let mut factor = unfold::times(self.factors[mode].view(), w.view());
            fix_signs(&mut factor, &mut w);
            self.core = unfold::product(self.core.view(), mode, w.view());
            self.factors[mode] = factor;
        }
        Ok(())
    }

    /// Leaves out slices of the core whose energy is below what is left of `allowance`, first the one that saves most numbers for
    /// its energy. True where there was one.
    pub(super) fn drop_slices(&mut self, mut allowance: f64) -> bool {
        let mut dropped = false;
        while let Some((mode, slice, energy)) = self.cheapest(allowance) {
            let keep: Vec<usize> = (0..self.core.shape()[mode]).filter(|i| *i != slice).collect();
            self.core = self.core.select(Axis(mode), &keep).as_standard_layout().into_owned();
            self.factors[mode] = unfold::standard(self.factors[mode].select(Axis(1), &keep).view());
            allowance -= energy;
            dropped = true;
        }
        dropped
    }

    /// Mode, slice and energy.
    fn cheapest(&self, allowance: f64) -> Option<(usize, usize, f64)> {
        let mut best = None;
        let mut most = 0.0;
        for (mode, factor) in self.factors.iter().enumerate() {
            let (size, rank) = factor.dim();
            let saved = (size + self.core.len() / rank) as f64;
            let energies = self.core.axis_iter(Axis(mode)).map(|slice| slice.iter().map(|g| g * g).sum::<f64>());
            let Some((slice, energy)) = energies.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
            let gain = saved / energy.max(f64::MIN_POSITIVE);
            if rank > 1 && energy <= allowance && gain > most {
                (best, most) = (Some((mode, slice, energy)), gain);
            }
        }
        best
    }

    /// G ×_1 U_1 … ×_N U_N.
    pub(super) fn reconstruct(&self) -> ArrayD<f64> {
        let transposed: Vec<Array2<f64>> = self.factors.iter().map(|u| unfold::standard(u.t())).collect();
        if self.core.is_empty() {
            return ArrayD::zeros(self.factors.iter().map(|u| u.nrows()).collect::<Vec<_>>());
        }
        unfold::project(self.core.view(), &transposed, None)
    }
}

fn fix_signs(factor: &mut Array2<f64>, w: &mut Array2<f64>) {
    for (mut column, mut turned) in factor.columns_mut().into_iter().zip(w.columns_mut()) {
        let largest = column.iter().fold(0f64, |largest, v| if v.abs() > largest.abs() { *v } else { largest });
        if largest < 0.0 {
            column.mapv_inplace(|v| -v);
            turned.mapv_inplace(|v| -v);
        }
    }
}
