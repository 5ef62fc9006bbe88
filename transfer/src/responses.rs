//! What the responses of a sample stand for.
//!
//! The rows of a sample are coefficients of what leaves it. With weights `w_r(v)` that depend on the local view
//! direction `v`, the radiance towards `v` is `Σ_r w_r(v) y_r` for the sample's responses `y = T x`. As on the side of
//! the lights ([`crate::basis`]), a squared error of responses is an error of radiance only in the metric of their
//! functions: the Gram matrix `A_ij = ∫ w_i w_j dv` over the hemisphere.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::label::Stage;
use crate::matrix::{MAX_LIGHTS, Shape};
use crate::sh::HemisphereSh;
use crate::texels::Texels;
use ndarray::Array2;
use std::fmt;
use std::str::FromStr;

/// The response basis of a transfer matrix's rows. Written as `plain:64`, `irradiance` or `irradiance:BRDF`, `local:8`,
/// `exit:24`, `exit-orthonormal:24`, `terms:16:BRDF` or `texels:256x256`, where a BRDF is a name with all of its parameters.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ResponseBasis {
    /// Numbers without a meaning that is known.
    Plain {
        /// How many.
        responses: usize,
    },
    /// One response: irradiance in W/m², of a Lambertian surface.
    Irradiance {
        /// The surface's, where it took part: in light that it reflected onto itself.
        brdf: Option<String>,
    },
    /// Light that arrives from around `edge`² directions in the sample's frame, see
    /// [`crate::hemisphere::local_directions`]: elements are parts of texels that are seen, without solid angles, which
    /// the light must bring along.
    LocalDirections {
        /// Directions along an edge of the square.
        edge: usize,
    },
    /// Exit radiance in real spherical harmonics on the hemisphere around the normal (Sloan et al. 2003, appendix):
    /// order² functions, or order² - 1 without the one of l = 1, m = 0, which the others nearly make up. They are not
    /// orthonormal there.
    Exit {
        /// How many functions.
        coefficients: usize,
        /// Which coefficients of them.
        coordinates: Coordinates,
    },
    /// View-dependent functions φ_k of a BRDF that was factored into views and lights (Tsai and Shih 2006, Eq. 9),
    /// orthonormal over projected solid angle: ∫ φ_j φ_k cos θ dv is 1 or 0, so that views count as much as a picture
    /// shows of the surface.
    Terms {
        /// How many functions.
        terms: usize,
        /// The BRDF, from which the functions are computed anew.
        brdf: String,
    },
    /// A surface light field: samples are the texels of a surface in rows, responses red, green and blue, and an element is the radiance that
    /// leaves the texel towards the direction of the column, without solid angles, which the light must bring along.
    Radiance {
        /// The surface's texels; as many as samples.
        texels: Texels,
        /// What the columns' directions are.
        directions: Directions,
    },
}

/// Coordinates of exit radiance f on the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coordinates {
    /// c: f = Σ c_i y_i by least squares, the paper's. A squared error in them is no error of radiance: `∫ f² = cᵀ A
    /// c`.
    Harmonics,
    /// d = Lᵀ c with A = L Lᵀ: those of the same functions made orthonormal in the order of their bands. `∫ f² = |d|²`,
    /// so that any codec that minimises squared error minimises that of radiance.
    Orthonormal,
}

crate::choices! {
    /// What a direction of a surface light field stands for.
    pub enum Directions {
        /// Where radiance goes, in the world (Miandji et al. 2011).
        World = "world",
        /// Where it would have come from in a mirror: the direction is mirrored about the point's normal (Wood et al. 2000). What a lobe
        /// reflects of a distant scene then is nearly the same at all points.
        Reflected = "reflected",
    }
}

