//! The phases, one after the other.

use super::assign::{Assignment, Candidates, Stacked, assign};
use super::basis::{Basis, Ranks, fit};
use super::elbg::elbg;
use super::lines::lines;
use super::products;
use super::shared::Shared;
use super::slabs::Slabs;
use super::{Phase, Plan, Sweep};
use crate::params::Start;
use ndarray::Array2;
use prt_transfer::groups::Groups;
use prt_transfer::samples::square;
use prt_transfer::{Progress, Result};
use rayon::prelude::*;

/// A phase ends with a sweep that lowers the error by less than this part.
const LITTLE: f64 = 2e-4;

/// Sweeps of the alternation in each fit of the clustering phase.
const INNER: usize = 1;

/// Where the search stands.
pub(super) struct State {
    pub(super) members: Vec<u32>,
    pub(super) bases: Vec<Basis>,
}

pub(super) struct Search<'a> {
    pub(super) plan: &'a Plan,
    pub(super) progress: &'a dyn Progress,
    /// Σ T².
    pub(super) whole: f64,
    pub(super) history: Vec<Sweep>,
    pub(super) converged: bool,
}

impl Search<'_> {
    fn push(&mut self, phase: Phase, rank: usize, kept: f64, moved: usize) {
        let error = if self.whole > 0.0 { (1.0 - kept / self.whole).max(0.0) } else { 0.0 };
        self.history.push(Sweep { phase, rank, error, moved });
    }

    /// Relative squared error behind the last sweep.
    fn error(&self) -> f64 {
        self.history.last().map_or(f64::INFINITY, |sweep| sweep.error)
    }

    /// The initialization and the clustering phase.
    pub(super) fn clustered(&mut self, slabs: &Slabs) -> Result<State> {
        let Plan { clusters, ranks, start, seed, sweeps, .. } = *self.plan;
        let members = match start {
            Start::Lines => lines(slabs, clusters, seed, self.progress)?,
            Start::Elbg => elbg(slabs, clusters, seed, self.progress)?,
        };
        let clusters = members.iter().max().map_or(1, |last| *last as usize + 1);
        let nothing = Basis::nothing(slabs.lights);
        let mut state = State { members, bases: vec![nothing; clusters] };
        let mut changed = vec![true; clusters];
        if start == Start::Lines && sweeps > 0 {
            for rank in std::iter::successors(Some(2), |rank| Some(2 * rank)).take_while(|rank| *rank < ranks.sample) {
                self.sweep(slabs, &mut state, &mut changed, Ranks { sample: rank, ..ranks }, &mut None)?;
                changed.fill(true);
            }
        }
        let (mut converged, mut candidates) = (sweeps == 0, None);
        for sweep in 0..sweeps {
            if sweep + 1 == sweeps {
                candidates = None;
            }
            let (before, whole) = (self.error(), candidates.is_none());
            let moved = self.sweep(slabs, &mut state, &mut changed, ranks, &mut candidates)?;
            self.progress.advance(1)?;
            converged = moved == 0 || before - self.error() <= LITTLE * self.error();
            if converged && (whole || candidates.as_ref().is_some_and(|c| c.are_all(clusters))) {
                break;
            }
            if converged {
                // Among the candidates: once more among all.
                candidates = None;
            }
        }
        self.converged &= converged;
        if sweeps == 0 {
            self.refit(slabs, &mut state, &changed, ranks, INNER)?;
        }
        Ok(state)
    }

    /// Fits the clusters that have changed and moves samples; how many have moved.
    /// With `candidates` they are all that is tried; without, all clusters are, and the best become candidates.
    fn sweep(
        &mut self,
        slabs: &Slabs,
        state: &mut State,
        changed: &mut [bool],
        ranks: Ranks,
        candidates: &mut Option<Candidates>,
    ) -> Result<usize> {
        self.refit(slabs, state, changed, ranks, INNER)?;
        let whole: Vec<Array2<f32>> = state.bases.par_iter().map(|basis| basis.whole(slabs.views)).collect();
        let stacked = Stacked::of(&whole);
        let mut next = match candidates {
            Some(candidates) => candidates.assign(slabs, &stacked),
            None => {
                let (next, found) = assign(slabs, &stacked);
                *candidates = Some(found);
                next
            }
        };
        changed.fill(false);
        fill_empty(slabs, &mut next, state.bases.len());
        let mut moved = 0;
        for (&old, &new) in state.members.iter().zip(&next.members).filter(|(old, new)| old != new) {
            changed[old as usize] = true;
            changed[new as usize] = true;
            moved += 1;
        }
        self.push(Phase::Clustering, ranks.sample, next.kept.iter().sum(), moved);
        state.members = next.members;
        Ok(moved)
    }

    /// Fits the bases of clusters that have changed; the sum of squares that these keep.
    fn refit(&self, slabs: &Slabs, state: &mut State, changed: &[bool], ranks: Ranks, sweeps: usize) -> Result<f64> {
        let (groups, progress) = (Groups::of(&state.members, state.bases.len()), self.progress);
        let fitted: Vec<Option<(Basis, f64)>> = state
            .bases
            .par_iter()
            .enumerate()
            .map(|(cluster, basis)| {
                let group = groups.of_cluster(cluster);
                if !changed[cluster] || group.is_empty() {
                    return Ok(None);
                }
                progress.advance(0)?;
                // A light basis of a lower rank is one that was fitted to fewer dimensions or members.
                let most = ranks.light.min(slabs.lights);
                let start = (basis.light.nrows() == most).then(|| basis.light.view());
                let members = slabs.gathered(group);
                fit(&members, start, ranks, sweeps).map(Some)
            })
            .collect::<Result<_>>()?;
        let mut kept = 0.0;
        for (basis, (next, of_next)) in state.bases.iter_mut().zip(fitted).filter_map(|(b, n)| n.map(|n| (b, n))) {
            kept += of_next;
            *basis = next;
        }
        Ok(kept)
    }

    /// The approximation phase: all bases are refitted in turn, the dual ones last. `reduced` is the tensor in the first view basis.
    pub(super) fn approximated<'t>(
        &mut self,
        tensor: &'t Slabs,
        reduced: Slabs<'t>,
        view: Array2<f32>,
        state: &mut State,
    ) -> Result<(Array2<f32>, Slabs<'t>)> {
        let (mut view, mut reduced, all) = (view, reduced, vec![true; state.bases.len()]);
        let (mut before, mut converged) = (f64::INFINITY, false);
        for sweep in 0..self.plan.refine {
            if sweep > 0 && view.nrows() < tensor.views {
                view = refitted_view(tensor, &reduced, state, view.nrows())?;
                reduced = tensor.in_views(view.view());
            }
            let kept = self.refit(&reduced, state, &all, self.plan.ranks, 1)?;
            self.push(Phase::Approximation, self.plan.ranks.sample, kept, 0);
            self.progress.advance(1)?;
            converged = before - self.error() <= LITTLE * self.error();
            if converged {
                break;
            }
            before = self.error();
        }
        self.converged &= converged;
        Ok((view, reduced))
    }

    /// Samples move into several clusters, and bases with them.
    pub(super) fn shared(&mut self, reduced: &Slabs, state: State) -> Result<Shared> {
        let (rank, mut converged) = (self.plan.ranks.sample, false);
        let mut shared = Shared::new(reduced, state.bases, &state.members, self.plan.members);
        self.push(Phase::Sharing, rank, shared.kept, 0);
        for _ in 0..self.plan.refine {
            let (before, members) = (self.error(), shared.members.clone());
            shared.sweep(reduced, self.plan.ranks)?;
            let moved = members.iter().zip(&shared.members).filter(|(a, b)| a != b).count();
            self.push(Phase::Sharing, rank, shared.kept, moved);
            self.progress.advance(1)?;
            converged = before - self.error() <= LITTLE * self.error();
            if converged {
                break;
            }
        }
        self.converged &= converged;
        Ok(shared)
    }
}

