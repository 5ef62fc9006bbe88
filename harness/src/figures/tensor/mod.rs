//! Tsai and Shih 2006: clustered tensor approximation of transfer in lobes (§5.2, Tables 1 and 2).

mod bytes;
mod coefficients;
mod decompositions;
mod encoding;
mod segments;
mod table1;
mod table1_layout;
mod table2;
mod tensors;

use super::Paper;
use super::stage::{Mesh, Stage};
use crate::number;
use crate::signal::{Signal, Spec};
use prt_tensor::CtaParams;
use prt_transfer::{LightBasis, Params};

/// Tables 1 and 2, and what stands behind them.
pub(super) const PAPER: Paper = Paper {
    name: "tensor",
    figures: &[table1::FIGURE, decompositions::FIGURE, bytes::FIGURE, table2::FIGURE],
    notes: &[
        "Light functions of the Cook-Torrance BRDF in 16 terms, 6 x 32 x 32 texels; T in 642 lobes on a subdivided icosahedron. Errors are squared",
        "errors over the sphere, as parts of the square of T: the paper's SE ratio. Its meshes and the roughness of its BRDF were not published.",
        "table1: T in lobes has an error of its own (SRBF), to which that of CTA is added. The paper's GB and MB are powers of two (41k x 16 x 6144",
        "numbers of 4 bytes are 15.0 GiB; ours are decimal). It encoded on an Athlon 64 FX-55; its frames per second (view moves / light moves) were",
        "75/16, 51/13 and 49/10. Relighting here: three channels of a light in lobes on all threads, the product alone. Memory counts what turns",
        "texels into lobes (3 MB) too, which a light in lobes does without.",
        "table2: Liu et al. (2004) cut the lights into segments of 256 wavelet coefficients and compress each by itself, since clusters of whole",
        "samples need vectors of 16 x 6144 numbers. Our cpca takes whole samples; segments here are as many matrices of their own, their bytes, times",
        "and squared errors added up. Numbers are stored in 16 bits by all. The paper (Buddha): CPCA 48.4 MB and 3.09 %, theirs 13.2 MB and 3.75 %.",
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

/// Bytes of the file and in memory, then error, seconds of encoding and milliseconds of relighting, for people.
fn cells(bytes: [u64; 2], [error, encode_s, relight_ms]: [f64; 3]) -> [String; 5] {
    let [file, memory] = bytes.map(number::bytes);
    [file, memory, number::short(error), number::short(encode_s), number::short(relight_ms)]
}

/// A mesh's name for people.
fn title(scene: &str) -> String {
    std::path::Path::new(scene).file_stem().map_or_else(|| scene.into(), |stem| stem.display().to_string())
}

#[cfg(test)]
mod tests;
