//! Samples as matrices: the tensor of samples x views x lights.

use super::products;
use ndarray::{Array2, ArrayView2};
use prt_transfer::linalg;
use prt_transfer::samples::square;
use rayon::prelude::*;
use std::borrow::Cow;

/// Samples that a thread projects at a time.
const BLOCK: usize = 64;

/// A tensor, row-major: sample by sample a matrix of views x lights.
pub(crate) struct Slabs<'a> {
    values: Cow<'a, [f32]>,
    pub(crate) count: usize,
    pub(crate) views: usize,
    pub(crate) lights: usize,
}

impl<'a> Slabs<'a> {
    pub(crate) fn lent(values: &'a [f32], [count, views, lights]: [usize; 3]) -> Slabs<'a> {
        Slabs { values: Cow::Borrowed(values), count, views, lights }
    }

    fn owned(values: Vec<f32>, [count, views, lights]: [usize; 3]) -> Slabs<'static> {
        Slabs { values: Cow::Owned(values), count, views, lights }
    }

    fn again(&self) -> Slabs<'_> {
        Slabs::lent(&self.values, [self.count, self.views, self.lights])
    }

    /// Numbers of a sample.
    pub(crate) fn dimension(&self) -> usize {
        self.views * self.lights
    }

    /// A sample, views x lights numbers.
    pub(crate) fn row(&self, sample: usize) -> &[f32] {
        &self.values[sample * self.dimension()..][..self.dimension()]
    }

    fn slab(&self, sample: usize) -> ArrayView2<'_, f32> {
        ArrayView2::from_shape((self.views, self.lights), self.row(sample)).expect("a sample is views x lights")
    }

    /// Mode 3 unfolded: a row of views x lights numbers for each sample.
    pub(crate) fn by_sample(&self) -> ArrayView2<'_, f32> {
        ArrayView2::from_shape((self.count, self.dimension()), &self.values).expect("whole samples")
    }

    /// Mode 2 unfolded: a row of lights for each view of each sample.
    pub(crate) fn by_light(&self) -> ArrayView2<'_, f32> {
        ArrayView2::from_shape((self.count * self.views, self.lights), &self.values).expect("whole samples")
    }

    /// Some of the samples.
    pub(crate) fn gathered(&self, group: &[u32]) -> Slabs<'static> {
        let mut values = Vec::with_capacity(group.len() * self.dimension());
        group.iter().for_each(|&sample| values.extend_from_slice(self.row(sample as usize)));
        Slabs::owned(values, [group.len(), self.views, self.lights])
    }

    /// About so many samples, evenly spread over all; all where there are no more.
    pub(crate) fn some(&self, count: usize) -> Slabs<'_> {
        if self.count <= count {
            return self.again();
        }
        let chosen: Vec<u32> = (0..self.count as u32).step_by(self.count.div_ceil(count)).collect();
        self.gathered(&chosen)
    }

    /// `Σ_x T_x T_xᵀ`, the Gram matrix of mode 1: views x views.
    pub(crate) fn gram_of_views(&self) -> Array2<f64> {
        // Sums of blocks, added in their order.
        let blocks: Vec<Array2<f64>> = (0..self.count.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let mut sum = Array2::zeros((self.views, self.views));
                let mut product = Array2::zeros((self.views, self.views));
                for sample in block * BLOCK..self.count.min((block + 1) * BLOCK) {
                    let slab = self.slab(sample).mapv(f64::from);
                    linalg::times_transposed_f64(slab.view(), slab.view(), product.view_mut());
                    sum += &product;
                }
                sum
            })
            .collect();
        blocks.into_iter().fold(Array2::zeros((self.views, self.views)), |sum, block| sum + block)
    }

    /// Mode-1 product: each sample T_x becomes `basis` (rank x views) · T_x.
    fn with_views(&self, basis: ArrayView2<f32>) -> Slabs<'static> {
        let (rank, lights) = (basis.nrows(), self.lights);
        let mut values = vec![0f32; self.count * rank * lights];
        values.par_chunks_mut((BLOCK * rank * lights).max(1)).enumerate().for_each(|(block, out)| {
            for (i, out) in out.chunks_exact_mut(rank * lights).enumerate() {
                let out = ndarray::ArrayViewMut2::from_shape((rank, lights), out).expect("a sample is rank x lights");
                linalg::times_single(basis, self.slab(block * BLOCK + i), out);
            }
        });
        Slabs::owned(values, [self.count, rank, lights])
    }

    /// As [`Slabs::with_views`]; the same tensor, lent, where the basis has as many rows as there are views: it is the identity then.
    pub(crate) fn in_views(&self, basis: ArrayView2<f32>) -> Slabs<'_> {
        if basis.nrows() == self.views {
            return self.again();
        }
        self.with_views(basis)
    }

    /// Mode-2 product: each sample T_x becomes T_x · `basis`ᵀ, `basis` being rank x lights.
    pub(crate) fn with_lights(&self, basis: ArrayView2<f32>) -> Slabs<'static> {
        let values = products::times_transposed(self.by_light(), basis).into_raw_vec_and_offset().0;
        Slabs::owned(values, [self.count, self.views, basis.nrows()])
    }

    /// Σ T², in double precision: that of each sample.
    pub(crate) fn squares(&self) -> Vec<f64> {
        self.values.par_chunks(self.dimension().max(1)).map(square).collect()
    }
}
