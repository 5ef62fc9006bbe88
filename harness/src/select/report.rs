//! What the command says: a table, one JSON object, select.csv and select.json.

use super::bound::{Bound, Goal};
use super::row::{Row, Told};
use super::search::SMALL_GRID;
use crate::machine::Machine;
use crate::number::{bytes, short};
use crate::{cache, files, table};
use anyhow::Result;
use serde::Serialize;
use std::cmp::Ordering;
use std::path::Path;

/// All families, the best first.
#[derive(Serialize)]
pub(super) struct Report {
    /// The matrix.
    title: String,
    /// The bound in words.
    bound: String,
    /// Which bytes count.
    bytes_of: &'static str,
    /// The label of the best model of all.
    winner: Option<String>,
    /// Models that were encoded, the whole matrix each: no part of a matrix is encoded instead.
    encodes: usize,
    /// Models of all grids together.
    grid_points: usize,
    /// Where a search looked first, and what it came to.
    estimates: Vec<Told>,
    /// A row for each family.
    rows: Vec<Row>,
    /// Where it was measured.
    machine: Machine,
    #[serde(skip)]
    goal: Goal,
}

/// A line of select.csv: where it was measured beside what.
#[derive(Serialize)]
struct Line<'a> {
    matrix: &'a str,
    bound: &'a str,
    family: &'a str,
    method: &'a str,
    kept: bool,
    reason: &'a str,
    bytes: Option<u64>,
    error: Option<f64>,
    relight_ms: Option<f64>,
    encodes: usize,
    seconds: f64,
    grid_points: usize,
    grid_method: Option<&'a str>,
    grid_bytes: Option<u64>,
    grid_error: Option<f64>,
    grid_encodes: Option<usize>,
    grid_seconds: Option<f64>,
    gap_percent: Option<f64>,
    machine: &'a str,
}

impl Report {
    /// Sorts the rows.
    pub(super) fn new(title: String, goal: Goal, mut rows: Vec<Row>, threads: usize) -> Report {
        rows.sort_by(|a, b| match (&a.trial, &b.trial) {
            (Some(x), Some(y)) => b.kept.cmp(&a.kept).then_with(|| goal.order(x, y)),
            (x, y) => {
                if x.is_some() {
                    Ordering::Less
                } else if y.is_some() {
                    Ordering::Greater
                } else {
                    Ordering::Equal
                }
            }
        });
        let winner = rows.first().filter(|row| row.kept).map(|row| row.method.clone());
        let estimates = rows.iter().flat_map(|row| row.estimates.clone()).collect();
        let [encodes, grid_points] =
            [rows.iter().map(|row| row.encodes).sum(), rows.iter().map(|row| row.grid_points).sum()];
        let (bound, bytes_of, machine) = (goal.text(), goal.place(), Machine::here(threads));
        Report { title, bound, bytes_of, winner, encodes, grid_points, estimates, rows, machine, goal }
    }

    /// The nearest miss, in words.
    pub(super) fn closest(&self) -> String {
        match self.rows.first().and_then(|row| Some((row, row.trial.as_ref()?))) {
            Some((row, trial)) => format!("the closest is {}, with {}", row.method, self.goal.reached(trial)),
            None => self.rows.first().map_or_else(|| "no method fits".into(), |row| row.reason.clone()),
        }
    }

