//! Tsai and Shih 2006: clustered tensor approximation of transfer in lobes (§5.2, Tables 1 and 2).

mod bytes;
mod coefficients;
mod decompositions;
mod encoding;
mod figure5;
mod segments;
mod table1;
mod table1_layout;
mod table2;
mod table2_layout;
mod tensors;

use super::stage::{Mesh, Stage, title};
use super::{Paper, srbf};
use crate::number;
use crate::signal::{Signal, Spec};
use coefficients::Coefficients;
use prt_tensor::CtaParams;
use prt_transfer::{LightBasis, Params};

/// Tables 1 and 2, and what stands behind them.
pub(super) const PAPER: Paper = Paper {
    name: "tensor",
    source: "Tsai and Shih 2006: spherical radial basis functions and clustered tensors",
    figures: &[
        table1::FIGURE,
        table2::FIGURE,
        srbf::figure4::FIGURE,
        figure5::FIGURE,
        decompositions::FIGURE,
        bytes::FIGURE,
    ],
    is_full: false,
    scenes: &[],
    notes: &[
        "Light functions of the Cook-Torrance BRDF in 16 terms, 6 x 32 x 32 texels; T in 642 lobes on a subdivided icosahedron. Errors are squared",
        "errors over the sphere, as parts of the square of T: the paper's SE ratio. Its meshes and the roughness of its BRDF were not published.",
        "T in lobes has an error of its own (SRBF), to which that of CTA is added. Relighting: three channels of a light in lobes on all threads,",
        "the product alone. Memory counts what turns texels into lobes (3 MB) too, which a light in lobes does without.",
    ],
};

/// Vertices of the paper's teapot for each of its clusters.
const MEMBERS: f64 = 41_000.0 / 110.0;
/// The paper's number of them.
const CLUSTERS: usize = 110;

/// K light functions of Cook-Torrance.
fn spec() -> Spec {
    Spec::new(Signal::Terms, LightBasis::Cubemap { resolution: 32 })
}

/// The paper's clusters; on a smaller scene as many as have about as many members.
fn clusters(stage: &Stage, samples: usize) -> usize {
    if stage.is_paper_sized() { CLUSTERS } else { own_clusters(samples) }
}

/// Clusters of about as many members as the paper's.
fn own_clusters(samples: usize) -> usize {
    ((samples as f64 / MEMBERS).round() as usize).max(1)
}

/// `srbf+cta` in its shortest form.
fn label(params: &CtaParams) -> String {
    format!("srbf+{}", params.to_stage())
}

/// The mesh where the user has it among the assets, else the built-in scene.
fn available(stage: &Stage, mesh: &Mesh) -> Mesh {
    let is_there = |file: &&str| stage.folder().is_none_or(|folder| folder.join(file).exists());
    Mesh { file: mesh.file.filter(is_there), ..*mesh }
}

/// Scene, signal, bases and shape.
fn subject(coefficients: &Coefficients) -> String {
    let (shape, lost) = (coefficients.matrix.shape(), number::short(coefficients.lost()));
    let (scene, basis) = (title(&coefficients.scene), &coefficients.basis);
    let size = format!("{} x {} x {}", shape.samples, shape.responses, shape.lights);
    format!("{scene} · terms · {basis} · {size} lobes, whose own error is {lost}")
}

#[cfg(test)]
mod tests;
