//! What decompositions take in memory, in bytes.

use prt_transfer::footprint::by;
use prt_transfer::{Extent, Shape};

/// The Gram matrix of `rows` x `columns` in double precision: of the rows, or of the columns where those are fewer.
pub(crate) fn gram(rows: usize, columns: usize) -> u64 {
    by(8.0, (rows.min(columns) as u64).pow(2))
}

/// Bases and cores of so many clusters at ranks of samples, views and lights, and the weights of all samples, in single precision.
pub(crate) fn result(extent: &Extent, clusters: usize, [sample, view, light]: [usize; 3]) -> u64 {
    let Shape { samples, responses, lights } = extent.shape;
    let [sample, view, light] = [sample.min(samples), view.min(responses), light.min(lights)].map(|n| n as u64);
    let (samples, responses, lights) = (samples as u64, responses as u64, lights as u64);
    let of_clusters = clusters as u64 * (light * lights + sample * view * light);
    by(4.0, of_clusters + view * responses + sample * samples) + by(16.0, samples)
}