    /// Writes select.csv and select.json into a folder.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let folder = cache::make(folder.into())?;
        files::write_beside(&folder.join("select.json"), &serde_json::to_vec_pretty(self)?)?;
        let (mut writer, machine) = (csv::Writer::from_writer(Vec::new()), self.machine.line());
        self.rows.iter().try_for_each(|row| writer.serialize(self.line(row, &machine)))?;
        Ok(files::write_beside(&folder.join("select.csv"), &writer.into_inner()?)?)
    }

    fn line<'a>(&'a self, row: &'a Row, machine: &'a str) -> Line<'a> {
        Line {
            matrix: &self.title,
            bound: &self.bound,
            family: &row.family,
            method: &row.method,
            kept: row.kept,
            reason: &row.reason,
            bytes: row.bytes,
            error: row.error,
            relight_ms: row.relight_ms,
            encodes: row.encodes,
            seconds: row.seconds,
            grid_points: row.grid_points,
            grid_method: row.grid_method.as_deref(),
            grid_bytes: row.grid_bytes,
            grid_error: row.grid_error,
            grid_encodes: row.grid_encodes,
            grid_seconds: row.grid_seconds,
            gap_percent: row.gap_percent,
            machine,
        }
    }

    /// The table and what is told below it.
    pub(super) fn text(&self, output: Option<&Path>) -> String {
        let mut parts = vec![format!("{}\n{}", self.title, self.bound), self.table()];
        if self.rows.iter().any(|row| row.grid_encodes.is_some()) {
            parts.push(self.comparison());
        }
        parts.extend(self.rows.iter().filter(|row| !row.kept).map(|row| self.miss(row)));
        parts.extend(self.estimates.iter().map(told));
        parts.push(self.counts());
        if let (Some(winner), Some(output)) = (&self.winner, output) {
            parts.push(format!("{winner} is in {}", output.display()));
        }
        parts.join("\n")
    }

    fn table(&self) -> String {
        let titles = ["method", self.bytes_of, "error", "relight ms", "encodes", "of grid", "s"];
        let rows = self.rows.iter().map(|row| {
            let figure = |value: Option<String>| value.filter(|_| row.kept).unwrap_or_else(|| "-".into());
            let method = if row.kept { row.method.clone() } else { format!("{} (none)", row.family) };
            let figures = [row.bytes.map(bytes), row.error.map(short), row.relight_ms.map(short)].map(figure);
            let counts = [row.encodes.to_string(), row.grid_points.to_string(), short(row.seconds)];
            [&[method], &figures[..], &counts].concat()
        });
        table::aligned(&titles, rows)
    }

    /// The whole grids beside the searches.
    fn comparison(&self) -> String {
        let least = if matches!(self.goal.bound, Bound::Error(_)) { "bytes" } else { "error" };
        let more = format!("more {least}");
        let titles = ["the best of the whole grid", self.bytes_of, "error", "encodes", "s", &more];
        let compared = self.rows.iter().filter(|row| row.grid_encodes.is_some()).map(|row| {
            let text = |value: Option<String>| value.unwrap_or_else(|| "-".into());
            let method = row.grid_method.clone().unwrap_or_else(|| format!("{} (none)", row.family));
            let gap = row.gap_percent.map(|gap| format!("{gap:.1} %"));
            let encodes = row.grid_encodes.map(|encodes| encodes.to_string());
            let figures =
                [row.grid_bytes.map(bytes), row.grid_error.map(short), encodes, row.grid_seconds.map(short), gap];
            [&[method], &figures.map(text)[..]].concat()
        });
        format!("\n{}", table::aligned(&titles, compared))
    }

    fn miss(&self, row: &Row) -> String {
        match &row.trial {
            Some(trial) => format!("{}: the closest is {}, with {}", row.family, row.method, self.goal.reached(trial)),
            None => format!("{}: {}", row.family, row.reason),
        }
    }

    fn counts(&self) -> String {
        let large: Vec<&Row> = self.rows.iter().filter(|row| row.grid_points >= SMALL_GRID).collect();
        let [of, all]: [usize; 2] =
            [large.iter().map(|row| row.encodes).sum(), large.iter().map(|row| row.grid_points).sum()];
        format!(
            "{} encodes of the whole matrix; of families with {SMALL_GRID} models and more {of}, for grids of {all}",
            self.encodes
        )
    }
}

fn told(estimate: &Told) -> String {
    let Told { family, by, of, estimate: number, checked, error, kept, needed } = estimate;
    let checked = match (checked, error, kept) {
        (Some(label), Some(error), Some(kept)) => {
            let within = if *kept { "within the bound" } else { "not within the bound" };
            format!("{label} has an error of {}, {within}", short(*error))
        }
        _ => "not encoded".into(),
    };
    let needed = needed.as_ref().map_or(String::new(), |needed| format!("; {needed} in truth"));
    format!("{family}: {number} {of} by {by}{needed}: {checked}")
}
