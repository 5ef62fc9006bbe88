//! Sweeps of the generalised LBG algorithm.

use crate::assign::{self, Assignment};
use crate::head::Head;
use crate::refit::refit;
use crate::subspaces::{Subspace, Subspaces};
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Progress, Result};

/// The search for clusters.
pub(crate) struct Search<'a> {
    pub(crate) samples: &'a Samples<'a>,
    pub(crate) head: &'a Head,
    pub(crate) progress: &'a dyn Progress,
}

/// Where the search stands.
#[derive(Clone)]
pub(crate) struct State {
    /// As of the last fit.
    pub(crate) subspaces: Subspaces,
    /// To those subspaces.
    pub(crate) assignment: Assignment,
    /// How much nearer to anything each subspace may have come since the assignment.
    drifts: Vec<f32>,
    /// Clusters whose members have changed since the fit.
    changed: Vec<bool>,
}

impl State {
    /// Another subspace in the place of one.
    pub(crate) fn replace(&mut self, cluster: usize, subspace: Subspace) {
        self.subspaces.set(cluster, subspace);
        self.drifts[cluster] = f32::INFINITY;
    }
}

impl Search<'_> {
    /// Samples with the nearest of some subspaces.
    pub(crate) fn begin(&self, subspaces: Subspaces) -> Result<State> {
        let assignment = assign::first(self.samples, self.head, &subspaces, self.progress)?;
        let (drifts, changed) = (vec![0.0; subspaces.len()], vec![true; subspaces.len()]);
        self.progress.advance(1)?;
        Ok(State { subspaces, assignment, drifts, changed })
    }

    /// Up to so many sweeps with `components` in each cluster; ends early where no sample moves, and no subspace that would.
    pub(crate) fn sweeps(&self, state: &mut State, components: &[usize], sweeps: usize) -> Result<()> {
        for _ in 0..sweeps {
            // A minimum of all samples alone need not be one of two clusters in one place and none in another.
            if self.sweep(state, components)? == 0 && self.shift_and_assign(state, components)? == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Fits subspaces to their members and assigns samples to the nearest; how many have moved.
    pub(crate) fn sweep(&self, state: &mut State, components: &[usize]) -> Result<usize> {
        self.fit(state, components)?;
        let mut moved = self.assign(state)?;
        if self.anyone_empty(state) {
            moved += self.shift_and_assign(state, components)?;
        }
        self.progress.advance(1)?;
        Ok(moved)
    }

    /// How many samples have moved since subspaces did.
    fn shift_and_assign(&self, state: &mut State, components: &[usize]) -> Result<usize> {
        if self.shift(state, components)? == 0 { Ok(0) } else { self.assign(state) }
    }

    fn fit(&self, state: &mut State, components: &[usize]) -> Result<()> {
        let groups = Groups::of(&state.assignment.members, state.subspaces.len());
        let next = refit(self.samples, &groups, &state.changed, components, &state.subspaces)?;
        for (drift, (old, new)) in state.drifts.iter_mut().zip(state.subspaces.all().iter().zip(next.all())) {
            *drift += drift_between(old, new);
        }
        state.subspaces = next;
        state.changed.fill(false);
        Ok(())
    }

    fn assign(&self, state: &mut State) -> Result<usize> {
        let (samples, head, progress) = (self.samples, self.head, self.progress);
        let next = assign::again(samples, head, &state.subspaces, &state.drifts, &state.assignment, progress)?;
        let mut moved = 0;
        for (&old, &new) in state.assignment.members.iter().zip(&next.members).filter(|(old, new)| old != new) {
            state.changed[old as usize] = true;
            state.changed[new as usize] = true;
            moved += 1;
        }
        state.assignment = next;
        state.drifts.fill(0.0);
        Ok(moved)
    }

    fn anyone_empty(&self, state: &State) -> bool {
        let groups = Groups::of(&state.assignment.members, state.subspaces.len());
        (0..groups.len()).any(|cluster| groups.of_cluster(cluster).is_empty())
    }
}

/// How far the means are apart; anything where components have changed, and rounding included.
fn drift_between(old: &Subspace, new: &Subspace) -> f32 {
    if old == new {
        0.0
    } else if old.components.is_empty() && new.components.is_empty() {
        let square: f64 = old.mean.iter().zip(&new.mean).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
        square.sqrt() as f32 * (1.0 + 4.0 * f32::EPSILON)
    } else {
        f32::INFINITY
    }
}
