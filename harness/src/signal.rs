//! What is precomputed of a scene.

use clap::ValueEnum;
use prt_transfer::LightBasis;
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
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Signal::Biscale => "biscale",
            Signal::Diffuse => "diffuse",
        })
    }
}

/// A signal with everything that decides its matrix, besides the mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Spec {
    /// The kind of transfer.
    pub signal: Signal,
    /// What the columns stand for.
    pub basis: LightBasis,
    /// Visibility is sampled with 2^m x 2^m rays for each texel.
    pub supersampling: u32,
    /// Local directions along an edge of the hemisphere's square map; `biscale` only.
    pub local_directions: usize,
}

impl Spec {
    /// A signal with the usual sampling: 2x2 rays a texel, 8x8 local directions.
    pub fn new(signal: Signal, basis: LightBasis) -> Spec {
        Spec { signal, basis, supersampling: 1, local_directions: 8 }
    }

    /// A name for files: letters, digits and dashes.
    pub fn file_name(&self) -> String {
        let Spec { signal, basis, supersampling, local_directions } = self;
        let basis = basis.to_string().replace(':', "");
        match signal {
            Signal::Biscale => format!("{signal}-{basis}-m{supersampling}-d{local_directions}"),
            Signal::Diffuse => format!("{signal}-{basis}-m{supersampling}"),
        }
    }
}
