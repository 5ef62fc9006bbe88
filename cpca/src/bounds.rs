//! Lower bounds of the distances of samples to all subspaces, from their heads.
//!
//! For a subspace with mean μ and orthonormal components V, r = x - μ splits into a head r_h and a tail of length ρ between
//! |t_x - t_μ| and t_x + t_μ, and `|Vᵀ r| ≤ |V_hᵀ r_h| + ν ρ` with ν = |V_t|. Therefore
//! `e² = |r|² - |Vᵀ r|² ≥ |r_h|² + ρ² - (a + ν ρ)²`, a = |V_hᵀ r_h|, of which the least over the interval of ρ is taken.

use crate::head::{Head, Seen, square};
use crate::subspaces::Subspaces;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use prt_transfer::Result;
use prt_transfer::linalg;
use rayon::prelude::*;

/// All subspaces of one sweep, seen from a head, in the layout of one product: for each number j of components, the clusters
/// that have so many. Clusters are in the order of their number of components, the most first, so that those are a prefix.
pub(crate) struct Bounds {
    /// Position to cluster.
    order: Vec<u32>,
    /// Means, then first components, second ...: rows of the head's size.
    rows: Array2<f32>,
    /// Where the rows of each level start.
    levels: Vec<usize>,
    /// μ_h · v_h for the rows of levels from 1 on, where they stand in `rows`.
    shifts: Vec<f32>,
    /// By position: |μ_h|², t_μ, ν, 1 / (1 - ν²).
    squares: Vec<f32>,
    tails: Vec<f32>,
    leaks: Vec<f32>,
    steeps: Vec<f32>,
}

/// Where a thread keeps its intermediate results.
#[derive(Default)]
pub(crate) struct Workspace {
    points: Vec<f32>,
    products: Vec<f32>,
    parts: Vec<f32>,
}

/// ν² is at most this, so that 1 - ν² can be divided by.
const MOST_LEAK: f64 = 1.0 - 1e-6;

impl Bounds {
    /// Of some clusters, by their numbers.
    pub(crate) fn new(head: &Head, subspaces: &Subspaces, clusters: &[u32]) -> Result<Bounds> {
        let (k, n, h) = (clusters.len(), subspaces.dimension().max(1), head.size());
        let mut order = clusters.to_vec();
        order.sort_by_key(|&c| std::cmp::Reverse(subspaces.components(c as usize)));
        let seen: Vec<(Seen, Vec<Seen>, f64)> = order
            .par_iter()
            .map(|&cluster| {
                let subspace = subspaces.of(cluster as usize);
                let vectors: Vec<Seen> = subspace.components.chunks(n).map(|v| head.direction(v)).collect();
                let leak = leak(&vectors)?;
                Ok((head.point(&subspace.mean), vectors, leak))
            })
            .collect::<Result<_>>()?;
        let mut levels = vec![0, k];
        let mut rows: Vec<f32> = seen.iter().flat_map(|(mean, ..)| &mean.coordinates).copied().collect();
        let mut shifts = vec![0f32; k];
        let most = order.first().map_or(0, |&c| subspaces.components(c as usize));
        for level in 0..most {
            for (mean, vectors, _) in seen.iter().take_while(|(_, vectors, _)| vectors.len() > level) {
                let vector = &vectors[level].coordinates;
                rows.extend(vector);
                shifts
                    .push(mean.coordinates.iter().zip(vector).map(|(m, v)| f64::from(*m) * f64::from(*v)).sum::<f64>()
                        as f32);
            }
            levels.push(shifts.len());
        }
        let rows = Array2::from_shape_vec((shifts.len(), h), rows).expect("a row for each shift");
        Ok(Bounds {
            order,
            rows,
            levels,
            shifts,
            squares: seen.iter().map(|(mean, ..)| square(&mean.coordinates) as f32).collect(),
            tails: seen.iter().map(|(mean, ..)| mean.tail as f32).collect(),
            leaks: seen.iter().map(|(.., leak)| leak.sqrt() as f32).collect(),
            steeps: seen.iter().map(|(.., leak)| (1.0 / (1.0 - leak)) as f32).collect(),
        })
    }

