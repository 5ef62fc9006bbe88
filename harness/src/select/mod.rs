//! `prt select`: the smallest model that keeps an error, or the best within so many bytes or ms.
//!
//! [`Search`] is the engine: [`Search::best_of`] finds the best model of one [`Family`] with far fewer encodes
//! than its grid has models. Along the first axis of a family models grow and errors fall: there the bound is bisected, beginning where the numbers
//! of the matrix say (tail energy, MDL, Gavish and Donoho). Everything else is halved: what was tried tells what to expect of the rest, the half that promises less is
//! dropped, and the rest is tried where it promises most.

mod bisection;
mod bound;
mod estimates;
mod grid;
mod halving;
mod hunt;
mod ledger;
mod models;
mod narrow;
mod projection;
mod report;
mod row;
mod search;
mod subject;
mod surrogate;
mod trial;
mod tried;

pub use bound::{Bound, Goal, Norm, Storage};
pub use estimates::Estimate;
pub use search::{Found, Outcome, Search};
pub use trial::Trial;

use crate::measure::{Bench, Pools, Reference};
use crate::progress::{Bar, Steps};
use crate::registry::families::{self, Family, Kind};
use crate::registry::registry;
use crate::scenes::Up;
use crate::signal::Signal;
use crate::timing::Budget;
use crate::{cache, files, interrupt, terminal};
use anyhow::{Result, bail};
use clap::{ArgGroup, Args};
use prt_transfer::{Label, LightBasis, Registry, ResponseBasis};
use report::Report;
use row::Row;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `prt select`.
#[derive(Args, Debug)]
#[command(
    group = ArgGroup::new("bound").required(true),
    after_help = "Examples:\n  prt select teapot.npz --max-error 1e-3 -o teapot.prt\n  prt select bunny.ply --up y --signal glossy --max-bytes 500kB --method cpca --method pca -o bunny.prt\n  prt select teapot --signal diffuse --max-relight 0.2 --size resident --json\n\nA family is searched by bisection along the parameter by which its models grow and by halving over its others, with at most a tenth of the encodes of its grid; --compare-grid shows what the whole grid finds."
)]
pub struct Select {
    /// A transfer matrix (.npz, .npy, .mtx), a built-in scene, a mesh (.ply, .obj) or a shape of a built-in world (WORLD/SHAPE)
    #[arg(value_name = "MATRIX|SCENE")]
    pub subject: String,
    /// Keep an error Σ(T-T̃)²/ΣT² of at most E, in the fewest bytes
    #[arg(long, value_name = "E", group = "bound", value_parser = bound::positive)]
    pub max_error: Option<f64>,
    /// Take at most so many bytes, with the least error: 200kB, 1.5MB, 4096
    #[arg(long, value_name = "BYTES", group = "bound", value_parser = crate::number::parse_bytes)]
    pub max_bytes: Option<u64>,
    /// Relight one channel on one thread in at most so many ms, with the least error; a time is measured, and not the same twice
    #[arg(long, value_name = "MS", group = "bound", value_parser = bound::positive)]
    pub max_relight: Option<f64>,
    /// Which bytes count: of the file, or resident in memory while relighting
    #[arg(long, value_name = "WHERE", default_value = "file")]
    pub size: Storage,
    /// Which error counts: of coefficients, or over the sphere
    #[arg(long, value_name = "NORM", default_value = "coefficients")]
    pub norm: Norm,
    /// A family of methods, instead of all that fit, such as cpca; parameters that are given stay as they are, such as cpca:mode=iterative; may be repeated
    #[arg(long = "method", value_name = "LABEL")]
    pub methods: Vec<String>,
    /// Encode at most so many models of a family [default: a tenth of its grid]
    #[arg(long, value_name = "N", value_parser = crate::precompute::count(1, 100_000), conflicts_with = "full_grid")]
    pub effort: Option<usize>,
    /// Encode every model of every grid instead
    #[arg(long, conflicts_with = "compare_grid")]
    pub full_grid: bool,
    /// Search, and encode every model of every grid too, to compare what they find
    #[arg(long)]
    pub compare_grid: bool,
    /// Of a matrix that does not say: what the rows of a sample stand for, their number or irradiance, local:8, exit:24, terms:16:BRDF
    #[arg(long, value_name = "RESPONSES")]
    pub responses: Option<ResponseBasis>,
    /// What the columns stand for: of a matrix that does not say, or of a scene [default of a scene: as of prt bench]
    #[arg(long, value_name = "BASIS")]
    pub basis: Option<LightBasis>,
    /// What is precomputed of a scene or mesh
    #[arg(long)]
    pub signal: Option<Signal>,
    /// Vertices of a built-in scene, about [default: 400]; a mesh keeps its own
    #[arg(long, value_name = "N", value_parser = crate::precompute::count(1, 100_000_000))]
    pub vertices: Option<usize>,
    /// The axis of a mesh file that points up
    #[arg(long, value_name = "AXIS")]
    pub up: Option<Up>,
    /// Where to write the best model
    #[arg(short, long, value_name = "FILE.prt")]
    pub output: Option<PathBuf>,
    /// Folder for select.csv and select.json, and for trials.csv: what was tried there is not tried again
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print rows, winner, encodes and estimates as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// A family, and what all of its labels begin with.
pub type Candidate = (Family, Label);

/// Runs the command.
pub fn run(arguments: &Select, threads: usize) -> Result<()> {
    interrupt::keeping(selected(arguments, threads), || match &arguments.out {
        Some(folder) => format!("what was tried is in {}; the same command goes on from there", folder.display()),
        None => "nothing is kept; with --out DIR the same command goes on where it was".into(),
    })
}

fn selected(arguments: &Select, threads: usize) -> Result<()> {
    if let Some(output) = &arguments.output {
        files::expect_extension(output, "prt")?;
    }
    let registry = registry();
    // First, so that a slip of the keyboard is told before anything is computed.
    let named: Vec<Candidate> =
        arguments.methods.iter().map(|m| families::named(&registry, m)).collect::<prt_transfer::Result<_>>()?;
    let bar = Bar::default();
    let (title, matrix) = subject::read(arguments, &bar)?;
    drop(bar);
    let candidates = if named.is_empty() { fitting(&registry, Kind::of_matrix(&matrix))? } else { named };
    let pools = Pools::new(threads)?;
    let reference = pools.everywhere(|| Reference::new(matrix))?;
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(Duration::from_millis(30)) };
    let goal = arguments.goal();
    let mut search = Search::new(&bench, &reference, goal)?;
    if let Some(folder) = &arguments.out {
        search.keep_in(&cache::make(folder.clone())?.join("trials.csv"))?;
    }
    let (mut rows, mut best) = (Vec::new(), None::<Found>);
    let steps = Steps::new(candidates.len());
    for candidate in &candidates {
        interrupt::check()?;
        let (row, found) = of_family(&mut search, candidate, arguments, &steps)?;
        rows.push(row);
        let better = |found: &Found| best.as_ref().is_none_or(|b| goal.order(&found.trial, &b.trial).is_lt());
        if let Some(found) = found.filter(better) {
            best = Some(found);
        }
    }
    steps.finish();
    let report = Report::new(title, goal, rows, threads);
    if let Some(folder) = &arguments.out {
        report.write(folder)?;
    }
    if let (Some(output), Some(found)) = (&arguments.output, &best) {
        files::write_beside(output, &found.file)?;
    }
    if arguments.json {
        terminal::say_json(&report)?;
    } else {
        terminal::say(report.text(arguments.output.as_deref()))?;
    }
    match best {
        Some(_) => Ok(()),
        None => bail!("no model keeps to {}; {}", goal.text(), report.closest()),
    }
}

