//! Samples that belong to several clusters (Tsai and Shih 2012, K-clustered tensor approximation): each is the sum of what its clusters hold
//! of it.
//!
//! Two steps alternate. Given the bases a sample takes clusters one by one, the one that keeps most of what is left of it, with weights of
//! all of them by least squares after each (orthogonal matching pursuit in blocks); it stays with those it had where they leave less.
//! Given the clusters of the samples each basis is fitted to what the others leave of its members, one after the other. Neither step raises
//! the error.

use super::assign::Stacked;
use super::basis::{Basis, Ranks, fit};
use super::products;
use super::slabs::Slabs;
use ndarray::{Array2, ArrayView1, ArrayViewMut2, Axis, s};
use prt_transfer::Result;
use prt_transfer::linalg::Cholesky;
use prt_transfer::samples::square;
use rayon::prelude::*;

/// Rows of all bases together at most: their inner products are held in memory.
pub(crate) const MOST_ROWS: usize = 1 << 14;
/// Samples whose products with all bases are in memory at once, for each thread.
const BLOCK: usize = 128;
/// What is added to the diagonal of the inner products of bases that overlap, of a diagonal of ones.
const RIDGE: f64 = 1e-7;

/// Samples as sums over clusters.
pub(crate) struct Shared {
    pub(crate) bases: Vec<Basis>,
    /// Clusters of each sample, sample after sample.
    pub(crate) memberships: usize,
    pub(crate) members: Vec<u32>,
    /// For each membership the weights of the cluster.
    pub(crate) weights: Vec<Vec<f32>>,
    /// What is kept of the square of all samples.
    pub(crate) kept: f64,
}

/// A sample's clusters, their weights one after the other, and what they keep of its square.
#[derive(Clone, Debug, Default)]
struct Code {
    members: Vec<u32>,
    weights: Vec<f64>,
    kept: f64,
}

impl Shared {
    /// Each sample in so many of the clusters, of no more than [`MOST_ROWS`] rows.
    pub(crate) fn new(slabs: &Slabs, bases: Vec<Basis>, members: &[u32], memberships: usize) -> Shared {
        let weights = vec![Vec::new(); members.len()];
        let mut shared = Shared { bases, memberships: 1, members: members.to_vec(), weights, kept: 0.0 };
        let memberships = memberships.min(shared.bases.len());
        shared.choose(slabs, memberships);
        shared
    }

    /// Fits every basis in turn, then chooses clusters anew.
    pub(crate) fn sweep(&mut self, slabs: &Slabs, ranks: Ranks) -> Result<()> {
        for cluster in 0..self.bases.len() {
            self.refit(slabs, cluster, ranks)?;
        }
        self.choose(slabs, self.memberships);
        Ok(())
    }

    /// The basis of a cluster from what the others leave of its members, and their weights.
    fn refit(&mut self, slabs: &Slabs, cluster: usize, ranks: Ranks) -> Result<()> {
        let places: Vec<usize> = (0..self.members.len()).filter(|&at| self.members[at] as usize == cluster).collect();
        if places.is_empty() {
            return Ok(());
        }
        let left = self.left_by_others(slabs, &places);
        let members = Slabs::lent(left.as_slice().expect("a fresh array"), [places.len(), slabs.views, slabs.lights]);
        let light = &self.bases[cluster].light;
        let start = (light.nrows() == ranks.light.min(slabs.lights)).then(|| light.view());
        let (basis, _) = fit(&members, start, ranks, 1)?;
        let weights = basis.weights(&members);
        for (&place, row) in places.iter().zip(weights.outer_iter()) {
            self.weights[place] = row.to_vec();
        }
        self.bases[cluster] = basis;
        Ok(())
    }

    /// For some memberships the sample less what its other clusters hold of it.
    fn left_by_others(&self, slabs: &Slabs, places: &[usize]) -> Array2<f32> {
        let mut left = Array2::<f32>::zeros((places.len(), slabs.dimension()));
        let rows = left.axis_iter_mut(Axis(0)).into_par_iter().zip(places);
        rows.for_each(|(mut out, &place)| {
            let sample = place / self.memberships;
            out.assign(&ArrayView1::from(slabs.row(sample)));
            for other in (sample * self.memberships..(sample + 1) * self.memberships).filter(|&other| other != place) {
                let basis = &self.bases[self.members[other] as usize];
                let out = out.as_slice_mut().expect("rows are contiguous");
                subtract(
                    basis,
                    &self.weights[other],
                    ArrayViewMut2::from_shape((slabs.views, slabs.lights), out).expect("a sample"),
                );
            }
        });
        left
    }

