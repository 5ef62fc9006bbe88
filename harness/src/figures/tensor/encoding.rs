//! What a method makes of coefficients, measured on what comes back from its file.

use super::coefficients::Coefficients;
use crate::figures::stage::Stage;
use crate::interrupt::Unseen;
use crate::{error_sums, memory, registry};
use anyhow::{Context, anyhow, ensure};
use ndarray::Array2;
use prt_transfer::Compressed;
use prt_transfer::io::prt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// A label and what was measured, or why nothing was.
#[derive(Clone, Debug)]
pub(super) struct Encoding {
    pub(super) label: String,
    pub(super) figures: Result<Figures, String>,
}

/// Figures of a label.
#[derive(Clone, Copy, Debug)]
pub(super) struct Figures {
    /// What relighting holds.
    pub(super) resident_bytes: u64,
    /// The `.prt` file.
    pub(super) file_bytes: u64,
    /// ‖T - T̃‖²/‖T‖² over the sphere.
    pub(super) error: f64,
    /// Wall clock of one run on all threads.
    pub(super) encode_s: f64,
    /// The most memory held while encoding, the matrix not counted.
    pub(super) peak_bytes: Option<u64>,
    /// Three channels of a light in lobes on all threads, median.
    pub(super) relight_ms: f64,
}

impl Encoding {
    /// Encodes once, since that may take hours. What fails has a reason.
    pub(super) fn of(stage: &Stage, coefficients: &Coefficients, label: &str) -> Encoding {
        stage.steps.show(&format!("{} {label}", super::title(&coefficients.scene)));
        let measured = catch_unwind(AssertUnwindSafe(|| measured(stage, coefficients, label)));
        stage.steps.done(1);
        let figures = measured.unwrap_or_else(|_| Err(anyhow!("the method panicked: a mistake in the program")));
        Encoding { label: label.into(), figures: figures.map_err(|error| format!("{error:#}")) }
    }
}

fn measured(stage: &Stage, coefficients: &Coefficients, label: &str) -> anyhow::Result<Figures> {
    let (pools, Coefficients { matrix, basis, .. }) = (stage.bench.pools, coefficients);
    let method = registry::method(stage.bench.registry, label)?;
    let began = Instant::now();
    let (encoded, peak_bytes) =
        memory::peak_of(|| pools.everywhere(|| method.encode_coefficients(matrix, basis, &Unseen)));
    let encode_s = began.elapsed().as_secs_f64();
    let file = prt::to_bytes(&encoded?, &Unseen)?;
    let compressed = prt::from_bytes(&file, stage.bench.registry)?;
    let error = pools.everywhere(|| error(coefficients, &compressed));
    ensure!(error.is_finite(), "the decoded matrix is not finite");
    Ok(Figures {
        resident_bytes: compressed.resident_bytes() as u64,
        file_bytes: file.len() as u64,
        error,
        encode_s,
        peak_bytes,
        relight_ms: relight_ms(stage, coefficients, &compressed)?,
    })
}

/// ‖T - T̃‖² = (‖T‖² - ‖C‖²) + ‖C - C̃‖²: C's coordinates are orthonormal over the sphere, and what is not in them is at right angles to T̃.
pub(super) fn error(coefficients: &Coefficients, compressed: &Compressed) -> f64 {
    let Coefficients { matrix, metric, square, .. } = coefficients;
    coefficients.lost() + error_sums::of_coefficients(matrix, compressed, metric).squares / square
}

fn relight_ms(stage: &Stage, coefficients: &Coefficients, compressed: &Compressed) -> anyhow::Result<f64> {
    let light = coefficients.light.view();
    let mut out = Array2::zeros((coefficients.matrix.rows(), light.ncols()));
    let mut relight = || compressed.apply_coefficients_into(light, out.view_mut());
    let (pools, budget) = (stage.bench.pools, stage.bench.budget);
    let timing = pools.everywhere(|| budget.time(&mut relight));
    Ok(timing.context("relighting with lobes")?.median_ms)
}
