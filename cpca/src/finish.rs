//! The model that is stored: exact means, components and weights of whole samples.

use crate::engine::Clustering;
use crate::model::{Cluster, Model};
use crate::refit::mean;
use crate::solver::{EigenSolver, product_transposed};
use ndarray::Array2;
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Progress, Result, Shape};
use rayon::prelude::*;

/// A cluster and the weights of its members, in single precision.
struct Finished {
    cluster: Cluster,
    /// Members x components.
    weights: Vec<f32>,
}

/// Means, components and weights for a clustering. Clusters without members are left out; a cluster has no more components than its
/// members have dimensions.
pub(crate) fn finish(
    samples: &Samples,
    shape: Shape,
    clustering: &Clustering,
    solver: &(dyn EigenSolver + Send),
    progress: &dyn Progress,
) -> Result<Model> {
    let Clustering { groups, components } = clustering;
    let kept: Vec<usize> = (0..groups.len()).filter(|&c| !groups.of_cluster(c).is_empty()).collect();
    let fit = |&cluster: &usize| {
        let finished = finished(samples, groups.of_cluster(cluster), components[cluster], solver)?;
        progress.advance(1)?;
        Ok(finished)
    };
    let finished: Vec<Finished> = kept.par_iter().map(fit).collect::<Result<_>>()?;
    let (members, weights) = by_sample(samples.count(), groups, &kept, &finished);
    Ok(Model { shape, clusters: finished.into_iter().map(|f| f.cluster).collect(), members, weights })
}

fn finished(
    samples: &Samples,
    group: &[u32],
    components: usize,
    solver: &(dyn EigenSolver + Send),
) -> Result<Finished> {
    let mean: Vec<f32> = mean(samples, group).iter().map(|m| *m as f32).collect();
    let rows = centred(samples, group, &mean);
    let wanted = components.min(group.len() - 1).min(samples.dimension());
    let vectors =
        if wanted == 0 { Array2::zeros((0, mean.len())) } else { solver.leading(rows.view(), wanted, None)?.vectors };
    let (of_weights, of_vectors) = samples.scales();
    // (x - x0) · x_i, with what the vectors are before they are rounded: to rounding the same, and orthogonal.
    let weights = product_transposed(vectors.view(), rows.view());
    let weights = weights.t().iter().map(|w| (w * of_weights) as f32).collect();
    let restored = |vector: &mut dyn Iterator<Item = f64>, scale: f64| {
        let mut vector: Vec<f64> = vector.collect();
        samples.restore(&mut vector);
        vector.into_iter().map(move |v| (v * scale) as f32)
    };
    let components = vectors.outer_iter().flat_map(|v| restored(&mut v.iter().copied(), of_vectors)).collect();
    let mean = restored(&mut mean.iter().map(|m| f64::from(*m)), of_weights * of_vectors).collect();
    Ok(Finished { cluster: Cluster { mean, components }, weights })
}

/// Samples less the mean that is stored, a row each.
fn centred(samples: &Samples, group: &[u32], mean: &[f32]) -> Array2<f64> {
    let mut rows = Array2::zeros((group.len(), samples.dimension()));
    for (mut out, &sample) in rows.outer_iter_mut().zip(group) {
        let terms = samples.row(sample as usize).iter().zip(mean);
        out.iter_mut().zip(terms).for_each(|(out, (x, m))| *out = f64::from(*x) - f64::from(*m));
    }
    rows
}

/// The cluster of each sample, and weights sample after sample.
fn by_sample(count: usize, groups: &Groups, kept: &[usize], finished: &[Finished]) -> (Vec<u32>, Vec<f32>) {
    let mut places = vec![(0u32, 0usize); count];
    for (number, &cluster) in kept.iter().enumerate() {
        for (row, &sample) in groups.of_cluster(cluster).iter().enumerate() {
            places[sample as usize] = (number as u32, row);
        }
    }
    let mut weights = Vec::with_capacity(finished.iter().map(|f| f.weights.len()).sum());
    for &(cluster, row) in &places {
        let of = &finished[cluster as usize].weights;
        let components = of.len() / groups.of_cluster(kept[cluster as usize]).len();
        weights.extend_from_slice(&of[row * components..][..components]);
    }
    (places.into_iter().map(|(cluster, _)| cluster).collect(), weights)
}
