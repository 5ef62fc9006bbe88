//! What the search for clusters and components takes in memory, in bytes.

use crate::Width;
use prt_transfer::Extent;
use prt_transfer::footprint::by;

/// Samples in the coordinates of the norm, less their mean, in single precision, and what the search knows of each.
pub(crate) fn searched(extent: &Extent) -> u64 {
    by(10.0, extent.cells()) + by(64.0, extent.shape.samples as u64)
}

/// An eigenproblem of all samples: they in double precision, a Gram matrix of the shorter side, and a subspace of Krylov's.
pub(crate) fn solved(extent: &Extent, components: u64) -> u64 {
    let sides = extent.shape.samples as u64 + dimension(extent);
    by(21.5, extent.cells()) + by(8.0, rank(extent).pow(2)) + by(64.0, sides * components.min(rank(extent)))
}

/// All components of all samples, from which those that a bound needs are taken.
pub(crate) fn bounded(extent: &Extent) -> u64 {
    by(44.0, extent.cells()) + by(22.0, rank(extent).pow(2))
}

/// The most components there can be.
pub(crate) fn rank(extent: &Extent) -> u64 {
    dimension(extent).min(extent.shape.samples as u64)
}

/// Means and components of so many clusters, weights and cluster of each sample.
pub(crate) fn result(
    extent: &Extent,
    clusters: u64,
    components: u64,
    (weights, representatives): (Width, Width),
) -> u64 {
    let (samples, components) = (extent.shape.samples as u64, components.min(rank(extent)));
    // Components of all clusters together are no more than samples.
    let representatives = by(
        representatives.bytes() as f64,
        dimension(extent) * (clusters.min(samples) + samples.min(clusters * components)),
    );
    representatives + by(weights.bytes() as f64, samples * components) + by(16.0, samples)
}

/// Numbers of a sample.
fn dimension(extent: &Extent) -> u64 {
    extent.shape.responses as u64 * extent.shape.lights as u64
}
