//! What has been tried of one family.

use super::bound::Goal;
use super::grid::{Grid, Point};
use super::trial::{Attempt, Trial};

/// Labels of a family, and what came of them.
pub(super) struct Log<'a> {
    /// The family's models.
    pub(super) grid: &'a Grid,
    /// What is looked for.
    pub(super) goal: Goal,
    /// In the order of the search.
    pub(super) entries: Vec<Entry>,
}

/// A label that was tried.
pub(super) struct Entry {
    /// Where it is on the grid, if it is.
    pub(super) point: Option<Point>,
    /// What came of it.
    pub(super) attempt: Attempt,
}

/// By how much a bound is missed clearly, as a logarithm: by more than rounding of stored numbers changes an error.
const CLEARLY: f64 = 0.1;

impl Entry {
    /// Its figures.
    pub(super) fn trial(&self) -> Option<&Trial> {
        match &self.attempt {
            Attempt::Tried(trial) => Some(trial),
            Attempt::Failed(_) => None,
        }
    }

    /// Where it is on the grid, and its figures.
    fn placed(&self) -> Option<(&Point, &Trial)> {
        self.point.as_ref().zip(self.trial())
    }
}

impl Log<'_> {
    fn at(&self, point: &[usize]) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.point.as_deref() == Some(point))
    }

    /// Points that keep the bound.
    fn kept(&self) -> impl Iterator<Item = (&Point, &Trial)> {
        self.entries.iter().filter_map(Entry::placed).filter(|(_, trial)| self.goal.keeps(trial))
    }

    /// Whether the bound is kept at a point, where that was tried.
    pub(super) fn known(&self, point: &[usize]) -> Option<bool> {
        self.at(point).map(|entry| entry.trial().is_some_and(|trial| self.goal.keeps(trial)))
    }

    /// Whether there is no model at a point that was tried.
    pub(super) fn is_missing(&self, point: &[usize]) -> bool {
        self.at(point).is_some_and(|entry| entry.trial().is_none())
    }

    /// The figures of a point that was tried.
    pub(super) fn trial_at(&self, point: &[usize]) -> Option<&Trial> {
        self.at(point)?.trial()
    }

    /// Whether a point cannot keep the bound, as a larger model of its configuration does not; or does not in other numbers, which are not what
    /// stands in the way where they keep it in a larger model still.
    pub(super) fn is_ruled_out(&self, point: &[usize]) -> bool {
        let upwards = self.goal.is_kept_by_large_models();
        self.entries.iter().filter_map(Entry::placed).any(|(other, trial)| {
            let nearer = if upwards { other[0] >= point[0] } else { other[0] <= point[0] };
            if !nearer || self.goal.keeps(trial) || !self.grid.is_same_but_stored(point, other) {
                return false;
            }
            let is_kept_above = || self.kept().any(|(kept, _)| kept[1..] == other[1..]);
            point[1..] == other[1..] || (upwards && self.goal.excess(trial) > CLEARLY && is_kept_above())
        })
    }

    /// The best point of the grid that keeps the bound.
    pub(super) fn best_point(&self) -> Option<Point> {
        self.kept().min_by(|a, b| self.goal.order(a.1, b.1)).map(|(point, _)| point.clone())
    }

    /// The value along the first axis that the configuration of a point needs, as far as it is known.
    pub(super) fn needed(&self, of: &[usize]) -> Option<&str> {
        let kept = self.kept().map(|(point, _)| point).filter(|point| point[1..] == of[1..]);
        let upwards = self.goal.is_kept_by_large_models();
        let nearest = if upwards { kept.min_by_key(|p| p[0]) } else { kept.max_by_key(|p| p[0]) };
        nearest.map(|point| self.grid.size_of(point))
    }
}
