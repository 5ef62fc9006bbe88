//! Takes a method through its file and measures what comes back.

use crate::error_sums::{self, Sums, relative};
use crate::family;
use crate::interrupt::{self, Unseen};
use crate::lights::{self, LIGHTS, Light};
use crate::pictures::{Portrait, SIZE, Turning, Viewpoint};
use crate::row::{Row, Status};
use crate::suite::{DENSE_LIMIT, Origin};
use crate::timing::{Budget, Timing};
use crate::{files, fingerprint, memory, number, room};
use anyhow::{Context, ensure};
use ndarray::{Array2, ArrayView2, s};
use prt_transfer::{Compressed, Extent, Label, Metric, Progress, Registry, TransferMatrix, linalg};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

/// Encoding is repeated so often …
const ENCODE_RUNS: usize = 7;
/// … or until so much time has passed.
const ENCODE_BUDGET: Duration = Duration::from_millis(120);

/// Threads to measure on: pools of their own, so that nothing else runs in them.
pub struct Pools {
    one: ThreadPool,
    all: ThreadPool,
}

/// A matrix with everything that methods are compared with.
pub struct Reference {
    matrix: TransferMatrix,
    metric: Metric,
    whole: Sums,
    /// Light and exact response by the names of [`LIGHTS`]; none where the basis has no place on the sphere.
    relit: Vec<(Array2<f32>, Array2<f32>)>,
    /// What relighting is timed with: lights x 3.
    timed: Array2<f32>,
    /// What is seen under the first of [`LIGHTS`]; none where nobody looks or there is nothing to see.
    seen: Option<(Viewpoint, Portrait)>,
    /// The first of [`LIGHTS`] while it turns; likewise.
    turning: Option<Turning>,
}

/// How much to spend and where to write.
pub struct Bench<'a> {
    /// Every method.
    pub registry: &'a Registry,
    /// Threads.
    pub pools: &'a Pools,
    /// Time for each relighting figure.
    pub budget: Budget,
}

impl Pools {
    /// One thread, and `threads` of them.
    pub fn new(threads: usize) -> anyhow::Result<Pools> {
        let pool = |n| ThreadPoolBuilder::new().num_threads(n).build();
        let pools = Pools { one: pool(1)?, all: pool(threads)? };
        // What a library keeps for each thread is no method's memory, least of all that of the first that runs.
        let before = memory::held();
        pools.all.broadcast(|_| linalg::warm_up());
        room::leave_out(memory::held().saturating_sub(before) as u64);
        Ok(pools)
    }
    /// Runs `work` on all threads.
    pub fn everywhere<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.all.install(work)
    }
}

