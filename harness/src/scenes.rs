//! The one place where the program learns of scenes, lights and signals.

use crate::signal::{Signal, Spec};
use ndarray::Array2;
use prt_transfer::basis::Direction;
use prt_transfer::image::Image;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::biscale::biscale;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::diffuse::diffuse;
use prt_transfer::scene::frames::vertex_frames;
use prt_transfer::scene::repair::{Repairs, repair};
use prt_transfer::scene::resample::{lookup, resample};
use prt_transfer::scene::signal::{Sampling, Surface, Traced};
use prt_transfer::scene::{lights, shapes};
use prt_transfer::{Error, LightBasis, Progress, Result, TransferMatrix, io, sh};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// A built-in scene or light.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// Its name.
    pub name: &'static str,
    /// A sentence.
    pub about: &'static str,
}

/// A matrix and what it took.
pub struct Precomputed {
    /// The transfer matrix.
    pub matrix: TransferMatrix,
    /// What was mended in the mesh.
    pub repairs: Repairs,
    /// Occlusion rays answered, and the time that took, summed over threads.
    pub traced: Traced,
    /// Wall clock of everything, s.
    pub seconds: f64,
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

/// The transfer matrix of a built-in scene with about `vertices` vertices, or of a mesh file, which has its own.
pub fn precompute(scene: &str, vertices: Option<usize>, spec: &Spec, progress: &dyn Progress) -> Result<Precomputed> {
    let began = Instant::now();
    let (mesh, repairs) = load(scene, vertices)?;
    let (occluders, frames) = (Occluders::new(&mesh)?, vertex_frames(&mesh)?);
    let surface = Surface { occluders: &occluders, points: &mesh.positions, frames: &frames };
    let mut sampling = Sampling { supersampling: spec.supersampling, ..Sampling::default() };
    if let LightBasis::Cubemap { resolution } = spec.basis {
        sampling.resolution = resolution;
    }
    let (matrix, traced) = match spec.signal {
        Signal::Diffuse => diffuse(&surface, &sampling, &spec.basis, progress)?,
        Signal::Biscale => {
            let sampled = LightBasis::Cubemap { resolution: sampling.resolution };
            if spec.basis != sampled {
                let (what, expected) = ("light basis of a biscale signal".into(), "cubemap:EDGE".into());
                return Err(Error::Unsupported { what, expected, found: spec.basis.to_string() });
            }
            biscale(&surface, &sampling, spec.local_directions, progress)?
        }
    };
    Ok(Precomputed { matrix, repairs, traced, seconds: began.elapsed().as_secs_f64() })
}

/// The mesh of a scene, repaired: its vertices are the samples of its matrices.
pub fn load(scene: &str, vertices: Option<usize>) -> Result<(Mesh, Repairs)> {
    repair(mesh(scene, vertices)?).map_err(|e| e.in_file(scene))
}

/// A mesh file by its extension, or a built-in scene.
fn mesh(scene: &str, vertices: Option<usize>) -> Result<Mesh> {
    if Path::new(scene).extension().is_none() {
        let shape = shapes::find(scene)?;
        return shape.build(vertices.unwrap_or(shape.default_vertices));
    }
    match vertices {
        None => io::mesh::read(scene),
        Some(vertices) => Err(Error::Unsupported {
            what: format!("vertices of {scene}"),
            expected: "its own, which a mesh file keeps".into(),
            found: vertices.to_string(),
        }),
    }
}

/// A built-in light or an image file (.exr, .hdr) in `basis`: lights x 3 channels. Negative pixels are taken for 0.
pub fn light(name: &str, basis: &LightBasis) -> Result<Array2<f32>> {
    if let LightBasis::SphericalHarmonics { order } = *basis {
        let texels = LightBasis::Cubemap { resolution: PROJECTED };
        let values = light(name, &texels)?;
        let mut coefficients = Array2::zeros((basis.lights(), values.ncols()));
        for (channel, values) in values.columns().into_iter().enumerate() {
            let projected = sh::project(order, &texels, &values.to_vec())?;
            coefficients.column_mut(channel).iter_mut().zip(projected).for_each(|(c, p)| *c = p as f32);
        }
        return Ok(coefficients);
    }
    if Path::new(name).extension().is_none() {
        return lights::find(name)?.environment().texels(basis);
    }
    resample(&light_image(name)?, basis)
}

/// Linear RGB radiance by unit direction.
pub type Backdrop = Box<dyn Fn(Direction) -> [f32; 3] + Sync>;

/// A light as the eye sees it: what is built in at its true sharpness, an image file between the centres of its pixels.
pub fn backdrop(name: &str) -> Result<Backdrop> {
    if Path::new(name).extension().is_none() {
        let environment = lights::find(name)?.environment();
        return Ok(Box::new(move |direction| environment.radiance(direction)));
    }
    let image = light_image(name)?;
    Ok(Box::new(move |direction| lookup(&image, direction)))
}

/// A lat-long image file; negative pixels are taken for 0.
fn light_image(name: &str) -> Result<Image> {
    let mut image = io::image::read(name)?;
    image.clamp_negatives().map_err(|e| e.in_file(name))?;
    Ok(image)
}
