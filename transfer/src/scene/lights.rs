//! Built-in lights, by name.

use super::environment::Environment;
use super::{room, sky};
use crate::error::{Error, Result};

/// A distant light that is built in.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Its name, as in `prt relight --light sky`.
    pub name: &'static str,
    /// One sentence on what it is.
    pub about: &'static str,
    build: fn() -> Environment,
}

const LIGHTS: [Light; 2] = [
    Light {
        name: "sky",
        about: "clear sky with a sun of its true size (Preetham et al. 1999), above brown ground",
        build: sky::environment,
    },
    Light {
        name: "room",
        about: "room with three windows and four small lamps, radiance range above 10,000",
        build: room::environment,
    },
];

/// Every built-in light.
pub fn all() -> &'static [Light] {
    &LIGHTS
}

/// The light of this name.
pub fn find(name: &str) -> Result<&'static Light> {
    LIGHTS.iter().find(|light| light.name == name).ok_or_else(|| Error::Unknown {
        what: "light",
        name: name.into(),
        known: LIGHTS.map(|light| light.name).join(", "),
    })
}

impl Light {
    /// The light itself.
    pub fn environment(&self) -> Environment {
        (self.build)()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::LightBasis;
    use crate::scene::resample::resample;

    fn energy(basis: &LightBasis, texels: &ndarray::Array2<f32>) -> f64 {
        let angles = basis.solid_angles().unwrap();
        angles.iter().zip(texels.column(1)).map(|(a, &l)| a * f64::from(l)).sum()
    }

    #[test]
    fn the_total_energy_of_a_light_does_not_depend_on_the_resolution() {
        for light in all().iter().map(Light::environment) {
            let bases = ["latlong:512x256", "latlong:64x32", "cubemap:8", "cubemap:32"].map(|b| b.parse().unwrap());
            let [reference, others @ ..] = bases.map(|basis| energy(&basis, &light.texels(&basis).unwrap()));
            for other in others {
                assert!((other / reference - 1.0).abs() < 5e-3, "{reference} {others:?}");
            }
        }
    }

    #[test]
    fn an_image_of_a_light_resampled_is_the_light_itself() {
        let basis = LightBasis::Cubemap { resolution: 16 };
        for light in all().iter().map(Light::environment) {
            let (direct, image) = (light.texels(&basis).unwrap(), light.image(512, 256).unwrap());
            let resampled = resample(&image, &basis).unwrap();
            assert!((energy(&basis, &resampled) / energy(&basis, &direct) - 1.0).abs() < 5e-3);
            // Squared difference against the brightest texels would hide all else: compare logarithms.
            let difference: f64 =
                direct.iter().zip(&resampled).map(|(a, b)| f64::from((a / b).ln().abs())).sum::<f64>()
                    / direct.len() as f64;
            assert!(difference < 0.03, "{difference}");
        }
    }

    #[test]
    fn lights_are_found_by_name_and_unknown_names_list_them() {
        for light in all() {
            assert_eq!(find(light.name).unwrap().about, light.about);
        }
        assert!(find("moon").err().unwrap().to_string().contains("known: sky, room"));
    }
}