/// Every sample in its one cluster.
pub(super) fn alone(reduced: &Slabs, state: State) -> Shared {
    let State { members, bases } = state;
    let groups = Groups::of(&members, bases.len());
    let (mut weights, mut kept) = (vec![Vec::new(); members.len()], 0.0);
    for (cluster, basis) in bases.iter().enumerate() {
        let group = groups.of_cluster(cluster);
        let of_members = basis.weights(&reduced.gathered(group));
        for (row, &sample) in of_members.outer_iter().zip(group) {
            kept += row.iter().map(|w| f64::from(*w).powi(2)).sum::<f64>();
            weights[sample as usize] = row.to_vec();
        }
    }
    Shared { bases, memberships: 1, members, weights, kept }
}

/// An empty cluster takes the worse half of the members of the one that leaves most.
fn fill_empty(slabs: &Slabs, next: &mut Assignment, clusters: usize) {
    let groups = Groups::of(&next.members, clusters);
    let empty: Vec<usize> = (0..clusters).filter(|&k| groups.of_cluster(k).is_empty()).collect();
    if empty.is_empty() {
        return;
    }
    let left: Vec<f64> = (0..slabs.count).map(|i| (square(slabs.row(i)) - next.kept[i]).max(0.0)).collect();
    let of = |k: usize| groups.of_cluster(k).iter().map(|&i| left[i as usize]).sum::<f64>();
    let mut worst: Vec<(f64, usize)> =
        (0..clusters).filter(|&k| groups.of_cluster(k).len() > 1).map(|k| (of(k), k)).collect();
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (cluster, (left_out, from)) in empty.into_iter().zip(worst) {
        if left_out <= 0.0 {
            break;
        }
        let mut group = groups.of_cluster(from).to_vec();
        group.sort_by(|a, b| left[*b as usize].total_cmp(&left[*a as usize]));
        group[..group.len() / 2].iter().for_each(|&sample| next.members[sample as usize] = cluster as u32);
    }
}

/// U_viewᵀ from the tensor in the light and vertex bases of all clusters (Eq. 19).
fn refitted_view(tensor: &Slabs, reduced: &Slabs, state: &State, rank: usize) -> Result<Array2<f32>> {
    let groups = Groups::of(&state.members, state.bases.len());
    let grams: Vec<Array2<f64>> = state
        .bases
        .par_iter()
        .enumerate()
        .map(|(cluster, basis)| {
            let group = groups.of_cluster(cluster);
            basis.gram_of_views(&tensor.gathered(group), &reduced.gathered(group))
        })
        .collect();
    let sum = grams.into_iter().fold(Array2::zeros((tensor.views, tensor.views)), |sum, gram| sum + gram);
    Ok(products::leading_of_gram(&sum, rank)?.single())
}
