//! All-frequency CPCA as it was published (Liu et al. 2004): wavelet coefficients of the lights in segments, each compressed by itself.

use crate::error_sums;
use crate::figures::stage::Stage;
use crate::interrupt::Unseen;
use crate::registry;
use anyhow::Context;
use ndarray::{Array2, s};
use prt_transfer::io::prt;
use prt_transfer::method::transform_rows;
use prt_transfer::{Compressed, Error, Label, LightBasis, LightTransform, Metric, TransferMatrix};
use std::time::Instant;

/// Coefficients of a segment.
pub(super) const LENGTH: usize = 256;

/// The sums over all segments.
pub(super) struct Segmented {
    pub(super) file_bytes: u64,
    pub(super) resident_bytes: u64,
    pub(super) error: f64,
    pub(super) encode_s: f64,
    pub(super) relight_ms: f64,
}

/// C of T ≈ C·B in segments of its columns.
pub(super) struct Segments {
    bound: Box<dyn LightTransform>,
    parts: Vec<TransferMatrix>,
    seconds: f64,
}

impl Segments {
    /// Of a light transform that is orthonormal over the sphere.
    pub(super) fn of(stage: &Stage, matrix: &TransferMatrix, transform: &str) -> anyhow::Result<Segments> {
        let label: Label = format!("{transform}+dense").parse()?;
        let (bound, began) = (stage.bench.registry.method(&label)?.bind(matrix.basis())?, Instant::now());
        let bound_ref = &*bound;
        let whole = stage.bench.pools.everywhere(|| transform_rows(matrix, bound_ref, &Unseen))?;
        let parts = (0..whole.lights()).step_by(LENGTH).map(|first| cut(&whole, first));
        let parts = parts.collect::<anyhow::Result<Vec<TransferMatrix>>>()?;
        Ok(Segments { bound, parts, seconds: began.elapsed().as_secs_f64() })
    }

    /// How many.
    pub(super) fn count(&self) -> usize {
        self.parts.len()
    }

    /// Every segment by the codec of this label; the transform is counted as encoding too.
    pub(super) fn measure(&self, stage: &Stage, codec: &str, light: &Array2<f32>) -> anyhow::Result<Segmented> {
        let (registry, pools) = (stage.bench.registry, stage.bench.pools);
        let method = registry::method(registry, codec)?;
        let (mut encoded, mut encode_s, mut file_bytes) = (Vec::new(), self.seconds, 0);
        let [mut error, mut square] = [0.0; 2];
        for part in &self.parts {
            let began = Instant::now();
            let compressed = pools.everywhere(|| method.encode(part, &Unseen))?;
            encode_s += began.elapsed().as_secs_f64();
            let file = prt::to_bytes(&compressed, &Unseen)?;
            file_bytes += file.len() as u64;
            let (compressed, metric) = (prt::from_bytes(&file, registry)?, Metric::of(part)?);
            error += pools.everywhere(|| error_sums::of_difference(part, &compressed, &metric)).squares;
            square += pools.everywhere(|| error_sums::of_matrix(part, &metric)).squares;
            encoded.push(compressed);
        }
        let resident_bytes = encoded.iter().map(|part| part.resident_bytes() as u64).sum();
        let relight_ms = self.relight_ms(stage, &encoded, light)?;
        Ok(Segmented { file_bytes, resident_bytes, error: error_sums::relative(error, square), encode_s, relight_ms })
    }

    /// The light's coefficients, then the sum of what all segments make of theirs.
    fn relight_ms(&self, stage: &Stage, encoded: &[Compressed], light: &Array2<f32>) -> anyhow::Result<f64> {
        let (budget, bound) = (stage.bench.budget, &*self.bound);
        let channels = light.ncols();
        let mut coefficients = Array2::zeros((bound.output().lights(), channels));
        let rows = self.parts.first().context("there are segments")?.rows();
        let [mut out, mut part] = [0, 1].map(|_| Array2::zeros((rows, channels)));
        let mut relight = || {
            bound.light_into(light.view(), coefficients.view_mut());
            out.fill(0.0);
            encoded.iter().enumerate().try_for_each(|(i, compressed)| {
                let own = coefficients.slice(s![i * LENGTH.., ..]);
                compressed.apply_into(own.slice(s![..compressed.shape().lights, ..]), part.view_mut())?;
                out += &part;
                Ok::<(), Error>(())
            })
        };
        Ok(stage.bench.pools.everywhere(|| budget.time(&mut relight))?.median_ms)
    }
}

fn cut(whole: &TransferMatrix, first: usize) -> anyhow::Result<TransferMatrix> {
    let (values, lights) = (whole.as_dense().context("dense coefficients")?, whole.lights());
    let length = LENGTH.min(lights - first);
    let own = values.chunks_exact(lights).flat_map(|row| &row[first..first + length]).copied().collect();
    let (basis, responses) = (LightBasis::Plain { lights: length }, whole.shape().responses);
    Ok(TransferMatrix::from_dense(own, whole.rows(), responses, basis)?.by_samples())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::precompute;
    use crate::figures::stage::Meshes;
    use crate::figures::tensor::spec;
    use crate::machine::Machine;
    use crate::measure::{Bench, Pools};
    use crate::timing::Budget;
    use prt_transfer::Quiet;
    use std::time::Duration;

    #[test]
    fn segments_hold_every_coefficient_once_and_what_an_exact_codec_makes_of_them_is_exact() {
        let (registry, pools) = (registry::registry(), Pools::new(2).unwrap());
        let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(Duration::ZERO) };
        let stage = Stage::new(bench, Machine::here(2), Meshes::BuiltIn(20));
        let matrix = precompute("blob", Some(20), &spec(), &Quiet).unwrap().matrix;
        let segments = Segments::of(&stage, &matrix, "haar:scale=sphere").unwrap();
        assert_eq!((segments.count(), segments.parts[23].lights()), (24, LENGTH));
        let square = |matrix: &TransferMatrix| error_sums::of_matrix(matrix, &Metric::of(matrix).unwrap()).weighted;
        let (parts, whole): (f64, f64) = (segments.parts.iter().map(square).sum(), square(&matrix));
        // The metric's weights 1/dω have a mean of 1.
        let angles = matrix.basis().solid_angles().unwrap();
        let mean = angles.iter().map(|a| 1.0 / a).sum::<f64>() / angles.len() as f64;
        assert!((parts / (mean * whole) - 1.0).abs() < 1e-5, "orthonormal over the sphere: {parts} {whole}");
        let light = Array2::ones((matrix.lights(), 3));
        let exact = segments.measure(&stage, "dense", &light).unwrap();
        let cells = 4 * matrix.rows() * matrix.lights();
        assert_eq!((exact.error, exact.resident_bytes), (0.0, cells as u64));
    }
}
