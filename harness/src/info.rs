//! `prt info`: what a compressed matrix is and what it costs.

use crate::number;
use crate::registry::registry;
use crate::{files, terminal};
use anyhow::Context;
use clap::Args;
use prt_transfer::Registry;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Arguments of `prt info`.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  prt info teapot.prt --json")]
pub struct InfoArguments {
    /// Compressed matrix
    #[arg(value_name = "FILE.prt")]
    pub input: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What is printed. The names are a promise to programs that read them.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// The method.
    pub label: String,
    /// Surface points.
    pub samples: usize,
    /// Rows of each sample.
    pub responses: usize,
    /// Columns.
    pub lights: usize,
    /// What the columns stand for.
    pub basis: String,
    /// What the responses of a sample stand for.
    pub response_basis: String,
    /// What relighting holds in memory.
    pub resident_bytes: u64,
    /// The file.
    pub file_bytes: u64,
    /// Resident bytes by section.
    pub sections: Map<String, Value>,
    /// Multiplications of relighting with one channel, a light of ones.
    pub multiplications: u64,
    /// Additions of the same.
    pub additions: u64,
    /// What the light transform decided beyond its label; absent where nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl Info {
    /// Measures a file.
    pub fn read(path: &Path, registry: &Registry) -> anyhow::Result<Info> {
        let compressed = files::read_prt(path, registry)?;
        let file = path.metadata().with_context(|| format!("cannot read {}", path.display()))?;
        let (shape, sink) = (compressed.shape(), compressed.held());
        let flops = compressed.flops(&vec![1.0; shape.lights])?;
        Ok(Info {
            label: compressed.label().to_string(),
            samples: shape.samples,
            responses: shape.responses,
            lights: shape.lights,
            basis: compressed.basis().to_string(),
            response_basis: compressed.responses().to_string(),
            resident_bytes: compressed.resident_bytes() as u64,
            file_bytes: file.len(),
            sections: sink.sizes().map(|(name, size)| (name.to_string(), size.into())).collect(),
            multiplications: flops.multiplications,
            additions: flops.additions,
            note: compressed.note(),
        })
    }

    /// For a person.
    fn text(&self) -> String {
        let mut lines = vec![
            format!("method           {}", self.label),
            format!(
                "matrix           {} samples x {} responses x {} lights",
                self.samples, self.responses, self.lights
            ),
            format!("light basis      {}", self.basis),
            format!("response basis   {}", self.response_basis),
            format!("resident         {}", number::bytes(self.resident_bytes)),
        ];
        // In line with the rest, unless a name is longer.
        let width = self.sections.keys().map(|name| name.len() + 1).fold(15, usize::max);
        for (name, size) in &self.sections {
            lines.push(format!("  {name:<width$}{}", number::bytes(size.as_u64().unwrap_or_default())));
        }
        lines.push(format!("file             {}", number::bytes(self.file_bytes)));
        lines.push(format!("multiplications  {}", number::count(self.multiplications)));
        lines.push(format!("additions        {}", number::count(self.additions)));
        lines.extend(self.note.iter().map(|note| format!("note             {note}")));
        lines.join("\n")
    }
}

/// Runs the command.
pub fn run(arguments: &InfoArguments) -> anyhow::Result<()> {
    let info = Info::read(&arguments.input, &registry())?;
    if arguments.json { terminal::say_json(&info) } else { terminal::say(info.text()) }
}
