//! Leading singular vectors of each cluster's residuals: `G_i ≈ U_i V_iᵀ` (paper §3.2), around nothing but 0.

use crate::gram::{Rows, tall_leading};
use crate::grouped::{Grouped, Part};
use crate::model::Model;
use crate::params::Colour;
use crate::residual::Residual;
use ndarray::{Array2, ArrayView2};
use prt_cpca::Solver;
use prt_transfer::{Progress, Result, linalg};
use rayon::prelude::*;

/// V and U of a part.
struct Fitted {
    /// Vectors x numbers.
    vectors: Array2<f64>,
    /// Members x vectors.
    weights: Array2<f64>,
    /// Σ G² less what is explained.
    left: f64,
}

/// The model of given clusters with at most so many components; fewer where no cluster has that rank.
pub(crate) fn fit(
    residual: &Residual,
    grouped: &Grouped,
    colour: Colour,
    components: usize,
    solver: Solver,
    progress: &dyn Progress,
) -> Result<Model> {
    let layout = grouped.layout(residual, colour, components);
    let parts = grouped.parts(&layout);
    progress.start("fit", parts.len() as u64);
    let fitted = |part: &Part| {
        let fitted = fit_part(&grouped.rows(residual, &layout, part), components, solver)?;
        progress.advance(1)?;
        Ok(fitted)
    };
    let fitted: Vec<Fitted> = parts.par_iter().map(fitted).collect::<Result<_>>()?;
    let rank = fitted.iter().map(|f| f.vectors.nrows()).max().unwrap_or(0);
    let (of_weights, of_vectors) = residual.scales();
    let (vector, square) = (of_vectors.powi(2), (of_weights * of_vectors).powi(2));
    let (left, energy) = (square * fitted.iter().map(|f| f.left).sum::<f64>(), square * residual.energy);
    if rank == 0 {
        // Clusters without components would differ in nothing.
        let one = Grouped::whole(residual.fields(), residual.shape.samples);
        let layout = one.layout(residual, colour, 0);
        let (surface, views) = (Vec::new(), Vec::new());
        let means = residual.means.clone();
        return Ok(Model { layout, members: one.members, means, surface, views, vector, left, energy });
    }
    let layout = grouped.layout(residual, colour, rank);
    let (mut surface, mut views) = (vec![0f32; layout.surface_numbers()], vec![0f32; layout.view_numbers()]);
    for (part, fitted) in parts.iter().zip(&fitted) {
        let channel = if colour == Colour::Separate { part.field } else { part.number };
        let group = grouped.fields[part.field].of_cluster(part.group);
        for (weights, &texel) in fitted.weights.outer_iter().zip(group) {
            let own = &mut surface[layout.weight(texel as usize, channel)..];
            own.iter_mut().zip(weights).for_each(|(own, w)| *own = (w * of_weights) as f32);
        }
        for (j, vector) in fitted.vectors.outer_iter().enumerate() {
            for (i, value) in vector.iter().enumerate() {
                // A vector over all channels has them one after the other.
                let (direction, channel) = (i % residual.shape.lights, part.number + i / residual.shape.lights);
                let at = layout.view(part.cluster, direction) + channel * rank + j;
                views[at] = (residual.restored(direction, *value) * of_vectors) as f32;
            }
        }
    }
    let members = grouped.members.clone();
    Ok(Model { layout, members, means: residual.means.clone(), surface, views, vector, left, energy })
}

fn fit_part(rows: &Rows, components: usize, solver: Solver) -> Result<Fitted> {
    let wanted = components.min(rows.group.len()).min(rows.length);
    let square = rows.square();
    if wanted == 0 {
        let (vectors, weights) = (Array2::zeros((0, rows.length)), Array2::zeros((rows.group.len(), 0)));
        return Ok(Fitted { vectors, weights, left: square });
    }
    let tall = rows.group.len() > rows.length && matches!(solver, Solver::Auto | Solver::Gram);
    let vectors = if tall {
        tall_leading(rows, wanted)?
    } else {
        solver.solver().leading(rows.gathered(0..rows.group.len()).view(), wanted, None)?.vectors
    };
    let weights = weights(rows, vectors.view());
    let explained: f64 = weights.iter().map(|w| w * w).sum();
    Ok(Fitted { vectors, weights, left: (square - explained).max(0.0) })
}

/// U = G V.
fn weights(rows: &Rows, vectors: ArrayView2<f64>) -> Array2<f64> {
    let mut weights = Array2::zeros((rows.group.len(), vectors.nrows()));
    if vectors.is_empty() {
        return weights;
    }
    for (range, mut out) in rows.blocks().zip(weights.axis_chunks_iter_mut(ndarray::Axis(0), Rows::BLOCK)) {
        let block = rows.gathered(range);
        linalg::times_transposed_f64(block.view(), vectors, out.view_mut());
    }
    weights
}
