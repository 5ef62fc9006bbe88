//! What each component of each cluster would save.

use crate::refit::{centred, mean};
use ndarray::Array2;
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Result, linalg};
use rayon::prelude::*;

/// Squares of the singular values of a cluster's centred members, descending: what each component takes from the error.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    pub(crate) members: usize,
    pub(crate) squares: Vec<f64>,
}

impl Spectrum {
    /// The error that so many components leave.
    pub(crate) fn tail(&self, components: usize) -> f64 {
        self.squares.iter().skip(components).rev().sum()
    }
}

/// The spectrum of every cluster, from the smaller of both Gram matrices.
pub(crate) fn spectra(samples: &Samples, groups: &Groups) -> Result<Vec<Spectrum>> {
    let of = |cluster: usize| {
        let group = groups.of_cluster(cluster);
        let mean: Vec<f32> = mean(samples, group).iter().map(|m| *m as f32).collect();
        let rows = centred(samples, group, &mean).mapv(f64::from);
        let (m, n) = rows.dim();
        let mut gram = Array2::zeros((m.min(n), m.min(n)));
        if n <= m {
            linalg::add_gram(rows.view(), gram.view_mut());
        } else {
            linalg::times_transposed_f64(rows.view(), rows.view(), gram.view_mut());
        }
        // A mean takes one direction of the members.
        let rank = m.saturating_sub(1).min(n);
        let squares = linalg::eigen(gram.view())?.values.into_iter().take(rank).map(|v| v.max(0.0)).collect();
        Ok(Spectrum { members: m, squares })
    };
    (0..groups.len()).into_par_iter().map(of).collect()
}