impl ResponseBasis {
    /// Responses of a sample.
    pub fn responses(&self) -> usize {
        match *self {
            ResponseBasis::Plain { responses } => responses,
            ResponseBasis::Irradiance { .. } => 1,
            ResponseBasis::LocalDirections { edge } => edge * edge,
            ResponseBasis::Exit { coefficients, .. } => coefficients,
            ResponseBasis::Terms { terms, .. } => terms,
            ResponseBasis::Radiance { .. } => 3,
        }
    }

    /// Refuses a matrix of another number of responses, or of samples where that is known.
    pub(crate) fn check(&self, shape: Shape) -> Result<()> {
        Error::expect_size(format!("responses of basis {self}"), shape.responses, self.responses())?;
        match self {
            ResponseBasis::Radiance { texels, .. } => {
                Error::expect_size(format!("samples of basis {self}"), shape.samples, texels.count())
            }
            _ => Ok(()),
        }
    }

    /// Whether elements stand for a whole texel of the light, whose solid angle the light must bring along.
    fn leaves_solid_angles_to_the_light(&self) -> bool {
        matches!(self, ResponseBasis::LocalDirections { .. } | ResponseBasis::Radiance { .. })
    }

    /// What a light of `basis`, lights x channels of radiance, must be for `y = T x`: itself, or for local directions
    /// and light fields radiance times the solid angle of its texel.
    ///
    /// # Errors
    /// A light of another size.
    pub fn light(&self, basis: &LightBasis, mut light: Array2<f32>) -> Result<Array2<f32>> {
        if let (true, Some(angles)) = (self.leaves_solid_angles_to_the_light(), basis.solid_angles()) {
            Error::expect_size("texels of the light", angles.len(), light.nrows())?;
            light.rows_mut().into_iter().zip(angles).for_each(|(mut row, angle)| row *= angle as f32);
        }
        Ok(light)
    }

    /// Weights of the columns, of mean 1, in which a squared error of elements is the expected one of output under
    /// light that is white noise over the sphere: 1/dω where elements hold their texel's solid angle, dω where the
    /// light brings it along. `None` where all are equal or columns have no place on the sphere.
    pub fn light_weights(&self, basis: &LightBasis) -> Option<Vec<f64>> {
        if !self.leaves_solid_angles_to_the_light() {
            return basis.sphere_weights();
        }
        let angles = basis.solid_angles()?;
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        Some(angles.iter().map(|a| a / mean).collect())
    }

    /// Whether nothing is known but their number.
    pub fn is_plain(&self) -> bool {
        matches!(self, ResponseBasis::Plain { .. })
    }
}

impl fmt::Display for ResponseBasis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ResponseBasis::Plain { responses } => write!(f, "plain:{responses}"),
            ResponseBasis::Irradiance { brdf: None } => f.write_str("irradiance"),
            ResponseBasis::Irradiance { brdf: Some(brdf) } => write!(f, "irradiance:{brdf}"),
            ResponseBasis::LocalDirections { edge } => write!(f, "local:{edge}"),
            ResponseBasis::Exit { coefficients, coordinates: Coordinates::Harmonics } => {
                write!(f, "exit:{coefficients}")
            }
            ResponseBasis::Exit { coefficients, coordinates: Coordinates::Orthonormal } => {
                write!(f, "exit-orthonormal:{coefficients}")
            }
            ResponseBasis::Terms { terms, brdf } => write!(f, "terms:{terms}:{brdf}"),
            ResponseBasis::Radiance { texels, directions: Directions::World } => write!(f, "texels:{texels}"),
            ResponseBasis::Radiance { texels, directions: Directions::Reflected } => {
                write!(f, "texels:{texels}:reflected")
            }
        }
    }
}

impl FromStr for ResponseBasis {
    type Err = Error;

