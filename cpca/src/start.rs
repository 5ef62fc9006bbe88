//! Where clusters start.

use crate::head::Head;
use crate::params::Start;
use crate::refit::fit;
use crate::shift::by_cluster;
use crate::subspaces::{Subspace, Subspaces};
use crate::sweeps::Search;
use prt_transfer::Result;
use prt_transfer::groups::Groups;
use prt_transfer::random::Random;
use prt_transfer::samples::Samples;
use rayon::prelude::*;

impl Search<'_> {
    /// `clusters` means, or fewer where there are no more distinct samples.
    pub(crate) fn start(&self, clusters: usize, start: Start, seed: u64) -> Result<Subspaces> {
        let (samples, mut random) = (self.samples, Random(seed));
        let chosen = match start {
            Start::Random => distinct(samples, &mut random).take(clusters).collect(),
            Start::PlusPlus => plus_plus(samples, self.head, clusters, &mut random),
            Start::Splitting => return self.splitting(clusters),
        };
        let at = |sample: usize| Subspace { mean: samples.row(sample).to_vec(), components: Vec::new() };
        Ok(Subspaces::new(samples.dimension(), chosen.into_iter().map(at).collect()))
    }

    /// From one cluster on, those of most error in two, with a few sweeps in between (Linde et al. 1980).
    fn splitting(&self, clusters: usize) -> Result<Subspaces> {
        let all: Vec<u32> = (0..self.samples.count() as u32).collect();
        let mut subspaces = Subspaces::new(self.samples.dimension(), vec![fit(self.samples, &all, 0, &[])?]);
        while subspaces.len() < clusters {
            let (k, none) = (subspaces.len(), vec![0; subspaces.len()]);
            let mut state = self.begin(subspaces.clone())?;
            self.sweeps(&mut state, &none, SWEEPS_BETWEEN)?;
            let groups = Groups::of(&state.assignment.members, k);
            let errors = by_cluster(&state.assignment.errors, &groups);
            let every: Vec<usize> = (0..k).collect();
            let gains = self.gains(&every, state.subspaces.all(), &groups, &none, &errors)?;
            subspaces = state.subspaces;
            for (cluster, _, halves) in gains.into_iter().filter(|(_, gain, _)| *gain > 0.0).take(clusters - k) {
                let [first, second] = halves.subspaces;
                subspaces.set(cluster, first);
                subspaces.push(second);
            }
            if subspaces.len() == k {
                break;
            }
        }
        Ok(subspaces)
    }
}

/// Sweeps between two doublings.
const SWEEPS_BETWEEN: usize = 2;

/// All samples in random order without those that equal one before.
fn distinct<'a>(samples: &'a Samples, random: &'a mut Random) -> impl Iterator<Item = usize> + 'a {
    let mut order: Vec<usize> = (0..samples.count()).collect();
    let mut seen = std::collections::HashSet::new();
    let shuffled = (0..order.len()).map(move |i| {
        let other = i + random.below(order.len() - i);
        order.swap(i, other);
        order[i]
    });
    shuffled.filter(move |&sample| seen.insert(bits(samples.row(sample))))
}

/// Numbers by their bits, both zeros the same.
fn bits(row: &[f32]) -> Vec<u32> {
    row.iter().map(|v| (v + 0.0).to_bits()).collect()
}

/// Samples for each cluster among which k-means++ draws: enough for its expectation, and a bound of its work.
const DRAWN_FROM: usize = 24;
/// Samples whose distances are summed together.
const BLOCK: usize = 512;

/// k-means++ (Arthur and Vassilvitskii 2007) by distances in the head, among some of the samples.
fn plus_plus(samples: &Samples, head: &Head, clusters: usize, random: &mut Random) -> Vec<usize> {
    let pool: Vec<usize> = distinct(samples, random).take(DRAWN_FROM * clusters).collect();
    let rows: Vec<f32> = pool.iter().flat_map(|&sample| head.coordinates(sample)).copied().collect();
    let size = head.size().max(1);
    let mut nearest = vec![f32::MAX; pool.len()];
    let mut chosen = vec![random.below(pool.len().max(1))];
    while chosen.len() < clusters.min(pool.len()) {
        let newest = chosen[chosen.len() - 1];
        let centre = rows.get(newest * size..(newest + 1) * size).unwrap_or(&[]);
        let sums: Vec<f64> = nearest
            .par_chunks_mut(BLOCK)
            .zip(rows.par_chunks(BLOCK * size))
            .map(|(nearest, rows)| pulp::Arch::new().dispatch(Nearer { rows, centre, nearest }))
            .collect();
        nearest[newest] = 0.0;
        let total: f64 = sums.iter().sum();
        chosen.push(match total > 0.0 {
            true => drawn(&nearest, random.uniform() * total),
            // Alike in the head and yet distinct: any that has not been chosen.
            false => (0..pool.len()).find(|i| !chosen.contains(i)).expect("fewer have been chosen than there are"),
        });
    }
    chosen.into_iter().filter_map(|i| pool.get(i).copied()).collect()
}

/// Squared distances to a new centre where they are less than before; their sum.
struct Nearer<'a> {
    rows: &'a [f32],
    centre: &'a [f32],
    nearest: &'a mut [f32],
}

impl pulp::WithSimd for Nearer<'_> {
    type Output = f64;
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> f64 {
        const LANES: usize = 16;
        let mut sum = 0f64;
        for (row, least) in self.rows.chunks_exact(self.centre.len().max(1)).zip(self.nearest) {
            let mut lanes = [0f32; LANES];
            let (row, centre) = (row.chunks_exact(LANES), self.centre.chunks_exact(LANES));
            let mut square = 0.0;
            for (x, c) in row.remainder().iter().zip(centre.remainder()) {
                square += (x - c) * (x - c);
            }
            for (x, c) in row.zip(centre) {
                for lane in 0..LANES {
                    let d = x[lane] - c[lane];
                    lanes[lane] += d * d;
                }
            }
            for lane in lanes {
                square += lane;
            }
            *least = if square < *least { square } else { *least };
            sum += f64::from(*least);
        }
        sum
    }
}

/// Where the running sum of weights passes `target`; the last that has a weight where rounding has passed the end.
fn drawn(weights: &[f32], mut target: f64) -> usize {
    for (i, weight) in weights.iter().enumerate() {
        target -= f64::from(*weight);
        if target < 0.0 {
            return i;
        }
    }
    weights.iter().rposition(|w| *w > 0.0).unwrap_or(0)
}
