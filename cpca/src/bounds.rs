//! Lower bounds of the distances of samples to all subspaces, from their heads.
//!
//! For a subspace with mean μ and orthonormal components V, r = x - μ splits into a head r_h and a tail of length ρ between
//! |t_x - t_μ| and t_x + t_μ, and `|Vᵀ r| ≤ |V_hᵀ r_h| + ν ρ` with ν = |V_t|. Therefore
//! `e² = |r|² - |Vᵀ r|² ≥ |r_h|² + ρ² - (a + ν ρ)²`, a = |V_hᵀ r_h|, of which the least over the interval of ρ is taken.

use crate::head::{Head, Seen};
use crate::subspaces::Subspaces;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use prt_transfer::Result;
use prt_transfer::linalg;
use prt_transfer::samples::square;
use pulp::{Simd, WithSimd};
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
    /// Slack of |μ_h|² + t_μ².
    margins: Vec<f32>,
    /// Whether anything lies outside the head.
    tailed: bool,
    /// By cluster: whether it is among these.
    present: Vec<bool>,
}

/// Where a thread keeps its intermediate results.
#[derive(Default)]
pub(crate) struct Workspace {
    points: Vec<f32>,
    products: Vec<f32>,
    parts: Vec<f32>,
    row: Vec<f32>,
}

/// ν² is at most this, so that 1 - ν² can be divided by.
const MOST_LEAK: f64 = 1.0 - 1e-6;

impl Bounds {
    /// Of some clusters, by their numbers.
    pub(crate) fn new(head: &Head, subspaces: &Subspaces, clusters: &[u32]) -> Result<Bounds> {
        let (k, h) = (clusters.len(), head.size());
        let mut order = clusters.to_vec();
        order.sort_by_key(|&c| std::cmp::Reverse(subspaces.components(c as usize)));
        let seen: Vec<(Seen, Vec<Seen>, f64)> = order
            .par_iter()
            .map(|&cluster| {
                let subspace = subspaces.of(cluster as usize);
                let mut vectors = head.see(&subspace.mean, &subspace.components);
                let mean = vectors.remove(0);
                let leak = leak(&vectors)?;
                Ok((mean, vectors, leak))
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
        let mut bounds = Bounds {
            order,
            rows,
            levels,
            shifts,
            squares: seen.iter().map(|(mean, ..)| square(&mean.coordinates) as f32).collect(),
            tails: seen.iter().map(|(mean, ..)| mean.tail as f32).collect(),
            leaks: seen.iter().map(|(.., leak)| leak.sqrt() as f32).collect(),
            steeps: seen.iter().map(|(.., leak)| (1.0 / (1.0 - leak)) as f32).collect(),
            margins: Vec::new(),
            tailed: !head.is_whole(),
            present: vec![false; subspaces.len()],
        };
        clusters.iter().for_each(|&cluster| bounds.present[cluster as usize] = true);
        let norms = bounds.squares.iter().zip(&bounds.tails);
        bounds.margins = norms.map(|(square, tail)| bounds.slack() * (square + tail * tail)).collect();
        Ok(bounds)
    }

    /// How much a bound may be above what it bounds, as a part of |x_h|² + t_x² + |μ_h|² + t_μ²: rounding of h products and of the tails.
    fn slack(&self) -> f32 {
        let strand = (self.rows.ncols() / 4 + 16) as f32 * f32::EPSILON;
        2.0 * strand * (1.0 + (self.levels.len() as f32 - 1.0).sqrt())
    }

    /// Subspaces other than its own that may lie no farther from each sample than its limit are handed to `found` with the sample's
    /// place among `samples`; `seconds` falls to the least bound of the others. The own one lies within the limit.
    pub(crate) fn scan(
        &self,
        head: &Head,
        (samples, owns, limits): (&[u32], &[u32], &[f32]),
        seconds: &mut [f32],
        work: &mut Workspace,
        mut found: impl FnMut(usize, u32),
    ) {
        let rows = self.multiply(head, samples, work);
        for (i, (&sample, products)) in samples.iter().zip(rows.products).enumerate() {
            let row = Row { bounds: self, head: (head.square(sample as usize), head.tail(sample as usize)), products };
            let summary = rows.arch.dispatch(Below { row, limit: limits[i], parts: rows.parts, out: rows.row });
            seconds[i] = seconds[i].min(summary.second);
            if summary.count > u32::from(self.present[owns[i] as usize]) {
                let near = rows.row.iter().zip(&self.order).filter(|(bound, _)| **bound <= limits[i]);
                near.filter(|(_, cluster)| **cluster != owns[i]).for_each(|(_, &cluster)| found(i, cluster));
            }
        }
    }

    /// The subspace of least bound for each sample.
    pub(crate) fn nearest(&self, head: &Head, samples: &[u32], work: &mut Workspace) -> Vec<u32> {
        let rows = self.multiply(head, samples, work);
        let nearest = samples.iter().zip(rows.products).map(|(&sample, products)| {
            let row = Row { bounds: self, head: (head.square(sample as usize), head.tail(sample as usize)), products };
            rows.arch.dispatch(Below { row, limit: f32::NEG_INFINITY, parts: rows.parts, out: rows.row });
            let least = rows
                .row
                .iter()
                .enumerate()
                .fold((0, f32::INFINITY), |best, (i, &b)| if b < best.1 { (i, b) } else { best });
            self.order[least.0]
        });
        nearest.collect()
    }

    /// Products of the samples' heads with everything.
    fn multiply<'a>(&self, head: &Head, samples: &[u32], work: &'a mut Workspace) -> Rows<'a> {
        let (count, k, width) = (samples.len(), self.order.len(), self.rows.nrows());
        work.products.resize(work.products.len().max(count * width), 0.0);
        work.parts.resize(k, 0.0);
        work.row.resize(k, 0.0);
        work.points.clear();
        samples.iter().for_each(|&s| work.points.extend_from_slice(head.coordinates(s as usize)));
        let points = ArrayView2::from_shape((count, head.size()), &work.points).expect("rows of the head");
        let products = &mut work.products[..count * width];
        let out = ArrayViewMut2::from_shape((count, width), &mut *products).expect("as resized");
        linalg::times_transposed(points, self.rows.view(), out);
        Rows {
            products: products.chunks_exact(width),
            parts: &mut work.parts,
            row: &mut work.row,
            arch: pulp::Arch::new(),
        }
    }
}

