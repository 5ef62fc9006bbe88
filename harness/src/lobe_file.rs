//! Lights of lobes as .json: what `prt fit-light` writes and what `--light` reads.

use crate::files;
use ndarray::Array2;
use prt_srbf::fit::Stage;
use prt_srbf::{Kernel, Lobe, ScatteredLight};
use prt_transfer::params::Value;
use prt_transfer::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file. The names are a promise to programs that read them; docs/format.md has them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LobeFile {
    /// `gaussian` or `abel-poisson`.
    pub kernel: String,
    /// Each one.
    pub lobes: Vec<LobeEntry>,
    /// How it was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<Provenance>,
}

/// A lobe.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LobeEntry {
    /// Unit vector, z up.
    pub centre: [f64; 3],
    /// λ.
    pub bandwidth: f64,
    /// Coefficient of R, G and B in W/m²/sr.
    pub radiance: [f64; 3],
}

/// How lobes were fitted.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Provenance {
    /// Parameters that differ from the default, as a label.
    pub label: String,
    /// What was fitted: the light's name.
    pub source: String,
    /// Texels that the error is taken over.
    pub basis: String,
    /// Over the texels' centres, weighted by solid angle, R, G and B together.
    pub relative_squared_error: f64,
    /// Of R, G and B: ∫ L̃ dω over the sphere against the texels', less 1.
    pub flux_error: Vec<f64>,
    /// After each stage.
    pub history: Vec<StageEntry>,
}

/// A stage of a fit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StageEntry {
    /// `start`, `grow`, `exchange` or `refine`.
    pub stage: String,
    /// That the error is taken over.
    pub texels: usize,
    /// Then.
    pub lobes: usize,
    /// Then.
    pub relative_squared_error: f64,
}

impl From<&Stage> for StageEntry {
    fn from(stage: &Stage) -> StageEntry {
        let &Stage { name, texels, lobes, relative_squared_error } = stage;
        StageEntry { stage: name.into(), texels, lobes, relative_squared_error }
    }
}

impl LobeFile {
    /// A light of three channels.
    pub fn new(light: &ScatteredLight, fit: Provenance) -> LobeFile {
        let colours = light.coefficients();
        let entries = light.lobes().iter().zip(colours.outer_iter());
        let lobes = entries.map(|(lobe, row)| LobeEntry {
            centre: lobe.centre,
            bandwidth: lobe.bandwidth,
            radiance: [0, 1, 2].map(|c| row[c]),
        });
        LobeFile { kernel: light.kernel().show(), lobes: lobes.collect(), fit: Some(fit) }
    }

    /// The light.
    ///
    /// # Errors
    /// An unknown kernel; what [`ScatteredLight::new`] refuses.
    pub fn light(&self) -> Result<ScatteredLight> {
        let unknown = || Error::Unknown { what: "kernel", name: self.kernel.clone(), known: Kernel::expected() };
        let kernel = Kernel::parse(&self.kernel).ok_or_else(unknown)?;
        let lobes = self.lobes.iter().map(|l| Lobe { centre: l.centre, bandwidth: l.bandwidth }).collect();
        let colours = Array2::from_shape_fn((self.lobes.len(), 3), |(j, c)| self.lobes[j].radiance[c]);
        ScatteredLight::new(kernel, lobes, colours)
    }
}

/// Reads a light of lobes.
pub fn read(path: &Path) -> Result<ScatteredLight> {
    from_bytes(&files::read_bytes(path)?).map_err(|e| e.in_file(path))
}

/// As [`read`], from memory.
pub fn from_bytes(bytes: &[u8]) -> Result<ScatteredLight> {
    let refuse = |found: String| Error::Unsupported {
        what: "light".into(),
        expected: "a light of lobes as prt fit-light writes it".into(),
        found,
    };
    serde_json::from_slice::<LobeFile>(bytes).map_err(|e| refuse(e.to_string()))?.light()
}

/// Writes a light of lobes.
pub fn write(path: &Path, file: &LobeFile) -> anyhow::Result<()> {
    Ok(files::write_beside(path, serde_json::to_string_pretty(file)?.as_bytes())?)
}
