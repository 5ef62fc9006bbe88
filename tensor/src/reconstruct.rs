//! Rows out of clusters and their bases.

use crate::encoded::EncodedCta;
use crate::layout::Place;
use ndarray::{Array2, ArrayViewMut2, Axis, concatenate, s};
use prt_transfer::{Shape, linalg};
use std::ops::Range;

/// Rows that meet a light basis one by one.
const FEW: usize = 2;

impl EncodedCta {
    /// Rows from `first` on, one a row of `out`.
    pub(crate) fn reconstruct(&self, first: usize, mut out: ArrayViewMut2<f32>) {
        let (Shape { responses, lights, .. }, memberships) = (self.shape, self.layout.memberships);
        let end = first + out.nrows();
        // Parts of rows by cluster, so that a light basis meets all of them at once.
        let mut parts = Vec::new();
        for sample in first / responses..end.div_ceil(responses) {
            let rows = first.max(sample * responses)..end.min((sample + 1) * responses);
            let mut weight = self.layout.first_weight(sample, &self.ids);
            for nth in 0..memberships {
                let cluster = self.ids.at(sample * memberships + nth) as usize;
                let place = self.layout.place(cluster);
                let of_sample = rows.start - sample * responses..rows.end - sample * responses;
                parts.push((cluster, rows.start - first, self.in_light_basis(place, weight, of_sample)));
                weight += place.sample_rank;
            }
        }
        parts.sort_by_key(|&(cluster, ..)| cluster);
        // In double precision, so that no sum of finite numbers overflows on its way.
        let mut sums = Array2::<f64>::zeros((out.nrows(), lights));
        for alike in parts.chunk_by(|a, b| a.0 == b.0) {
            let factors: Vec<_> = alike.iter().map(|(_, _, factors)| factors.view()).collect();
            let factors = concatenate(Axis(0), &factors).expect("rows of one light basis");
            let product = self.in_lights(self.layout.place(alike[0].0), factors);
            let mut from = 0;
            for (_, to, factors) in alike {
                let mut sums = sums.slice_mut(s![*to..to + factors.nrows(), ..]);
                sums += &product.slice(s![from..from + factors.nrows(), ..]);
                from += factors.nrows();
            }
        }
        let (least, most) = (f64::from(f32::MIN), f64::from(f32::MAX));
        out.zip_mut_with(&sums, |y, sum| *y = sum.clamp(least, most) as f32);
    }

    /// What the `nth` cluster of a sample makes of each of `views` in its light basis, a row each: `Σ_j w_j V_j[v, ·]`. `first` is the weight
    /// that it begins with.
    fn mixed(&self, place: &Place, first: usize, views: Range<usize>) -> Array2<f64> {
        let (mut mixed, mut buffer) = (Array2::zeros((views.len(), place.light_rank)), Vec::new());
        for j in 0..place.sample_rank {
            let row = place.sample + j;
            let weight = f64::from(self.weights.stored(first + j)) * f64::from(self.weights.scale(row));
            let weight = weight * f64::from(self.dual.scale(row));
            let start = place.dual + (j * self.layout.views + views.start) * place.light_rank;
            let values = self.dual.unpack(start..start + mixed.len(), 0, &mut buffer);
            mixed.iter_mut().zip(values).for_each(|(sum, &v)| *sum += weight * f64::from(v));
        }
        mixed
    }

    /// Some rows of a sample in the light basis of its `nth` cluster, a row each: `Σ_v U_view[response, v] Σ_j w_j V_j[v, ·]`.
    fn in_light_basis(&self, place: &Place, first: usize, responses: Range<usize>) -> Array2<f64> {
        let Some(view) = &self.view else { return self.mixed(place, first, responses) };
        let view = view.slice(s![responses, ..]).mapv(f64::from);
        view.dot(&self.mixed(place, first, 0..self.layout.views))
    }

    /// Factors of a cluster's light basis, a row each, become rows of lights.
    fn in_lights(&self, place: &Place, factors: Array2<f64>) -> Array2<f64> {
        let (lights, mut buffer) = (self.shape.lights, Vec::new());
        let mut product = Array2::zeros((factors.nrows(), lights));
        // Few rows are done before a basis in double precision is made.
        let mut basis = Array2::zeros((if factors.nrows() > FEW { place.light_rank } else { 0 }, lights));
        for i in 0..place.light_rank {
            let (row, scale) = (place.light + i, f64::from(self.light.scale(place.light + i)));
            let values = self.light.unpack(row * lights..(row + 1) * lights, 0, &mut buffer);
            if factors.nrows() > FEW {
                basis.row_mut(i).iter_mut().zip(values).for_each(|(to, &v)| *to = scale * f64::from(v));
                continue;
            }
            for (mut out, factors) in product.outer_iter_mut().zip(factors.outer_iter()) {
                let factor = scale * factors[i];
                out.iter_mut().zip(values).for_each(|(sum, &v)| *sum += factor * f64::from(v));
            }
        }
        if factors.nrows() > FEW {
            linalg::times(factors.view(), basis.view(), product.view_mut());
        }
        product
    }
}