impl Reference {
    /// Computes the exact responses and norms.
    pub fn new(matrix: TransferMatrix) -> anyhow::Result<Reference> {
        let basis = matrix.basis();
        let metric = Metric::of(&matrix)?;
        let whole = error_sums::of_matrix(&matrix, &metric);
        let mut relit = Vec::new();
        // A basis without a place on the sphere has no light to compare under.
        for light in LIGHTS.iter().map_while(|name| lights::light(name, basis).ok()) {
            let light = matrix.responses().light(basis, light)?;
            let mut out = Array2::zeros((matrix.rows(), light.ncols()));
            matrix.apply_into(light.view(), out.view_mut())?;
            relit.push((light, out));
        }
        let timed = match relit.first() {
            Some((light, _)) => light.clone(),
            None => Array2::from_shape_fn((matrix.lights(), 3), |(k, c)| 1.0 + (7 * k + c) as f32 % 5.0),
        };
        Ok(Reference { matrix, metric, whole, relit, timed, seen: None, turning: None })
    }
    /// With what errors of pictures and flicker take, where `origin` says what is seen.
    pub fn with_pictures(self, origin: &Origin) -> anyhow::Result<Reference> {
        let (matrix, light) = (&self.matrix, Light::named(LIGHTS[0])?);
        let Some(viewpoint) = Viewpoint::of(origin, matrix.responses(), SIZE, &Unseen)? else { return Ok(self) };
        let turning = viewpoint.is_lit().then(|| Turning::new(matrix, &light, &self.metric)).transpose()?;
        let portrait = Portrait::taken(&viewpoint, matrix, light.on(matrix.basis(), 0.0)?)?;
        Ok(Reference { seen: Some((viewpoint, portrait)), turning, ..self })
    }
    /// Σ T², which errors are relative to.
    pub fn square(&self) -> f64 {
        self.whole.squares
    }
    /// Sums of T, which errors are relative to.
    pub fn whole(&self) -> &Sums {
        &self.whole
    }
    /// The matrix itself.
    pub fn matrix(&self) -> &TransferMatrix {
        &self.matrix
    }
    /// What an error over the sphere is measured by.
    pub fn metric(&self) -> &Metric {
        &self.metric
    }
    /// Σ(T-T̃)²/ΣT², and the same over the sphere where lights have a place on it.
    pub fn error_of(&self, compressed: &Compressed) -> (f64, Option<f64>) {
        let Reference { matrix, metric, whole, .. } = self;
        let sums = error_sums::of_difference(matrix, compressed, metric);
        let weighted = metric.is_known().then(|| relative(sums.weighted, whole.weighted));
        (relative(sums.squares, whole.squares), weighted)
    }
}

