//! The three phases of clustered tensor approximation (Tsai and Shih 2006, §5.2).

mod assign;
mod basis;
mod elbg;
mod lines;
mod products;
mod shared;
mod slabs;

use crate::params::Start;
use assign::{Assignment, Candidates, Stacked, assign};
use basis::Basis;
pub(crate) use basis::Ranks;
use basis::fit;
use elbg::elbg;
use lines::lines;
use ndarray::Array2;
use prt_transfer::groups::Groups;
use prt_transfer::{Progress, Result};
use rayon::prelude::*;
use shared::Shared;
pub(crate) use slabs::Slabs;
use slabs::square;

/// What the search is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) clusters: usize,
    pub(crate) view: usize,
    pub(crate) ranks: Ranks,
    /// Clusters of each sample.
    pub(crate) members: usize,
    pub(crate) sweeps: usize,
    pub(crate) refine: usize,
    pub(crate) start: Start,
    pub(crate) seed: u64,
}

/// A sweep of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Which phase it belongs to.
    pub phase: Phase,
    /// Rank of the samples in it.
    pub rank: usize,
    /// Relative squared error behind it, in the coordinates of the phase.
    pub error: f64,
    /// Samples that it moved to another cluster.
    pub moved: usize,
}

/// A phase of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Samples move to the cluster that keeps most of them (§5.2.3), in the light coordinates that hold nearly everything.
    Clustering,
    /// Bases are fitted to the clusters, the view basis too (§5.2.4).
    Approximation,
    /// Samples move into several clusters.
    Sharing,
}

/// What the search found, in the coordinates of the samples.
pub(crate) struct Found {
    /// U_viewᵀ: R_view x responses.
    pub(crate) view: Array2<f32>,
    pub(crate) bases: Vec<Basis>,
    /// Clusters of each sample.
    pub(crate) memberships: usize,
    /// The clusters of each sample, sample after sample.
    pub(crate) members: Vec<u32>,
    /// For each membership the weights of the cluster.
    pub(crate) weights: Vec<Vec<f32>>,
    /// Squared error.
    pub(crate) square: f64,
    pub(crate) history: Vec<Sweep>,
    /// Whether all phases ended by themselves.
    pub(crate) converged: bool,
}

/// Light coordinates of the clustering phase may leave out this part of the energy.
const LEFT_OUT: f64 = 2e-3;
/// Samples that decide on those coordinates.
const DECIDING: usize = 4096;
/// A phase ends with a sweep that lowers the error by less than this part.
const LITTLE: f64 = 2e-4;
/// Sweeps of the alternation in each fit of the clustering phase.
const INNER: usize = 1;

/// Bases and clusters for a tensor of samples x responses x lights.
pub(crate) fn search(tensor: &Slabs, plan: &Plan, progress: &dyn Progress) -> Result<Found> {
    progress.start("tensor approximation", (2 + plan.sweeps + 2 * plan.refine) as u64);
    let whole: f64 = tensor.squares().iter().sum();
    let view = first_view(tensor, plan.view)?;
    let reduced = tensor.with_views(view.view());
    let head = light_head(&reduced)?;
    let mut search = Search { plan, progress, whole, history: Vec::new(), converged: true };
    let mut state = match &head {
        Some(head) => search.clustered(&reduced.with_lights(head.view()))?,
        None => search.clustered(&reduced)?,
    };
    if let Some(head) = &head {
        state.bases.iter_mut().for_each(|basis| basis.light = products::times(basis.light.view(), head.view()));
    }
    let (view, reduced) = search.approximated(tensor, reduced, view, &mut state)?;
    let shared = if plan.members > 1 && state.bases.len() > 1 {
        search.shared(&reduced, state)?
    } else {
        alone(&reduced, state)
    };
    let Search { history, converged, .. } = search;
    let Shared { bases, memberships, members, weights, kept } = shared;
    let square = (whole - kept).max(0.0);
    Ok(Found { view, bases, memberships, members, weights, square, history, converged })
}

/// U_viewᵀ with all other bases the identity (Eq. 14); the identity itself where the rank is not below the number of responses.
fn first_view(tensor: &Slabs, rank: usize) -> Result<Array2<f32>> {
    if rank >= tensor.views {
        return Ok(Array2::eye(tensor.views));
    }
    Ok(products::leading_of_gram(&tensor.gram_of_views(), rank)?.single())
}

/// Light coordinates (a row each) that hold nearly all of some of the samples; `None` where they would hardly be fewer.
fn light_head(slabs: &Slabs) -> Result<Option<Array2<f32>>> {
    let leading = products::leading(slabs.some(DECIDING).by_light(), slabs.lights)?;
    let whole: f64 = leading.squares.iter().sum();
    let mut left = whole;
    let needed = leading.squares.iter().take_while(|square| {
        let more = left > LEFT_OUT * whole;
        left -= **square;
        more
    });
    let size = needed.count().next_multiple_of(8);
    let fewer = 4 * size <= 3 * slabs.lights && size <= leading.squares.len();
    Ok(fewer.then(|| leading.single().slice(ndarray::s![..size, ..]).to_owned()))
}

/// Where the search stands.
struct State {
    members: Vec<u32>,
    bases: Vec<Basis>,
}

struct Search<'a> {
    plan: &'a Plan,
    progress: &'a dyn Progress,
    /// Σ T².
    whole: f64,
    history: Vec<Sweep>,
    converged: bool,
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
    fn clustered(&mut self, slabs: &Slabs) -> Result<State> {
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
            refit(slabs, &mut state, &changed, ranks, INNER)?;
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
        refit(slabs, state, changed, ranks, INNER)?;
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

    /// The approximation phase: all bases are refitted in turn, the dual ones last. `reduced` is the tensor in the first view basis.
    fn approximated(
        &mut self,
        tensor: &Slabs,
        reduced: Slabs<'static>,
        view: Array2<f32>,
        state: &mut State,
    ) -> Result<(Array2<f32>, Slabs<'static>)> {
        let (mut view, mut reduced, all) = (view, reduced, vec![true; state.bases.len()]);
        let (mut before, mut converged) = (f64::INFINITY, false);
        for sweep in 0..self.plan.refine {
            if sweep > 0 && view.nrows() < tensor.views {
                view = refitted_view(tensor, &reduced, state, view.nrows())?;
                reduced = tensor.with_views(view.view());
            }
            let kept = refit(&reduced, state, &all, self.plan.ranks, 1)?;
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
    fn shared(&mut self, reduced: &Slabs, state: State) -> Result<Shared> {
        let (rank, mut converged) = (self.plan.ranks.sample, false);
        let mut shared = Shared::new(reduced, state.bases, &state.members, self.plan.members)?;
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
fn alone(reduced: &Slabs, state: State) -> Shared {
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

/// Fits the bases of clusters that have changed; the sum of squares that these keep.
fn refit(slabs: &Slabs, state: &mut State, changed: &[bool], ranks: Ranks, sweeps: usize) -> Result<f64> {
    let groups = Groups::of(&state.members, state.bases.len());
    let fitted: Vec<Option<(Basis, f64)>> = state
        .bases
        .par_iter()
        .enumerate()
        .map(|(cluster, basis)| {
            let group = groups.of_cluster(cluster);
            if !changed[cluster] || group.is_empty() {
                return Ok(None);
            }
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