/// Products of samples, and where one of them is looked at.
struct Rows<'a> {
    products: std::slice::ChunksExact<'a, f32>,
    parts: &'a mut [f32],
    row: &'a mut [f32],
    arch: pulp::Arch,
}

/// One sample.
struct Row<'a> {
    bounds: &'a Bounds,
    /// |x_h|², t_x
    head: (f32, f32),
    products: &'a [f32],
}

/// The work of one sample, which the processor's vectors do: code of a closure would be compiled without them.
struct Below<'a> {
    row: Row<'a>,
    limit: f32,
    parts: &'a mut [f32],
    out: &'a mut [f32],
}

impl WithSimd for Below<'_> {
    type Output = Summary;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Summary {
        self.row.below(self.limit, self.parts, self.out)
    }
}

/// What a row of bounds says.
struct Summary {
    /// The least of those above the limit.
    second: f32,
    /// How many are not above it.
    count: u32,
}

impl Row<'_> {
    /// Bounds of all subspaces into `out`.
    #[inline(always)]
    fn below(&self, limit: f32, parts: &mut [f32], out: &mut [f32]) -> Summary {
        let b = self.bounds;
        if b.levels.len() > 2 {
            self.explained(parts);
        }
        match (b.levels.len() > 2, b.tailed) {
            (false, false) => self.bound(out, |i| {
                let _ = i;
                0.0
            }),
            (true, false) => self.bound(out, |i| -parts[i]),
            (false, true) => self.bound(out, |i| {
                let rest = self.head.1 - b.tails[i];
                rest * rest
            }),
            (true, true) => self.bound(out, |i| {
                let a = parts[i].sqrt();
                let (least, most) = ((self.head.1 - b.tails[i]).abs(), self.head.1 + b.tails[i]);
                let rest = (b.leaks[i] * a * b.steeps[i]).max(least).min(most);
                let along = a + b.leaks[i] * rest;
                rest * rest - along * along
            }),
        }
        summary(out, limit)
    }

    /// a² by position.
    #[inline(always)]
    fn explained(&self, parts: &mut [f32]) {
        parts.fill(0.0);
        for level in self.bounds.levels.windows(2).skip(1) {
            let range = level[0]..level[1];
            let terms = self.products[range.clone()].iter().zip(&self.bounds.shifts[range]);
            for (part, (product, shift)) in parts.iter_mut().zip(terms) {
                let a = product - shift;
                *part += a * a;
            }
        }
    }

    /// |x_h - μ_h|² with what is `beside` it, less what rounding may have added.
    #[inline(always)]
    fn bound(&self, out: &mut [f32], beside: impl Fn(usize) -> f32) {
        let (square, tail) = self.head;
        let k = out.len();
        let (products, squares, margins) = (&self.products[..k], &self.bounds.squares[..k], &self.bounds.margins[..k]);
        let own = square - self.bounds.slack() * (square + tail * tail);
        for i in 0..k {
            out[i] = own - 2.0 * products[i] + (squares[i] - margins[i]) + beside(i);
        }
    }
}

/// Strands of a summary.
const LANES: usize = 16;

#[inline(always)]
fn summary(bounds: &[f32], limit: f32) -> Summary {
    let (mut least, mut counts) = ([f32::INFINITY; LANES], [0u32; LANES]);
    let chunks = bounds.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for lane in 0..LANES {
            let above = chunk[lane] > limit;
            let bound = if above { chunk[lane] } else { f32::INFINITY };
            least[lane] = if bound < least[lane] { bound } else { least[lane] };
            counts[lane] += u32::from(!above);
        }
    }
    let (mut second, mut count) = (f32::INFINITY, 0);
    for lane in 0..LANES {
        second = second.min(least[lane]);
        count += counts[lane];
    }
    for &bound in rest {
        second = if bound > limit { second.min(bound) } else { second };
        count += u32::from(bound <= limit);
    }
    Summary { second, count }
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
