//! `prt figures`: the figures of a paper, measured anew.
//!
//! A paper is one folder of data (a file for each figure) and one line in [`PAPERS`]; what a figure measures ([`setting`]) is apart
//! from how it is drawn ([`plot`]). Those that stand beside what the paper prints are its tables: `prt tables` shows them alone.

mod biclustering;
mod clustered_pca;
pub mod outcome;
pub mod place;
pub mod plot;
pub mod setting;
mod slf;
mod srbf;
pub mod stage;
mod tensor;

use crate::charts::curves::Curves;
use crate::machine::Machine;
use crate::measure::{Bench, Pools};
use crate::tables::beside::Beside;
use crate::timing::Budget;
use crate::{cache, files, interrupt, registry, terminal};
use anyhow::ensure;
use clap::Args;
use clap::builder::PossibleValuesParser;
use place::Place;
use prt_transfer::image::Picture;
use prt_transfer::{Error, Result};
use stage::{Chosen, Stage};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A paper whose figures are measured anew.
pub struct Paper {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its authors, year and subject.
    pub source: &'static str,
    /// Its figures.
    pub figures: &'static [Figure],
    /// Whether built-in scenes have the paper's sizes where nobody says otherwise.
    pub is_full: bool,
    /// The paper's names of scenes, where they and the methods can be chosen.
    pub scenes: &'static [&'static str],
    /// What a reader must know before comparing.
    pub notes: &'static [&'static str],
}

/// A figure or table of a paper.
pub struct Figure {
    /// Its name on the command line and for files.
    pub name: &'static str,
    /// What it shows beside what the paper prints; none for a figure of our own.
    pub table: Option<&'static str>,
    /// Measures and draws it.
    pub draw: fn(&Stage) -> anyhow::Result<Drawing>,
}

/// What came out of a figure.
#[derive(Default)]
pub struct Drawing {
    /// For the terminal.
    pub text: String,
    /// Ours beside the paper's.
    pub beside: Vec<Beside>,
    /// The raw figures: what is added to the figure's name, and CSV.
    pub tables: Vec<(&'static str, Vec<u8>)>,
    /// The chart; none for a table.
    pub chart: Option<Curves>,
    /// Pictures: what is added to the figure's name, and pixels.
    pub pictures: Vec<(&'static str, Picture)>,
    /// Whether anything could be measured that is not in a table.
    pub measured: bool,
}

/// Every paper.
pub static PAPERS: [Paper; 5] = [biclustering::PAPER, clustered_pca::PAPER, slf::PAPER, srbf::PAPER, tensor::PAPER];

/// Time for each relighting figure: short, since there are dozens; methods are timed in turn.
const BUDGET: Duration = Duration::from_millis(20);

/// Arguments of `prt figures`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt figures clustered-pca\n  prt figures clustered-pca --assets meshes --figure figure10 --figure table1\n  prt figures srbf --assets lights --figure lights\n  prt figures tensor --assets meshes --figure table1\n  prt figures slf --full --figure table1"
)]
pub struct Figures {
    /// Which paper's
    #[arg(value_name = "PAPER", value_parser = PossibleValuesParser::new(PAPERS.iter().map(|p| p.name)))]
    pub paper: String,
    /// Where scenes and lights come from
    #[command(flatten)]
    pub place: Place,
    /// Only this figure; may be repeated
    #[arg(long = "figure", visible_alias = "figures", value_name = "FIGURE", value_delimiter = ',')]
    pub figures: Vec<String>,
    /// Folder for the figures as .svg, .png and .csv
    #[arg(long, value_name = "DIR", default_value = "prt-figures")]
    pub out: PathBuf,
}

/// What to measure, and where.
pub struct Request<'a> {
    /// Of whom.
    pub paper: &'static Paper,
    /// Which figures of it.
    pub figures: Vec<&'static Figure>,
    /// On which meshes.
    pub place: &'a Place,
    /// Which scenes and methods of them.
    pub chosen: Chosen,
    /// The folder to write to.
    pub out: &'a Path,
    /// "All" threads.
    pub threads: usize,
}