    /// A number alone is a plain basis.
    fn from_str(text: &str) -> Result<ResponseBasis> {
        let refuse = || {
            Error::Unknown {
            what: "response basis",
            name: text.into(),
            known:
                "a number, plain:NUMBER, irradiance, irradiance:BRDF, local:EDGE, exit:COEFFICIENTS and exit-orthonormal:COEFFICIENTS \
                    (n² or n² - 1, n up to 10), terms:NUMBER:BRDF, texels:WIDTHxHEIGHT with :wrap or :octahedral, and with :reflected"
                    .into(),
        }
        };
        let number = |t: &str, most: usize| t.parse().ok().filter(|n| (1..=most).contains(n)).ok_or_else(refuse);
        if text.bytes().all(|b| b.is_ascii_digit()) {
            return Ok(ResponseBasis::Plain { responses: number(text, MAX_LIGHTS)? });
        }
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let exit = |coordinates| match number(rest, HemisphereSh::MAX_ORDER.pow(2))? {
            coefficients if HemisphereSh::new(coefficients).is_ok() => {
                Ok(ResponseBasis::Exit { coefficients, coordinates })
            }
            _ => Err(refuse()),
        };
        // A name and parameters, whoever knows them: nothing that could not be printed.
        let brdf = |rest: &str| match rest.bytes().all(|b| b.is_ascii_graphic()) {
            true => rest.parse::<Stage>().map(|stage| stage.to_string()),
            false => Err(refuse()),
        };
        match kind {
            "plain" => Ok(ResponseBasis::Plain { responses: number(rest, MAX_LIGHTS)? }),
            "irradiance" if text == kind => Ok(ResponseBasis::Irradiance { brdf: None }),
            "irradiance" => Ok(ResponseBasis::Irradiance { brdf: Some(brdf(rest)?) }),
            "local" => Ok(ResponseBasis::LocalDirections { edge: number(rest, crate::hemisphere::MAX_EDGE)? }),
            "exit" => exit(Coordinates::Harmonics),
            "exit-orthonormal" => exit(Coordinates::Orthonormal),
            "texels" => {
                let (rest, directions) = match rest.strip_suffix(":reflected") {
                    Some(rest) => (rest, Directions::Reflected),
                    None => (rest, Directions::World),
                };
                let texels = rest.parse().map_err(|_| refuse())?;
                Ok(ResponseBasis::Radiance { texels, directions })
            }
            "terms" => match rest.split_once(':') {
                Some((terms, rest)) => {
                    Ok(ResponseBasis::Terms { terms: number(terms, MAX_LIGHTS)?, brdf: brdf(rest)? })
                }
                None => Err(refuse()),
            },
            _ => Err(refuse()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_basis_reads_back_what_it_prints() {
        let brdf = "terms:16:cook-torrance:roughness=0.3";
        for text in [
            "plain:64",
            "irradiance",
            "irradiance:lambert:albedo=0.5",
            "local:8",
            "exit:16",
            "exit:24",
            "exit-orthonormal:99",
            "texels:256x128",
            "texels:4x4:octahedral",
            "texels:4x4:reflected",
            "texels:4x4:wrap:reflected",
            brdf,
        ] {
            let basis: ResponseBasis = text.parse().unwrap();
            assert_eq!(basis.to_string(), text);
            assert_eq!(basis.is_plain(), text.starts_with("plain"));
        }
        let counts = ["7", "plain:7", "irradiance", "local:3", "exit:8", brdf];
        let found = counts.map(|text| text.parse::<ResponseBasis>().unwrap().responses());
        assert_eq!(found, [7, 7, 1, 9, 8, 16]);
        let wrong = [
            "",
            "0",
            "-1",
            "plain:",
            "plain:0",
            "irradiance:",
            "irradiance: a",
            "terms:2:\u{1b}[2J",
            "local:65",
            "exit:17",
            "exit:0",
            "texels:4",
        ];
        let more =
            ["exit:121", "exit-orthonormal:14", "terms:16", "terms:16:", "terms:0:lambert", "99999999999999999999"];
        for text in wrong.into_iter().chain(more) {
            assert!(text.parse::<ResponseBasis>().is_err(), "{text}");
        }
    }
}