    /// Clusters and weights of every sample anew.
    fn choose(&mut self, slabs: &Slabs, memberships: usize) {
        let whole: Vec<Array2<f32>> = self.bases.iter().map(|basis| basis.whole(slabs.views)).collect();
        let stacked = Stacked::of(&whole);
        let inner = products::times_transposed(stacked.rows(), stacked.rows());
        let samples = slabs.by_sample();
        let (before, had) = (&self.members, self.memberships);
        let codes: Vec<Code> = (0..slabs.count.div_ceil(BLOCK))
            .into_par_iter()
            .flat_map_iter(|block| {
                let numbers = block * BLOCK..slabs.count.min((block + 1) * BLOCK);
                let products = products::times_transposed(samples.slice(s![numbers.clone(), ..]), stacked.rows());
                let pursuit = Pursuit { stacked: &stacked, inner: &inner };
                let code = |(row, sample): (ArrayView1<f32>, usize)| {
                    let products = row.to_slice().expect("rows are contiguous");
                    let old = &before[sample * had..(sample + 1) * had];
                    let found = pursuit.found(products, memberships);
                    // Fewer than are asked for are completed, not compared.
                    let stay = if had == memberships { pursuit.solved(products, old) } else { Code::default() };
                    if stay.kept > found.kept { stay } else { found }
                };
                products.outer_iter().zip(numbers).map(code).collect::<Vec<_>>()
            })
            .collect();
        self.kept = codes.iter().map(|code| code.kept).sum();
        self.memberships = memberships;
        self.members = codes.iter().flat_map(|code| code.members.iter().copied()).collect();
        self.weights = codes.into_iter().flat_map(|code| cut(&self.bases, code)).collect();
    }
}

/// The weights of a sample by cluster.
fn cut(bases: &[Basis], code: Code) -> Vec<Vec<f32>> {
    let mut weights = code.weights.iter().map(|w| *w as f32);
    code.members.iter().map(|&k| weights.by_ref().take(bases[k as usize].rank()).collect()).collect()
}

/// `out` (views x lights) -= what weights make of a basis: (Σ_j w_j uf⁻¹(V_j)) U_lightᵀ.
fn subtract(basis: &Basis, weights: &[f32], mut out: ArrayViewMut2<f32>) {
    if basis.rank() == 0 {
        return;
    }
    let (views, light) = (out.nrows(), basis.light.nrows());
    let mut sum = vec![0f32; basis.dual.ncols()];
    for (weight, row) in weights.iter().zip(basis.dual.outer_iter()) {
        sum.iter_mut().zip(row).for_each(|(sum, v)| *sum += weight * v);
    }
    let sum = Array2::from_shape_vec((views, light), sum).expect("views x R_light");
    let mut product = Array2::zeros(out.dim());
    prt_transfer::linalg::times_single(sum.view(), basis.light.view(), product.view_mut());
    out -= &product;
}

/// Clusters of one sample after the other.
struct Pursuit<'a> {
    stacked: &'a Stacked,
    /// Of all rows with each other.
    inner: &'a Array2<f32>,
}

impl Pursuit<'_> {
    /// So many clusters, each the one that keeps most of what those before leave. `products` are those of the sample with all rows.
    fn found(&self, products: &[f32], memberships: usize) -> Code {
        let (mut left, mut code) = (products.to_vec(), Code::default());
        for nth in 0..memberships {
            let keeps = |k: usize| square(&left[self.stacked.range(k)]);
            let open = (0..self.stacked.len()).filter(|k| !code.members.contains(&(*k as u32)));
            let best = open.map(|k| (keeps(k), k)).reduce(|best, next| if next.0 > best.0 { next } else { best });
            let Some((_, best)) = best else { break };
            code.members.push(best as u32);
            code = self.solved(products, &code.members);
            if nth + 1 < memberships {
                left.copy_from_slice(products);
                for (row, weight) in self.rows(&code.members).zip(&code.weights) {
                    let weight = *weight as f32;
                    left.iter_mut().zip(self.inner.row(row)).for_each(|(left, g)| *left -= weight * g);
                }
            }
        }
        code
    }

    fn rows<'b>(&'b self, members: &'b [u32]) -> impl Iterator<Item = usize> + Clone + 'b {
        members.iter().flat_map(|&k| self.stacked.range(k as usize))
    }

    /// The weights in some clusters by least squares.
    fn solved(&self, products: &[f32], members: &[u32]) -> Code {
        let rows: Vec<usize> = self.rows(members).collect();
        let mut weights: Vec<f64> = rows.iter().map(|&row| f64::from(products[row])).collect();
        if members.len() > 1 {
            let gram = Array2::from_shape_fn((rows.len(), rows.len()), |(i, j)| {
                f64::from(self.inner[[rows[i], rows[j]]]) + if i == j { RIDGE } else { 0.0 }
            });
            // Without a factor clusters are alike: the first alone has all of it.
            match Cholesky::factor(gram) {
                Some(factor) => {
                    let column = ArrayViewMut2::from_shape((rows.len(), 1), &mut weights);
                    factor.solve(column.expect("a column"));
                }
                None => weights[self.stacked.range(members[0] as usize).len()..].fill(0.0),
            }
        }
        let inner = |i: usize, j: usize| f64::from(self.inner[[rows[i], rows[j]]]) * weights[i] * weights[j];
        let of_model: f64 = (0..rows.len()).map(|i| (0..rows.len()).map(|j| inner(i, j)).sum::<f64>()).sum();
        let along: f64 = rows.iter().zip(&weights).map(|(&row, w)| f64::from(products[row]) * w).sum();
        // ‖T‖² - ‖T - T̃‖².
        Code { members: members.to_vec(), weights, kept: 2.0 * along - of_model }
    }
}
