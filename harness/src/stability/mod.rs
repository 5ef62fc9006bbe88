//! `prt stability`: where methods fail, on matrices that leave the case they were made for step by step.
//!
//! A sweep is one file ([`study::Sweep`]) and one word in a study; a study is one file and one line in [`STUDIES`]. [`eigensolvers`]
//! are no methods but what methods are made of: a study of their own.

pub mod atlas;
mod biclustering;
pub mod columns;
pub mod eigensolvers;
pub mod outcome;
pub mod scatter;
pub mod study;
pub mod values;
pub mod vertices;

use crate::cache::About;
use crate::compare::compare;
use crate::interrupt::Unseen;
use crate::labels::BASELINE;
use crate::machine::Machine;
use crate::measure::{Bench, Pools, Reference};
use crate::progress::Steps;
use crate::row::Row;
use crate::timing::Budget;
use crate::{cache, compute, files, interrupt, labels, number, registry, terminal};
use anyhow::ensure;
use clap::Args;
use clap::builder::PossibleValuesParser;
use outcome::Outcome;
use prt_transfer::{Error, Result, TransferMatrix};
use std::collections::HashSet;
use std::path::PathBuf;
use std::time::Duration;
use study::{Study, Sweep};

/// Every study.
pub static STUDIES: [Study; 1] = [biclustering::STUDY];

/// Time for each relighting figure: short, since there are hundreds; methods are timed in turn.
const BUDGET: Duration = Duration::from_millis(15);

/// Vertices of the scene where nobody says otherwise.
const VERTICES: u32 = 300;

/// Arguments of `prt stability`.
#[derive(Args, Debug)]
#[command(
    after_help = "Without a study: the atlas of failure, every known way in which a method fails, by the paper's form and by ours, with the bounds that ours keep.\n\nExamples:\n  prt stability\n  prt stability --sweep lobes --sweep start\n  prt stability biclustering\n  prt stability biclustering --sweep values --method csr --method compact\n  prt stability eigensolvers --method krylov --sweep zero-tail"
)]
pub struct Stability {
    /// Which methods' weaknesses in depth; none = the atlas of all
    #[arg(value_name = "STUDY", value_parser = PossibleValuesParser::new(STUDIES.iter().map(|s| s.name).chain([eigensolvers::NAME])))]
    pub study: Option<String>,
    /// A method (of eigensolvers: a solver), instead of the usual ones; may be repeated. `compact` is always measured: other
    /// methods are compared with it
    #[arg(long = "method", value_name = "LABEL")]
    pub methods: Vec<String>,
    /// Only this sweep (of eigensolvers: this spectrum; of the atlas: this part or case); may be repeated
    #[arg(long = "sweep", value_name = "SWEEP")]
    pub sweeps: Vec<String>,
    /// Vertices of the scene that every sweep starts from, about [default: 300]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub vertices: Option<u32>,
    /// Folder for the sweeps as .csv, .svg and .png
    #[arg(long, value_name = "DIR", default_value = "prt-stability")]
    pub out: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Stability, threads: usize) -> anyhow::Result<()> {
    let study = match arguments.study.as_deref() {
        None => {
            ensure!(
                arguments.methods.is_empty() && arguments.vertices.is_none(),
                "--method, --vertices: of a study; the atlas has cases of its own"
            );
            return atlas::run::run(&arguments.sweeps, &arguments.out, threads);
        }
        Some(eigensolvers::NAME) => return eigensolvers::run(arguments, threads),
        Some(study) => find(study)?,
    };
    let registry = registry::registry();
    let sweeps = chosen(study, &arguments.sweeps)?;
    let methods = labels::with_baseline(&registry, &arguments.methods, study.methods, BASELINE)?;
    let out = cache::make(arguments.out.clone())?;
    let (machine, pools) = (Machine::here(threads), Pools::new(threads)?);
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(BUDGET) };
    let base = compute::precompute(
        study.scene,
        Some(arguments.vertices.unwrap_or(VERTICES) as usize),
        &(study.spec)(),
        &Unseen,
    )?
    .matrix;
    let steps = Steps::new(sweeps.iter().map(|sweep| (sweep.values)(&base).len()).sum::<usize>() * methods.len());
    let subject = subject(study, &base);
    let mut measured = false;
    let names: Vec<&str> = sweeps.iter().map(|sweep| sweep.name).collect();
    for (finished, sweep) in sweeps.iter().enumerate() {
        let outcomes = outcomes(&bench, sweep, &base, &methods, &steps);
        let outcomes = interrupt::keeping(outcomes, || interrupt::parts(&names, finished, "sweeps", &out))?;
        let path = |extension| out.join(format!("{}.{extension}", sweep.name));
        let chart = outcome::panels(sweep, &subject, &outcomes, &methods);
        files::write_beside(&path("csv"), &outcome::csv(sweep, &outcomes, &machine)?)?;
        files::write_beside(&path("svg"), chart.svg(Some(&machine)).as_bytes())?;
        files::write_beside(&path("png"), &chart.png(&machine)?)?;
        steps.suspend(|| terminal::say(outcome::table(sweep, &outcomes)))?;
        measured |= outcomes.iter().any(|outcome| outcome.row.is_ok());
    }
    steps.finish();
    // One failure is what a sweep is for; nothing but failures is a failure.
    ensure!(measured, "no method could be measured; {} says why", out.display());
    let machine = machine.line();
    terminal::say(format!("\n{subject}\n{LEGEND}\n{machine}\nsweeps as .csv, .svg and .png are in {}", out.display()))
}

