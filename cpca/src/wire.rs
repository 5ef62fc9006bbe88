//! Sections of clustered principal components.

use crate::encoded::{EncodedCpca, vector_of};
use crate::layout::Layout;
use prt_transfer::ids::Ids;
use prt_transfer::numbers::Width;
use prt_transfer::numbers::{Numbers, Sections};
use prt_transfer::sections::broken;
use prt_transfer::{Result, Shape, Sink, Source};

const HEADER: &str = "header/layout";
const SUPERCLUSTERS: &str = "index/superclusters";
const REPRESENTATIVES: Sections = Sections { numbers: "basis/representatives", scales: "basis/scales" };
const WEIGHTS: Sections = Sections { numbers: "weights/weights", scales: "weights/scales" };

/// Writes everything but the numbers of components.
pub(crate) fn write(encoded: &EncodedCpca, sink: &mut Sink) {
    let widths = [&encoded.representatives, &encoded.weights].map(|numbers| numbers.width() as u32);
    // Ids are 32 bits, so that a cluster's place fits one.
    sink.put(HEADER, &[encoded.layout.clusters() as u32, widths[0], widths[1]]);
    encoded.representatives.write(sink, REPRESENTATIVES);
    encoded.weights.write(sink, WEIGHTS);
    encoded.ids.write(sink);
    if let Some(superclusters) = &encoded.superclusters {
        sink.put(SUPERCLUSTERS, superclusters);
    }
}

/// Reads what [`write`] and [`Layout::write`] wrote.
pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<EncodedCpca> {
    let header: Vec<u32> = source.take_exact(HEADER, 3)?;
    let (clusters, widths) =
        (header[0] as usize, [Width::of_code(header[1], HEADER)?, Width::of_code(header[2], HEADER)?]);
    // Clusters without numbers would cost a file nothing; samples it had to earn.
    if clusters < shape.samples.min(1) || clusters > shape.samples.max(1) {
        return Err(broken(HEADER, format!("1 to {} clusters, the samples", shape.samples), clusters.to_string()));
    }
    let ids = Ids::read(source, shape.samples, clusters)?;
    let layout = Layout::read(source, clusters, shape, &ids)?;
    let (dimension, vectors) = (shape.responses * shape.lights, layout.vectors());
    // Saturated, a count is one that no section has.
    let count = [vectors.saturating_mul(dimension), vectors];
    let representatives = Numbers::read(source, REPRESENTATIVES, widths[0], count, vector_of(vectors, dimension))?;
    let count = [layout.first_weight(shape.samples, &ids), vectors - clusters];
    let of_weights = layout.components_of_weights(shape.samples, &ids);
    let weights = Numbers::read(source, WEIGHTS, widths[1], count, of_weights)?;
    let superclusters = match source.has(SUPERCLUSTERS) {
        true => Some(source.take_exact(SUPERCLUSTERS, clusters)?),
        false => None,
    };
    Ok(EncodedCpca { shape, layout, ids, representatives, weights, superclusters })
}
