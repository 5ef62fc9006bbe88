//! Coherence of a model's clusters.

use super::fit::Fit;
use super::overdraw::{Overdraw, overdraw};
use super::reclassify::{Reclassified, expect_not_negative, reclassify};
use super::supercluster::{supercluster_of_samples, superclusters};
use crate::model::Model;
use prt_transfer::{Result, TransferMatrix};

/// What [`recluster`] did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Squared error of the model as it came, over all samples, in coefficients of the matrix.
    pub initial_error: f64,
    /// The same of the model that is returned.
    pub final_error: f64,
    /// Of the model as it came.
    pub original: Overdraw,
    /// Of the model that is returned.
    pub reclassified: Overdraw,
    /// Samples that are of another cluster now.
    pub moved: usize,
    /// Clusters without a member, which the model that is returned lacks.
    pub dropped: usize,
}

impl Report {
    /// What reclassification adds to the squared error, as a fraction of the initial one; 0 where there was none and is
    /// none.
    pub fn increase(&self) -> f64 {
        if self.final_error == self.initial_error { 0.0 } else { self.final_error / self.initial_error - 1.0 }
    }
}

/// The squared error of a model over all samples, in coefficients of the matrix that it is of.
///
/// # Errors
/// A model whose sizes contradict each other or those of `samples`.
pub fn squared_error(model: &Model, samples: &TransferMatrix) -> Result<f64> {
    Ok(Fit::new(model, samples)?.errors().iter().sum())
}

/// Moves samples to clusters of their neighbours: less overdraw for no more than `budget` times the model's squared
/// error, such as 0.05 (paper §5); see [`reclassify`]. The model is one of `samples`, and sample i is vertex i of
/// `triangles`.
///
/// A sample's error in a cluster is that of its least-squares approximation by the cluster's mean and components, with
/// weights as the model stores them: samples that move get new weights, the others keep theirs. Means and components
/// stay as they are. Clusters without a member are dropped, and the rest renumbered in their order.
///
/// # Errors
/// A model whose sizes contradict each other or those of `samples`, triangles with vertices beyond them, a budget that
/// is negative, NaN or infinite.
pub fn recluster(
    model: &Model,
    samples: &TransferMatrix,
    triangles: &[[u32; 3]],
    budget: f64,
) -> Result<(Model, Report)> {
    expect_not_negative("error budget, a fraction of the squared error", budget)?;
    let fit = Fit::new(model, samples)?;
    let original = overdraw(triangles, &model.members)?;
    let mut errors = fit.errors();
    let initial_error: f64 = errors.iter().sum();
    expect_not_negative("squared error of the model", initial_error)?;
    let error = |sample: usize, cluster| match cluster == model.members[sample] {
        true => errors[sample],
        false => fit.error(sample, cluster),
    };
    let Reclassified { clusters, moved, .. } = reclassify(triangles, &model.members, budget * initial_error, error)?;
    let movers = || clusters.iter().zip(&model.members).enumerate().filter(|(_, (to, from))| to != from);
    let moved_errors: Vec<(usize, f64)> = movers().map(|(s, (&to, _))| (s, fit.error(s, to))).collect();
    moved_errors.into_iter().for_each(|(sample, error)| errors[sample] = error);
    let result = rebuilt(model, &fit, &clusters);
    let report = Report {
        initial_error,
        final_error: errors.iter().sum(),
        original,
        reclassified: overdraw(triangles, &clusters)?,
        moved,
        dropped: model.clusters.len() - result.clusters.len(),
    };
    Ok((result, report))
}

/// The model with other members, without the clusters that have none.
fn rebuilt(model: &Model, fit: &Fit, clusters: &[u32]) -> Model {
    let mut used = vec![false; model.clusters.len()];
    clusters.iter().for_each(|&cluster| used[cluster as usize] = true);
    let mut numbers = vec![0u32; used.len()];
    let kept: Vec<usize> = (0..used.len()).filter(|&cluster| used[cluster]).collect();
    kept.iter().enumerate().for_each(|(number, &cluster)| numbers[cluster] = number as u32);
    let mut weights = Vec::with_capacity(model.weights.len());
    clusters.iter().enumerate().for_each(|(sample, &cluster)| weights.extend_from_slice(&fit.weights(sample, cluster)));
    Model {
        shape: model.shape,
        weights,
        members: clusters.iter().map(|&cluster| numbers[cluster as usize]).collect(),
        clusters: kept.iter().map(|&cluster| model.clusters[cluster].clone()).collect(),
    }
}

/// What [`optimise`] found: the four entries of a row in the table of §7.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimised {
    /// The reclassified model.
    pub model: Model,
    /// The supercluster of each of its clusters.
    pub superclusters: Vec<u32>,
    /// Errors, and overdraw before ("original") and after reclassification ("rec").
    pub report: Report,
    /// Overdraw of the model as it came with superclusters alone ("sc").
    pub superclustered: Overdraw,
    /// Overdraw of the reclassified model with its superclusters ("sc+rec").
    pub both: Overdraw,
}

/// Both techniques of the paper's §5: [`recluster`] with an error budget, then [`superclusters`] of at most `members`
/// clusters, of the model as it came too, for comparison.
///
/// # Errors
/// As [`recluster`]; no `members`.
pub fn optimise(
    model: &Model,
    samples: &TransferMatrix,
    triangles: &[[u32; 3]],
    budget: f64,
    members: usize,
) -> Result<Optimised> {
    let (result, report) = recluster(model, samples, triangles, budget)?;
    let (_, superclustered) = superclustered_of(model, triangles, members)?;
    let (superclusters, both) = superclustered_of(&result, triangles, members)?;
    Ok(Optimised { model: result, superclusters, report, superclustered, both })
}

/// The superclusters of a model's clusters, and overdraw with them.
fn superclustered_of(model: &Model, triangles: &[[u32; 3]], members: usize) -> Result<(Vec<u32>, Overdraw)> {
    let superclusters = superclusters(triangles, &model.members, model.clusters.len(), members)?;
    let of_samples = supercluster_of_samples(&model.members, &superclusters)?;
    Ok((superclusters, overdraw(triangles, &of_samples)?))
}
