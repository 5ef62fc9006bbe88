//! Reclassification: samples move to the clusters of their neighbours, for less overdraw at a bounded price in error.

use super::fans::Fans;
use super::overdraw::{check, distinct};
use prt_transfer::{Error, Result};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::fmt::Display;

/// What [`reclassify`] found.
#[derive(Clone, Debug, PartialEq)]
pub struct Reclassified {
    /// The cluster of each sample.
    pub clusters: Vec<u32>,
    /// Samples whose cluster is not the one they came with.
    pub moved: usize,
    /// Squared error that this adds over all samples; below 0 where moves saved more than others cost.
    pub increase: f64,
}

/// Moves samples to clusters of their neighbours in the mesh, greedily, as long as overdraw falls and the budget lasts
/// (paper §5).
///
/// Vertex i of `triangles` is sample i, of cluster `clusters[i]`. A sample may move to the cluster of a vertex that it
/// shares a triangle with. Moves are made in descending order of overdraw reduction over error increase; after each,
/// the quotients of the sample and its neighbours are computed anew, so that a sample may move twice. What the paper
/// leaves open:
///
/// - A move that does not increase error is free. Free moves are made first, those that reduce overdraw most before the
///   others; one that only reduces error is made too. A move that increases overdraw is never made.
/// - The budget pays for every increase of error, and what free moves save is not spent on others. The error of the
///   result exceeds that of `clusters` by `budget` at most, and with a budget of 0 every move is free.
/// - A move that exceeds what is left of the budget is passed over; cheaper ones after it are made.
/// - Of equally good moves that of the lower vertex is made, then that to the lower cluster: the result is the same on
///   any number of threads.
/// - A cluster may lose its last member. Its number stays unused; dropping it is up to the caller.
///
/// `error(sample, cluster)` is the squared error of a sample where it is approximated in a cluster. It is asked only
/// for clusters that a sample could move to without more overdraw, and for its own, at most once each, from several
/// threads. Clusters themselves do not change: a representative stays what it is when members come and go.
///
/// # Errors
/// Triangles with vertices beyond the samples; a budget or an error that is negative, NaN or infinite.
pub fn reclassify(
    triangles: &[[u32; 3]],
    clusters: &[u32],
    budget: f64,
    error: impl Fn(usize, u32) -> f64 + Sync,
) -> Result<Reclassified> {
    check(triangles, clusters.len())?;
    expect_not_negative("budget of squared error", budget)?;
    let search =
        Search { fans: Fans::new(triangles, clusters.len()), clusters: clusters.to_vec(), left: budget, error };
    search.run(clusters)
}

/// A sample's move to another cluster. The greatest is made first.
#[derive(Clone, Copy, Debug)]
struct Move {
    /// Triangles that are drawn less.
    reduction: u32,
    /// Of the squared error.
    increase: f64,
    sample: u32,
    cluster: u32,
    /// Of the sample's quotients when this was computed; not a part of the order.
    version: u32,
}

impl Move {
    fn is_free(&self) -> bool {
        self.increase <= 0.0
    }
    fn quotient(&self) -> f64 {
        f64::from(self.reduction) / self.increase
    }
}

impl Ord for Move {
    fn cmp(&self, other: &Move) -> Ordering {
        let free = self.is_free();
        let gain = || match free {
            true => self.reduction.cmp(&other.reduction).then(other.increase.total_cmp(&self.increase)),
            false => self.quotient().total_cmp(&other.quotient()),
        };
        let tie = || (other.sample, other.cluster).cmp(&(self.sample, self.cluster));
        free.cmp(&other.is_free()).then_with(gain).then_with(tie)
    }
}

impl PartialOrd for Move {
    fn partial_cmp(&self, other: &Move) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Move {
    fn eq(&self, other: &Move) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Move {}

/// The errors of a sample that have been asked for, by cluster.
type Asked = Vec<(u32, f64)>;

struct Search<'a, E> {
    fans: Fans<'a>,
    clusters: Vec<u32>,
    /// Of the budget.
    left: f64,
    error: E,
}

impl<E: Fn(usize, u32) -> f64 + Sync> Search<'_, E> {
    fn run(mut self, before: &[u32]) -> Result<Reclassified> {
        let mut asked: Vec<Asked> = vec![Vec::new(); before.len()];
        let first = asked.par_iter_mut().enumerate().map(|(sample, asked)| self.best(sample, 0, asked));
        let first: Vec<Option<Move>> = first.collect::<Result<_>>()?;
        let mut queue: BinaryHeap<Move> = first.into_iter().flatten().collect();
        let mut versions = vec![0u32; before.len()];
        while let Some(step) = queue.pop() {
            let sample = step.sample as usize;
            if step.version != versions[sample] {
                continue;
            }
            let affordable = step.increase <= self.left;
            if affordable {
                self.left -= step.increase.max(0.0);
                self.clusters[sample] = step.cluster;
            }
            let changed = if affordable { self.fans.ring(sample) } else { [step.sample].into() };
            for other in changed.into_iter().map(|other| other as usize) {
                versions[other] += 1;
                queue.extend(self.best(other, versions[other], &mut asked[other])?);
            }
        }
        let mut result = Reclassified { clusters: self.clusters, moved: 0, increase: 0.0 };
        for (sample, (&from, &to)) in
            before.iter().zip(&result.clusters).enumerate().filter(|(_, (from, to))| from != to)
        {
            let known = |cluster| asked[sample].iter().find(|(c, _)| *c == cluster).map_or(0.0, |(_, error)| *error);
            result.moved += 1;
            result.increase += known(to) - known(from);
        }
        Ok(result)
    }

    /// The best move of a sample that what is left of the budget allows.
    fn best(&self, sample: usize, version: u32, asked: &mut Asked) -> Result<Option<Move>> {
        let from = self.clusters[sample];
        let mut targets: Vec<u32> = Vec::new();
        for cluster in self.fans.of(sample).flatten().map(|v| self.clusters[v as usize]) {
            if cluster != from && !targets.contains(&cluster) {
                targets.push(cluster);
            }
        }
        let mut best = None;
        for cluster in targets {
            let Some(reduction) = self.drawn(sample, from).checked_sub(self.drawn(sample, cluster)) else { continue };
            let increase = self.ask(sample, cluster, asked)? - self.ask(sample, from, asked)?;
            if (reduction > 0 || increase < 0.0) && increase <= self.left {
                best = best.max(Some(Move { reduction, increase, sample: sample as u32, cluster, version }));
            }
        }
        Ok(best)
    }

    /// Overdraw of the triangles around a sample where it is of `cluster`.
    fn drawn(&self, sample: usize, cluster: u32) -> u32 {
        let cluster_of = |v: u32| if v as usize == sample { cluster } else { self.clusters[v as usize] };
        self.fans.of(sample).map(|triangle| distinct(triangle.map(cluster_of))).sum()
    }

    fn ask(&self, sample: usize, cluster: u32, asked: &mut Asked) -> Result<f64> {
        if let Some((_, error)) = asked.iter().find(|(c, _)| *c == cluster) {
            return Ok(*error);
        }
        let error = (self.error)(sample, cluster);
        expect_not_negative(format_args!("squared error of sample {sample} in cluster {cluster}"), error)?;
        asked.push((cluster, error));
        Ok(error)
    }
}

/// Refuses negative and infinite numbers, and NaN.
pub(crate) fn expect_not_negative(what: impl Display, value: f64) -> Result<()> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    let expected = "a finite number, not negative".into();
    Err(Error::Unsupported { what: what.to_string(), expected, found: value.to_string() })
}
