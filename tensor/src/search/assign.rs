//! Which cluster keeps most of a sample.

use super::products;
use super::slabs::Slabs;
use ndarray::{Array2, ArrayView2, Axis, concatenate, s};
use prt_transfer::groups::Groups;
use prt_transfer::samples::square;
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

    /// Of all clusters.
    pub(crate) fn rows(&self) -> ArrayView2<'_, f32> {
        self.rows.view()
    }

    /// The rows of a cluster.
    pub(crate) fn range(&self, cluster: usize) -> std::ops::Range<usize> {
        self.starts[cluster]..self.starts[cluster + 1]
    }

    /// How many clusters.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The squares that clusters keep of a sample whose products with all rows these are (Eq. 17).
    fn kept<'a>(&'a self, products: &'a [f32]) -> impl Iterator<Item = f64> + 'a {
        (0..self.len()).map(|cluster| square(&products[self.range(cluster)]))
    }
}

/// Clusters that a sample may move to before all are tried again.
const CANDIDATES: usize = 8;
/// Samples that are brought together for a product with one cluster.
const GATHERED: usize = 64;

/// For each sample the clusters that kept most of it when all were tried, one after the other.
pub(crate) struct Candidates {
    each: usize,
    clusters: Vec<u32>,
}

impl Candidates {
    /// Whether the candidates are all clusters there are.
    pub(crate) fn are_all(&self, clusters: usize) -> bool {
        self.each == clusters
    }

    /// As [`assign`] among the candidates.
    pub(crate) fn assign(&self, slabs: &Slabs, clusters: &Stacked) -> Assignment {
        let groups = Groups::of(&self.clusters, clusters.len());
        let kept: Vec<Vec<f64>> = (0..clusters.len())
            .into_par_iter()
            .map(|cluster| {
                let rows = clusters.rows.slice(s![clusters.range(cluster), ..]);
                let blocks = groups.of_cluster(cluster).chunks(GATHERED);
                blocks.flat_map(|places| self.kept(slabs, places, rows)).collect()
            })
            .collect();
        let mut all = vec![0f64; self.clusters.len()];
        for (cluster, kept) in kept.into_iter().enumerate() {
            groups.of_cluster(cluster).iter().zip(kept).for_each(|(&place, kept)| all[place as usize] = kept);
        }
        let best = |(own, kept): (&[u32], &[f64])| {
            let pairs = own.iter().zip(kept);
            pairs.fold(
                (0, -1.0),
                |best, (&k, &kept)| if kept > best.1 || kept == best.1 && k < best.0 { (k, kept) } else { best },
            )
        };
        let (members, kept) = self.clusters.chunks(self.each).zip(all.chunks(self.each)).map(best).unzip();
        Assignment { members, kept }
    }

    /// What a cluster keeps of the samples at some places of the list.
    fn kept(&self, slabs: &Slabs, places: &[u32], rows: ArrayView2<f32>) -> Vec<f64> {
        let samples: Vec<u32> = places.iter().map(|place| place / self.each as u32).collect();
        let products = products::times_transposed(slabs.gathered(&samples).by_sample(), rows);
        products.outer_iter().map(|row| square(row.to_slice().expect("rows are contiguous"))).collect()
    }
}

/// Every sample with the cluster that keeps most of it: ‖T - T̃‖² is what is left, since a cluster's rows are orthonormal.
pub(crate) fn assign(slabs: &Slabs, clusters: &Stacked) -> (Assignment, Candidates) {
    let each = CANDIDATES.min(clusters.len());
    let samples = slabs.by_sample();
    let blocks: Vec<(Vec<f64>, Vec<u32>)> = (0..slabs.count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let numbers = block * BLOCK..slabs.count.min((block + 1) * BLOCK);
            let products = products::times_transposed(samples.slice(s![numbers, ..]), clusters.rows.view());
            let (mut kept, mut candidates) = (Vec::new(), Vec::new());
            for row in products.outer_iter() {
                let row = row.to_slice().expect("rows are contiguous");
                let mut all: Vec<(f64, u32)> = clusters.kept(row).zip(0..).collect();
                let descending = |a: &(f64, u32), b: &(f64, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
                if each < all.len() {
                    all.select_nth_unstable_by(each - 1, descending);
                    all.truncate(each);
                }
                all.sort_unstable_by(descending);
                kept.push(all[0].0);
                candidates.extend(all.iter().map(|(_, cluster)| *cluster));
            }
            (kept, candidates)
        })
        .collect();
    let (kept, candidates): (Vec<_>, Vec<_>) = blocks.into_iter().unzip();
    let candidates = Candidates { each, clusters: candidates.concat() };
    let members = candidates.clusters.iter().step_by(each).copied().collect();
    (Assignment { members, kept: kept.concat() }, candidates)
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::random::Random;

    #[test]
    fn the_best_cluster_is_that_of_the_least_error_and_among_its_candidates() {
        let mut random = Random(4);
        let values: Vec<f32> = (0..300 * 12).map(|_| random.normal() as f32).collect();
        let slabs = Slabs::lent(&values, [300, 3, 4]);
        // Orthonormal rows of 0 to 4 dimensions.
        let clusters: Vec<Array2<f32>> = (0..20)
            .map(|k| {
                let rows = Array2::from_shape_simple_fn((30, 12), || random.normal() as f32);
                products::leading(rows.view(), k % 5).unwrap().single()
            })
            .collect();
        let stacked = Stacked::of(&clusters);
        let (all, candidates) = assign(&slabs, &stacked);
        for sample in 0..300 {
            let row = ndarray::ArrayView1::from(slabs.row(sample));
            let left = |rows: &Array2<f32>| {
                let outside = &row - &rows.t().dot(&rows.dot(&row));
                square(outside.as_slice().expect("a fresh array"))
            };
            let errors: Vec<f64> = clusters.iter().map(left).collect();
            let best = errors[all.members[sample] as usize];
            assert!(errors.iter().all(|e| best <= e + 1e-4), "sample {sample}");
            assert!((square(slabs.row(sample)) - all.kept[sample] - best).abs() < 1e-4);
        }
        assert!(!candidates.are_all(20));
        let again = candidates.assign(&slabs, &stacked);
        assert_eq!(again.members, all.members);
        assert!(again.kept.iter().zip(&all.kept).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}
