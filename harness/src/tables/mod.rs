//! `prt tables`: the tables of a paper, measured anew beside what it prints.
//!
//! A paper is one file of data ([`paper::Paper`]) and one line in [`PAPERS`].

mod biclustering;
pub mod layout;
pub mod paper;
pub mod quantity;
pub mod survey;

use crate::machine::Machine;
use crate::measure::{Bench, Pools};
use crate::progress::Steps;
use crate::timing::Budget;
use crate::{cache, files, labels, registry, terminal};
use anyhow::ensure;
use clap::Args;
use clap::builder::PossibleValuesParser;
use layout::Layout;
use paper::{Paper, PaperScene, PaperTable};
use prt_transfer::{Error, Result};
use std::path::PathBuf;
use std::time::Duration;
use survey::{Meshes, Survey, Surveyor};

/// Every paper.
pub static PAPERS: [Paper; 1] = [biclustering::PAPER];

/// Time for each relighting figure.
const BUDGET: Duration = Duration::from_millis(200);

/// Arguments of `prt tables`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt tables biclustering --assets meshes\n  prt tables biclustering --vertices 300 --method csr --scene bunny,temple"
)]
pub struct Tables {
    /// Which paper's
    #[arg(value_name = "PAPER", value_parser = PossibleValuesParser::new(PAPERS.iter().map(|p| p.name)))]
    pub paper: String,
    /// Folder of meshes (bunny_3k.ply, teapot_10k.ply, …); built-in scenes stand in where none is given
    #[arg(long, value_name = "DIR", conflicts_with = "vertices")]
    pub assets: Option<PathBuf>,
    /// Vertices of the first built-in scene of each table, all others in proportion [default: about as many as the paper's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub vertices: Option<u32>,
    /// Only these scenes, by the paper's names; may be repeated
    #[arg(long = "scene", visible_alias = "scenes", value_name = "SCENE", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// A method, instead of the usual ones; may be repeated. `compact` is always measured: others are compared with it
    #[arg(long = "method", value_name = "LABEL")]
    pub methods: Vec<String>,
    /// Folder for the tables as .csv and tables.md
    #[arg(long, value_name = "DIR", default_value = "prt-tables")]
    pub out: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Tables, threads: usize) -> anyhow::Result<()> {
    let registry = registry::registry();
    let paper = find(&arguments.paper)?;
    let methods = labels::with_baseline(&registry, &arguments.methods, paper.methods, quantity::BASELINE)?;
    let chosen = chosen(paper, &arguments.scenes)?;
    let meshes = match (&arguments.assets, arguments.vertices) {
        (Some(folder), _) => {
            ensure!(folder.is_dir(), "there is no folder of assets {}", folder.display());
            Meshes::Files(folder.clone())
        }
        (None, vertices) => Meshes::BuiltIn(vertices.map(|n| n as usize)),
    };
    let out = cache::make(arguments.out.clone())?;
    let (machine, pools) = (Machine::here(threads), Pools::new(threads)?);
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(BUDGET) };
    let steps = Steps::new(chosen.iter().map(|(_, scenes)| scenes.len()).sum::<usize>() * methods.len());
    let mut surveyor = Surveyor::new(&bench, (paper.spec)(), &methods, &meshes, &steps);
    let (mut pages, mut measured) = (Vec::new(), false);
    for (table, scenes) in chosen {
        let first = table.scenes.iter().find_map(PaperScene::vertices);
        let surveys = scenes.into_iter().map(|scene| surveyor.survey(scene, first));
        let surveys = surveys.collect::<anyhow::Result<Vec<Survey>>>()?;
        let layout = Layout::new(table.title, &surveys, &methods);
        steps.suspend(|| terminal::say(layout.terminal()))?;
        files::write_beside(&out.join(format!("{}.csv", table.name)), &layout.csv(&machine)?)?;
        pages.push(layout.markdown());
        measured |= surveys.iter().any(|survey| survey.rows.iter().any(|row| row.is_ok()));
    }
    steps.finish();
    files::write_beside(&out.join("tables.md"), page(paper, &pages, &machine).as_bytes())?;
    // One scene that is missing is a column; nothing but missing scenes is a failure.
    ensure!(measured, "no scene could be measured; {} says why", out.join("tables.md").display());
    let notes = paper.notes.join("\n");
    terminal::say(format!("\n{notes}\n{}\ntables.md and the tables as .csv are in {}", machine.line(), out.display()))
}

fn find(name: &str) -> Result<&'static Paper> {
    let known = || PAPERS.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
    PAPERS.iter().find(|p| p.name == name).ok_or_else(|| Error::Unknown {
        what: "paper",
        name: name.into(),
        known: known(),
    })
}

/// The tables with the scenes that were asked for; all of them where none was.
fn chosen(paper: &'static Paper, names: &[String]) -> Result<Vec<(&'static PaperTable, Vec<&'static PaperScene>)>> {
    let scenes = || paper.tables.iter().flat_map(|table| table.scenes);
    if let Some(name) = names.iter().find(|name| scenes().all(|scene| scene.name != **name)) {
        let mut known: Vec<&str> = scenes().map(|scene| scene.name).collect();
        known.sort_unstable();
        known.dedup();
        let (what, known) = ("scene of the paper", known.join(", "));
        return Err(Error::Unknown { what, name: name.clone(), known });
    }
    let wanted = |scene: &&PaperScene| names.is_empty() || names.iter().any(|name| scene.name == name);
    let tables = paper.tables.iter().map(|table| (table, table.scenes.iter().filter(wanted).collect::<Vec<_>>()));
    Ok(tables.filter(|(_, scenes)| !scenes.is_empty()).collect())
}

/// All tables with what a reader must know, as Markdown.
fn page(paper: &Paper, tables: &[String], machine: &Machine) -> String {
    let notes: String = paper.notes.iter().map(|note| format!("- {note}\n")).collect();
    let (source, tables, machine) = (paper.source, tables.join("\n"), machine.line());
    format!("# Measured anew: {source}\n\n{machine}\n\n{tables}\n## Notes\n\n{notes}")
}

#[cfg(test)]
mod tests;
