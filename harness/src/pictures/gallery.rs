//! A scene relit by many methods at about the same bytes.

use super::flicker::Turning;
use super::portrait::Portrait;
use super::scenery::fill_behind;
use super::viewpoint::{SIZE, Viewpoint};
use crate::cache::safe;
use crate::files;
use crate::lights::Light;
use crate::operator::Operator;
use crate::png::Png;
use crate::suite::Origin;
use anyhow::Context;
use ndarray::Array2;
use prt_transfer::image::Picture;
use prt_transfer::io::image::png_bytes;
use prt_transfer::{Compressed, Metric, Progress, TransferMatrix};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Frames of a strip, in each of which the light is turned on by as many degrees as divide a turn evenly; and their size.
const FRAMES: usize = 8;
const FRAME: [usize; 2] = [128, 96];

/// The light of what has its own within it.
pub(super) const OWN: &str = "own";

/// The scene under one light, by every method at about the same bytes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Pictures {
    /// Name of the light; `own` of a light field.
    pub light: String,
    /// The size that methods were asked for.
    pub budget_bytes: u64,
    /// PNG of the exact matrix's picture, which others are compared with.
    pub reference: Png,
    /// PNG of the same while the light turns, frame beside frame; none where no light falls on what is seen.
    pub reference_strip: Option<Png>,
    /// One for each method.
    pub shown: Vec<Shown>,
}

/// A method's picture.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Shown {
    /// The method's label.
    pub method: String,
    /// Its transform and codec without parameters.
    pub family: String,
    /// The `.prt` file.
    pub file_bytes: u64,
    /// What relighting holds in memory.
    pub resident_bytes: u64,
    /// PNG, as large as the reference.
    pub picture: Png,
    /// PNG of FLIP of each pixel in colours.
    pub error_map: Png,
    /// PNG of the picture while the light turns.
    pub strip: Option<Png>,
    /// Of linear radiance.
    pub relative_squared_error: f64,
    /// None where both pictures are equal.
    pub psnr_db: Option<f64>,
    /// Mean over the pixels that the surface covers.
    pub flip: f64,
    /// Of relit output while the light turns.
    pub flicker: Option<f64>,
}

/// A method that is shown.
pub struct Candidate {
    /// Its transform and codec without parameters.
    pub family: String,
    /// The `.prt` file.
    pub file_bytes: u64,
    /// What it compressed the matrix to.
    pub compressed: Compressed,
}

/// From where pictures of an origin's matrix are taken, large ones and those of strips.
pub struct Gallery<'a> {
    matrix: &'a TransferMatrix,
    metric: Metric,
    large: Viewpoint,
    small: Viewpoint,
}

impl<'a> Gallery<'a> {
    /// `None` where nothing is known of the matrix's scene.
    pub fn new(
        origin: &Origin,
        matrix: &'a TransferMatrix,
        progress: &dyn Progress,
    ) -> anyhow::Result<Option<Gallery<'a>>> {
        let of = |size| Viewpoint::of(origin, matrix.responses(), size, progress);
        let Some((large, small)) = of(SIZE)?.zip(of(FRAME)?) else { return Ok(None) };
        Ok(Some(Gallery { matrix, metric: Metric::of(matrix)?, large, small }))
    }

    /// Whether light falls on what is seen, so that there is something to be seen under several.
    pub fn is_lit(&self) -> bool {
        self.large.is_lit()
    }

    /// Under a light, by its name or the path of its file.
    pub fn under(
        &self,
        name: &str,
        light: &Light,
        budget_bytes: u64,
        candidates: &[Candidate],
    ) -> anyhow::Result<Pictures> {
        let portrait = Portrait::taken(&self.large, self.matrix, light.on(self.matrix.basis(), 0.0)?)?;
        let is_lit = self.is_lit();
        let turned = if is_lit { self.turned(light)? } else { Vec::new() };
        let turning = is_lit.then(|| Turning::new(self.matrix, light, &self.metric)).transpose()?;
        let strip = |matrix: &dyn Operator| -> anyhow::Result<Option<Png>> {
            is_lit.then(|| Ok(Png(png_bytes(&self.strip(&portrait, matrix, &turned)?)?))).transpose()
        };
        let shown = |candidate: &Candidate| -> anyhow::Result<Shown> {
            let compressed = &candidate.compressed;
            let comparison = portrait.compare(&self.large, compressed)?;
            let errors = comparison.errors;
            Ok(Shown {
                method: compressed.label().to_string(),
                family: candidate.family.clone(),
                file_bytes: candidate.file_bytes,
                resident_bytes: compressed.resident_bytes() as u64,
                picture: Png(png_bytes(&comparison.picture)?),
                error_map: Png(png_bytes(&comparison.flip.picture())?),
                strip: strip(compressed)?,
                relative_squared_error: errors.relative_squared_error,
                psnr_db: Some(errors.psnr_db).filter(|p| p.is_finite()),
                flip: errors.flip,
                flicker: turning.as_ref().map(|t| t.flicker(compressed, &self.metric)).transpose()?,
            })
        };
        Ok(Pictures {
            light: if is_lit { stem(name) } else { OWN.into() },
            budget_bytes,
            reference: Png(png_bytes(portrait.original().picture())?),
            reference_strip: strip(self.matrix)?,
            shown: candidates.iter().map(shown).collect::<anyhow::Result<_>>()?,
        })
    }

    /// The light of each frame of a strip.
    fn turned(&self, light: &Light) -> anyhow::Result<Vec<Array2<f32>>> {
        let (basis, responses) = (self.matrix.basis(), self.matrix.responses());
        let of = |frame: usize| responses.light(basis, light.on(basis, 360.0 * frame as f64 / FRAMES as f64)?);
        Ok((0..FRAMES).map(of).collect::<prt_transfer::Result<_>>()?)
    }

    /// Frames side by side, all exposed as the portrait is.
    fn strip(&self, portrait: &Portrait, matrix: &dyn Operator, lights: &[Array2<f32>]) -> anyhow::Result<Picture> {
        let frame = |light: &Array2<f32>| -> anyhow::Result<Picture> {
            let mut image = self.small.image(matrix, light.view())?;
            fill_behind(&mut image, self.small.coverage(), portrait.behind());
            Ok(portrait.original().develop(&image))
        };
        Ok(Picture::beside(&lights.iter().map(frame).collect::<anyhow::Result<Vec<_>>>()?))
    }
}

impl Pictures {
    /// Writes every PNG into a folder: NAME-LIGHT-reference.png, NAME-LIGHT-METHOD.png, the same with -flip and -strip.
    pub fn write(&self, folder: &Path, name: &str) -> anyhow::Result<()> {
        let write = |parts: &[&str], Png(png): &Png| {
            let path = folder.join(format!("{}.png", safe(&[&[name, &self.light][..], parts].concat().join("-"))));
            files::write_beside(&path, png).with_context(|| "a picture of the bench")
        };
        write(&["reference"], &self.reference)?;
        self.reference_strip.iter().try_for_each(|png| write(&["reference", "strip"], png))?;
        for shown in &self.shown {
            write(&[&shown.method], &shown.picture)?;
            write(&[&shown.method, "flip"], &shown.error_map)?;
            shown.strip.iter().try_for_each(|png| write(&[&shown.method, "strip"], png))?;
        }
        Ok(())
    }
}

/// A light's name, or that of its file.
fn stem(light: &str) -> String {
    Path::new(light).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
