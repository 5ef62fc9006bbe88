//! The one place where the program learns of lights.

use crate::lobe_file;
use crate::scenes::About;
use ndarray::Array2;
use prt_srbf::ScatteredLight;
use prt_transfer::basis::Direction;
use prt_transfer::image::Image;
use prt_transfer::scene::lights;
use prt_transfer::scene::resample::{lookup, resample, texel_of, turned};
use prt_transfer::{LightBasis, Result, io, sh};
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// The lights under which `prt bench` compares relit output, in the order of the columns of results.csv.
pub const LIGHTS: [&str; 2] = ["sky", "room"];

/// Texels along an edge of the cubemap from which a light is projected onto spherical harmonics.
const PROJECTED: usize = 64;

/// Every built-in light.
pub fn all() -> Vec<About> {
    lights::all().iter().map(|l| About { name: l.name, about: l.about }).collect()
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

/// A distant light, read once for any basis and any turn. What was computed of it is kept; clones share it.
#[derive(Clone)]
pub struct Light {
    source: Arc<Source>,
    known: Arc<Mutex<Vec<Known>>>,
}

/// What a light is made of.
enum Source {
    /// A function of direction.
    BuiltIn(&'static lights::Light),
    /// Lat-long.
    Image(Image),
    /// A sum of them.
    Lobes(ScatteredLight),
}

/// A light on a basis, turned by so many degrees.
struct Known {
    basis: LightBasis,
    degrees: f64,
    values: Array2<f32>,
}

/// Numbers that are kept of a light: 64 MB.
const KEPT: usize = 1 << 24;

/// Lights that are built in, each made when it is first asked for.
static BUILT_IN: LazyLock<Vec<(&'static str, Light)>> =
    LazyLock::new(|| lights::all().iter().map(|light| (light.name, Light::of(Source::BuiltIn(light)))).collect());

impl Light {
    /// As [`light`] takes it.
    pub fn named(name: &str) -> Result<Light> {
        Ok(match Path::new(name).extension() {
            None => {
                let name = lights::find(name)?.name;
                let found = BUILT_IN.iter().find(|(other, _)| *other == name);
                found.expect("what is found is one of all").1.clone()
            }
            Some(_) if is_lobes(name) => Light::lobes(lobe_file::read(Path::new(name))?),
            Some(_) => Light::of(Source::Image(light_image(name)?)),
        })
    }

    /// A sum of lobes.
    pub fn lobes(light: ScatteredLight) -> Light {
        Light::of(Source::Lobes(light))
    }

    fn of(source: Source) -> Light {
        Light { source: Arc::new(source), known: Arc::default() }
    }

    /// On a basis, turned about z by an angle in degrees, counter-clockwise seen from above: lights x 3.
    pub fn on(&self, basis: &LightBasis, degrees: f64) -> Result<Array2<f32>> {
        let degrees = degrees.rem_euclid(360.0);
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known().iter().find(|known| known.degrees == degrees && known.basis == *basis) {
            return Ok(known.values.clone());
        }
        let values = self.computed(basis, degrees)?;
        let mut known = known();
        if known.iter().map(|known| known.values.len()).sum::<usize>() + values.len() > KEPT {
            known.clear();
        }
        known.push(Known { basis: basis.clone(), degrees, values: values.clone() });
        Ok(values)
    }

    /// Tells it from another on a basis; 0 where the basis has no place on the sphere.
    pub fn checksum(&self, basis: &LightBasis) -> u32 {
        let bytes = |values: Array2<f32>| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        self.on(basis, 0.0).map_or(0, |values| crc32fast::hash(&bytes(values)))
    }

    fn computed(&self, basis: &LightBasis, degrees: f64) -> Result<Array2<f32>> {
        if let LightBasis::SphericalHarmonics { order } = *basis {
            return match degrees == 0.0 {
                true => projected(order, |texels| self.on(texels, 0.0)),
                // Harmonics turn exactly: of all turns together one projection is made.
                false => turned_harmonics(order, &self.on(basis, 0.0)?, degrees),
            };
        }
        match &*self.source {
            Source::BuiltIn(light) => light.environment().turned(degrees).texels(basis),
            Source::Image(image) => resample(&turned(image, degrees), basis),
            Source::Lobes(light) if degrees == 0.0 => light.texels(basis),
            Source::Lobes(light) => light.rotated(about_z(degrees))?.texels(basis),
        }
    }
}

/// The matrix of a turn about z by so many degrees, row by row.
fn about_z(degrees: f64) -> [Direction; 3] {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]
}

/// Spherical harmonics, coefficients x channels, turned about z.
fn turned_harmonics(order: usize, still: &Array2<f32>, degrees: f64) -> Result<Array2<f32>> {
    let rotation = sh::Rotation::new(order, about_z(degrees))?;
    let (values, mut turned) = (still.mapv(f64::from), Array2::zeros(still.dim()));
    for (still, mut turned) in values.columns().into_iter().zip(turned.columns_mut()) {
        let mut out = vec![0.0; still.len()];
        rotation.apply(&still.to_vec(), &mut out)?;
        turned.iter_mut().zip(out).for_each(|(to, value)| *to = value as f32);
    }
    Ok(turned)
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
    Ok(match &*Light::named(name)?.source {
        Source::BuiltIn(light) => {
            let environment = light.environment();
            Box::new(move |direction| environment.radiance(direction))
        }
        Source::Image(image) => {
            let image = image.clone();
            Box::new(move |direction| lookup(&image, direction))
        }
        Source::Lobes(light) => {
            let light = light.clone();
            Box::new(move |direction| {
                let radiance = light.radiance(direction);
                [0, 1, 2].map(|channel| radiance[channel] as f32)
            })
        }
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
        vec![Light::named("room").unwrap(), Light::named(&path.display().to_string()).unwrap(), Light::lobes(lobes)]
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

    /// To what texels of 1.4 degrees leave of a turn: the turned harmonics are the harmonics of the turned light.
    #[test]
    fn harmonics_turn_with_the_light() {
        let (folder, order) = (tempfile::tempdir().unwrap(), 5);
        let basis = LightBasis::SphericalHarmonics { order };
        for light in some(folder.path()) {
            let (still, turned) = (light.on(&basis, 0.0).unwrap(), light.on(&basis, 25.0).unwrap());
            let expected = projected(order, |texels| light.on(texels, 25.0)).unwrap();
            assert!(difference(&turned, &expected) < 1e-4, "{}", difference(&turned, &expected));
            assert!(difference(&turned, &still) > 1e-2);
        }
    }

    #[test]
    fn what_was_computed_is_given_again() {
        let (light, basis) = (Light::named("sky").unwrap(), "cubemap:5".parse().unwrap());
        let first = light.on(&basis, 33.0).unwrap();
        let kept = |light: &Light| light.known.lock().unwrap().iter().filter(|known| known.basis == basis).count();
        assert_eq!((light.on(&basis, 393.0).unwrap(), kept(&light)), (first.clone(), 1));
        assert_eq!((Light::named("sky").unwrap().on(&basis, 33.0).unwrap(), kept(&light)), (first, 1));
    }
}
