//! What a family came to, as it is printed and written.

use super::bound::Goal;
use super::search::Outcome;
use super::trial::Trial;
use serde::Serialize;

/// A line of select.csv; figures are empty where they do not exist.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    /// What all labels of the family begin with.
    pub family: String,
    /// The best model, or where none keeps the bound the nearest to it.
    pub method: String,
    /// Whether it keeps the bound.
    pub kept: bool,
    /// Why there is no model.
    pub reason: String,
    /// The bytes that count.
    pub bytes: Option<u64>,
    /// The error that counts.
    pub error: Option<f64>,
    /// The `.prt` file.
    pub file_bytes: Option<u64>,
    /// What relighting holds in memory.
    pub resident_bytes: Option<u64>,
    /// Relighting one channel on one thread, median, ms.
    pub relight_ms: Option<f64>,
    /// Models that were encoded, the whole matrix each.
    pub encodes: usize,
    /// What that took, measuring included, s.
    pub seconds: f64,
    /// Models of the grid.
    pub grid_points: usize,
    /// The best model of the whole grid, where that was encoded too.
    pub grid_method: Option<String>,
    /// Its bytes.
    pub grid_bytes: Option<u64>,
    /// Its error.
    pub grid_error: Option<f64>,
    /// Models of the grid that were encoded.
    pub grid_encodes: Option<usize>,
    /// What that takes, s.
    pub grid_seconds: Option<f64>,
    /// By how much more the search's model takes than the grid's of what is least: bytes under a bound of error, else error; %.
    pub gap_percent: Option<f64>,
    /// Where the search looked first.
    #[serde(skip)]
    pub estimates: Vec<Told>,
    /// For sorting.
    #[serde(skip)]
    pub trial: Option<Trial>,
}

/// An estimate as it is told.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Told {
    /// What all labels of the family begin with.
    pub family: String,
    /// Whose it is.
    pub by: &'static str,
    /// What it counts.
    pub of: &'static str,
    /// How many.
    pub estimate: usize,
    /// The model that was encoded for it.
    pub checked: Option<String>,
    /// The error of that.
    pub error: Option<f64>,
    /// Whether that keeps the bound.
    pub kept: Option<bool>,
    /// The value of the grid that the same configuration needed in truth.
    pub needed: Option<String>,
}

impl Row {
    /// The search's outcome, and the grid's beside it.
    pub(super) fn new(goal: &Goal, family: &str, outcome: &Outcome, grid: Option<&Outcome>) -> Row {
        let trial = outcome.trial();
        let kept = outcome.found.is_some();
        let method = trial.map_or_else(String::new, |trial| trial.label.clone());
        let of_grid = grid.and_then(|grid| grid.found.as_ref()).map(|found| &found.trial);
        let gap = of_grid.zip(trial.filter(|_| kept)).map(|(of_grid, trial)| 100.0 * goal.gap(trial, of_grid));
        let told = |estimate: &super::estimates::Estimate| Told {
            family: family.into(),
            by: estimate.by,
            of: estimate.of,
            estimate: estimate.number,
            checked: estimate.checked.as_ref().map(|trial| trial.label.clone()),
            error: estimate.checked.as_ref().map(|trial| goal.error(trial)),
            kept: estimate.enough,
            needed: estimate.needed.clone(),
        };
        Row {
            family: family.into(),
            method,
            kept,
            reason: outcome.reason.clone().unwrap_or_default(),
            bytes: trial.map(|trial| goal.bytes(trial)),
            error: trial.map(|trial| goal.error(trial)),
            file_bytes: trial.map(|trial| trial.file_bytes),
            resident_bytes: trial.map(|trial| trial.resident_bytes),
            relight_ms: trial.and_then(|trial| trial.relight_ms),
            encodes: outcome.encodes,
            seconds: outcome.seconds,
            grid_points: outcome.grid,
            grid_method: of_grid.map(|trial| trial.label.clone()),
            grid_bytes: of_grid.map(|trial| goal.bytes(trial)),
            grid_error: of_grid.map(|trial| goal.error(trial)),
            grid_encodes: grid.map(|grid| grid.encodes),
            grid_seconds: grid.map(|grid| grid.seconds),
            gap_percent: gap,
            estimates: outcome.estimates.iter().map(told).collect(),
            trial: trial.cloned(),
        }
    }
}
