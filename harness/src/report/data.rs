//! What the page shows, and carries along as JSON for its charts.

use crate::bench::Group;
use crate::family::{distinction, in_order};
use crate::machine::Machine;
use crate::row::Row;
use serde::{Deserialize, Serialize, Serializer};

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Data {
    /// Where.
    pub machine: Machine,
    /// On which matrices.
    pub groups: Vec<Group>,
    /// The best models within a bound; empty where nobody searched.
    pub selections: Vec<Selection>,
}

/// The best model of each family within a bound.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Selection {
    /// Of which matrix.
    pub title: String,
    /// The bound in words: `squared error ≤ 1e-3`.
    pub bound: String,
    /// Best first.
    pub rows: Vec<Selected>,
}

/// The best model of a family within a bound, beside the best one of an exhaustive grid of parameters.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Selected {
    /// Transform and codec without parameters.
    pub family: String,
    /// The label that was selected.
    pub method: String,
    /// What it takes.
    pub bytes: u64,
    /// Its error.
    pub error: f64,
    /// Models that were made to find it.
    pub encodes: u64,
    /// The best label of the grid.
    pub grid_method: Option<String>,
    /// What that takes.
    pub grid_bytes: Option<u64>,
    /// What that leaves.
    pub grid_error: Option<f64>,
    /// By how much more than the grid's model it has of what is least: bytes under a bound of error, else error; %.
    pub gap_percent: Option<f64>,
    /// Models of the grid.
    pub grid_encodes: Option<u64>,
    /// Relighting one channel on one thread, median, ms.
    pub relight_ms: Option<f64>,
}

impl Data {
    /// Every family in the order of its first row, which decides its marker; then those that are only on pictures.
    pub(super) fn families(&self) -> Vec<String> {
        let rows = self.groups.iter().flat_map(|g| &g.rows).map(|row| row.family.as_str());
        let pictures = self.groups.iter().flat_map(|g| &g.pictures).flat_map(|p| &p.shown);
        in_order(rows.chain(pictures.map(|shown| shown.family.as_str())))
    }
}

/// A row, and what the page would otherwise have to work out of it.
#[derive(Serialize)]
pub(super) struct Labelled<'a> {
    #[serde(flatten)]
    row: &'a Row,
    /// What tells it from the others of its family.
    label: String,
    /// Multiplications and additions.
    flops: Option<u64>,
}

impl<'a> Labelled<'a> {
    pub(super) fn new(row: &'a Row) -> Labelled<'a> {
        let label = row.method.parse().map_or_else(|_| row.method.clone(), |label| distinction(&label));
        Labelled { row, label, flops: row.flops() }
    }
}

/// Rows as the page takes them.
pub(crate) fn labelled<S: Serializer>(rows: &[Row], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(rows.iter().map(Labelled::new))
}