impl Bench<'_> {
    /// What a row says before anything is measured: `subject` with the method, the threads and the program.
    pub fn planned(&self, subject: &Row, method: &str) -> Row {
        Row {
            method: method.into(),
            family: family::of(method),
            threads: self.pools.all.current_num_threads(),
            program: fingerprint::program().into(),
            ..subject.clone()
        }
    }

    /// As [`Bench::measure`] by the method of `planned`; whatever goes wrong becomes the row's reason.
    ///
    /// # Errors
    /// The user's wish to stop, which is no failure of the method.
    pub fn attempt(
        &self,
        planned: Row,
        reference: &Reference,
        path: &Path,
        progress: &dyn Progress,
    ) -> anyhow::Result<Row> {
        let label: Label = match planned.method.parse() {
            Ok(label) => label,
            Err(error) => return Ok(planned.failed(format!("{error}"))),
        };
        let cells = 4 * planned.samples as u64 * planned.responses as u64 * planned.lights as u64;
        if label.to_string() == "dense" && cells > DENSE_LIMIT {
            let [size, limit] = [cells, DENSE_LIMIT].map(number::bytes);
            return Ok(planned.failed(format!("would need {size}, above the bench's limit of {limit}")));
        }
        let measured =
            catch_unwind(AssertUnwindSafe(|| self.measure(planned.clone(), &label, reference, path, progress)));
        match measured {
            Ok(Err(error)) if interrupt::is_cause_of(&error) => Err(error),
            Ok(Ok(row)) => Ok(row),
            Ok(Err(error)) => Ok(planned.failed(format!("{error:#}"))),
            Err(_) => Ok(planned.failed("the method panicked: a mistake in the program")),
        }
    }

    /// Encodes, writes `path`, reads it back, and fills `row` with the figures of what came back.
    pub fn measure(
        &self,
        row: Row,
        label: &Label,
        reference: &Reference,
        path: &Path,
        progress: &dyn Progress,
    ) -> anyhow::Result<Row> {
        let method = self.registry.method(label)?;
        let matrix = &reference.matrix;
        self.pools.everywhere(|| room::check_method(&method, &Extent::of(matrix), matrix.basis(), 0))?;
        let encode = || self.pools.everywhere(|| method.encode(&reference.matrix, progress));
        let (mut encoded, mut times, mut peak_encode_bytes, began) = (None, Vec::new(), None, Instant::now());
        while times.is_empty() || (times.len() < ENCODE_RUNS && began.elapsed() < ENCODE_BUDGET) {
            drop(encoded.take());
            let start = Instant::now();
            let (result, peak) = memory::peak_of(encode);
            times.push(start.elapsed().as_secs_f64() * 1e3);
            encoded = Some(result?);
            peak_encode_bytes = peak_encode_bytes.max(peak);
        }
        let encode = Timing::of(&mut times);
        let encode_spread_s = (encode.runs >= 3).then_some(encode.spread_ms / 1e3);
        let encoded = encoded.context("at least one run")?;
        let sizes = files::write_prt(path, &encoded, progress)?;
        drop(encoded);
        let compressed = files::read_prt(path, self.registry)?;
        let encode_s = Some(encode.median_ms / 1e3);
        let mut row = Row { encode_s, encode_spread_s, peak_encode_bytes, file_bytes: Some(sizes.file), ..row };
        storage_and_work(&mut row, &compressed, reference)?;
        self.pools.everywhere(|| errors(&mut row, &compressed, reference))?;
        ensure!(row.error.is_some_and(f64::is_finite), "the decoded matrix is not finite");
        self.pools.everywhere(|| pictures(&mut row, &compressed, reference))?;
        self.times(&mut row, &compressed, reference)?;
        Ok(Row { status: Status::Ok, reason: String::new(), ..row })
    }

    /// Relights one channel on one thread by each of `runners` in turn; a timing for each.
    pub fn race(&self, runners: &[Compressed], reference: &Reference) -> anyhow::Result<Vec<Timing>> {
        let light = reference.timed.slice(s![.., ..1]).to_owned();
        let mut out = Array2::zeros((reference.matrix.rows(), 1));
        let mut run = |i: usize| runners[i].apply_into(light.view(), out.view_mut());
        Ok(self.pools.one.install(|| self.budget.race(runners.len(), &mut run))?)
    }

    fn times(&self, row: &mut Row, compressed: &Compressed, reference: &Reference) -> anyhow::Result<()> {
        let timed = reference.timed.view();
        let one = timed.slice(s![.., ..1]).to_owned();
        let mut runs = usize::MAX;
        let mut of = |pool: &ThreadPool, light: ArrayView2<f32>| -> anyhow::Result<(Option<f64>, Option<f64>)> {
            let mut out = Array2::zeros((compressed.shape().rows(), light.ncols()));
            let timing: Timing =
                pool.install(|| self.budget.time(|| compressed.apply_into(light.view(), out.view_mut())))?;
            runs = runs.min(timing.runs);
            Ok((Some(timing.median_ms), Some(timing.spread_ms)))
        };
        let Pools { one: single, all } = self.pools;
        (row.relight_1_ms, row.relight_1_spread_ms) = of(single, one.view())?;
        (row.relight_all_ms, row.relight_all_spread_ms) = of(all, one.view())?;
        (row.relight_rgb_1_ms, row.relight_rgb_1_spread_ms) = of(single, timed)?;
        (row.relight_rgb_all_ms, row.relight_rgb_all_spread_ms) = of(all, timed)?;
        row.runs = runs;
        Ok(())
    }
}

fn storage_and_work(row: &mut Row, compressed: &Compressed, reference: &Reference) -> anyhow::Result<()> {
    let resident = compressed.resident_bytes() as u64;
    row.resident_bytes = Some(resident);
    row.bytes_per_non_zero = (row.non_zeros > 0).then(|| resident as f64 / row.non_zeros as f64);
    let flops = compressed.flops(&reference.timed.column(0).to_vec())?;
    row.multiplications = Some(flops.multiplications);
    row.additions = Some(flops.additions);
    row.flops_value_aware = Some(flops.value_aware());
    Ok(())
}

