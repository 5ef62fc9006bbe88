//! Several methods on one matrix, relit in turn so that their times can be divided by each other.

use crate::cache::safe;
use crate::files;
use crate::interrupt::Unseen;
use crate::measure::{Bench, Reference};
use crate::progress::Steps;
use crate::row::Row;
use anyhow::Result;
use prt_transfer::Compressed;

/// Measures every method on a matrix that `subject` describes; what fails is a row with its reason. The one-thread relight times
/// of one channel are those of [`Bench::race`]. The compressed files are forgotten.
pub fn compare(
    bench: &Bench,
    subject: &Row,
    reference: &Reference,
    methods: &[String],
    steps: &Steps,
) -> Result<Vec<Row>> {
    let folder = tempfile::tempdir()?;
    let path = |method: &str| folder.path().join(format!("{}.prt", safe(method)));
    let measure = |method: &String| -> Result<Row> {
        steps.show(&format!("{} {method}", subject.scene));
        let row = bench.attempt(bench.planned(subject, method), reference, &path(method), &Unseen)?;
        steps.done(1);
        Ok(row)
    };
    let mut rows: Vec<Row> = methods.iter().map(measure).collect::<Result<_>>()?;
    let mut finished: Vec<&mut Row> = rows.iter_mut().filter(|row| row.is_ok()).collect();
    let runners = finished.iter().map(|row| Ok(files::read_prt(&path(&row.method), bench.registry)?));
    let runners = runners.collect::<Result<Vec<Compressed>>>()?;
    for (row, timing) in finished.iter_mut().zip(bench.race(&runners, reference)?) {
        row.relight_1_ms = Some(timing.median_ms);
        row.relight_1_spread_ms = Some(timing.spread_ms);
        row.runs = row.runs.min(timing.runs);
    }
    Ok(rows)
}
