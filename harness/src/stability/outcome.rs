//! What one method cost at one value of a sweep's parameter.

use super::study::Sweep;
use crate::charts::panels::{Panel, Panels};
use crate::machine::Machine;
use crate::number;
use crate::row::Row;
use crate::table::aligned;

/// One method at one value.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Of the sweep's parameter.
    pub value: f64,
    /// Distinct non-zero values of the matrix.
    pub distinct: usize,
    /// The measurement.
    pub row: Row,
    /// Relighting by the baseline in the same run, one thread, ms; where it was measured.
    pub baseline_ms: Option<f64>,
}

/// A figure of an outcome.
pub struct Figure {
    /// Column of the CSV.
    pub name: &'static str,
    /// Quantity and unit, over a panel.
    pub title: &'static str,
    /// The same on the terminal.
    pub short: &'static str,
    /// The figure.
    pub of: fn(&Outcome) -> Option<f64>,
}

/// What the chart has panels for. Every one is by non-zero or relative, so that matrices of any size are on one scale.
pub const DRAWN: [Figure; 6] = [
    figure("resident_bytes_per_nnz", "in memory, bytes a non-zero", "B/nnz", |o| {
        o.by_non_zero(o.row.resident_bytes? as f64)
    }),
    figure("flops_percent", "FLOPs, % of 2·nnz", "FLOPs %", |o| o.by_non_zero(50.0 * o.row.flops()? as f64)),
    figure("encode_s_per_million_nnz", "encoding, s a million non-zeros", "enc s/M", |o| {
        o.by_non_zero(1e6 * o.row.encode_s?)
    }),
    figure("file_bytes_per_nnz", "file, bytes a non-zero", "file", |o| o.by_non_zero(o.row.file_bytes? as f64)),
    figure("flops_value_aware_percent", "FLOPs with x1 free, % of 2·nnz", "x1 free", |o| {
        o.by_non_zero(50.0 * o.row.flops_value_aware? as f64)
    }),
    figure("relight_of_compact", "relight time, one thread, compact = 1", "relight", |o| {
        Some(o.row.relight_1_ms? / o.baseline_ms?)
    }),
];

/// What is told besides.
pub const TOLD: [Figure; 2] = [
    figure("error", "Σ(T-T̃)²/ΣT²", "error", |o| o.row.error),
    figure("peak_encode_bytes_per_nnz", "peak memory of encoding, bytes a non-zero", "peak B", |o| {
        o.by_non_zero(o.row.peak_encode_bytes? as f64)
    }),
];

const fn figure(
    name: &'static str,
    title: &'static str,
    short: &'static str,
    of: fn(&Outcome) -> Option<f64>,
) -> Figure {
    Figure { name, title, short, of }
}

impl Outcome {
    fn by_non_zero(&self, figure: f64) -> Option<f64> {
        (self.row.non_zeros > 0).then(|| figure / self.row.non_zeros as f64)
    }
}

/// One line for each outcome, with the machine in every line.
pub fn csv(sweep: &Sweep, outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head =
        [sweep.name, "method", "status", "reason", "samples", "responses", "lights", "non_zeros", "distinct_values"];
    let figures = || DRAWN.iter().chain(&TOLD);
    writer.write_record(head.into_iter().chain(figures().map(|f| f.name)).chain(["relight_1_ms", "machine"]))?;
    let text = |figure: Option<f64>| figure.map_or(String::new(), |f| f.to_string());
    for outcome in outcomes {
        let Row { method, reason, samples, responses, lights, non_zeros, .. } = &outcome.row;
        let status = if outcome.row.is_ok() { "ok" } else { "failed" };
        let sizes = [samples, responses, lights, non_zeros, &outcome.distinct].map(usize::to_string);
        let head = [outcome.value.to_string(), method.clone(), status.into(), reason.clone()].into_iter().chain(sizes);
        let figures = figures().map(|f| text((f.of)(outcome)));
        writer.write_record(head.chain(figures).chain([text(outcome.row.relight_1_ms), machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}

/// The chart: a panel for each of [`DRAWN`], a line for each method in their order.
pub fn panels(sweep: &Sweep, subject: &str, outcomes: &[Outcome], methods: &[String]) -> Panels {
    let by = |method: &String| outcomes.iter().filter(|o| o.row.method == *method).collect::<Vec<_>>();
    // A failure is none; what is measured and has no such figure is drawn as a gap, not as a failure.
    let value = |figure: &Figure, o: &Outcome| o.row.is_ok().then(|| (figure.of)(o).unwrap_or(f64::NAN));
    let marks: Vec<String> = methods.first().map_or(Vec::new(), by).into_iter().map(|o| o.value.to_string()).collect();
    let panel = |figure: &Figure| Panel {
        heading: vec![figure.title.into()],
        parameter: sweep.parameter.into(),
        marks: marks.clone(),
        values: methods.iter().map(|m| by(m).into_iter().map(|o| value(figure, o)).collect()).collect(),
    };
    Panels {
        title: sweep.title.into(),
        subject: subject.into(),
        methods: methods.to_vec(),
        panels: DRAWN.iter().map(panel).collect(),
    }
}

/// Title, a line for each outcome, and the reasons of those that failed.
pub fn table(sweep: &Sweep, outcomes: &[Outcome]) -> String {
    let figures = || DRAWN.iter().chain(&TOLD);
    let titles: Vec<&str> =
        [sweep.name, "method", "nnz", "distinct"].into_iter().chain(figures().map(|f| f.short)).collect();
    let mut previous = None;
    let lines = outcomes.iter().map(|outcome| {
        // Once for all methods.
        let value = if previous.replace(outcome.value) == Some(outcome.value) {
            String::new()
        } else {
            outcome.value.to_string()
        };
        let sizes = [outcome.row.non_zeros, outcome.distinct].map(|n| number::count(n as u64));
        let figures = figures().enumerate().map(|(i, figure)| match (outcome.row.is_ok(), i) {
            (false, 0) => "failed".into(),
            _ => (figure.of)(outcome).map_or_else(|| "-".into(), number::short),
        });
        [value, outcome.row.method.clone()].into_iter().chain(sizes).chain(figures).collect()
    });
    let lines: Vec<Vec<String>> = lines.collect();
    let failed = outcomes.iter().filter(|o| !o.row.is_ok());
    let failed = failed.map(|o| format!("{} at {}: {}", o.row.method, o.value, o.row.reason));
    let parts = [format!("\n{}", sweep.title), aligned(&titles, lines.into_iter())];
    parts.into_iter().chain(failed).collect::<Vec<_>>().join("\n")
}
