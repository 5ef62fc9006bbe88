//! Subspaces move from where they are hardly missed to where one is not enough (the shift of enhanced LBG, Patanè and Russo
//! 2001, for affine subspaces).
//!
//! LBG ends in the nearest local optimum, in which some clusters hold much more error than others. A cluster with little error
//! is dissolved, its members going to the next nearest subspaces, and a cluster with much is split in two, where this
//! saves more than it costs.

use crate::assign;
use crate::groups::Groups;
use crate::refit::fit;
use crate::residual::explicit;
use crate::subspaces::Subspace;
use crate::sweeps::{Search, State};
use prt_transfer::Result;
use rayon::prelude::*;

/// At most such a part of the clusters is dissolved at a time.
const PART: usize = 4;
/// Rounds of two-way LBG within a cluster that is split.
const ROUNDS: usize = 3;

/// A cluster in two.
struct Halves {
    cluster: usize,
    gain: f64,
    halves: [Subspace; 2],
}

impl Search<'_> {
    /// Moves subspaces where it pays, by the distances of the last assignment; how many. Members follow with the next one.
    pub(crate) fn shift(&self, state: &mut State, components: &[usize]) -> Result<usize> {
        let k = state.subspaces.len();
        let groups = Groups::of(&state.assignment.members, k);
        let own = assign::own(self.samples, self.head, &state.subspaces, &state.assignment.members);
        let mut errors = vec![0f64; k];
        state.assignment.members.iter().zip(&own).for_each(|(&c, e)| errors[c as usize] += f64::from(*e));
        let mean = errors.iter().sum::<f64>() / k as f64;
        let mut order: Vec<usize> = (0..k).collect();
        order.sort_by(|&a, &b| errors[a].total_cmp(&errors[b]).then(a.cmp(&b)));
        let empty = (0..k).filter(|&c| groups.of_cluster(c).is_empty()).count();
        let most = (k / PART).max(empty);
        let low: Vec<usize> = order.iter().copied().take(most).filter(|&c| errors[c] < mean).collect();
        let high: Vec<usize> = order.iter().rev().copied().take(most).filter(|&c| errors[c] > mean).collect();
        let mut costs = self.costs(state, &groups, &low, &own)?;
        costs.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let split =
            |&c: &usize| self.split(&state.subspaces.of(c).clone(), groups.of_cluster(c), components[c], errors[c], c);
        let mut halves: Vec<Halves> =
            high.par_iter().map(split).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
        halves.sort_by(|a, b| b.gain.total_cmp(&a.gain).then(a.cluster.cmp(&b.cluster)));
        let mut moved = 0;
        for ((dissolved, _), split) in costs.into_iter().zip(halves).take_while(|((_, cost), split)| split.gain > *cost)
        {
            let [first, second] = split.halves;
            state.replace(split.cluster, first);
            state.replace(dissolved, second);
            moved += 1;
        }
        Ok(moved)
    }

    /// What dissolving each cluster adds to the error, if none of them takes in the others' members.
    fn costs(&self, state: &State, groups: &Groups, low: &[usize], own: &[f32]) -> Result<Vec<(usize, f64)>> {
        let others: Vec<u32> = (0..state.subspaces.len() as u32).filter(|&c| !low.contains(&(c as usize))).collect();
        let samples: Vec<u32> = low.iter().flat_map(|&c| groups.of_cluster(c)).copied().collect();
        let nearest = assign::nearest(self.samples, self.head, &state.subspaces, &others, &samples)?;
        let mut nearest = nearest.into_iter();
        let cost = low.iter().map(|&cluster| {
            let group = groups.of_cluster(cluster);
            let cost = group.iter().map(|&s| nearest.next().map_or(0.0, f64::from) - f64::from(own[s as usize])).sum();
            (cluster, cost)
        });
        Ok(cost.collect())
    }

    /// A cluster's members cut in two across its first component, with a subspace for each half.
    fn split(
        &self,
        whole: &Subspace,
        group: &[u32],
        components: usize,
        error: f64,
        cluster: usize,
    ) -> Result<Option<Halves>> {
        let n = self.samples.dimension();
        if group.len() < 2 {
            return Ok(None);
        }
        let along: Vec<f64> = match whole.components.get(..n) {
            Some(first) => group.iter().map(|&s| project(self.samples.row(s as usize), &whole.mean, first)).collect(),
            None => {
                let farthest = self.farthest(group, &whole.mean);
                let axis: Vec<f32> = self.samples.row(farthest).iter().zip(&whole.mean).map(|(x, m)| x - m).collect();
                group.iter().map(|&s| project(self.samples.row(s as usize), &whole.mean, &axis)).collect()
            }
        };
        let mut sides: Vec<bool> = along.iter().map(|a| *a > 0.0).collect();
        let mut best: Option<Halves> = None;
        for _ in 0..ROUNDS {
            let side = |which: bool| {
                group.iter().zip(&sides).filter(|(_, s)| **s == which).map(|(g, _)| *g).collect::<Vec<u32>>()
            };
            let (left, right) = (side(false), side(true));
            if left.is_empty() || right.is_empty() {
                break;
            }
            let halves = [
                fit(self.samples, &left, components, &whole.components)?,
                fit(self.samples, &right, components, &whole.components)?,
            ];
            let distance =
                |s: u32, half: &Subspace| explicit(self.samples.row(s as usize), &half.mean, &half.components);
            let mut sum = 0.0;
            for (side, &sample) in sides.iter_mut().zip(group) {
                let [a, b] = [distance(sample, &halves[0]), distance(sample, &halves[1])];
                *side = b < a;
                sum += a.min(b);
            }
            let gain = error - sum;
            if best.as_ref().is_none_or(|b| gain > b.gain) {
                best = Some(Halves { cluster, gain, halves });
            }
        }
        Ok(best)
    }

    fn farthest(&self, group: &[u32], mean: &[f32]) -> usize {
        let distance = |s: u32| explicit(self.samples.row(s as usize), mean, &[]);
        let far = group
            .iter()
            .copied()
            .map(|s| (distance(s), s))
            .fold((-1.0, 0), |best, d| if d.0 > best.0 { d } else { best });
        far.1 as usize
    }
}

fn project(x: &[f32], mean: &[f32], axis: &[f32]) -> f64 {
    x.iter().zip(mean).zip(axis).map(|((x, m), a)| (f64::from(*x) - f64::from(*m)) * f64::from(*a)).sum()
}
