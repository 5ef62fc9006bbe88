//! Samples approximated in clusters other than their own.

use crate::model::{Cluster, Model};
use prt_transfer::{Error, Result, TransferMatrix};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::OnceLock;

/// A matrix beside a model of it.
pub(crate) struct Fit<'a> {
    model: &'a Model,
    samples: &'a TransferMatrix,
    /// `samples + 1` offsets into the model's weights.
    offsets: Vec<usize>,
    /// The factor of each cluster's Gram matrix, once it is asked for.
    factors: Vec<OnceLock<Cholesky>>,
}

impl<'a> Fit<'a> {
    /// Refuses a model that is not one of `samples`, or that contradicts itself.
    pub(crate) fn new(model: &'a Model, samples: &'a TransferMatrix) -> Result<Fit<'a>> {
        let (found, expected) = (model.shape, samples.shape());
        Error::expect_size("samples of the model", expected.samples, found.samples)?;
        Error::expect_size("responses of the model", expected.responses, found.responses)?;
        Error::expect_size("lights of the model", expected.lights, found.lights)?;
        Error::expect_size("cluster numbers of samples", expected.samples, model.members.len())?;
        let n = model.dimension();
        for (i, cluster) in model.clusters.iter().enumerate() {
            Error::expect_size(format!("numbers in the mean of cluster {i}"), n, cluster.mean.len())?;
            let numbers = model.components(i) * n;
            Error::expect_size(format!("numbers in the components of cluster {i}"), numbers, cluster.components.len())?;
        }
        let mut offsets = vec![0];
        for (sample, &cluster) in model.members.iter().enumerate() {
            if cluster as usize >= model.clusters.len() {
                return Err(Error::Unsupported {
                    what: format!("cluster of sample {sample}"),
                    expected: format!("a number below {}", model.clusters.len()),
                    found: cluster.to_string(),
                });
            }
            offsets.push(offsets[sample] + model.components(cluster as usize));
        }
        Error::expect_size("weights of the model", offsets[expected.samples], model.weights.len())?;
        let factors = model.clusters.iter().map(|_| OnceLock::new()).collect();
        Ok(Fit { model, samples, offsets, factors })
    }

    /// The squared error of each sample in its own cluster, with the weights that it has.
    pub(crate) fn errors(&self) -> Vec<f64> {
        let error = |(sample, &cluster): (usize, &u32)| self.error(sample, cluster);
        self.model.members.par_iter().enumerate().map(error).collect()
    }

    /// The squared error of a sample in a cluster: the residual itself, in f64, with weights as the model stores them.
    /// Subtracting squared weights from a squared norm would cancel.
    pub(crate) fn error(&self, sample: usize, cluster: u32) -> f64 {
        let mut residual = self.difference(sample, cluster);
        let weights = match cluster == self.model.members[sample] {
            true => Cow::Borrowed(self.own_weights(sample)),
            false => Cow::Owned(self.projected(cluster, &residual)),
        };
        for (weight, component) in weights.iter().zip(self.components(cluster)) {
            let weight = f64::from(*weight);
            residual.iter_mut().zip(component).for_each(|(r, &c)| *r -= weight * f64::from(c));
        }
        squared(&residual)
    }

    /// The weights of a sample in a cluster: its own where it is a member, those of least squares elsewhere.
    pub(crate) fn weights(&self, sample: usize, cluster: u32) -> Cow<'_, [f32]> {
        match cluster == self.model.members[sample] {
            true => Cow::Borrowed(self.own_weights(sample)),
            false => Cow::Owned(self.projected(cluster, &self.difference(sample, cluster))),
        }
    }

    /// The weights of least squares for a sample at `from_mean` (n numbers).
    fn projected(&self, cluster: u32, from_mean: &[f64]) -> Vec<f32> {
        let products = self.components(cluster).map(|component| dot(from_mean, component)).collect();
        let weights = self.factor(cluster).solve(products).into_iter();
        weights.map(|w| w.clamp(f32::MIN.into(), f32::MAX.into()) as f32).collect()
    }

    fn own_weights(&self, sample: usize) -> &[f32] {
        &self.model.weights[self.offsets[sample]..self.offsets[sample + 1]]
    }

    fn cluster(&self, cluster: u32) -> &Cluster {
        &self.model.clusters[cluster as usize]
    }

    fn components(&self, cluster: u32) -> impl Iterator<Item = &[f32]> + Clone {
        self.cluster(cluster).components.chunks_exact(self.model.dimension().max(1))
    }

    fn factor(&self, cluster: u32) -> &Cholesky {
        self.factors[cluster as usize].get_or_init(|| Cholesky::of_gram(self.components(cluster)))
    }

    /// `x - mean`, n numbers.
    fn difference(&self, sample: usize, cluster: u32) -> Vec<f64> {
        let lights = self.samples.lights();
        let mut difference: Vec<f64> = self.cluster(cluster).mean.iter().map(|&m| -f64::from(m)).collect();
        for (response, row) in difference.chunks_exact_mut(lights.max(1)).enumerate() {
            let elements = self.samples.row(sample * self.samples.shape().responses + response);
            elements.non_zeros().for_each(|(column, value)| row[column] += f64::from(value));
        }
        difference
    }
}

