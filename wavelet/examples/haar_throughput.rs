//! Throughput of the Haar transform of a transfer matrix of 1,839 rows x 6 faces x 32 x 32 texels, in the words of its rival
//! `benches/peers/haar_pywavelets.py`:
//!
//! ```text
//! cargo run --release -p prt-wavelet --example haar_throughput [-- THREADS]
//! ```
//!
//! Two lines: `rows into memory that is there`, which is the transform alone, and `transform_rows`, which also makes
//! the new matrix and checks it.

use prt_transfer::method::transform_rows;
use prt_transfer::{Configure, LightBasis, LightTransform, Quiet, TransferMatrix, Transform};
use prt_wavelet::{Haar, HaarParams};
use rayon::prelude::*;
use std::io::Write;
use std::time::Instant;

const ROWS: usize = 1839;
const RUNS: usize = 7;

/// Median and least of the seconds of `RUNS` runs, after one that warms up.
fn seconds(mut run: impl FnMut()) -> (f64, f64) {
    let mut seconds: Vec<f64> = (0..=RUNS)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .skip(1)
        .collect();
    seconds.sort_by(f64::total_cmp);
    (seconds[RUNS / 2], seconds[0])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let threads = std::env::args().nth(1).map_or(Ok(1), |t| t.parse())?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    let basis = LightBasis::Cubemap { resolution: 32 };
    let lights = basis.lights();
    let values = (0..ROWS * lights).map(|i| (i as u32).wrapping_mul(0x9E37_79B9) as f32 / u32::MAX as f32).collect();
    let matrix = TransferMatrix::from_dense(values, ROWS, 1, basis)?;
    let haar = Haar::new(HaarParams::default())?.bind(matrix.basis())?;

    let mut out = vec![0f32; ROWS * lights];
    let into = seconds(|| {
        let rows = matrix.as_dense().unwrap_or_default().par_chunks(lights);
        rows.zip(out.par_chunks_mut(lights)).for_each(|(row, out)| haar.row_into(row, out));
    });
    let mut result = Ok(());
    let whole = seconds(|| result = transform_rows(&matrix, &haar, &Quiet).map(drop));
    result?;
    for (name, (median, least)) in [("rows into memory that is there", into), ("transform_rows", whole)] {
        let megabytes = (ROWS * lights * size_of::<f32>()) as f64 / 1e6;
        writeln!(
            std::io::stdout(),
            "prt-wavelet {name}, {threads} thread(s): {ROWS} x {lights} in {:.2} ms (fastest {:.2}), {:.0} rows/s, {:.0} MB/s",
            median * 1e3,
            least * 1e3,
            ROWS as f64 / median,
            megabytes / median
        )?;
    }
    Ok(())
}
