//! `prt render`: a picture of a scene, relit from a matrix or traced.

mod arguments;
mod world;

use crate::files::{self, Description};
use crate::lights::{self, Backdrop};
use crate::operator::Operator;
use crate::pictures::{Comparison, Errors, Original, SAMPLES, Scenery, fill_behind};
use crate::progress::Bar;
use crate::registry::registry;
use crate::scenes;
use crate::{number, terminal, worlds};
use anyhow::bail;
pub use arguments::{Background, Exposure, Place, Render};
use glam::Vec3;
use ndarray::Array2;
use prt_transfer::image::{Image, Picture, Tone};
use prt_transfer::scene::reference::Reference;
use prt_transfer::scene::shading::Shading;
use prt_transfer::scene::signal::Sampling;
use prt_transfer::scene::view::View;
use prt_transfer::{Error, LightBasis, Progress, ResponseBasis, Result};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// What is printed. The names are a promise to programs that read them.
#[derive(Serialize)]
struct Rendered {
    /// Wall clock of everything, s.
    seconds: f64,
    /// Of the picture alone, without reading files and building what rays are traced in, s.
    picture_s: f64,
    /// Share of the pixels that the surface fills.
    filled: f64,
    /// Stops.
    exposure: f64,
    /// Against the picture compared with, over the pixels that the surface fills.
    #[serde(flatten)]
    errors: Option<Errors>,
    /// What should not go unsaid.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

/// A picture before exposure.
struct Drawn {
    /// Linear radiance.
    image: Image,
    /// For every pixel the share of its samples that meet a surface.
    coverage: Vec<f32>,
    /// Wall clock of the picture itself, s.
    picture_s: f64,
    /// What should not go unsaid.
    note: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Render) -> anyhow::Result<()> {
    let began = Instant::now();
    check(arguments)?;
    // First, so that nothing is traced for a picture that cannot be compared.
    let compared = arguments.compare.as_deref().map(|path| compared(path, arguments.size)).transpose()?;
    let bar = Bar::default();
    let drawn = if world::is_asked_for(arguments) { world::drawn(arguments, &bar)? } else { drawn(arguments, &bar)? };
    drop(bar);
    let Drawn { mut image, coverage, picture_s, note } = drawn;
    let (exposure, tone) = (arguments.exposure.unwrap_or(Exposure::Auto), arguments.tone.unwrap_or(Tone::Clip));
    let stops = match exposure {
        Exposure::Stops(stops) => stops,
        Exposure::Auto => compared.as_ref().unwrap_or(&image).automatic_exposure(&coverage)?,
    };
    if let Background::Screen(colour) = arguments.background {
        fill_behind(&mut image, &coverage, colour.map(|c| c / stops.exp2() as f32));
    }
    let original = compared.map(|reference| Original::new(reference, stops, tone)).transpose()?;
    let errors = original.map(|original| beside(arguments, &image, &original, &coverage)).transpose()?;
    match linear(&arguments.output)? {
        true => files::write_radiance(&arguments.output, &image)?,
        false => files::write_picture(&arguments.output, &image.develop(stops, tone))?,
    }
    let filled = coverage.iter().filter(|c| **c == 1.0).count() as f64 / coverage.len() as f64;
    let seconds = began.elapsed().as_secs_f64();
    let rendered = Rendered { seconds, picture_s, filled, exposure: stops, errors, note };
    if arguments.json { terminal::say_json(&rendered) } else { terminal::say(sentence(&rendered)) }
}

/// A mesh relit from a matrix, or traced in direct light.
fn drawn(arguments: &Render, bar: &Bar) -> anyhow::Result<Drawn> {
    let scenery = Scenery::new(scenes::load(&arguments.scene, arguments.vertices, arguments.up)?.0)?;
    if arguments.seed.is_some() {
        bail!("--seed belongs to paths: direct light of a mesh is sampled on a grid (--bounces traces paths)");
    }
    let samples = arguments.samples.unwrap_or(if arguments.reference { 2 } else { SAMPLES });
    let camera = arguments.camera(scenery.mesh())?;
    let began = Instant::now();
    let view = scenery.view(camera, samples, bar)?;
    let backdrop: Backdrop = match arguments.background {
        Background::Light => lights::backdrop(light(arguments))?,
        Background::Screen(_) => Box::new(|_| [0.0; 3]),
    };
    let image = match &arguments.matrix {
        Some(matrix) => {
            let (shading, responses) = responses(arguments, matrix, view.vertices())?;
            scenery.image(&view, &shading, responses.view(), backdrop)?
        }
        None => traced(arguments, &scenery, &view, backdrop, bar)?,
    };
    Ok(Drawn { image, coverage: view.coverage(), picture_s: began.elapsed().as_secs_f64(), note: None })
}

/// The light of a mesh.
fn light(arguments: &Render) -> &str {
    arguments.light.as_deref().unwrap_or(worlds::LIGHT)
}

/// Errors against a picture, and the pictures that show them.
fn beside(arguments: &Render, image: &Image, original: &Original, coverage: &[f32]) -> anyhow::Result<Errors> {
    let Comparison { errors, picture, .. } = original.compare(image, coverage)?;
    let map = image.error_map(original.image(), coverage, original.exposure())?;
    if let Some(path) = &arguments.error_map {
        files::write_picture(path, &map)?;
    }
    if let Some(path) = &arguments.beside {
        let row = [picture, original.picture().clone(), map];
        files::write_picture(path, &Picture::beside(&row))?;
    }
    Ok(errors)
}

/// Refuses options that would say nothing.
fn check(arguments: &Render) -> anyhow::Result<()> {
    let Render { output, compare, error_map, beside, exposure, tone, background, .. } = arguments;
    // Not by `requires`: clap waives it where what is required conflicts with what is there.
    if arguments.interpolation.is_some() && arguments.slf.is_none() {
        bail!("--interpolation belongs to --slf DIR");
    }
    if arguments.supersampling.is_some() && !arguments.reference {
        bail!("--supersampling belongs to --reference");
    }
    let plain = linear(output)? && compare.is_none();
    if plain && tone.is_some() {
        bail!("--tone belongs to a .png: {} holds linear radiance", output.display());
    }
    if plain && exposure.is_some() && matches!(background, Background::Light) {
        bail!("--exposure belongs to a .png: {} holds linear radiance", output.display());
    }
    for path in [error_map, beside].into_iter().flatten() {
        files::expect_extension(path, "png")?;
    }
    Ok(())
}

/// Whether the output file holds linear radiance; the other kind is a picture.
fn linear(output: &Path) -> Result<bool> {
    Ok(files::expect_one_of(output, &["png", "exr"])? == "exr")
}

/// A picture to compare with, of the size that will be rendered.
fn compared(path: &Path, size: [usize; 2]) -> Result<Image> {
    let image = files::read_radiance(path)?;
    for (side, expected, found) in [("width", size[0], image.width), ("height", size[1], image.height)] {
        Error::expect_size(format!("{side} of {} (--size says)", path.display()), expected, found)?;
    }
    Ok(image)
}

/// Responses of a matrix of `vertices` samples to the light, rows x 3, and what they make of a view.
fn responses(arguments: &Render, path: &Path, vertices: usize) -> anyhow::Result<(Shading, Array2<f32>)> {
    let Render { scene, brdf, responses, basis, .. } = arguments;
    let relit = |matrix: &dyn Operator, rows: &ResponseBasis| -> anyhow::Result<(Shading, Array2<f32>)> {
        let (path, columns, samples) = (path.display(), matrix.basis(), matrix.shape().samples);
        Error::expect_size(format!("samples of {path}, one for each vertex of {scene}"), vertices, samples)?;
        if let LightBasis::Plain { .. } = columns {
            bail!("{path} does not say what its columns stand for: give --basis");
        }
        if rows.is_plain() {
            bail!("{path} does not say what its rows stand for: give --responses");
        }
        let shading = Shading::new(rows, brdf.as_ref())?;
        let light = rows.light(columns, lights::light(light(arguments), columns)?)?;
        Ok((shading, matrix.relit(light.view())?))
    };
    if files::expect_extension(path, "prt").is_err() {
        let matrix = files::read_matrix(path, &Description { responses: responses.clone(), basis: basis.clone() })?;
        return relit(&matrix, matrix.responses());
    }
    let compressed = files::read_prt(path, &registry())?;
    // A file that was encoded from a bare matrix may leave the meaning of rows open.
    let said = compressed.responses();
    let rows = match responses {
        Some(given) if said.is_plain() && given.responses() == said.responses() => given,
        Some(given) if given != said => bail!("--responses {given}: {} holds {said}", path.display()),
        _ => said,
    };
    if basis.as_ref().is_some_and(|given| given != compressed.basis()) {
        bail!("--basis belongs to a bare matrix: {} holds {}", path.display(), compressed.basis());
    }
    relit(&compressed, rows)
}

/// The brute-force picture.
fn traced(
    arguments: &Render,
    scenery: &Scenery,
    view: &View,
    backdrop: Backdrop,
    progress: &dyn Progress,
) -> Result<Image> {
    let brdf = arguments.brdf.clone().map_or_else(|| "lambert".parse(), Ok)?;
    let reflectance = |out: Vec3, incoming: Vec3| brdf.evaluate(out.as_dvec3(), incoming.as_dvec3()) as f32;
    let usual = Sampling::default();
    let basis = arguments.basis.clone().unwrap_or(LightBasis::Cubemap { resolution: usual.resolution });
    let LightBasis::Cubemap { resolution } = basis else {
        let (what, expected) = ("light of --reference".into(), "cubemap:EDGE".into());
        return Err(Error::Unsupported { what, expected, found: basis.to_string() });
    };
    let sampling = Sampling { resolution, supersampling: arguments.supersampling.unwrap_or(usual.supersampling) };
    let light = lights::light(light(arguments), &basis)?;
    let reference = Reference { surface: scenery.surface(), sampling, light: light.view(), brdf: &reflectance };
    reference.image(view, backdrop, progress)
}

fn sentence(rendered: &Rendered) -> String {
    let Rendered { seconds, picture_s, filled, exposure, errors, note } = rendered;
    let (percent, [seconds, alone]) = (number::short(100.0 * filled), [seconds, picture_s].map(|s| number::short(*s)));
    let mut text = format!(
        "surface on {percent} % of the pixels, exposure {exposure:+.2} EV, rendered in {seconds} s, the picture alone in {alone} s"
    );
    if let Some(errors) = errors {
        let [error, psnr, flip] = [errors.relative_squared_error, errors.psnr_db, errors.flip].map(number::short);
        text += &format!("; relative squared error {error}, PSNR {psnr} dB, FLIP {flip}");
    }
    text + &note.as_ref().map_or(String::new(), |note| format!("\n{note}"))
}