impl Select {
    fn goal(&self) -> Goal {
        let bytes = || self.max_bytes.map(Bound::Bytes);
        let bound = self.max_error.map(Bound::Error).or_else(bytes);
        // One of the three is required.
        let bound = bound.or_else(|| self.max_relight.map(Bound::Relight)).unwrap_or(Bound::Error(0.0));
        Goal { bound, storage: self.size, norm: self.norm }
    }
}

/// Every family that fits a matrix.
fn fitting(registry: &Registry, kind: Kind) -> Result<Vec<Candidate>> {
    let families = families::families(registry, kind).into_iter();
    families.map(|family| Ok((family, family.base.parse()?))).collect()
}

/// The search of a family, its grid, or both.
fn of_family(
    search: &mut Search,
    (family, base): &Candidate,
    arguments: &Select,
    steps: &Steps,
) -> Result<(Row, Option<Found>)> {
    let name = base.to_string();
    steps.show(&name);
    let single = search.grid_of(family, base) == 1;
    let all = |search: &mut Search| {
        let points = search.grid_of(family, base);
        steps.more(points);
        search.best_of_all(family, base, &mut || steps.done(1))
    };
    let (outcome, grid) = match arguments.full_grid {
        true => (all(search)?, None),
        false => {
            let outcome = search.best_of(family, base, arguments.effort)?;
            let grid = if arguments.compare_grid && !single { Some(all(search)?) } else { None };
            (outcome, grid)
        }
    };
    steps.done(1);
    let row = Row::new(search.goal(), &name, &outcome, grid.as_ref());
    // A grid may find what the search missed.
    let found = [outcome.found, grid.and_then(|grid| grid.found)].into_iter().flatten();
    let best = found.min_by(|a, b| search.goal().order(&a.trial, &b.trial));
    Ok((row, best))
}

#[cfg(test)]
mod tests;