    /// The cluster at a position of the bounds.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// How much a bound may be above what it bounds, as a part of |x_h|² + t_x² + |μ_h|² + t_μ²: rounding of h products and of the tails.
    fn slack(&self) -> f32 {
        let strand = (self.rows.ncols() / 4 + 16) as f32 * f32::EPSILON;
        2.0 * strand * (1.0 + (self.levels.len() as f32 - 1.0).sqrt())
    }

    /// Squared distances of the samples to all subspaces from below: samples x positions.
    pub(crate) fn of(&self, head: &Head, samples: &[u32], work: &mut Workspace, out: &mut Vec<f32>) {
        let (count, k, width) = (samples.len(), self.order.len(), self.rows.nrows());
        work.products.resize(count * width, 0.0);
        work.parts.resize(k, 0.0);
        out.resize(count * k, 0.0);
        work.points.clear();
        samples.iter().for_each(|&s| work.points.extend_from_slice(head.coordinates(s as usize)));
        let points = ArrayView2::from_shape((count, head.size()), &work.points).expect("rows of the head");
        let products =
            ArrayViewMut2::from_shape((count, width), &mut work.products[..count * width]).expect("as resized");
        linalg::times_transposed(points, self.rows.view(), products);
        let slack = self.slack();
        pulp::Arch::new().dispatch(|| {
            let rows = work.products.chunks_exact(width).zip(out.chunks_exact_mut(k));
            for (&sample, (products, out)) in samples.iter().zip(rows) {
                let sample = sample as usize;
                self.explained(products, &mut work.parts);
                self.bound(head.square(sample), head.tail(sample), products, &work.parts, slack, out);
            }
        });
    }

    /// a² by position.
    #[inline(always)]
    fn explained(&self, products: &[f32], parts: &mut [f32]) {
        parts.fill(0.0);
        for level in self.levels.windows(2).skip(1) {
            let range = level[0]..level[1];
            let terms = products[range.clone()].iter().zip(&self.shifts[range]);
            for (part, (product, shift)) in parts.iter_mut().zip(terms) {
                let a = product - shift;
                *part += a * a;
            }
        }
    }

    #[inline(always)]
    fn bound(&self, square: f32, tail: f32, products: &[f32], parts: &[f32], slack: f32, out: &mut [f32]) {
        let k = out.len();
        let (squares, tails) = (&self.squares[..k], &self.tails[..k]);
        let (leaks, steeps, products, parts) = (&self.leaks[..k], &self.steeps[..k], &products[..k], &parts[..k]);
        let own = square + tail * tail;
        for i in 0..k {
            let head = square - 2.0 * products[i] + squares[i];
            let a = parts[i].sqrt();
            let (least, most) = ((tail - tails[i]).abs(), tail + tails[i]);
            let rest = (leaks[i] * a * steeps[i]).max(least).min(most);
            let along = a + leaks[i] * rest;
            let margin = slack * (own + squares[i] + tails[i] * tails[i]);
            out[i] = head + rest * rest - along * along - margin;
        }
    }
}

/// ν² of components with these heads: 1 less the least eigenvalue of V_hᵀ V_h.
fn leak(vectors: &[Seen]) -> Result<f64> {
    if vectors.iter().all(|v| v.tail == 0.0) {
        return Ok(0.0);
    }
    let q = vectors.len();
    let dot =
        |a: &Seen, b: &Seen| a.coordinates.iter().zip(&b.coordinates).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
    let gram = Array2::from_shape_fn((q, q), |(i, j)| dot(&vectors[i], &vectors[j]));
    let least = linalg::eigen(gram.view())?.values[q - 1];
    Ok((1.0 - least + 1e-6).clamp(0.0, MOST_LEAK))
}
