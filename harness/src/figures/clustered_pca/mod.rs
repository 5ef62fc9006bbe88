//! Sloan, Hall, Hart and Snyder 2003: clustered principal components for precomputed radiance transfer.

mod claims;
mod figure10;
mod figure2;
mod figure3;
mod matched;
mod table1;
mod table1_layout;

use super::Paper;
use super::setting::{Curve, Setting};
use super::stage::Mesh;
use crate::signal::{Signal, Spec};
use prt_cpca::{Allocation, Clusters, CpcaParams, Mode, PcaParams, VqParams};
use prt_transfer::LightBasis;

/// Figures 2, 3, 10 and 11, and Table 1.
pub(super) const PAPER: Paper = Paper {
    name: "clustered-pca",
    source: "Sloan et al. 2003: clustered principal components",
    figures: &[figure2::FIGURE, figure3::FIGURE, figure10::FIGURE, table1::FIGURE],
    is_full: false,
    scenes: &[],
    notes: &[
        "The paper's meshes were not published: SE, a sum over all vertices, is comparable as a ratio between methods only. It rendered on a",
        "graphics card of 2003 and encoded on a 2.2 GHz Pentium 4; relighting here is the product alone, on one thread.",
    ],
};

/// The paper's bird statue.
const BIRD: Mesh = Mesh { file: Some("bunny_35k.ply"), built_in: "blob", vertices: 48_688 };

/// The paper's Buddha, bumpier than the bird.
const BUDDHA: Mesh = Mesh { file: Some("dragon_23k.ply"), built_in: "bumpy-sphere", vertices: 49_990 };

/// The clusters of most of its figures.
const CLUSTERS: usize = 256;

/// Shadowed diffuse transfer in harmonics of this order.
fn diffuse(order: usize) -> Spec {
    Spec::new(Signal::Diffuse, LightBasis::SphericalHarmonics { order })
}

/// Glossy transfer of a BRDF, so many exit harmonics x 25.
fn glossy(brdf: &str, coefficients: usize) -> Spec {
    let brdf = brdf.parse().expect("a BRDF by its name alone");
    Spec { brdf, coefficients, ..Spec::new(Signal::Glossy, LightBasis::SphericalHarmonics { order: 5 }) }
}

/// An anisotropic BRDF, of which the paper says no more.
const ANISOTROPIC: &str = "ward";
/// An isotropic one.
const ISOTROPIC: &str = "cook-torrance";

/// Vector quantisation: n' = 0.
fn vq(clusters: usize) -> Setting {
    Setting::new(&VqParams { clusters, ..VqParams::default() }, clusters, 0)
}

/// Principal components of all samples at once: m_c = 1.
fn pca(components: usize) -> Setting {
    Setting::new(&PcaParams { components, ..PcaParams::default() }, 1, components)
}

/// Clustered principal components.
fn cpca(mode: Mode, clusters: usize, components: usize) -> Setting {
    let params = CpcaParams { clusters: Clusters::Number(clusters), components, mode, ..CpcaParams::default() };
    Setting::new(&params, clusters, components)
}

/// Adaptive ones by the paper's rule, which does not count what a representative takes.
fn adaptive_by_the_paper(clusters: usize, components: usize) -> Setting {
    let params = CpcaParams {
        clusters: Clusters::Number(clusters),
        components,
        mode: Mode::Adaptive,
        allocation: Allocation::Paper,
        ..CpcaParams::default()
    };
    Setting::new(&params, clusters, components)
}

/// The matrix itself.
fn uncompressed() -> Curve {
    Curve::new("uncompressed", [Setting::whole("dense")])
}

#[cfg(test)]
mod tests;
