//! Error against time of four ways to a Tucker decomposition.

use super::tensors::{TENSORS, Tensor};
use crate::charts::curves::{Curves, Dot, Plane};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::machine::Machine;
use crate::number;
use crate::table::aligned;
use crate::timing::Timing;
use ndarray::ArrayD;
use prt_tensor::tucker::{Algorithm, Decomposer, Ranks, Tucker, TuckerParams};

pub(super) const FIGURE: Figure = Figure { name: "decompositions", table: None, draw };

/// As samples x responses x lobes of a cluster are.
const SIZE: [usize; 3] = [400, 16, 300];
/// Of the first mode and of the last.
const RANKS: [usize; 5] = [4, 8, 16, 32, 64];
/// In which they are timed and drawn.
const ALGORITHMS: [(Algorithm, &str); 4] = [
    (Algorithm::Hosvd, "HOSVD"),
    (Algorithm::Sequential, "ST-HOSVD"),
    (Algorithm::Hooi, "HOOI"),
    (Algorithm::Randomised, "randomised ST-HOSVD"),
];
/// Points of one rank stand close to each other: these alone say which.
const LABELLED: Algorithm = Algorithm::Hooi;

/// An algorithm on an array.
pub(super) struct Outcome {
    tensor: &'static Tensor,
    /// Place in [`ALGORITHMS`].
    algorithm: usize,
    rank: usize,
    result: Result<(Tucker, Timing), String>,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    drawing(stage, SIZE, &RANKS)
}

/// The figure of arrays of this size.
pub(super) fn drawing(stage: &Stage, size: [usize; 3], ranks: &[usize]) -> anyhow::Result<Drawing> {
    stage.steps.more(TENSORS.len() * ranks.len() * ALGORITHMS.len());
    let mut outcomes = Vec::new();
    for tensor in &TENSORS {
        let array = tensor.of(size);
        for (&rank, algorithm) in ranks.iter().flat_map(|rank| (0..ALGORITHMS.len()).map(move |a| (rank, a))) {
            stage.steps.show(&format!("{}, {}, rank {rank}", tensor.name, ALGORITHMS[algorithm].1));
            let result = timed(stage, &array, &params(algorithm, rank)).map_err(|error| format!("{error:#}"));
            outcomes.push(Outcome { tensor, algorithm, rank, result });
            stage.steps.done(1);
        }
    }
    Ok(Drawing {
        text: table(&outcomes),
        tables: vec![("", csv(&outcomes, &stage.machine)?)],
        chart: Some(chart(size, &outcomes)),
        measured: outcomes.iter().any(|o| o.result.is_ok()),
        ..Drawing::default()
    })
}

/// The middle mode is short: it has half the rank, up to three quarters of 16.
fn ranks(rank: usize) -> [usize; 3] {
    [rank, (rank / 2).clamp(2, 12), rank]
}

fn params(algorithm: usize, rank: usize) -> TuckerParams {
    TuckerParams {
        algorithm: ALGORITHMS[algorithm].0,
        ranks: Ranks::Given(ranks(rank).into()),
        ..TuckerParams::default()
    }
}

fn timed(stage: &Stage, array: &ArrayD<f32>, params: &TuckerParams) -> anyhow::Result<(Tucker, Timing)> {
    let decomposer = Decomposer::new(params.clone())?;
    let (pools, budget, mut found) = (stage.bench.pools, stage.bench.budget, None);
    let mut once = || decomposer.decompose(array.view(), &Unseen).map(|tucker| found = Some(tucker));
    let timing = pools.everywhere(|| budget.time(&mut once))?;
    Ok((found.expect("it ran"), timing))
}

fn chart(size: [usize; 3], outcomes: &[Outcome]) -> Curves {
    let dot = |o: &Outcome| {
        let (tucker, timing) = o.result.as_ref().ok()?;
        let label = if ALGORITHMS[o.algorithm].0 == LABELLED { o.rank.to_string() } else { String::new() };
        Some(Dot { x: timing.median_ms / 1e3, y: tucker.relative_error(), label })
    };
    let plane = |tensor: &Tensor| {
        let of = |a: usize| outcomes.iter().filter(move |o| o.tensor.name == tensor.name && o.algorithm == a);
        Plane {
            upwards: format!("{}: relative squared error", tensor.name),
            across: "seconds on all threads (median)".into(),
            curves: (0..ALGORITHMS.len()).map(|a| of(a).filter_map(dot).collect()).collect(),
            references: Vec::new(),
        }
    };
    let formulas: Vec<String> = TENSORS.iter().map(|t| format!("{}: {}", t.name, t.formula)).collect();
    let [a, b, c] = size;
    Curves {
        title: "Four ways to a Tucker decomposition: error and time".into(),
        subject: format!("{a} x {b} x {c} · {}", formulas.join(" · ")),
        names: ALGORITHMS.map(|(_, name)| name.to_string()).into(),
        remark: Some("numbers: R of ranks R x min(R/2, 12) x R".into()),
        apart: true,
        planes: TENSORS.iter().map(plane).collect(),
    }
}

fn table(outcomes: &[Outcome]) -> String {
    let titles = ["array", "R", "algorithm", "ranks", "numbers", "error", "ms", "sweeps"];
    let rows = outcomes.iter().map(|o| {
        let head = [o.tensor.name.into(), o.rank.to_string(), ALGORITHMS[o.algorithm].1.into()];
        let figures = match &o.result {
            Err(_) => ["-", "-", "failed", "-", "-"].map(String::from),
            Ok((tucker, timing)) => [
                shown(tucker.ranks()),
                number::count(tucker.numbers() as u64),
                format!("{:.4e}", tucker.relative_error()),
                number::short(timing.median_ms),
                sweeps(tucker),
            ],
        };
        head.into_iter().chain(figures).collect()
    });
    let failed = outcomes.iter().filter_map(|o| Some((o, o.result.as_ref().err()?)));
    let failed = failed.map(|(o, reason)| format!("{}, {}: {reason}", o.tensor.name, ALGORITHMS[o.algorithm].1));
    let table = aligned(&titles, rows);
    ["\nTucker decompositions".into(), table].into_iter().chain(failed).collect::<Vec<_>>().join("\n")
}

fn shown(ranks: &[usize]) -> String {
    ranks.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
}

/// Of HOOI, marked where they did not end by themselves.
fn sweeps(tucker: &Tucker) -> String {
    let report = tucker.report();
    let mark = if report.converged { "" } else { ", not converged" };
    if report.sweeps.is_empty() { "-".into() } else { format!("{}{mark}", report.sweeps.len()) }
}

fn csv(outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "array",
        "formula",
        "rank",
        "algorithm",
        "status",
        "reason",
        "ranks",
        "numbers",
        "error",
        "seconds",
        "spread_s",
        "runs",
        "sweeps",
        "converged",
        "machine",
    ])?;
    for o in outcomes {
        let head = [o.tensor.name, o.tensor.formula, &o.rank.to_string(), ALGORITHMS[o.algorithm].1].map(String::from);
        let figures = match &o.result {
            Err(reason) => ["failed", reason, "", "", "", "", "", "", "", ""].map(String::from),
            Ok((tucker, timing)) => [
                "ok".into(),
                String::new(),
                shown(tucker.ranks()),
                tucker.numbers().to_string(),
                tucker.relative_error().to_string(),
                (timing.median_ms / 1e3).to_string(),
                (timing.spread_ms / 1e3).to_string(),
                timing.runs.to_string(),
                tucker.report().sweeps.len().to_string(),
                tucker.report().converged.to_string(),
            ],
        };
        writer.write_record(head.into_iter().chain(figures).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
