//! What is precomputed of a scene.

use clap::ValueEnum;
use prt_transfer::LightBasis;
use prt_transfer::responses::Coordinates;
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::glossy::GlossyParams;
use prt_transfer::scene::separable::Terms;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A kind of transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Signal {
    /// Visibility by vertex and local direction: rows are (vertex, local direction), values k/4^m.
    Biscale,
    /// Shadowed diffuse transfer: one row for each vertex.
    Diffuse,
    /// Exit radiance of a BRDF in harmonics on each vertex's hemisphere, for light in harmonics.
    Glossy,
    /// Light functions of a BRDF factored into views and lights: rows are (vertex, term).
    Terms,
}

impl Signal {
    /// Every signal.
    pub const ALL: [Signal; 4] = [Signal::Biscale, Signal::Diffuse, Signal::Glossy, Signal::Terms];

    /// The light basis where nobody says otherwise.
    pub fn usual_basis(self) -> LightBasis {
        match self {
            Signal::Glossy => LightBasis::SphericalHarmonics { order: 5 },
            _ => LightBasis::Cubemap { resolution: 32 },
        }
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Signal::Biscale => "biscale",
            Signal::Diffuse => "diffuse",
            Signal::Glossy => "glossy",
            Signal::Terms => "terms",
        })
    }
}

/// A signal with everything that decides its matrix, besides the mesh. Each field belongs to some of the signals and is
/// not looked at by the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// The kind of transfer.
    pub signal: Signal,
    /// What the columns stand for.
    pub basis: LightBasis,
    /// Visibility is sampled with 2^m x 2^m rays for each texel.
    pub supersampling: u32,
    /// Local directions along an edge of the hemisphere's square map; `biscale`.
    pub local_directions: usize,
    /// The surface's reflectance; `glossy`, `terms`, and `diffuse` with bounces, which takes the albedo of `lambert`.
    pub brdf: Brdf,
    /// Harmonics of exit radiance: n² or n² - 1; `glossy`.
    pub coefficients: usize,
    /// Which coordinates of exit radiance; `glossy`.
    pub coordinates: Coordinates,
    /// Bands in which arriving light is projected before it is reflected; `glossy`.
    pub incident: usize,
    /// How many functions of the BRDF; `terms`.
    pub terms: Terms,
    /// Interreflections; `diffuse` and `glossy`.
    pub bounces: usize,
}

impl Spec {
    /// A signal as it is usual: 2x2 rays a texel, 8x8 local directions, the papers' BRDF (Cook-Torrance of roughness
    /// 0.3) in 24 harmonics or 16 terms, direct light. A diffuse surface is white.
    pub fn new(signal: Signal, basis: LightBasis) -> Spec {
        let brdf = if signal == Signal::Diffuse { "lambert" } else { "cook-torrance" };
        Spec {
            signal,
            basis,
            supersampling: 1,
            local_directions: 8,
            brdf: brdf.parse().expect("a BRDF by its name alone"),
            coefficients: 24,
            coordinates: Coordinates::Harmonics,
            incident: GlossyParams::default().incident,
            terms: Terms::Count(16),
            bounces: 0,
        }
    }

    /// A name for files: letters, digits, dashes and underscores.
    pub fn file_name(&self) -> String {
        let Spec { signal, basis, supersampling, brdf, bounces, .. } = self;
        let mut parts = vec![signal.to_string(), basis.to_string(), format!("m{supersampling}")];
        match signal {
            Signal::Biscale => parts.push(format!("d{}", self.local_directions)),
            Signal::Diffuse if *bounces > 0 => parts.push(brdf.to_string()),
            Signal::Diffuse => {}
            Signal::Glossy => {
                let kind = if self.coordinates == Coordinates::Harmonics { "c" } else { "d" };
                parts.extend([format!("{kind}{}", self.coefficients), format!("i{}", self.incident), brdf.to_string()]);
            }
            Signal::Terms => parts.extend([format!("k{}", self.terms), brdf.to_string()]),
        }
        if *bounces > 0 {
            parts.push(format!("b{bounces}"));
        }
        let plain = |c: char| if c.is_ascii_alphanumeric() || "._".contains(c) { c } else { '-' };
        parts.iter().map(|part| part.replace([':', '='], "")).collect::<Vec<_>>().join("-").chars().map(plain).collect()
    }
}