fn errors(row: &mut Row, compressed: &Compressed, reference: &Reference) -> anyhow::Result<()> {
    let Reference { matrix, metric, whole, relit, .. } = reference;
    let sums = error_sums::of_difference(matrix, compressed, metric);
    row.error = Some(relative(sums.squares, whole.squares));
    row.error_sphere = metric.is_known().then(|| relative(sums.weighted, whole.weighted));
    row.error_max = Some(sums.max);
    for ((light, exact), figure) in relit.iter().zip(row.relit_errors_mut()) {
        let mut out = Array2::zeros(exact.dim());
        compressed.apply_into(light.view(), out.view_mut())?;
        let difference = metric
            .square_of_output(exact.indexed_iter().map(|(at, &y)| f64::from(y) - f64::from(out[at])), exact.ncols());
        let size = metric.square_of_output(exact.iter().map(|&y| f64::from(y)), exact.ncols());
        *figure = Some(relative(difference, size));
    }
    Ok(())
}

/// Errors of what is seen.
fn pictures(row: &mut Row, compressed: &Compressed, reference: &Reference) -> anyhow::Result<()> {
    let Reference { metric, seen, turning, .. } = reference;
    row.flicker = turning.as_ref().map(|turning| turning.flicker(compressed, metric)).transpose()?;
    if let Some((viewpoint, portrait)) = seen {
        let errors = portrait.compare(viewpoint, compressed)?.errors;
        row.picture_error = Some(errors.relative_squared_error);
        row.picture_psnr_db = Some(errors.psnr_db).filter(|psnr| psnr.is_finite());
        row.picture_flip = Some(errors.flip);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::registry;
    use prt_transfer::LightBasis;
    use prt_transfer::Quiet;
    use std::time::Duration;

    fn measured(matrix: TransferMatrix) -> Row {
        let (folder, registry, pools) = (tempfile::tempdir().unwrap(), registry(), Pools::new(2).unwrap());
        let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(Duration::ZERO) };
        let row = Row { non_zeros: matrix.non_zeros(), ..Row::default() };
        let reference = Reference::new(matrix).unwrap();
        let path = folder.path().join("a.prt");
        let row = bench.measure(row, &"csr".parse().unwrap(), &reference, &path, &Quiet).unwrap();
        assert_eq!(row.file_bytes, Some(path.metadata().unwrap().len()));
        row
    }

    #[test]
    fn an_exact_method_is_measured_exact_and_counted_by_the_closed_formula() {
        let basis = LightBasis::Cubemap { resolution: 4 };
        let values = (0..30 * 96).map(|i| if i % 3 == 0 { 1.0 } else { 0.5 }).collect();
        let row = measured(TransferMatrix::from_dense(values, 30, 1, basis).unwrap());
        assert_eq!((row.error, row.error_sphere, row.error_max), (Some(0.0), Some(0.0), Some(0.0)));
        let nnz = 30 * 96;
        assert_eq!((row.multiplications, row.additions), (Some(nnz), Some(nnz)));
        assert_eq!(row.flops_value_aware, Some(2 * nnz - nnz / 3));
        assert_eq!(row.resident_bytes, Some(8 * 31 + 8 * nnz));
        // The reference accumulates in f64, the method in f32.
        assert!(row.relit_errors().iter().all(|e| e.is_some_and(|e| e < 1e-12)), "{row:?}");
        assert!(row.runs >= 7 && row.relight_1_ms.is_some() && row.relight_rgb_all_ms.is_some());
    }

    #[test]
    fn a_matrix_off_the_sphere_or_without_elements_is_measured_too() {
        let plain = |rows: usize, lights| {
            let basis = LightBasis::Plain { lights };
            TransferMatrix::from_csr(vec![0; rows + 1], Vec::new(), Vec::new(), 1, basis).unwrap()
        };
        for row in [measured(plain(5, 7)), measured(plain(0, 3))] {
            assert_eq!((row.error, row.error_sphere, row.relit_errors()), (Some(0.0), None, [None, None]));
            assert_eq!((row.multiplications, row.bytes_per_non_zero), (Some(0), None));
        }
    }
}
