//! Components where they save most, at the same bytes: a gain by what it costs, and by what the paper says that it costs.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::Array2;
use prt_transfer::Result;
use prt_transfer::random::Random;

pub(super) const CASE: Case = Case {
    name: "allocation",
    title: "Components for clusters of many sizes",
    source: "Sloan et al. 2003, §4.3: D²/m, without what a vector costs",
    parameter: "ratio of the sizes of neighbouring clusters",
    values: &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0],
    quantity: "error beyond that of the better of both rules, at the same bytes, relative",
    printed: Form { name: "allocation=paper", figure: |ratio| figure(ratio, "paper") },
    here: Form { name: "allocation=bytes", figure: |ratio| figure(ratio, "bytes") },
    bound: |_| 1e-9,
    promise: "never worse than the paper's rule",
    breaks: Some(1.2),
};

const CLUSTERS: usize = 8;
const DIMENSION: usize = 60;

/// Clusters far apart, spectra of which fall alike.
fn samples(ratio: f64) -> Array2<f64> {
    let sizes: Vec<usize> = (0..CLUSTERS).map(|c| (12.0 * ratio.powi(c as i32)) as usize).collect();
    let (centres, mut random) = (ground::noise(CLUSTERS, DIMENSION, 31) * 20.0, Random(32));
    let of: Vec<usize> = sizes.iter().enumerate().flat_map(|(c, size)| std::iter::repeat_n(c, *size)).collect();
    Array2::from_shape_fn((of.len(), DIMENSION), |(i, j)| {
        centres[[of[i], j]] + random.normal() * 0.8f64.powi((j as i32 + 7 * of[i] as i32) % DIMENSION as i32)
    })
}

fn figure(ratio: f64, allocation: &str) -> Result<f64> {
    let matrix = ground::plain(samples(ratio).view())?;
    let error = |allocation: &str| {
        ground::error(&format!("cpca:clusters={CLUSTERS}:components=6:mode=adaptive:allocation={allocation}"), &matrix)
    };
    Ok(error(allocation)? / error("paper")?.min(error("bytes")?) - 1.0)
}
