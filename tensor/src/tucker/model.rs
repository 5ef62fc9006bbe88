//! Core and factors in the making.

use super::leading::{self, Want};
use super::unfold::{self, Unfolding};
use ndarray::{Array2, ArrayD, ArrayViewD, Axis};
use prt_transfer::Result;

/// Slices of up to so many times the least energy are dropped with it.
const ALIKE: f64 = 1.5;

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
    /// those of a HOSVD (De Lathauwer et al. 2000a, Theorem 2): by the sequential HOSVD of the core itself, which loses `zero` at
    /// most. Of each column the element of largest magnitude is positive.
    pub(super) fn turn(&mut self, zero: f64) -> Result<()> {
        let want = Want { rank: usize::MAX, tail: zero / self.factors.len() as f64 };
        for mode in 0..self.factors.len() {
            let view = self.core.view();
            let mut w = leading::direct(&Unfolding::new(&view, mode), want)?.vectors;
            let mut factor = unfold::times(self.factors[mode].view(), w.view());
            fix_signs(&mut factor, &mut w);
            self.core = unfold::product(self.core.view(), mode, w.view());
            self.factors[mode] = factor;
        }
        Ok(())
    }

    /// Leaves out slices of the core whose energy fits into `allowance`, those first that save most numbers for their energy, until
    /// none fits. True where there was one.
    pub(super) fn drop_slices(&mut self, mut allowance: f64) -> bool {
        let mut dropped = false;
        while let Some((mode, mut energies)) = self.cheapest(allowance) {
            energies.sort_by(|a, b| a.1.total_cmp(&b.1));
            // Slices of one mode add up. All are dropped that cost about as little: a pass for each would take long.
            let (most, last) = (ALIKE * energies[0].1, energies.len() - 1);
            let mut fits = |(_, energy): &(usize, f64)| {
                let fits = *energy <= allowance.min(most);
                allowance -= if fits { *energy } else { 0.0 };
                fits
            };
            let beyond = energies[..last].iter().take_while(|slice| fits(slice)).count();
            let mut keep: Vec<usize> = energies[beyond..].iter().map(|slice| slice.0).collect();
            keep.sort_unstable();
            self.core = self.core.select(Axis(mode), &keep).as_standard_layout().into_owned();
            self.factors[mode] = unfold::standard(self.factors[mode].select(Axis(1), &keep).view());
            dropped = true;
        }
        dropped
    }

    /// The mode whose slice of least energy saves most for it, and the energies of its slices; of slices that fit.
    fn cheapest(&self, allowance: f64) -> Option<(usize, Vec<(usize, f64)>)> {
        let (mut best, mut most) = (None, 0.0);
        for (mode, factor) in self.factors.iter().enumerate() {
            let (size, rank) = factor.dim();
            let energy = |slice: ArrayViewD<f64>| slice.iter().map(|g| g * g).sum::<f64>();
            let energies: Vec<_> = self.core.axis_iter(Axis(mode)).map(energy).enumerate().collect();
            let least = energies.iter().fold(f64::INFINITY, |least, slice| least.min(slice.1));
            let gain = (size + self.core.len() / rank) as f64 / least.max(f64::MIN_POSITIVE);
            if rank > 1 && least <= allowance && gain > most {
                (best, most) = (Some((mode, energies)), gain);
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
