//! Each sample to the subspace that it lies nearest to: exact, whatever the order of the work.
//!
//! Distances are computed only where they can matter. What a sample's distance from any other than its own cluster was at least
//! is remembered; subspaces that have moved little since, or not at all, are told apart from those that must be looked at anew.
//! Bounds from the heads ([`crate::bounds`]) leave few of those for each sample; their distances are computed in single
//! precision, and those that rounding cannot tell apart in double precision from the explicit residual. The result is that of
//! the last alone; of equal distances the first cluster has the sample.

use crate::bounds::{Bounds, Workspace};
use crate::head::Head;
use crate::residual::{Residual, explicit};
use crate::subspaces::Subspaces;
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Progress, Result};
use rayon::prelude::*;

/// Samples and their clusters.
#[derive(Clone, Debug)]
pub(crate) struct Assignment {
    /// The cluster of each sample.
    pub(crate) members: Vec<u32>,
    /// Squared distance of each sample from its own subspace when it was assigned.
    pub(crate) errors: Vec<f32>,
    /// No other subspace was nearer than this distance.
    seconds: Vec<f32>,
}

/// Samples that a thread assigns at a time.
const BLOCK: usize = 128;

/// A subspace that a sample may lie nearest to.
#[derive(Clone, Copy, Default)]
struct Candidate {
    /// Position in the block.
    sample: u32,
    cluster: u32,
    error: f32,
    /// How much `error` may be off.
    margin: f32,
}

/// A sample's outcome.
struct Found {
    sample: u32,
    cluster: u32,
    error: f32,
    second: f32,
}

/// A sample that is looked at, and what is known of it.
#[derive(Clone, Copy)]
struct Known {
    sample: u32,
    /// Its cluster, whose distance has been computed.
    own: Candidate,
    /// The distance from what is not looked at is at least this.
    rest: f32,
}

/// What stays the same from sample to sample.
struct Pass<'a> {
    samples: &'a Samples<'a>,
    head: &'a Head,
    subspaces: &'a Subspaces,
    residual: Residual,
}

#[derive(Default)]
struct Scratch {
    work: Workspace,
    residual: Vec<f32>,
    candidates: Vec<Candidate>,
    starts: Vec<usize>,
    sorted: Vec<Candidate>,
}

/// Assigns every sample to the nearest of `subspaces`.
pub(crate) fn first(
    samples: &Samples,
    head: &Head,
    subspaces: &Subspaces,
    progress: &dyn Progress,
) -> Result<Assignment> {
    let bounds = Bounds::new(head, subspaces, &every(subspaces))?;
    // The nearest by its bound is as good a guess as any.
    let all: Vec<u32> = (0..samples.count() as u32).collect();
    let nearest = |work: &mut Workspace, block: &[u32]| bounds.nearest(head, block, work);
    let guesses = all.par_chunks(BLOCK).map_init(Workspace::default, nearest).collect::<Vec<_>>().concat();
    let before = Assignment { errors: vec![0.0; guesses.len()], seconds: vec![0.0; guesses.len()], members: guesses };
    again(samples, head, subspaces, &vec![f32::INFINITY; subspaces.len()], &before, progress)
}

