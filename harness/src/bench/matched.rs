//! The best model of each family within so many bytes: what pictures are compared at.

use crate::family;
use crate::files;
use crate::measure::{Bench, Reference};
use crate::pictures::Candidate;
use crate::registry::families::{Kind, families};
use crate::report::{Selected, Selection};
use crate::row::Row;
use crate::select::{Bound, Goal, Norm, Search, Storage};

/// Encodes of each family: bisection of its first parameter, and little else.
const EFFORT: usize = 4;
/// The budget as a part of what the exact sparse matrix takes: where methods differ to the eye.
const SHARE: u64 = 20;

/// Whether a search pays: where a matrix takes seconds to compress, what was measured is shown instead.
pub(super) fn is_searched(kind: Kind) -> bool {
    !matches!(kind, Kind::Biscale | Kind::Terms)
}

/// Of each family that is not exact the row whose model is nearest to so many bytes in memory, in the order of the rows.
pub(super) fn nearest(rows: &[Row], budget: u64) -> Vec<&Row> {
    let distance = |row: &Row| (row.resident_bytes.unwrap_or(0).max(1) as f64 / budget.max(1) as f64).ln().abs();
    let mut chosen: Vec<&Row> = Vec::new();
    for row in rows.iter().filter(|row| row.is_ok() && row.error.is_some_and(|error| error > 0.0)) {
        match chosen.iter_mut().find(|other| other.family == row.family) {
            Some(other) if distance(row) < distance(other) => *other = row,
            Some(_) => {}
            None => chosen.push(row),
        }
    }
    chosen
}

/// Bytes in memory that pictures are compared at; none where the sparse matrix was not measured.
pub(super) fn budget(rows: &[Row]) -> Option<u64> {
    let csr = rows.iter().find(|row| row.is_ok() && row.method == "csr")?;
    Some(csr.resident_bytes? / SHARE)
}

/// The model of least error of each family within `budget`, families that have none left out; and the same as the report tells it.
pub(super) fn matched(
    bench: &Bench,
    reference: &Reference,
    title: &str,
    budget: u64,
) -> anyhow::Result<(Vec<Candidate>, Selection)> {
    let goal = Goal { bound: Bound::Bytes(budget), storage: Storage::Resident, norm: Norm::Coefficients };
    let mut selection = Selection { title: title.into(), bound: goal.text(), rows: Vec::new() };
    let mut candidates = Vec::new();
    if reference.square() == 0.0 {
        return Ok((candidates, selection));
    }
    let mut search = Search::new(bench, reference, goal)?;
    // What has no size cannot be matched.
    let sized = |kind| families(bench.registry, kind).into_iter().filter(|family| !family.axes.is_empty());
    for family in sized(Kind::of_matrix(reference.matrix())) {
        let outcome = search.best_of(&family, &family.base.parse()?, Some(EFFORT))?;
        let Some(found) = outcome.found else { continue };
        let trial = &found.trial;
        selection.rows.push(Selected {
            family: family::of(&trial.label),
            method: trial.label.clone(),
            bytes: trial.resident_bytes,
            error: trial.error,
            encodes: outcome.encodes as u64,
            relight_ms: trial.relight_ms,
            ..Selected::default()
        });
        let (family, file_bytes) = (family::of(&trial.label), trial.file_bytes);
        candidates.push(Candidate {
            family,
            file_bytes,
            compressed: files::prt_from_bytes(&found.file, bench.registry)?,
        });
    }
    selection.rows.sort_by(|a, b| a.error.total_cmp(&b.error));
    Ok((candidates, selection))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Status;

    #[test]
    fn of_each_inexact_family_the_model_nearest_to_the_budget_is_shown() {
        let row = |method: &str, family: &str, bytes, error| Row {
            method: method.into(),
            family: family.into(),
            status: Status::Ok,
            resident_bytes: Some(bytes),
            error: Some(error),
            ..Row::default()
        };
        let rows = [
            row("csr", "csr", 2000, 0.0),
            row("a", "vq", 40, 0.3),
            row("b", "pca", 300, 0.1),
            row("c", "vq", 90, 0.2),
            row("d", "vq", 160, 0.1),
            row("e", "f16", 100, 0.1).failed("no"),
        ];
        assert_eq!(budget(&rows), Some(100));
        assert_eq!(nearest(&rows, 100).iter().map(|row| row.method.as_str()).collect::<Vec<_>>(), ["c", "b"]);
        assert_eq!(budget(&rows[1..]), None, "without the sparse matrix there is no budget");
    }
}