/// Runs the command.
pub fn run(arguments: &Figures, threads: usize) -> anyhow::Result<()> {
    let paper = find(&arguments.paper)?;
    let figures = chosen(paper.figures.iter(), &arguments.figures)?;
    let Figures { place, out, .. } = arguments;
    let request = Request { paper, figures, place, chosen: Chosen::default(), out, threads };
    let (machine, measured) = measure(&request, |drawing| {
        let tables = drawing.beside.iter().map(Beside::terminal);
        let text = Some(drawing.text.clone()).filter(|text| !text.is_empty());
        text.into_iter().chain(tables).collect::<Vec<_>>().join("\n")
    })?;
    // One failed setting is a line with its reason; nothing but failures is a failure.
    ensure!(measured, "no setting could be measured; {} says why", out.display());
    let (notes, machine) = (paper.notes.join("\n"), machine.line());
    terminal::say(format!("\n{notes}\n{machine}\nfigures as .csv, .svg and .png are in {}", out.display()))
}

/// Measures figures one after the other, writes each, and says of it what `told` makes of it. On which machine, and whether anything
/// could be measured.
pub fn measure(request: &Request, mut told: impl FnMut(&Drawing) -> String) -> anyhow::Result<(Machine, bool)> {
    let Request { paper, figures, place, chosen, out, threads } = request;
    let (registry, meshes) = (registry::registry(), place.meshes(paper)?);
    let out = cache::make(out.to_path_buf())?;
    let (machine, pools) = (Machine::here(*threads), Pools::new(*threads)?);
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(BUDGET) };
    let mut stage = Stage::new(bench, machine, meshes);
    stage.chosen = chosen.clone();
    let mut measured = false;
    let names: Vec<&str> = figures.iter().map(|figure| figure.name).collect();
    for (finished, figure) in figures.iter().enumerate() {
        let drawing = (figure.draw)(&stage);
        let drawing = interrupt::keeping(drawing, || interrupt::parts(&names, finished, "figures", &out))?;
        write(figure, &drawing, &out, &stage.machine)?;
        stage.steps.suspend(|| terminal::say(told(&drawing)))?;
        measured |= drawing.measured || drawing.beside.iter().any(Beside::is_measured);
    }
    stage.steps.finish();
    Ok((stage.machine, measured))
}

fn write(figure: &Figure, drawing: &Drawing, out: &Path, machine: &Machine) -> anyhow::Result<()> {
    for beside in &drawing.beside {
        let path = out.join(format!("{}{}.csv", figure.name, beside.addition));
        files::write_beside(&path, &beside.csv(machine)?)?;
    }
    for (addition, csv) in &drawing.tables {
        files::write_beside(&out.join(format!("{}{addition}.csv", figure.name)), csv)?;
    }
    for (addition, picture) in &drawing.pictures {
        files::write_picture(&out.join(format!("{}{addition}.png", figure.name)), picture)?;
    }
    if let Some(chart) = &drawing.chart {
        let path = |extension| out.join(format!("{}.{extension}", figure.name));
        files::write_beside(&path("svg"), chart.svg(Some(machine)).as_bytes())?;
        files::write_beside(&path("png"), &chart.png(machine)?)?;
    }
    Ok(())
}

/// The paper of a name.
pub fn find(name: &str) -> Result<&'static Paper> {
    let known = || PAPERS.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
    PAPERS.iter().find(|p| p.name == name).ok_or_else(|| Error::Unknown {
        what: "paper",
        name: name.into(),
        known: known(),
    })
}

/// The figures that were asked for; all of them where none was.
pub fn chosen(all: impl Iterator<Item = &'static Figure>, names: &[String]) -> Result<Vec<&'static Figure>> {
    let all: Vec<&Figure> = all.collect();
    if names.is_empty() {
        return Ok(all);
    }
    let known = || all.iter().map(|f| f.name).collect::<Vec<_>>().join(", ");
    let find = |name: &String| {
        let unknown = || Error::Unknown { what: "figure", name: name.clone(), known: known() };
        all.iter().copied().find(|figure| figure.name == name).ok_or_else(unknown)
    };
    names.iter().map(find).collect()
}

#[cfg(test)]
mod tests;
