//! `prt figures`: the figures of a paper, measured anew.
//!
//! A paper is one folder of data (a file for each figure) and one line in [`PAPERS`]; what a figure measures ([`setting`]) is apart
//! from how it is drawn ([`plot`]).

mod clustered_pca;
pub mod outcome;
pub mod plot;
pub mod setting;
mod slf;
mod srbf;
pub mod stage;
mod tensor;

use crate::charts::curves::Curves;
use crate::machine::Machine;
use crate::measure::{Bench, Pools};
use crate::timing::Budget;
use crate::{cache, files, registry, terminal};
use anyhow::ensure;
use clap::Args;
use clap::builder::PossibleValuesParser;
use prt_transfer::image::Picture;
use prt_transfer::{Error, Result};
use stage::{Meshes, Stage};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A paper whose figures are measured anew.
pub struct Paper {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its figures.
    pub figures: &'static [Figure],
    /// What a reader must know before comparing.
    pub notes: &'static [&'static str],
}

/// A figure or table of a paper.
pub struct Figure {
    /// Its name on the command line and for files.
    pub name: &'static str,
    /// Measures and draws it.
    pub draw: fn(&Stage) -> anyhow::Result<Drawing>,
}

/// What came out of a figure.
pub struct Drawing {
    /// For the terminal.
    pub text: String,
    /// The raw figures: what is added to the figure's name, and CSV.
    pub tables: Vec<(&'static str, Vec<u8>)>,
    /// The chart; none for a table.
    pub chart: Option<Curves>,
    /// Pictures: what is added to the figure's name, and pixels.
    pub pictures: Vec<(&'static str, Picture)>,
    /// Whether anything could be measured.
    pub measured: bool,
}

/// Every paper.
pub static PAPERS: [Paper; 4] = [clustered_pca::PAPER, slf::PAPER, srbf::PAPER, tensor::PAPER];

/// Time for each relighting figure: short, since there are dozens; methods are timed in turn.
const BUDGET: Duration = Duration::from_millis(20);
/// Vertices of a built-in scene: enough for clusters as large as the papers', few enough for a minute or two.
const VERTICES: u32 = 4000;

/// Arguments of `prt figures`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt figures clustered-pca\n  prt figures clustered-pca --assets meshes --figure figure10 --figure table1\n  prt figures srbf --assets lights --figure lights\n  prt figures tensor --assets meshes --figure table1\n  prt figures slf --full --figure table1"
)]
pub struct Figures {
    /// Which paper's
    #[arg(value_name = "PAPER", value_parser = PossibleValuesParser::new(PAPERS.iter().map(|p| p.name)))]
    pub paper: String,
    /// Folder of meshes (bunny_35k.ply, dragon_23k.ply, …) or, for srbf, of lights (.exr), with the paper's own settings; built-in scenes and lights and fewer settings where none is given
    #[arg(long, value_name = "DIR", conflicts_with = "vertices")]
    pub assets: Option<PathBuf>,
    /// Built-in scenes and worlds at the papers' sizes; for slf tens of minutes of tracing
    #[arg(long, conflicts_with_all = ["assets", "vertices"])]
    pub full: bool,
    /// Vertices of the built-in scenes, about
    #[arg(long, value_name = "N", default_value_t = VERTICES, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub vertices: u32,
    /// Only this figure; may be repeated
    #[arg(long = "figure", visible_alias = "figures", value_name = "FIGURE", value_delimiter = ',')]
    pub figures: Vec<String>,
    /// Folder for the figures as .svg, .png and .csv
    #[arg(long, value_name = "DIR", default_value = "prt-figures")]
    pub out: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Figures, threads: usize) -> anyhow::Result<()> {
    let registry = registry::registry();
    let paper = find(&arguments.paper)?;
    let figures = chosen(paper, &arguments.figures)?;
    let meshes = match &arguments.assets {
        Some(folder) => {
            ensure!(folder.is_dir(), "there is no folder of assets {}", folder.display());
            Meshes::Files(folder.clone())
        }
        None if arguments.full => Meshes::PaperSized,
        None => Meshes::BuiltIn(arguments.vertices as usize),
    };
    let out = cache::make(arguments.out.clone())?;
    let (machine, pools) = (Machine::here(threads), Pools::new(threads)?);
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(BUDGET) };
    let stage = Stage::new(bench, machine, meshes);
    let mut measured = false;
    for figure in figures {
        let drawing = (figure.draw)(&stage)?;
        write(figure, &drawing, &out, &stage.machine)?;
        stage.steps.suspend(|| terminal::say(&drawing.text))?;
        measured |= drawing.measured;
    }
    stage.steps.finish();
    // One failed setting is a line with its reason; nothing but failures is a failure.
    ensure!(measured, "no setting could be measured; {} says why", out.display());
    let (notes, machine) = (paper.notes.join("\n"), stage.machine.line());
    terminal::say(format!("\n{notes}\n{machine}\nfigures as .csv, .svg and .png are in {}", out.display()))
}

fn write(figure: &Figure, drawing: &Drawing, out: &Path, machine: &Machine) -> anyhow::Result<()> {
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

fn find(name: &str) -> Result<&'static Paper> {
    let known = || PAPERS.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
    PAPERS.iter().find(|p| p.name == name).ok_or_else(|| Error::Unknown {
        what: "paper",
        name: name.into(),
        known: known(),
    })
}

/// The figures that were asked for; all of them where none was.
fn chosen(paper: &'static Paper, names: &[String]) -> Result<Vec<&'static Figure>> {
    if names.is_empty() {
        return Ok(paper.figures.iter().collect());
    }
    let known = || paper.figures.iter().map(|f| f.name).collect::<Vec<_>>().join(", ");
    let find = |name: &String| {
        let unknown = || Error::Unknown { what: "figure", name: name.clone(), known: known() };
        paper.figures.iter().find(|figure| figure.name == name).ok_or_else(unknown)
    };
    names.iter().map(find).collect()
}

#[cfg(test)]
mod tests;