/// As [`first`], from an assignment to subspaces each of which has since come no nearer to any point than by `drifts`
/// (infinity: anywhere).
pub(crate) fn again(
    samples: &Samples,
    head: &Head,
    subspaces: &Subspaces,
    drifts: &[f32],
    before: &Assignment,
    progress: &dyn Progress,
) -> Result<Assignment> {
    let pass = Pass { samples, head, subspaces, residual: Residual::new() };
    let threshold = threshold(drifts);
    let moved: Vec<u32> = (0..drifts.len() as u32).filter(|&k| drifts[k as usize] > threshold).collect();
    let own = pass.own(&before.members);
    let mut after = before.clone();
    let (mut all, mut some) = (Vec::new(), Vec::new());
    for (sample, own) in own.into_iter().enumerate() {
        // Rounded towards nothing.
        let rest = (before.seconds[sample] - threshold) * (1.0 - 4.0 * f32::EPSILON);
        let far = rest > 0.0 && own.error + own.margin <= rest * rest;
        after.errors[sample] = own.error.max(0.0);
        after.seconds[sample] = rest.max(0.0);
        let known = Known { sample: sample as u32, own, rest: if far { rest * rest } else { f32::INFINITY } };
        if far { some.push(known) } else { all.push(known) }
    }
    let moved_bounds =
        if moved.is_empty() || some.is_empty() { None } else { Some(Bounds::new(head, subspaces, &moved)?) };
    let all_bounds = if all.is_empty() { None } else { Some(Bounds::new(head, subspaces, &every(subspaces))?) };
    let work = [(all, all_bounds), (some, moved_bounds)];
    for (known, bounds) in work.iter().filter_map(|(known, bounds)| Some((known, bounds.as_ref()?))) {
        let found: Vec<Vec<Found>> = known
            .par_chunks(BLOCK)
            .map_init(Scratch::default, |scratch, block| {
                progress.advance(0)?;
                Ok(pass.block(bounds, block, scratch))
            })
            .collect::<Result<_>>()?;
        for found in found.into_iter().flatten() {
            let sample = found.sample as usize;
            after.members[sample] = found.cluster;
            after.errors[sample] = found.error;
            after.seconds[sample] = found.second;
        }
    }
    Ok(after)
}

/// Squared distance of each sample from its own subspace.
pub(crate) fn own(samples: &Samples, head: &Head, subspaces: &Subspaces, members: &[u32]) -> Vec<f32> {
    let pass = Pass { samples, head, subspaces, residual: Residual::new() };
    pass.own(members).into_iter().map(|own| own.error.max(0.0)).collect()
}

/// Squared distance of each of some samples from the nearest of some subspaces; infinity where there are none.
pub(crate) fn nearest(
    samples: &Samples,
    head: &Head,
    subspaces: &Subspaces,
    clusters: &[u32],
    of: &[u32],
) -> Result<Vec<f32>> {
    if clusters.is_empty() {
        return Ok(vec![f32::INFINITY; of.len()]);
    }
    let pass = Pass { samples, head, subspaces, residual: Residual::new() };
    let bounds = Bounds::new(head, subspaces, clusters)?;
    let found = of.par_chunks(BLOCK).map_init(Scratch::default, |scratch, block| {
        let guesses = bounds.nearest(head, block, &mut scratch.work);
        let known = block.iter().zip(guesses).map(|(&sample, cluster)| {
            let own = pass.distance(sample as usize, cluster, &mut scratch.residual);
            Known { sample, own, rest: f32::INFINITY }
        });
        let known: Vec<Known> = known.collect();
        pass.block(&bounds, &known, scratch).into_iter().map(|found| found.error).collect::<Vec<f32>>()
    });
    Ok(found.collect::<Vec<_>>().concat())
}

fn every(subspaces: &Subspaces) -> Vec<u32> {
    (0..subspaces.len() as u32).collect()
}

/// Subspaces that have moved by more are looked at by every sample: an eighth of them, and all that may be anywhere.
fn threshold(drifts: &[f32]) -> f32 {
    let mut finite: Vec<f32> = drifts.iter().copied().filter(|d| d.is_finite()).collect();
    finite.sort_by(f32::total_cmp);
    if finite.is_empty() { 0.0 } else { finite[(finite.len() - 1) - finite.len() / 8] }
}

