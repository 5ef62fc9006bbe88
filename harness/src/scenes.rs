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
use prt_transfer::scene::resample::{lookup, resample, texel_of, turned};
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
    turned_light(name, basis, 0.0)
}

/// [`light`], turned about z by an angle in degrees, counter-clockwise seen from above.
pub fn turned_light(name: &str, basis: &LightBasis, degrees: f64) -> Result<Array2<f32>> {
    Light::named(name)?.on(basis, degrees)
}

/// A distant light, read once for any basis and any turn.
pub enum Light {
    /// By its function of direction.
    BuiltIn(&'static lights::Light),
    /// Lat-long.
    Image(Image),
    /// A sum of them.
    Lobes(ScatteredLight),
}

impl Light {
    /// As [`light`] takes it.
    pub fn named(name: &str) -> Result<Light> {
        match Path::new(name).extension() {
            None => Ok(Light::BuiltIn(lights::find(name)?)),
            Some(_) if is_lobes(name) => Ok(Light::Lobes(lobe_file::read(Path::new(name))?)),
            Some(_) => Ok(Light::Image(light_image(name)?)),
        }
    }

    /// On a basis, turned about z by an angle in degrees, counter-clockwise seen from above: lights x 3.
    pub fn on(&self, basis: &LightBasis, degrees: f64) -> Result<Array2<f32>> {
        if let LightBasis::SphericalHarmonics { order } = *basis {
            return projected(order, |texels| self.on(texels, degrees));
        }
        let degrees = degrees.rem_euclid(360.0);
        match self {
            Light::BuiltIn(light) => light.environment().turned(degrees).texels(basis),
            Light::Image(image) => resample(&turned(image, degrees), basis),
            Light::Lobes(light) if degrees == 0.0 => light.texels(basis),
            Light::Lobes(light) => {
                let (sine, cosine) = degrees.to_radians().sin_cos();
                light.rotated([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])?.texels(basis)
            }
        }
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
    Ok(match Light::named(name)? {
        Light::BuiltIn(light) => {
            let environment = light.environment();
            Box::new(move |direction| environment.radiance(direction))
        }
        Light::Image(image) => Box::new(move |direction| lookup(&image, direction)),
        Light::Lobes(light) => Box::new(move |direction| {
            let radiance = light.radiance(direction);
            [0, 1, 2].map(|channel| radiance[channel] as f32)
        }),
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use prt_srbf::{Kernel, Lobe};
    use prt_transfer::io::image::{Precision, write_exr};

    /// A built-in light, an image and a lobe.
    fn some(folder: &Path) -> Vec<Light> {
        let pixels = (0..64 * 32).map(|i| [(i * 37 % 101) as f32, 1.0, if i == 700 { 1e4 } else { 0.0 }]).collect();
        let path = folder.join("light.exr");
        write_exr(&path, &Image { width: 64, height: 32, pixels }, Precision::Single).unwrap();
        let lobes = vec![Lobe { centre: [0.6, 0.0, 0.8], bandwidth: 9.0 }];
        let lobes = ScatteredLight::new(Kernel::Gaussian, lobes, Array2::from_elem((1, 3), 2.0)).unwrap();
        vec![Light::named("room").unwrap(), Light::named(&path.display().to_string()).unwrap(), Light::Lobes(lobes)]
    }

    fn difference(a: &Array2<f32>, b: &Array2<f32>) -> f64 {
        let square = |values: &Array2<f32>| values.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
        square(&(a - b)) / square(b)
    }

    #[test]
    fn a_light_that_is_not_turned_or_wholly_so_is_the_light_itself() {
        for basis in ["cubemap:8", "latlong:16x8", "sh:5"].map(|text| text.parse().unwrap()) {
            for name in ["sky", "room"] {
                let still = light(name, &basis).unwrap();
                for degrees in [0.0, 360.0, -720.0] {
                    assert_eq!(turned_light(name, &basis, degrees).unwrap(), still, "{basis} {name} {degrees}");
                }
                assert!(difference(&turned_light(name, &basis, 90.0).unwrap(), &still) > 1e-3);
            }
        }
    }

    /// A quarter turn takes the texels of a cubemap onto each other.
    #[test]
    fn a_quarter_turn_moves_the_texels_of_a_cubemap() {
        let (folder, basis) = (tempfile::tempdir().unwrap(), LightBasis::Cubemap { resolution: 6 });
        for light in some(folder.path()) {
            let (still, turned) = (light.on(&basis, 0.0).unwrap(), light.on(&basis, 90.0).unwrap());
            let from = |[x, y, z]: Direction| texel_of(&basis, [y, -x, z]).unwrap();
            let sources: Vec<usize> = basis.directions().unwrap().into_iter().map(from).collect();
            let moved = Array2::from_shape_fn(still.dim(), |(k, channel)| still[[sources[k], channel]]);
            assert!(difference(&turned, &moved) < 1e-8, "{}", difference(&turned, &moved));
        }
    }

    /// To what texels of 1.4 degrees leave of a turn: the harmonics of a turned light are the turned harmonics.
    #[test]
    fn harmonics_turn_with_the_light() {
        let (folder, order) = (tempfile::tempdir().unwrap(), 5);
        let (sine, cosine) = 25f64.to_radians().sin_cos();
        let rows = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]];
        let rotation = sh::Rotation::new(order, rows).unwrap();
        for light in some(folder.path()) {
            let basis = LightBasis::SphericalHarmonics { order };
            let (still, turned) = (light.on(&basis, 0.0).unwrap(), light.on(&basis, 25.0).unwrap());
            let mut expected = still.clone();
            for (mut column, still) in expected.columns_mut().into_iter().zip(still.columns()) {
                let (coefficients, mut out) = (still.mapv(f64::from).to_vec(), vec![0.0; order * order]);
                rotation.apply(&coefficients, &mut out).unwrap();
                column.iter_mut().zip(out).for_each(|(to, value)| *to = value as f32);
            }
            assert!(difference(&turned, &expected) < 1e-4, "{}", difference(&turned, &expected));
            assert!(difference(&turned, &still) > 1e-2);
        }
    }
}
