//! Signals whose rows are dense, computed point by point and handed on as they are finished.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::matrix::{Shape, TransferMatrix};
use crate::progress::Progress;
use crate::responses::ResponseBasis;
use crate::scene::signal::{Samples, Surface, Traced, Visible, for_each_point};
use crate::transform::LightTransform;
use ndarray::{Array2, ArrayViewMut2};
use std::sync::OnceLock;

/// A signal with everything that its rows need besides the surface.
pub trait DenseSignal: Sync {
    /// What the columns stand for.
    fn basis(&self) -> LightBasis;
    /// What the rows of a sample stand for.
    fn responses(&self) -> ResponseBasis;
    /// The directions that visibility is asked for.
    fn samples(&self) -> &Samples;
    /// The rows of a surface point, responses x lights, into `out`, which holds zeros.
    fn rows_into(&self, surface: &Surface, point: usize, visible: &Visible, out: &mut [f32]) -> Result<()>;
}

/// A signal in the coordinates of a light transform: the rows of C of T ≈ C·B, point by point, so that T never has to be in memory.
pub struct Transformed<'a> {
    signal: &'a dyn DenseSignal,
    transform: &'a dyn LightTransform,
    inverse_angles: Option<Vec<f64>>,
    /// Σ T²/dω of each point that has been computed.
    squares: Vec<OnceLock<f64>>,
}

impl<'a> Transformed<'a> {
    /// `transform` is bound to the signal's basis; so many points will be computed.
    pub fn new(signal: &'a dyn DenseSignal, transform: &'a dyn LightTransform, points: usize) -> Transformed<'a> {
        let angles = signal.basis().solid_angles();
        let inverse_angles = angles.map(|angles| angles.into_iter().map(|a| 1.0 / a).collect());
        Transformed { signal, transform, inverse_angles, squares: vec![OnceLock::new(); points] }
    }

    /// Σ T²/dω of all points so far, the square over the sphere, where columns have solid angles. Where the transform is a projection onto
    /// orthonormal functions it loses as much of it as Σ C² is less.
    pub fn square(&self) -> Option<f64> {
        self.inverse_angles.as_ref().map(|_| self.squares.iter().filter_map(OnceLock::get).sum())
    }
}

impl DenseSignal for Transformed<'_> {
    fn basis(&self) -> LightBasis {
        self.transform.output()
    }
    fn responses(&self) -> ResponseBasis {
        self.signal.responses()
    }
    fn samples(&self) -> &Samples {
        self.signal.samples()
    }
    fn rows_into(&self, surface: &Surface, point: usize, visible: &Visible, out: &mut [f32]) -> Result<()> {
        let (responses, lights) = (self.responses().responses(), self.signal.basis().lights());
        let mut rows = Array2::<f32>::zeros((responses, lights));
        self.signal.rows_into(surface, point, visible, rows.as_slice_mut().expect("a fresh array is contiguous"))?;
        let weight = |k: usize| self.inverse_angles.as_ref().map_or(1.0, |w| w[k]);
        let square = rows.indexed_iter().map(|((_, k), t)| weight(k) * f64::from(*t).powi(2)).sum();
        // A point is computed once.
        let _ = self.squares[point].set(square);
        let out = ArrayViewMut2::from_shape((responses, self.transform.output().lights()), out);
        self.transform.rows_into(rows.view(), out.expect("a point's rows of C"));
        Ok(())
    }
}

/// The shape of the matrix at so many points.
///
/// # Errors
/// More elements than memory could ever address.
pub fn shape(signal: &dyn DenseSignal, points: usize) -> Result<Shape> {
    Shape::new(points, signal.responses().responses(), signal.basis().lights())
}

/// Computes the rows of every point and hands them to `take`, responses x lights at a time, in the order of the points.
/// No more than a batch of them is in memory at once.
pub fn stream(
    signal: &dyn DenseSignal,
    surface: &Surface,
    progress: &dyn Progress,
    mut take: impl FnMut(&[f32]) -> Result<()> + Send,
) -> Result<Traced> {
    let shape = shape(signal, surface.points.len())?;
    let at = |point: usize, visible: &Visible| {
        let mut rows = vec![0f32; shape.responses * shape.lights];
        signal.rows_into(surface, point, visible, &mut rows)?;
        Ok(rows)
    };
    let bytes = size_of::<f32>() * shape.responses * shape.lights;
    let mut point = 0;
    for_each_point(surface, signal.samples(), bytes, progress, at, |rows| {
        if let Some(at) = rows.iter().position(|v| !v.is_finite()) {
            let (row, col) = (point * shape.responses + at / shape.lights, at % shape.lights);
            return Err(Error::NotFinite { row, col, value: rows[at].into() });
        }
        point += 1;
        take(&rows)
    })
}

/// The rows of all points, one after the other.
pub(crate) fn rows(signal: &dyn DenseSignal, surface: &Surface, progress: &dyn Progress) -> Result<(Vec<f32>, Traced)> {
    let shape = shape(signal, surface.points.len())?;
    let (mut values, elements) = (Vec::new(), shape.rows() * shape.lights);
    values.try_reserve_exact(elements).map_err(|_| Error::Unsupported {
        what: "dense matrix in memory".into(),
        expected: "as much as there is, or a .npy, which is written as it is computed".into(),
        found: format!("{elements} elements of 4 bytes"),
    })?;
    let traced = stream(signal, surface, progress, |rows| {
        values.extend_from_slice(rows);
        Ok(())
    })?;
    Ok((values, traced))
}

/// A matrix of rows that were computed: samples x responses x lights where there are several responses.
pub(crate) fn assemble(
    values: Vec<f32>,
    shape: Shape,
    basis: LightBasis,
    responses: ResponseBasis,
) -> Result<TransferMatrix> {
    let matrix = TransferMatrix::from_dense(values, shape.rows(), shape.responses, basis)?.with_responses(responses)?;
    Ok(if shape.responses > 1 { matrix.by_samples() } else { matrix })
}

/// The whole matrix, dense, samples x responses x lights.
pub fn matrix(
    signal: &dyn DenseSignal,
    surface: &Surface,
    progress: &dyn Progress,
) -> Result<(TransferMatrix, Traced)> {
    let (values, traced) = rows(signal, surface, progress)?;
    let shape = shape(signal, surface.points.len())?;
    Ok((assemble(values, shape, signal.basis(), signal.responses())?, traced))
}