/// What the columns of the table mean.
const LEGEND: &str = "B/nnz, file, peak B: bytes in memory, in the file and at the peak of encoding, by non-zero\n\
FLOPs %: of 2·nnz; x1 free: the same without multiplications by 1 and -1; enc s/M: encoding a million non-zeros, s\n\
relight: time on one thread, compact = 1; error: Σ(T-T̃)²/ΣT², 0 is exact";

fn find(name: &str) -> Result<&'static Study> {
    let known = || STUDIES.iter().map(|s| s.name).collect::<Vec<_>>().join(", ");
    STUDIES.iter().find(|s| s.name == name).ok_or_else(|| Error::Unknown {
        what: "study",
        name: name.into(),
        known: known(),
    })
}

/// The sweeps that were asked for; all of them where none was.
fn chosen(study: &'static Study, names: &[String]) -> Result<Vec<&'static Sweep>> {
    if names.is_empty() {
        return Ok(study.sweeps.iter().collect());
    }
    let known = || study.sweeps.iter().map(|s| s.name).collect::<Vec<_>>().join(", ");
    let find = |name: &String| {
        let unknown = || Error::Unknown { what: "sweep", name: name.clone(), known: known() };
        study.sweeps.iter().find(|sweep| sweep.name == name).ok_or_else(unknown)
    };
    names.iter().map(find).collect()
}

/// Scene, signal, basis, shape and non-zeros of the base.
fn subject(study: &Study, base: &TransferMatrix) -> String {
    let (shape, non_zeros) = (base.shape(), number::count(base.non_zeros() as u64));
    let size = format!("{} x {} x {}", shape.samples, shape.responses, shape.lights);
    format!("{} · {} · {} · {size} · {non_zeros} non-zeros", study.scene, (study.spec)().signal, base.basis())
}

/// Every method at every value of a sweep. What fails is an outcome with its reason.
pub fn outcomes(
    bench: &Bench,
    sweep: &Sweep,
    base: &TransferMatrix,
    methods: &[String],
    steps: &Steps,
) -> anyhow::Result<Vec<Outcome>> {
    let mut outcomes = Vec::new();
    for value in (sweep.values)(base) {
        interrupt::check()?;
        let matrix = (sweep.matrix)(base, value)?;
        let (about, distinct) = (About::of(&matrix, 0, 0.0), distinct(&matrix));
        let reference = bench.pools.everywhere(|| Reference::new(matrix))?;
        let subject = about.describe(Row { scene: format!("{} {value}", sweep.name), ..Row::default() });
        let rows = compare(bench, &subject, &reference, methods, steps)?;
        let baseline_ms = rows.iter().find(|row| row.method == BASELINE).and_then(|row| row.relight_1_ms);
        outcomes.extend(rows.into_iter().map(|row| Outcome { value, distinct, row, baseline_ms }));
    }
    Ok(outcomes)
}

fn distinct(matrix: &TransferMatrix) -> usize {
    let mut found = HashSet::new();
    for row in 0..matrix.rows() {
        found.extend(matrix.row(row).non_zeros().map(|(_, value)| value.to_bits()));
    }
    found.len()
}

#[cfg(test)]
mod tests;
