//! What `cta` and `tucker` can be asked for.

use crate::tucker::Algorithm;
use prt_transfer::samples::Norm;

prt_transfer::choices! {
    /// Where the search for clusters starts.
    pub enum Start {
        /// Lines through the origin, drawn as k-means++ draws, then subspaces of 2, 4, 8, … dimensions until there are as many as asked for.
        Lines = "lines",
        /// Means of samples drawn at random, by the enhanced LBG algorithm (Patanè and Russo 2001), as in the paper.
        Elbg = "elbg",
    }
}

prt_transfer::choices! {
    /// How numbers are stored.
    pub enum Storage {
        /// Single precision.
        F32 = "f32",
        /// Half precision with a scale for each vector of numbers.
        F16 = "f16",
        /// 16-bit integers with a scale for each vector of numbers.
        I16 = "i16",
        /// Integers as coarse as the model's own error allows, few of them far from 0: small once the file's bytes are entropy-coded.
        Coded = "coded",
    }
}

prt_transfer::params! {
    /// Clustered tensor approximation: one view basis, and for each cluster of samples a light basis and a dual sample basis.
    pub struct CtaParams: "cta" {
        /// Clusters, 1 to 65536, no more than there are samples.
        clusters: usize = 64,
        /// Rank of the responses, 1 to 4096, of all clusters together.
        view: usize = 8,
        /// Rank of the lights, 1 to 4096, of each cluster; no more than its data have.
        light: usize = 48,
        /// Rank of the samples, 1 to 4096, of each cluster; no more than its data have.
        sample: usize = 24,
        /// Clusters that a sample belongs to, 1 to 16, no more than there are: it is the sum of what they hold of it.
        members: usize = 1,
        /// Sweeps of reclassification at most, 0 to 1000.
        sweeps: usize = 20,
        /// Sweeps at most, 1 to 1000, in which all bases are fitted to the final clusters, the view basis included; as many again with members.
        refine: usize = 8,
        /// Where the search starts: lines or elbg.
        start: Start = Start::Lines,
        /// Of what is drawn.
        seed: u64 = 0,
        /// Error that is minimised: coefficients (of the matrix) or radiance (orthonormal coordinates).
        norm: Norm = Norm::Coefficients,
        /// Numbers are stored as f32, f16, i16 or coded.
        numbers: Storage = Storage::I16,
        /// Squared error that numbers=coded may add, as a part of the model's own, above 0 to 1.
        noise: f64 = 0.01,
    }
}

prt_transfer::params! {
    /// One Tucker decomposition of samples x responses x lights.
    pub struct TuckerCodecParams: "tucker" {
        /// Rank of the responses, 1 to 65536; no more than the data have.
        view: usize = 8,
        /// Rank of the lights, 1 to 65536; no more than the data have.
        light: usize = 96,
        /// Rank of the samples, 1 to 65536; no more than the data have.
        sample: usize = 128,
        /// How factors are found: hosvd, st-hosvd, hooi or randomised.
        mode: Algorithm = Algorithm::Sequential,
        /// Sweeps of hooi at most, 1 to 1000.
        sweeps: usize = 50,
        /// Of the sketches of mode=randomised.
        seed: u64 = 0,
        /// Error that is minimised: coefficients (of the matrix) or radiance (orthonormal coordinates).
        norm: Norm = Norm::Coefficients,
        /// Numbers are stored as f32, f16, i16 or coded.
        numbers: Storage = Storage::I16,
        /// Squared error that numbers=coded may add, as a part of the model's own, above 0 to 1.
        noise: f64 = 0.01,
        /// Bound on Σ(T-T̃)²/ΣT² of what is decoded, in the norm, 1e-12 to 1: the ranks that just keep it; view, light and sample cannot be given then.
        max_error: Option<f64> = None,
    }
}
