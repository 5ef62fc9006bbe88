//! Pictures of worlds: from surface light fields, or path-traced.

use super::{Background, Drawn, Render};
use crate::light_field::Fields;
use crate::progress::Bar;
use crate::worlds::{self, Look, Needs};
use anyhow::{bail, ensure};
use prt_transfer::basis::Direction;
use prt_transfer::scene::path::{self, PathParams, PathTracer};
use prt_transfer::scene::picture::Shot;
use std::time::Instant;

/// Most samples along an edge of a pixel of a path-traced picture.
const MAX_TRACED: usize = 64;

/// Whether a picture is one of a world: of paths or of light fields, not of transfer.
pub(super) fn is_asked_for(arguments: &Render) -> bool {
    arguments.slf.is_some() || arguments.bounces.is_some() || worlds::is_built_in(&arguments.scene)
}

/// The picture, linear radiance.
pub(super) fn drawn(arguments: &Render, bar: &Bar) -> anyhow::Result<Drawn> {
    check(arguments)?;
    let look = Look { light: arguments.light.as_deref(), brdf: arguments.brdf.as_ref(), up: arguments.up };
    let needs = if arguments.slf.is_some() { Needs::Charts } else { Needs::Nothing };
    let world = worlds::load(&arguments.scene, look, needs)?;
    let camera = arguments.camera(world.mesh())?;
    let background = |direction: Direction| match (arguments.background, world.sky()) {
        (Background::Light, Some(sky)) => sky.radiance(direction),
        _ => [0.0; 3],
    };
    let usual = PathParams { seed: arguments.seed.unwrap_or_default(), ..PathParams::default() };
    let tracer = PathTracer::new(&world, PathParams { bounces: arguments.bounces.unwrap_or(usual.bounces), ..usual })?;
    let Some(folder) = &arguments.slf else {
        let n = arguments.samples.unwrap_or(4);
        let range = 1..=MAX_TRACED;
        ensure!(range.contains(&n), "--samples {n}: a path-traced pixel has 1 to {MAX_TRACED} samples along an edge");
        let began = Instant::now();
        let path::Traced { image, coverage, tally } = path::image(&tracer, &camera, (n * n) as u32, background, bar)?;
        let lost = tally.not_finite;
        let note = (lost > 0).then(|| format!("{lost} paths brought no finite radiance and count as none"));
        return Ok(Drawn { image, coverage, picture_s: began.elapsed().as_secs_f64(), note });
    };
    let fields = Fields::read(folder, &world, arguments.interpolation.unwrap_or_default())?;
    let shot = Shot { camera: &camera, samples: arguments.samples.unwrap_or(3), background: &background };
    let began = Instant::now();
    let (image, coverage) = fields.picture(&tracer, &shot, bar)?;
    let without = fields.without(&world);
    let note = (!without.is_empty()).then(|| format!("without a field, and traced: {}", without.join(", ")));
    Ok(Drawn { image, coverage, picture_s: began.elapsed().as_secs_f64(), note })
}

/// Refuses what belongs to transfer matrices.
fn check(arguments: &Render) -> anyhow::Result<()> {
    let Render { scene, matrix, vertices, responses, basis, supersampling, .. } = arguments;
    if matrix.is_some() {
        bail!("{scene} is drawn from fields (--slf DIR) or traced (--reference), not from a transfer matrix");
    }
    let foreign = [
        ("--vertices", vertices.is_some()),
        ("--responses", responses.is_some()),
        ("--basis", basis.is_some()),
        ("--supersampling", supersampling.is_some()),
    ];
    match foreign.iter().find(|(_, given)| *given) {
        Some((option, _)) => bail!("{option} belongs to a transfer matrix, not to the paths and fields of {scene}"),
        None => Ok(()),
    }
}
