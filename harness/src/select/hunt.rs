//! The search of one family: bisection along the axis of size, halving over everything else, and a last look between the points.

use super::bound::{Bound, Goal};
use super::estimates::{Estimate, Spectra};
use super::grid::{Grid, Point};
use super::models::Models;
use super::search::{Found, Outcome};
use super::trial::{Attempt, Trial, Trials};
use super::tried::{Entry, Log};
use crate::registry::families::{Counts, Family};
use anyhow::Result;
use prt_transfer::Label;
use std::collections::HashSet;

/// What is known while one family is searched.
pub(super) struct Hunt<'a, 'b> {
    trials: &'a mut Trials<'b>,
    /// What was tried.
    pub(super) log: Log<'a>,
    /// Encodes that are left.
    pub(super) left: usize,
    /// Each is one encode.
    labels: HashSet<String>,
    /// The best model so far, or the nearest to the bound, with its file where that is new.
    best: Option<(Trial, Option<Vec<u8>>)>,
    estimates: Vec<Estimate>,
}

impl<'a, 'b> Hunt<'a, 'b> {
    /// Nothing has been tried.
    pub(super) fn new(trials: &'a mut Trials<'b>, grid: &'a Grid, goal: Goal, allowance: usize) -> Hunt<'a, 'b> {
        let log = Log { grid, goal, entries: Vec::new() };
        Hunt { trials, log, left: allowance, labels: HashSet::new(), best: None, estimates: Vec::new() }
    }

    /// Searches, within the encodes that are left.
    pub(super) fn run(&mut self, family: &Family, spectra: &mut Spectra) -> Result<()> {
        let grid = self.log.grid;
        let start = grid.start(self.trials.reference().matrix().shape());
        if grid.is_single() {
            self.attempt(&start);
            return Ok(());
        }
        // One encode is for the bound as a parameter.
        let kept_back = usize::from(self.parameter(family).is_some() && self.left > 2);
        self.left -= kept_back;
        self.begin(family, spectra, &start)?;
        if grid.len() > grid.sizes() {
            self.halve(&start);
        }
        if let Some(best) = self.log.best_point() {
            self.bisect(&best, Some(best[0]));
        }
        let between = self.between();
        self.left += kept_back;
        self.by_parameter(family, &start);
        self.conclude(&start, between);
        Ok(())
    }

    /// Bisects the configuration of the start from what the numbers of the matrix say, and tries every estimate.
    fn begin(&mut self, family: &Family, spectra: &mut Spectra, start: &[usize]) -> Result<()> {
        let Log { grid, goal, .. } = self.log;
        let (registry, reference) = (self.trials.registry(), self.trials.reference());
        self.estimates = spectra.guesses(family.counts, registry, &grid.label(start), reference, &goal)?;
        let places: Vec<usize> = self.estimates.iter().map(|e| grid.place_of(e.number as f64)).collect();
        // Where the error is bounded the first is exact, or the bound is a value itself; else they are the ends of a bracket.
        let guess = match (family.counts, goal.bound) {
            (Counts::Bound, Bound::Error(bound)) => Some(grid.place_of(bound)),
            (_, Bound::Error(_)) => places.first().copied(),
            _ => None,
        };
        if guess.is_some() {
            self.bisect(start, guess);
        }
        for (i, place) in places.into_iter().enumerate() {
            let point = [&[place], &start[1..]].concat();
            self.attempt(&point);
            self.estimates[i].checked = self.log.trial_at(&point).cloned();
        }
        self.bisect(start, guess);
        Ok(())
    }

    /// What estimates come to: what their configuration needed, in whole numbers where that is known.
    fn conclude(&mut self, start: &[usize], between: Option<usize>) {
        let alike = self.log.best_point().is_some_and(|best| self.log.grid.is_same_but_stored(&best, start));
        let needed = between.filter(|_| alike).map(|number| number.to_string());
        let needed = needed.or_else(|| self.log.needed(start).map(String::from));
        for estimate in &mut self.estimates {
            estimate.enough = estimate.checked.as_ref().map(|trial| self.log.goal.keeps(trial));
            estimate.needed.clone_from(&needed);
        }
    }

    /// Tries a point, where it was not tried and encodes are left. Whether the bound is kept there; none where nothing is known.
    pub(super) fn attempt(&mut self, point: &[usize]) -> Option<bool> {
        if self.log.known(point).is_none() {
            self.attempt_label(&self.log.grid.label(point), Some(point.to_vec()))?;
        }
        self.log.known(point)
    }

    /// As [`Hunt::attempt`], any label.
    pub(super) fn attempt_label(&mut self, label: &Label, point: Option<Point>) -> Option<bool> {
        if self.left == 0 {
            return None;
        }
        let (attempt, file) = self.trials.attempt(label);
        if self.trials.is_stopped() {
            self.left = 0;
            return None;
        }
        let entry = Entry { point, attempt };
        let name = entry.trial().map_or_else(|| label.to_string(), |trial| trial.label.clone());
        // A label that was tried by another way is no encode.
        if self.labels.insert(name) {
            self.left -= 1;
        }
        let goal = &self.log.goal;
        let kept = entry.trial().is_some_and(|trial| goal.keeps(trial));
        if let Some(trial) = entry.trial()
            && self.best.as_ref().is_none_or(|(best, _)| goal.order(trial, best).is_lt())
        {
            self.best = Some((trial.clone(), file));
        }
        self.log.entries.push(entry);
        Some(kept)
    }

    /// What is expected of the points that were not tried.
    pub(super) fn models(&self) -> Option<Models> {
        let kept = self.best.as_ref().filter(|(trial, _)| self.log.goal.keeps(trial));
        Models::of(&self.log, kept.map(|(trial, _)| self.log.goal.price(trial)))
    }

    /// The outcome: the best model as it is read back from its file.
    pub(super) fn finish(self) -> Result<Outcome> {
        let Hunt { trials, log: Log { grid, goal, entries }, labels, mut best, estimates, .. } = self;
        trials.kept()?;
        let mut tried: Vec<&Trial> = entries.iter().filter_map(Entry::trial).collect();
        tried.sort_by(|a, b| goal.order(a, b));
        let seconds = tried.iter().map(|trial| trial.seconds).sum();
        let mut outcome = Outcome { encodes: labels.len(), grid: grid.len(), estimates, seconds, ..Outcome::default() };
        for trial in tried {
            let file = best.take().filter(|(best, _)| best == trial).and_then(|(_, file)| file);
            let file = file.map_or_else(|| trials.file(&trial.label), Ok)?;
            let mut read = Trial { seconds: trial.seconds, ..trials.read_back(&file)? };
            if let Bound::Relight(_) = goal.bound {
                // A timing is not the same twice: the one that decided stays.
                read.relight_ms = trial.relight_ms;
            }
            if goal.keeps(&read) {
                outcome.found = Some(Found { trial: read, file });
                return Ok(outcome);
            }
            let missed = !goal.keeps(trial);
            outcome.closest = outcome.closest.or(Some(read));
            if missed {
                break;
            }
        }
        outcome.reason = entries.iter().find_map(|entry| match &entry.attempt {
            Attempt::Failed(why) if outcome.closest.is_none() => Some(why.clone()),
            _ => None,
        });
        Ok(outcome)
    }
}
