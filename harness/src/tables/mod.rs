//! `prt tables`: the tables of a paper, and what can be measured of its figures, ours beside theirs.
//!
//! They are the figures of [`crate::figures`] that stand beside what a paper prints, all of them laid out by [`beside`].

pub mod beside;

use crate::figures::place::Place;
use crate::figures::stage::Chosen;
use crate::figures::{self, Figure, PAPERS, Paper, Request, chosen, find};
use crate::machine::Machine;
use crate::{files, terminal};
use anyhow::ensure;
use beside::Beside;
use clap::Args;
use clap::builder::PossibleValuesParser;
use prt_transfer::Error;
use std::path::PathBuf;

/// Arguments of `prt tables`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt tables\n  prt tables biclustering --assets meshes\n  prt tables biclustering --vertices 300 --method csr --scene bunny,temple\n  prt tables tensor --table table1 --table figure5"
)]
pub struct Tables {
    /// Which paper's; a list of all tables where none is given
    #[arg(value_name = "PAPER", value_parser = PossibleValuesParser::new(with_tables().map(|p| p.name)))]
    pub paper: Option<String>,
    /// Where scenes and lights come from
    #[command(flatten)]
    pub place: Place,
    /// Only this table; may be repeated
    #[arg(long = "table", visible_alias = "tables", value_name = "TABLE", value_delimiter = ',', requires = "paper")]
    pub tables: Vec<String>,
    /// Of biclustering only these scenes, by the paper's names; may be repeated
    #[arg(long = "scene", visible_alias = "scenes", value_name = "SCENE", value_delimiter = ',', requires = "paper")]
    pub scenes: Vec<String>,
    /// Of biclustering a method, instead of the usual ones; may be repeated. `compact` is always measured: others are compared with it
    #[arg(long = "method", value_name = "LABEL", requires = "paper")]
    pub methods: Vec<String>,
    /// Folder for the tables as .csv and tables.md, and for charts that belong to them
    #[arg(long, value_name = "DIR", default_value = "prt-tables", requires = "paper")]
    pub out: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Tables, threads: usize) -> anyhow::Result<()> {
    let Some(paper) = &arguments.paper else { return terminal::say(list()) };
    let paper = find(paper)?;
    let figures = chosen(tables(paper), &arguments.tables)?;
    check(paper, arguments)?;
    let Tables { place, out, .. } = arguments;
    let chosen = Chosen { scenes: arguments.scenes.clone(), methods: arguments.methods.clone() };
    let mut pages = Vec::new();
    let (machine, measured) = figures::measure(&Request { paper, figures, place, chosen, out, threads }, |drawing| {
        pages.extend(drawing.beside.iter().map(Beside::markdown));
        drawing.beside.iter().map(Beside::terminal).collect::<Vec<_>>().join("\n")
    })?;
    files::write_beside(&out.join("tables.md"), page(paper, &pages, &machine).as_bytes())?;
    // What is missing is a line with its reason; nothing but missing things is a failure.
    ensure!(measured, "nothing could be measured; {} says why", out.join("tables.md").display());
    let (notes, machine) = (paper.notes.join("\n"), machine.line());
    terminal::say(format!("\n{notes}\n{machine}\ntables.md and the tables as .csv are in {}", out.display()))
}

/// Papers that have tables.
fn with_tables() -> impl Iterator<Item = &'static Paper> {
    PAPERS.iter().filter(|paper| tables(paper).next().is_some())
}

fn tables(paper: &'static Paper) -> impl Iterator<Item = &'static Figure> {
    paper.figures.iter().filter(|figure| figure.table.is_some())
}

/// Every table of every paper.
fn list() -> String {
    let lines = with_tables().flat_map(|paper| {
        let of = |figure: &Figure| ["", figure.name, figure.table.unwrap_or_default()].map(String::from).into();
        let head = vec![paper.name.into(), String::new(), paper.source.into()];
        std::iter::once(head).chain(tables(paper).map(of))
    });
    let lines: Vec<Vec<String>> = lines.collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let [paper, table] = [width(0), width(1)];
    let text = lines.iter().map(|line| format!("{:paper$}  {:table$}  {}", line[0], line[1], line[2]));
    text.collect::<Vec<_>>().join("\n")
}

/// Refuses what would say nothing of this paper.
fn check(paper: &Paper, arguments: &Tables) -> anyhow::Result<()> {
    let is_chosen = !(arguments.scenes.is_empty() && arguments.methods.is_empty());
    ensure!(
        !(is_chosen && paper.scenes.is_empty()),
        "the tables of {} have scenes and methods of their own: leave --scene and --method out",
        paper.name
    );
    if let Some(name) = arguments.scenes.iter().find(|name| !paper.scenes.contains(&name.as_str())) {
        let (what, known) = ("scene of the paper", paper.scenes.join(", "));
        return Err(Error::Unknown { what, name: name.clone(), known }.into());
    }
    Ok(())
}

/// All tables with what a reader must know, as Markdown.
fn page(paper: &Paper, tables: &[String], machine: &Machine) -> String {
    let (source, tables, notes, machine) = (paper.source, tables.join("\n"), paper.notes.join(" "), machine.line());
    format!("# Measured anew: {source}\n\n{machine}\n\n{tables}\n## Notes\n\n{notes}\n")
}

#[cfg(test)]
mod tests;
