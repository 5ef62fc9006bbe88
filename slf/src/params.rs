//! What `slf` can be asked for.

use prt_cpca::{Clusters, Solver, Start};
use prt_transfer::numbers::Width;
use prt_transfer::samples::Norm;

prt_transfer::choices! {
    /// What colour channels have in common.
    pub enum Colour {
        /// The cluster of a texel (one id, as the paper's size counts), maps for each channel.
        Shared = "shared",
        /// Nothing: each channel has clusters of its own (as the paper's text has it).
        Separate = "separate",
        /// The cluster of a texel and its weights: components go over all channels.
        Joint = "joint",
    }
}

prt_transfer::choices! {
    /// How clusters are found.
    pub enum Mode {
        /// By distance to their means: k-means, as in the paper.
        Static = "static",
        /// By distance to affine subspaces, components introduced one by one (Sloan et al. 2003, §4.2).
        Iterative = "iterative",
    }
}

prt_transfer::choices! {
    /// How maps are kept in a file.
    pub enum Maps {
        /// As memory holds them.
        Plain = "plain",
        /// Rounded in the Haar basis of their images, where that is smaller, or as they are; memory holds single precision.
        Haar = "haar",
    }
}

prt_transfer::params! {
    /// Surface light field: mean of each texel, clusters of texels, leading singular vectors of each (Miandji et al. 2011).
    pub struct SlfParams: "slf" {
        /// Clusters η, 1 to 65536, no more than there are distinct texels; auto with max_error.
        clusters: Clusters = Clusters::Number(256),
        /// Components k of each cluster, 0 to 4096, no more than the greatest rank.
        components: usize = 8,
        /// What channels have in common: shared (clusters), separate (nothing) or joint (clusters and weights).
        colour: Colour = Colour::Shared,
        /// static or iterative.
        mode: Mode = Mode::Static,
        /// Sweeps at most, 1 to 1000: in all (static) or for each number of components (iterative); none = 20 (static) or 10.
        sweeps: Option<usize> = None,
        /// Where clusters start: random, plusplus or splitting.
        start: Start = Start::PlusPlus,
        /// Of what is drawn.
        seed: u64 = 0,
        /// Eigen-solver of the components: auto, power (the paper's), krylov, gram or svd.
        solver: Solver = Solver::Auto,
        /// Error that is minimised: coefficients (the paper's: all directions count the same) or radiance (as their solid angles).
        norm: Norm = Norm::Coefficients,
        /// Surface map and mean map are stored as f32, f16 or i16.
        surface: Width = Width::F32,
        /// View maps are stored as f32, f16 or i16.
        views: Width = Width::F32,
        /// How maps are kept in a file: plain or haar.
        maps: Maps = Maps::Plain,
        /// Squared error that maps=haar may add, as a part of the model's own, above 0 to 1.
        noise: f64 = 0.05,
        /// Bound on Σ(T-T̃)²/ΣT² of what is decoded, in the norm, above 0 to 1: the fewest bytes that keep it, in place of `components`.
        max_error: Option<f64> = None,
    }
}
