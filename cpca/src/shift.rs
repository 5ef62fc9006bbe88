//! Subspaces move from where they are hardly missed to where one is not enough (the shift of enhanced LBG, Patanè and Russo
//! 2001, for affine subspaces).
//!
//! A cluster with little error, or without members, is dissolved, its members going to the next nearest subspaces, and a cluster with
//! much is split in two, where this saves more than it costs.

use crate::assign;
use crate::split::{Halves, halves};
use crate::subspaces::Subspace;
use crate::sweeps::{Search, State};
use prt_transfer::Result;
use prt_transfer::groups::Groups;
use rayon::prelude::*;

/// At most such a part of the clusters is dissolved at a time, or all that are empty.
const PART: usize = 4;

impl Search<'_> {
    /// Moves subspaces where it pays; how many. Members follow with the next assignment.
    pub(crate) fn shift(&self, state: &mut State, components: &[usize]) -> Result<usize> {
        let k = state.subspaces.len();
        let groups = Groups::of(&state.assignment.members, k);
        let own = assign::own(self.samples, self.head, &state.subspaces, &state.assignment.members);
        let errors = by_cluster(&own, &groups);
        let order = ascending(&errors);
        let most = (k / PART).max((0..k).filter(|&c| groups.of_cluster(c).is_empty()).count());
        let mean = errors.iter().sum::<f64>() / k as f64;
        let low: Vec<usize> = order.iter().copied().take(most).filter(|&c| errors[c] < mean).collect();
        let high: Vec<usize> = order.iter().rev().copied().take(most).filter(|&c| errors[c] > mean).collect();
        let costs = self.costs(state, &groups, &low, &own)?;
        let gains = self.gains(&high, state.subspaces.all(), &groups, components, &errors)?;
        let mut moved = 0;
        for ((dissolved, _), (split, _, halves)) in
            costs.into_iter().zip(gains).take_while(|((_, cost), (_, gain, _))| gain > cost)
        {
            let [first, second] = halves.subspaces;
            state.replace(split, first);
            state.replace(dissolved, second);
            moved += 1;
        }
        Ok(moved)
    }

    /// What dissolving each cluster adds to the error, if none of them takes in the others' members; the least first.
    fn costs(&self, state: &State, groups: &Groups, low: &[usize], own: &[f32]) -> Result<Vec<(usize, f64)>> {
        let others: Vec<u32> = (0..state.subspaces.len() as u32).filter(|&c| !low.contains(&(c as usize))).collect();
        let samples: Vec<u32> = low.iter().flat_map(|&c| groups.of_cluster(c)).copied().collect();
        let nearest = assign::nearest(self.samples, self.head, &state.subspaces, &others, &samples)?;
        let mut nearest = nearest.into_iter();
        let cost = low.iter().map(|&cluster| {
            let group = groups.of_cluster(cluster).iter();
            (cluster, group.map(|&s| nearest.next().map_or(0.0, f64::from) - f64::from(own[s as usize])).sum())
        });
        let mut costs: Vec<(usize, f64)> = cost.collect();
        costs.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        Ok(costs)
    }

    /// What splitting each cluster takes from the error, and the halves; the most first.
    pub(crate) fn gains(
        &self,
        clusters: &[usize],
        subspaces: &[Subspace],
        groups: &Groups,
        components: &[usize],
        errors: &[f64],
    ) -> Result<Vec<(usize, f64, Halves)>> {
        let split = |&c: &usize| {
            let halves = halves(self.samples, &subspaces[c], groups.of_cluster(c), components[c])?;
            Ok(halves.map(|halves| (c, errors[c] - halves.error, halves)))
        };
        let split: Vec<Option<_>> = clusters.par_iter().map(split).collect::<Result<_>>()?;
        let mut gains: Vec<(usize, f64, Halves)> = split.into_iter().flatten().collect();
        gains.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        Ok(gains)
    }
}

/// Sums of the members' errors.
pub(crate) fn by_cluster(errors: &[f32], groups: &Groups) -> Vec<f64> {
    let sum = |cluster: usize| groups.of_cluster(cluster).iter().map(|&s| f64::from(errors[s as usize])).sum();
    (0..groups.len()).map(sum).collect()
}

/// Clusters, those of least error first.
fn ascending(errors: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..errors.len()).collect();
    order.sort_by(|&a, &b| errors[a].total_cmp(&errors[b]).then(a.cmp(&b)));
    order
}
