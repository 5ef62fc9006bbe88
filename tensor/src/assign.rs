//! Which cluster keeps most of a sample.

use crate::products;
use crate::slabs::{Slabs, square};
use ndarray::{Array2, Axis, concatenate, s};
use rayon::prelude::*;

/// Samples whose products with all clusters are in memory at once, for each thread.
const BLOCK: usize = 128;

/// The cluster of each sample, and what it keeps of the sample's square.
#[derive(Clone, Debug)]
pub(crate) struct Assignment {
    pub(crate) members: Vec<u32>,
    pub(crate) kept: Vec<f64>,
}

/// Orthonormal rows of every cluster, one cluster below the other.
pub(crate) struct Stacked {
    rows: Array2<f32>,
    /// Where a cluster's rows begin, and behind the last.
    starts: Vec<usize>,
}

impl Stacked {
    /// Each of `clusters` is rank x dimension.
    pub(crate) fn of(clusters: &[Array2<f32>]) -> Stacked {
        let views: Vec<_> = clusters.iter().map(|rows| rows.view()).collect();
        let mut starts = vec![0];
        for cluster in clusters {
            starts.push(starts[starts.len() - 1] + cluster.nrows());
        }
        Stacked { rows: concatenate(Axis(0), &views).expect("rows of one dimension"), starts }
    }

    /// The rows of a cluster.
    pub(crate) fn range(&self, cluster: usize) -> std::ops::Range<usize> {
        self.starts[cluster]..self.starts[cluster + 1]
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The squares that clusters keep of a sample whose products with all rows these are (Eq. 17).
    fn kept<'a>(&'a self, products: &'a [f32]) -> impl Iterator<Item = f64> + 'a {
        (0..self.len()).map(|cluster| square(&products[self.range(cluster)]))
    }
}

/// Every sample with the cluster that keeps most of it: ‖T - T̃‖² is what is left, since a cluster's rows are orthonormal.
pub(crate) fn assign(slabs: &Slabs, clusters: &Stacked) -> Assignment {
    let samples = slabs.by_sample();
    let blocks: Vec<Vec<(u32, f64)>> = (0..slabs.count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let numbers = block * BLOCK..slabs.count.min((block + 1) * BLOCK);
            let products = products::times_transposed(samples.slice(s![numbers, ..]), clusters.rows.view());
            let rows = products.outer_iter();
            rows.map(|row| {
                let all = clusters.kept(row.to_slice().expect("rows are contiguous"));
                all.enumerate().fold((0, -1.0), |best, (k, kept)| if kept > best.1 { (k as u32, kept) } else { best })
            })
            .collect()
        })
        .collect();
    let (members, kept) = blocks.into_iter().flatten().unzip();
    Assignment { members, kept }
}