impl Pass<'_> {
    /// Each sample's distance from its own subspace, cluster by cluster so that its vectors stay in the cache.
    fn own(&self, members: &[u32]) -> Vec<Candidate> {
        let groups = Groups::of(members, self.subspaces.len());
        let parts: Vec<Vec<Candidate>> = (0..groups.len())
            .into_par_iter()
            .map_init(Vec::new, |residual, cluster| {
                let of = |&sample: &u32| self.distance(sample as usize, cluster as u32, residual);
                groups.of_cluster(cluster).iter().map(of).collect()
            })
            .collect();
        let mut own = vec![Candidate::default(); members.len()];
        for (cluster, parts) in parts.into_iter().enumerate() {
            groups.of_cluster(cluster).iter().zip(parts).for_each(|(&sample, part)| own[sample as usize] = part);
        }
        own
    }

    fn distance(&self, sample: usize, cluster: u32, scratch: &mut Vec<f32>) -> Candidate {
        let (x, subspace) = (self.samples.row(sample), self.subspaces.of(cluster as usize));
        let parts = self.residual.parts(x, &subspace.mean, &subspace.components, scratch);
        let margin = parts.square * Residual::uncertainty(x.len(), self.subspaces.components(cluster as usize));
        Candidate { sample: 0, cluster, error: parts.square - parts.explained, margin }
    }

    /// The nearest of a sample's own subspace and those of `bounds`.
    fn block(&self, bounds: &Bounds, known: &[Known], scratch: &mut Scratch) -> Vec<Found> {
        let samples: Vec<u32> = known.iter().map(|k| k.sample).collect();
        let limits: Vec<f32> = known.iter().map(|known| known.own.error + known.own.margin).collect();
        let mut seconds: Vec<f32> = known.iter().map(|known| known.rest).collect();
        let (work, candidates) = (&mut scratch.work, &mut scratch.candidates);
        candidates.clear();
        let owns: Vec<u32> = known.iter().map(|known| known.own.cluster).collect();
        bounds.scan(self.head, (&samples, &owns, &limits), &mut seconds, work, |i, cluster| {
            candidates.push(Candidate { sample: i as u32, cluster, error: 0.0, margin: 0.0 });
        });
        self.measure(&samples, scratch);
        let own = known.iter().enumerate().map(|(i, known)| Candidate { sample: i as u32, ..known.own });
        scratch.sorted.extend(own);
        self.choose(&samples, &seconds, &scratch.sorted)
    }

    /// Distances of the candidates, into `sorted`, cluster by cluster.
    fn measure(&self, samples: &[u32], scratch: &mut Scratch) {
        let starts = &mut scratch.starts;
        starts.clear();
        starts.resize(self.subspaces.len() + 1, 0);
        scratch.candidates.iter().for_each(|c| starts[c.cluster as usize + 1] += 1);
        (1..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        scratch.sorted.clear();
        scratch.sorted.resize(scratch.candidates.len(), Candidate::default());
        for candidate in &scratch.candidates {
            let place = &mut starts[candidate.cluster as usize];
            scratch.sorted[*place] = *candidate;
            *place += 1;
        }
        for candidate in &mut scratch.sorted {
            let sample = samples[candidate.sample as usize] as usize;
            let measured = self.distance(sample, candidate.cluster, &mut scratch.residual);
            *candidate = Candidate { sample: candidate.sample, ..measured };
        }
    }

    /// The nearest candidate of each sample; no subspace that is no candidate is nearer than the root of `seconds`.
    fn choose(&self, samples: &[u32], seconds: &[f32], candidates: &[Candidate]) -> Vec<Found> {
        let mut limits = vec![f32::INFINITY; samples.len()];
        for c in candidates {
            let limit = &mut limits[c.sample as usize];
            *limit = limit.min(c.error + c.margin);
        }
        // Those that may be the nearest: one for most samples.
        let possible = |c: &&Candidate| c.error - c.margin <= limits[c.sample as usize];
        let mut counts = vec![0u32; samples.len()];
        candidates.iter().filter(possible).for_each(|c| counts[c.sample as usize] += 1);
        let mut best = vec![(f64::INFINITY, u32::MAX); samples.len()];
        for c in candidates.iter().filter(possible) {
            let i = c.sample as usize;
            let certain = counts[i] == 1 && c.error > c.margin;
            let error = if certain { f64::from(c.error) } else { self.explicit(samples[i], c.cluster) };
            let (least, cluster) = best[i];
            if error < least || error == least && c.cluster < cluster {
                best[i] = (error, c.cluster);
            }
        }
        let mut seconds = seconds.to_vec();
        for c in candidates.iter().filter(|c| c.cluster != best[c.sample as usize].1) {
            let second = &mut seconds[c.sample as usize];
            *second = second.min(c.error - c.margin);
        }
        let found = samples.iter().zip(best).zip(seconds).map(|((&sample, (error, cluster)), second)| Found {
            sample,
            cluster,
            error: error as f32,
            second: second.max(0.0).sqrt(),
        });
        found.collect()
    }

    fn explicit(&self, sample: u32, cluster: u32) -> f64 {
        let subspace = self.subspaces.of(cluster as usize);
        explicit(self.samples.row(sample as usize), &subspace.mean, &subspace.components)
    }
}

#[cfg(test)]
mod tests;
