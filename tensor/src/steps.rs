//! How coarse numbers may be stored: steps that each add the same to the squared error.

use crate::layout::Layout;
use crate::model::Model;
use prt_transfer::ids::Ids;

/// Steps of the vectors of numbers.
pub(crate) struct Steps {
    /// Of each row of the light bases.
    pub(crate) light: Vec<f64>,
    /// Of each row of the dual bases.
    pub(crate) dual: Vec<f64>,
    /// Of the weights that meet each row of the dual bases.
    pub(crate) weights: Vec<f64>,
}

/// Steps that together add about `added` to the squared error.
///
/// A number that is rounded to a step Δ is off by Δ²/12 on average. Off by ε, a weight adds ε² to the squared error of its sample, since
/// cluster bases are orthonormal; an element of row j of a dual basis adds ε² Σ_x W_xj²; an element of row i of a light basis ε² times
/// the square of what all samples have along it, Σ_x Σ_v (Vᵀ W_x)_vi². With steps in the inverse proportion of the roots of these factors
/// every number adds the same, and entropy is least (reverse water-filling at high rate). Light bases that are `of_bases` times orthonormal
/// ones multiply by that what weights and dual bases are off.
pub(crate) fn of(model: &Model, layout: &Layout, ids: &Ids, added: f64, of_bases: f64) -> Steps {
    let of_weights = squares_of_weights(model, layout, ids);
    let lights = squares_of_lights(model, layout, &of_weights);
    let numbers = model.weights.len() + layout.end().dual + layout.end().light * model.shape.lights;
    let step = (12.0 * added / numbers.max(1) as f64).sqrt();
    let before_bases = step / of_bases;
    let weights = vec![before_bases; of_weights.len()];
    let steps = |step: f64, squares: Vec<f64>| {
        squares.into_iter().map(|s| if s > 0.0 { step / s.sqrt() } else { 0.0 }).collect()
    };
    Steps { light: steps(step, lights), dual: steps(before_bases, of_weights), weights }
}

/// Σ_x W_xj² for each row j of the dual bases.
fn squares_of_weights(model: &Model, layout: &Layout, ids: &Ids) -> Vec<f64> {
    let mut squares = vec![0f64; layout.end().sample];
    for (row, weight) in layout.rows_of_weights(model.shape.samples, ids).zip(&model.weights) {
        squares[row] += f64::from(*weight).powi(2);
    }
    squares
}

/// Σ_x Σ_v (Vᵀ W_x)_vi² for each row i of the light bases. Weights that meet different rows of a dual basis are orthogonal over the members
/// of a cluster.
fn squares_of_lights(model: &Model, layout: &Layout, of_weights: &[f64]) -> Vec<f64> {
    let mut squares = vec![0f64; layout.end().light];
    for (cluster, place) in model.clusters.iter().zip(layout.places()) {
        for (j, row) in cluster.dual.outer_iter().enumerate() {
            for (at, v) in row.iter().enumerate() {
                squares[place.light + at % place.light_rank] += of_weights[place.sample + j] * f64::from(*v).powi(2);
            }
        }
    }
    squares
}