/// The lower triangular factor L of a Gram matrix G = L Lᵀ, row after row.
///
/// Components that are orthonormal in the coordinates of compression need not be so in those of the matrix, and are not
/// quite so once they are stored in few bits: weights are G⁻¹ times the dot products, which then are the weights
/// themselves.
struct Cholesky(Vec<Vec<f64>>);

/// A pivot is 0 where no more than this fraction of its diagonal element is left: the component depends on those before
/// it.
const DEPENDENT: f64 = 1e-12;

impl Cholesky {
    fn of_gram<'a>(components: impl Iterator<Item = &'a [f32]> + Clone) -> Cholesky {
        let wide = |component: &[f32]| component.iter().map(|&c| f64::from(c)).collect::<Vec<f64>>();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (i, component) in components.clone().enumerate() {
            let component_i = wide(component);
            let mut row: Vec<f64> =
                components.clone().take(i + 1).map(|component| dot(&component_i, component)).collect();
            for j in 0..=i {
                let before: f64 = (0..j).map(|k| row[k] * if j == i { row[k] } else { rows[j][k] }).sum();
                let left = row[j] - before;
                row[j] = match j == i {
                    true if left > DEPENDENT * row[i] => left.sqrt(),
                    false if rows[j][j] > 0.0 => left / rows[j][j],
                    _ => 0.0,
                };
            }
            rows.push(row);
        }
        Cholesky(rows)
    }

    /// G⁻¹ times `products`; 0 for a component that depends on those before it.
    fn solve(&self, mut products: Vec<f64>) -> Vec<f64> {
        let rows = &self.0;
        for i in 0..rows.len() {
            let before: f64 = (0..i).map(|k| rows[i][k] * products[k]).sum();
            products[i] = divided(products[i] - before, rows[i][i]);
        }
        for i in (0..rows.len()).rev() {
            let after: f64 = (i + 1..rows.len()).map(|k| rows[k][i] * products[k]).sum();
            products[i] = divided(products[i] - after, rows[i][i]);
        }
        products
    }
}

fn divided(value: f64, pivot: f64) -> f64 {
    if pivot > 0.0 { value / pivot } else { 0.0 }
}

/// Sums that are kept apart, so that the compiler may use vectors.
const LANES: usize = 8;

fn dot(a: &[f64], b: &[f32]) -> f64 {
    let mut sums = [0f64; LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        (0..LANES).for_each(|i| sums[i] += a[i] * f64::from(b[i]));
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * f64::from(*b)).sum::<f64>()
}

fn squared(residual: &[f64]) -> f64 {
    let mut sums = [0f64; LANES];
    let (chunks, rest) = residual.as_chunks::<LANES>();
    for chunk in chunks {
        (0..LANES).for_each(|i| sums[i] += chunk[i] * chunk[i]);
    }
    sums.iter().sum::<f64>() + rest.iter().map(|r| r * r).sum::<f64>()
}
