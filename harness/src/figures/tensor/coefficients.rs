//! A mesh's transfer in lobes, computed without ever holding the transfer itself.

use super::{spec, title};
use crate::compute::Computation;
use crate::figures::stage::{Mesh, Stage};
use crate::interrupt::Unseen;
use crate::lights::{self, LIGHTS};
use anyhow::Context;
use ndarray::Array2;
use prt_transfer::samples::square;
use prt_transfer::scene::dense::{self, DenseSignal, Transformed};
use prt_transfer::{LightBasis, LightTransform, Metric, Stage as Part, TransferMatrix};

/// C of T ≈ C·B in orthonormal coordinates, and what is known of T.
pub(super) struct Coefficients {
    /// The mesh.
    pub(super) scene: String,
    /// C, samples x responses x lobes.
    pub(super) matrix: TransferMatrix,
    /// T's columns.
    pub(super) basis: LightBasis,
    /// ‖T‖² over the sphere.
    pub(super) square: f64,
    /// ‖C‖².
    pub(super) kept: f64,
    /// A light as relighting takes it: lobes x 3.
    pub(super) light: Array2<f32>,
    /// All of the precomputation, lobes included, s.
    pub(super) seconds: f64,
    /// Of C, in which squared error is that over the sphere.
    pub(super) metric: Metric,
}

impl Coefficients {
    /// Of a mesh.
    pub(super) fn of(stage: &Stage, mesh: &Mesh) -> anyhow::Result<Coefficients> {
        let ((scene, vertices, up), spec) = (stage.place(mesh), spec());
        stage.steps.show(&title(&scene));
        let computation = Computation::new(&scene, vertices, up, &spec)?;
        let (signal, bound) = computation.transformed(&Part::named("srbf"))?;
        let transformed = Transformed::new(&*signal, &*bound, computation.points());
        let shape = dense::shape(&transformed, computation.points())?;
        let (mut values, mut kept) = (Vec::new(), 0.0);
        values.try_reserve_exact(shape.rows() * shape.lights).context("no room for the coefficients")?;
        let take = |rows: &[f32]| {
            values.extend_from_slice(rows);
            kept += square(rows);
            Ok(())
        };
        let streamed = stage.bench.pools.everywhere(|| computation.stream(&transformed, &Unseen, take))?;
        let square = transformed.square().context("lobes lie on the sphere")?;
        let matrix = TransferMatrix::from_dense(values, shape.rows(), shape.responses, streamed.basis)?;
        let matrix = matrix.with_responses(streamed.responses)?.by_samples();
        let (basis, metric, light) = (signal.basis(), Metric::of(&matrix)?, light(&*signal, &*bound)?);
        Ok(Coefficients { scene, matrix, basis, square, kept, light, seconds: streamed.seconds, metric })
    }

    /// Surface points.
    pub(super) fn samples(&self) -> usize {
        self.matrix.shape().samples
    }

    /// The part of T's square that is not in C, which is T's projection: ‖T‖² - ‖C‖².
    pub(super) fn lost(&self) -> f64 {
        (self.square - self.kept).max(0.0) / self.square
    }
}

fn light(signal: &dyn DenseSignal, bound: &dyn LightTransform) -> anyhow::Result<Array2<f32>> {
    let texels = lights::light(LIGHTS[0], &signal.basis())?;
    let mut coefficients = Array2::zeros((bound.output().lights(), texels.ncols()));
    bound.light_into(texels.view(), coefficients.view_mut());
    Ok(coefficients)
}
