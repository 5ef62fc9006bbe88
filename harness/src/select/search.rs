//! The best model of a family within a bound.

use super::bound::{Bound, Goal, Norm};
use super::estimates::{Estimate, Spectra};
use super::grid::{Grid, set};
use super::hunt::Hunt;
use super::trial::{Trial, Trials};
use crate::measure::{Bench, Reference};
use crate::registry::families::Family;
use anyhow::{Result, ensure};
use prt_transfer::Label;
use std::path::Path;

/// Searches one matrix. What was tried once is known to every later search.
pub struct Search<'a> {
    trials: Trials<'a>,
    spectra: Spectra,
    goal: Goal,
}

/// A model that keeps the bound.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its figures, all of them of what was read back from the file.
    pub trial: Trial,
    /// The file.
    pub file: Vec<u8>,
}

/// What a search of a family came to.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The best model; none where no model keeps the bound.
    pub found: Option<Found>,
    /// Where none does, the one that comes nearest to it.
    pub closest: Option<Trial>,
    /// Where no model exists, why.
    pub reason: Option<String>,
    /// Models that were encoded, the whole matrix each.
    pub encodes: usize,
    /// Models of the family's grid.
    pub grid: usize,
    /// Where the search looked first, and what came of it.
    pub estimates: Vec<Estimate>,
    /// All trials together, s.
    pub seconds: f64,
}

impl Outcome {
    /// The best model, or the nearest to the bound.
    pub fn trial(&self) -> Option<&Trial> {
        self.found.as_ref().map(|found| &found.trial).or(self.closest.as_ref())
    }
}

/// Encodes of a search: a tenth of what the whole grid takes.
const SHARE: usize = 10;
/// A smaller grid is bisected, which takes more than a tenth.
pub(super) const SMALL_GRID: usize = 20;
/// Encodes of a small grid at most.
const SMALL_GRID_ENCODES: usize = 10;

impl<'a> Search<'a> {
    /// Nothing is known yet.
    ///
    /// # Errors
    /// A matrix without elements; an error over the sphere of what has no place on it.
    pub fn new(bench: &'a Bench<'a>, reference: &'a Reference, goal: Goal) -> Result<Search<'a>> {
        ensure!(reference.whole().squares > 0.0, "the matrix is zero: there is nothing to approximate");
        ensure!(
            goal.norm != Norm::Sphere || reference.metric().is_known(),
            "an error over the sphere needs a light basis that has a place on it, not {}",
            reference.matrix().basis()
        );
        let timed = matches!(goal.bound, Bound::Relight(_));
        Ok(Search { trials: Trials::new(bench, reference, timed), spectra: Spectra::default(), goal })
    }

    /// Looks for another bound, and keeps what is known of the matrix.
    pub fn set_bound(&mut self, bound: Bound) {
        self.goal.bound = bound;
        self.trials.set_timed(matches!(bound, Bound::Relight(_)));
    }

    /// Begins with what a file knows of the matrix from an earlier search, and adds to it whatever is tried.
    ///
    /// # Errors
    /// A file that cannot be read and written.
    pub fn keep_in(&mut self, path: &Path) -> Result<()> {
        self.trials.keep_in(path)
    }

    /// What is looked for.
    pub fn goal(&self) -> &Goal {
        &self.goal
    }

    /// The best model of `family`, whose labels begin with `base`, with at most `effort` encodes.
    pub fn best_of(&mut self, family: &Family, base: &Label, effort: Option<usize>) -> Result<Outcome> {
        let grid = self.grid(family, base);
        let allowance = effort.unwrap_or(match grid.len() {
            0..SMALL_GRID => SMALL_GRID_ENCODES,
            points => points / SHARE,
        });
        let mut hunt = Hunt::new(&mut self.trials, &grid, self.goal, allowance.max(1));
        hunt.run(family, &mut self.spectra)?;
        hunt.finish()
    }

    /// The best model of `family` by trying every point of its grid.
    pub fn best_of_all(&mut self, family: &Family, base: &Label, each: &mut dyn FnMut()) -> Result<Outcome> {
        let grid = self.grid(family, base);
        let mut hunt = Hunt::new(&mut self.trials, &grid, self.goal, usize::MAX);
        for point in grid.points() {
            hunt.attempt(&point);
            each();
        }
        hunt.finish()
    }

    /// How many models the grid of a family has.
    pub fn grid_of(&self, family: &Family, base: &Label) -> usize {
        self.grid(family, base).len()
    }

    /// The grid, in the norm of the bound where the codec minimises its error in one.
    fn grid(&self, family: &Family, base: &Label) -> Grid {
        let mut base = base.clone();
        let codecs = self.trials.registry().codecs();
        let has_norm = |name: &str| codecs.iter().any(|c| c.name == name && c.fields.iter().any(|f| f.name == "norm"));
        if self.goal.norm == Norm::Sphere && has_norm(&base.codec.name) && !Grid::gives(&base, "norm") {
            let parameter = format!("{}:norm", base.codec.name);
            set(&mut base, &parameter, "radiance");
        }
        Grid::new(family, base, self.trials.reference().matrix().shape())
    }
}
