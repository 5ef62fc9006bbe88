//! The one place where the program learns of scenes and lights.

use crate::lobe_file;
use clap::ValueEnum;
use glam::Vec3;
use ndarray::Array2;
use prt_srbf::ScatteredLight;
use prt_transfer::basis::Direction;
use prt_transfer::image::Image;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::repair::{Repairs, repair};
use prt_transfer::scene::resample::{lookup, resample, texel_of};
use prt_transfer::scene::{lights, shapes};
use prt_transfer::{Error, LightBasis, Result, io, sh};
use serde::Serialize;
use std::path::Path;

/// A built-in scene or light.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// Its name.
    pub name: &'static str,
    /// A sentence.
    pub about: &'static str,
}

/// The lights under which `prt bench` compares relit output, in the order of the columns of results.csv.
pub const LIGHTS: [&str; 2] = ["sky", "room"];

/// Texels along an edge of the cubemap from which a light is projected onto spherical harmonics.
const PROJECTED: usize = 64;

/// Every built-in scene.
pub fn scenes() -> Vec<About> {
    shapes::all().iter().map(|s| About { name: s.name, about: s.about }).collect()
}

/// Every built-in light.
pub fn lights() -> Vec<About> {
    lights::all().iter().map(|l| About { name: l.name, about: l.about }).collect()
}

/// Which axis of a mesh file points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Up {
    /// The mesh is turned about x.
    Y,
    /// As everywhere here.
    #[default]
    Z,
}

/// The mesh of a built-in scene with about `vertices` vertices, or of a mesh file, which has its own; repaired: its
/// vertices are the samples of its matrices.
pub fn load(scene: &str, vertices: Option<usize>, up: Up) -> Result<(Mesh, Repairs)> {
    repair(mesh(scene, vertices, up)?).map_err(|e| e.in_file(scene))
}

/// A mesh file by its extension, or a built-in scene.
fn mesh(scene: &str, vertices: Option<usize>, up: Up) -> Result<Mesh> {
    let refuse = |what: &str, expected: &str, found: String| {
        Err(Error::Unsupported { what: format!("{what} of {scene}"), expected: expected.into(), found })
    };
    if Path::new(scene).extension().is_none() {
        let shape = shapes::find(scene)?;
        return match up {
            Up::Z => shape.build(vertices.unwrap_or(shape.default_vertices)),
            Up::Y => refuse("upward axis", "z, as of every built-in scene", "y".into()),
        };
    }
    if let Some(vertices) = vertices {
        return refuse("vertices", "its own, which a mesh file keeps", vertices.to_string());
    }
    Ok(upright(io::mesh::read(scene)?, up))
}

/// A mesh with the axis that points up in its file as z.
pub fn upright(mesh: Mesh, up: Up) -> Mesh {
    if up == Up::Y { mesh.turned(|v| Vec3::new(v.x, -v.z, v.y)) } else { mesh }
}

/// A built-in light, an image file (.exr, .hdr) or lobes (.json) in `basis`: lights x 3 channels. Negative pixels are taken for 0; lobes
/// count as they are.
pub fn light(name: &str, basis: &LightBasis) -> Result<Array2<f32>> {
    if let LightBasis::SphericalHarmonics { order } = *basis {
        return projected(order, |texels| light(name, texels));
    }
    if Path::new(name).extension().is_none() {
        return lights::find(name)?.environment().texels(basis);
    }
    if is_lobes(name) {
        return lobe_light(&lobe_file::read(Path::new(name))?, basis);
    }
    resample(&light_image(name)?, basis)
}

/// A light of lobes in `basis`: lights x channels.
pub fn lobe_light(light: &ScatteredLight, basis: &LightBasis) -> Result<Array2<f32>> {
    match *basis {
        LightBasis::SphericalHarmonics { order } => projected(order, |texels| light.texels(texels)),
        _ => light.texels(basis),
    }
}

/// Spherical harmonics of a light on texels, coefficients x channels.
fn projected(order: usize, light: impl FnOnce(&LightBasis) -> Result<Array2<f32>>) -> Result<Array2<f32>> {
    let texels = LightBasis::Cubemap { resolution: PROJECTED };
    let values = light(&texels)?;
    let mut coefficients = Array2::zeros((order * order, values.ncols()));
    for (channel, values) in values.columns().into_iter().enumerate() {
        let projected = sh::project(order, &texels, &values.to_vec())?;
        coefficients.column_mut(channel).iter_mut().zip(projected).for_each(|(c, p)| *c = p as f32);
    }
    Ok(coefficients)
}

/// Linear RGB radiance by unit direction.
pub type Backdrop = Box<dyn Fn(Direction) -> [f32; 3] + Send + Sync>;

/// A light as the eye sees it: what is built in at its true sharpness, an image file between the centres of its pixels.
pub fn backdrop(name: &str) -> Result<Backdrop> {
    if Path::new(name).extension().is_none() {
        let environment = lights::find(name)?.environment();
        return Ok(Box::new(move |direction| environment.radiance(direction)));
    }
    if is_lobes(name) {
        let light = lobe_file::read(Path::new(name))?;
        return Ok(Box::new(move |direction| {
            let radiance = light.radiance(direction);
            [0, 1, 2].map(|channel| radiance[channel] as f32)
        }));
    }
    let image = light_image(name)?;
    Ok(Box::new(move |direction| lookup(&image, direction)))
}

/// Whether a light is a file of lobes.
pub fn is_lobes(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

/// Texels as a lat-long image of `width` x `height` pixels, each the texel that holds its centre; black where a basis has no texels.
pub fn unwrapped(basis: &LightBasis, texels: &Array2<f32>, [width, height]: [usize; 2]) -> Image {
    let directions = LightBasis::LatLong { width, height }.directions().unwrap_or_default();
    let texel = |d: Direction| texel_of(basis, d).map_or([0.0; 3], |k| [0, 1, 2].map(|channel| texels[[k, channel]]));
    Image { width, height, pixels: directions.into_iter().map(texel).collect() }
}

/// A lat-long image file; negative pixels are taken for 0.
fn light_image(name: &str) -> Result<Image> {
    let mut image = io::image::read(name)?;
    image.clamp_negatives().map_err(|e| e.in_file(name))?;
    Ok(image)
}
