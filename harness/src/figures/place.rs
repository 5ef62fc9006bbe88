//! Where meshes and lights come from, on the command line.

use super::Paper;
use super::stage::Meshes;
use anyhow::ensure;
use clap::Args;
use std::path::PathBuf;

/// Vertices of a built-in scene: enough for clusters as large as the papers', few enough for a minute or two.
const VERTICES: usize = 4000;

/// Assets or built-in scenes, of `prt figures` and `prt tables`.
#[derive(Args, Clone, Debug, Default)]
pub struct Place {
    /// Folder of meshes (bunny_35k.ply, dragon_23k.ply, …) and lights (.exr), with the paper's own settings; built-in scenes and lights and fewer settings where none is given
    #[arg(long, value_name = "DIR", conflicts_with = "vertices", requires = "paper")]
    pub assets: Option<PathBuf>,
    /// Built-in scenes and worlds at the papers' sizes; for slf tens of minutes of tracing
    #[arg(long, conflicts_with_all = ["assets", "vertices"], requires = "paper")]
    pub full: bool,
    /// Vertices of the built-in scenes, about [default: 4000; for biclustering the paper's, and of its other scenes in proportion to the first]
    #[arg(long, value_name = "N", requires = "paper", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub vertices: Option<u32>,
}

impl Place {
    /// As a stage takes it.
    pub fn meshes(&self, paper: &Paper) -> anyhow::Result<Meshes> {
        if let Some(folder) = &self.assets {
            ensure!(folder.is_dir(), "there is no folder of assets {}", folder.display());
            return Ok(Meshes::Files(folder.clone()));
        }
        ensure!(
            !(self.full && paper.is_full),
            "the scenes of {} have the paper's sizes as it is: leave --full out",
            paper.name
        );
        Ok(match self.vertices {
            Some(vertices) => Meshes::BuiltIn(vertices as usize),
            None if self.full || paper.is_full => Meshes::PaperSized,
            None => Meshes::BuiltIn(VERTICES),
        })
    }
}
