//! `prt bench`: every method on every scene, measured on what came back from its file.

use crate::cache::{self, Prepared};
use crate::charts;
use crate::machine::Machine;
use crate::measure::{Bench as Measure, Pools, Reference};
use crate::progress::Steps;
use crate::results::Results;
use crate::row::Row;
use crate::suite::{Origin, Size, Suite};
use crate::timing::Budget;
use crate::{files, labels, registry, report, scenes, table, terminal};
use anyhow::ensure;
use clap::Args;
use prt_transfer::{Error, Quiet, Registry};
use std::path::{Path, PathBuf};

/// Arguments of `prt bench`.
#[derive(Args, Debug)]
#[command(
    after_help = "A finished row is never measured twice: run the same command again to resume.\n\nExamples:\n  prt bench\n  prt bench --quick --out quick\n  prt bench --scene bunny.ply --method csr --method haar+truncate:terms=64"
)]
pub struct Bench {
    /// A built-in scene, a mesh (.ply, .obj) or a matrix (.npz, .npy, .mtx), instead of the usual scenes; may be repeated
    #[arg(long = "scene", value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// A method, instead of the usual ones; may be repeated
    #[arg(long = "method", value_name = "LABEL")]
    pub methods: Vec<String>,
    /// Half a minute: one small scene, few methods
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Every scene, denser, more parameters
    #[arg(long)]
    pub full: bool,
    /// Folder for results.csv, machine.json, charts, report.html and the compressed files
    #[arg(long, value_name = "DIR", default_value = "prt-bench")]
    pub out: PathBuf,
    /// Print the rows as one JSON array instead of tables
    #[arg(long)]
    pub json: bool,
}

/// All rows of one matrix.
#[derive(Clone, Debug)]
pub struct Group {
    /// Scene, signal and basis, for people.
    pub title: String,
    /// The same for file names.
    pub file_name: String,
    /// One for each method, in the order of the suite.
    pub rows: Vec<Row>,
}

/// One run of the command.
struct Run<'a> {
    measure: Measure<'a>,
    out: &'a Path,
    results: Results,
    steps: Steps,
}

/// Runs the command.
pub fn run(arguments: &Bench, threads: usize) -> anyhow::Result<()> {
    let registry = registry::registry();
    let suite = suite(arguments, &registry)?;
    let out = cache::make(arguments.out.clone())?;
    let machine = Machine::here(threads);
    files::write_beside(&out.join("machine.json"), &serde_json::to_vec_pretty(&machine)?)?;
    let pools = Pools::new(threads)?;
    let mut run = Run {
        measure: Measure { registry: &registry, pools: &pools, budget: Budget::of(suite.budget) },
        out: &out,
        results: Results::open(out.join("results.csv"))?,
        steps: Steps::new(suite.origins.iter().map(|o| suite.methods_on(o).len()).sum()),
    };
    let mut groups = Vec::new();
    for origin in &suite.origins {
        let group = run.group(origin, &suite.methods_on(origin))?;
        if !arguments.json {
            run.steps.suspend(|| terminal::say(table::of(&group)))?;
        }
        charts::draw(&group, &cache::make(out.join("charts"))?, &machine)?;
        groups.push(group);
    }
    run.steps.finish();
    files::write_beside(&out.join("report.html"), report::page(&groups, &machine).as_bytes())?;
    let rows: Vec<&Row> = groups.iter().flat_map(|g| &g.rows).collect();
    if arguments.json {
        terminal::say_json(&rows)?;
    } else {
        let (legend, machine) = (table::LEGEND, machine.line());
        terminal::say(format!("\n{legend}\n{machine}\nresults.csv, charts and report.html are in {}", out.display()))?;
    }
    // One failed method is a row; nothing but failures is a failure.
    ensure!(
        rows.iter().any(|row| row.is_ok()),
        "no method could be measured; {} says why",
        run.results.path().display()
    );
    Ok(())
}

/// Scene, signal, basis and shape, as far as they are known.
fn title(row: &Row) -> String {
    let Row { scene, signal, basis, samples, responses, lights, .. } = row;
    let shape = if row.fingerprint.is_empty() { String::new() } else { format!("{samples} x {responses} x {lights}") };
    let parts = [scene, signal, basis, &shape].into_iter().filter(|part| !part.is_empty());
    parts.map(String::as_str).collect::<Vec<_>>().join(" · ")
}

/// The suite with the user's scenes and methods, all of them known: a slip of the keyboard should not cost minutes.
fn suite(arguments: &Bench, registry: &Registry) -> anyhow::Result<Suite> {
    let known: Vec<&str> = scenes::scenes().iter().map(|s| s.name).collect();
    for scene in &arguments.scenes {
        if Path::new(scene).extension().is_none() && !known.contains(&scene.as_str()) {
            return Err(Error::Unknown { what: "scene", name: scene.clone(), known: known.join(", ") }.into());
        }
    }
    let methods = labels::shortest(registry, &arguments.methods)?;
    let size = match (arguments.quick, arguments.full) {
        (true, _) => Size::Quick,
        (_, true) => Size::Full,
        _ => Size::Standard,
    };
    Ok(Suite::new(size, &arguments.scenes, &methods))
}

impl Run<'_> {
    /// Every method on one matrix. Where there is no matrix, every row says why.
    fn group(&mut self, origin: &Origin, methods: &[String]) -> anyhow::Result<Group> {
        let subject = cache::subject(origin);
        self.steps.show(&format!("{} {}", subject.scene, subject.signal));
        let prepared = cache::prepare(&cache::folder(self.out)?, origin, &Quiet);
        let rows = match prepared {
            Ok(prepared) => self.rows(prepared, &subject, methods, &cache::file_name(origin))?,
            Err(error) => {
                let failed = |m: &String| self.measure.planned(&subject, m).failed(format!("{error:#}"));
                let rows: Vec<Row> = methods.iter().map(failed).collect();
                rows.iter().try_for_each(|row| self.results.put(row.clone()))?;
                self.steps.done(rows.len());
                rows
            }
        };
        Ok(Group { title: rows.first().map_or_else(String::new, title), file_name: cache::file_name(origin), rows })
    }

    fn rows(&mut self, prepared: Prepared, subject: &Row, methods: &[String], name: &str) -> anyhow::Result<Vec<Row>> {
        let subject = prepared.about().describe(subject.clone());
        // Read and compared only when something is left to measure.
        let (mut prepared, mut reference) = (Some(prepared), None);
        let mut rows = Vec::new();
        for method in methods {
            let planned = self.measure.planned(&subject, method);
            let row = match self.results.finished(&planned) {
                Some(row) => row.clone(),
                None => {
                    self.steps.show(&format!("{} {} {method}", planned.scene, planned.signal));
                    if let Some(prepared) = prepared.take() {
                        let pools = self.measure.pools;
                        reference = Some(pools.everywhere(|| Reference::new(prepared.into_matrix()?))?);
                    }
                    let path =
                        cache::make(self.out.join("encoded"))?.join(format!("{name}-{}.prt", cache::safe(method)));
                    let row = match &reference {
                        Some(reference) => self.measure.attempt(planned, reference, &path, &Quiet),
                        None => planned.failed("no matrix"),
                    };
                    self.results.put(row.clone())?;
                    row
                }
            };
            self.steps.done(1);
            rows.push(row);
        }
        Ok(rows)
    }
}
