//! Factors that are nearly parallel: alternation creeps, and where it begins decides how far it gets.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::{Array2, Array3, ArrayD, Axis};
use prt_tensor::tucker::{Algorithm, Decomposer, Ranks, TuckerParams};
use prt_transfer::{Quiet, Result, linalg};

pub(super) const CASE: Case = Case {
    name: "swamp",
    title: "Swamps: nearly parallel factors",
    source: "De Lathauwer et al. 2000b; Tsai and Shih 2006, §5.2 (alternation)",
    parameter: "1 - cosine between factors",
    values: &[1.0, 0.3, 0.1, 0.03, 0.01, 1e-3],
    quantity: "squared error after one sweep beyond that after 200, relative",
    printed: Form { name: "alternation from random factors", figure: printed },
    here: Form {
        name: "HOOI, from ST-HOSVD",
        figure: |spread| Ok((error(spread, 1)? / error(spread, 200)? - 1.0).max(0.0)),
    },
    bound: |_| 0.01,
    promise: "1 %",
    breaks: Some(1.0),
};

const SIZES: [usize; 3] = [24, 20, 16];
const RANK: usize = 3;

/// Six products of vectors this far from parallel, each half as large as the one before, and a thousandth of noise.
fn tensor(spread: f64) -> Array3<f32> {
    let factor = |n: usize| {
        let (common, own) = (ground::noise(1, SIZES[n], 43 + n as u64), ground::noise(6, SIZES[n], 53 + n as u64));
        let (cosine, sine) = (1.0 - spread, (1.0 - (1.0 - spread) * (1.0 - spread)).sqrt());
        &common * cosine + &own * sine
    };
    let (factors, noise) = ([0, 1, 2].map(factor), ground::noise(SIZES[0], SIZES[1] * SIZES[2], 63));
    Array3::from_shape_fn((SIZES[0], SIZES[1], SIZES[2]), |(i, j, k)| {
        let term = |t: usize| 0.5f64.powi(t as i32) * factors[0][[t, i]] * factors[1][[t, j]] * factors[2][[t, k]];
        ((0..6).map(term).sum::<f64>() + 1e-3 * noise[[i, j * SIZES[2] + k]]) as f32
    })
}

fn error(spread: f64, sweeps: usize) -> Result<f64> {
    let ranks = Ranks::Given(vec![RANK; 3]);
    let params = TuckerParams { algorithm: Algorithm::Hooi, ranks, sweeps, tolerance: 0.0, ..TuckerParams::default() };
    let tensor: ArrayD<f32> = tensor(spread).into_dyn();
    Ok(Decomposer::new(params)?.decompose(tensor.view(), &Quiet)?.relative_error())
}

fn printed(spread: f64) -> Result<f64> {
    let t = tensor(spread).mapv(f64::from);
    let mut factors =
        [0, 1, 2].map(|n| linalg::orthonormal_columns(ground::noise(SIZES[n], RANK, 73 + n as u64).view()));
    for _ in 0..1 {
        for mode in 0..3 {
            // The others projected, then the leading left singular vectors of what is left.
            let mut rest = t.clone();
            for other in (0..3).filter(|&n| n != mode) {
                rest = product(&rest, &factors[other].t().to_owned(), other);
            }
            let unfolded = unfold(&rest, mode);
            let vectors = linalg::eigen(unfolded.dot(&unfolded.t()).as_standard_layout().view())?.vectors;
            factors[mode] = vectors.slice_axis(Axis(0), (..RANK).into()).t().as_standard_layout().into_owned();
        }
    }
    let core = (0..3).fold(t.clone(), |t, n| product(&t, &factors[n].t().to_owned(), n));
    let (whole, kept) = (t.iter().map(|v| v * v).sum::<f64>(), core.iter().map(|v| v * v).sum::<f64>());
    Ok(((1.0 - kept / whole) / error(spread, 200)? - 1.0).max(0.0))
}

/// uf_mode, the mode's size x all others.
fn unfold(t: &Array3<f64>, mode: usize) -> Array2<f64> {
    let mut moved = t.view();
    moved.swap_axes(0, mode);
    let (rows, columns) = (moved.shape()[0], moved.len() / moved.shape()[0]);
    moved.as_standard_layout().into_owned().into_shape_with_order((rows, columns)).unwrap_or_default()
}

/// T ×_mode M.
fn product(t: &Array3<f64>, m: &Array2<f64>, mode: usize) -> Array3<f64> {
    let mut sizes = [t.shape()[0], t.shape()[1], t.shape()[2]];
    sizes.swap(0, mode);
    sizes[0] = m.nrows();
    let folded = m.dot(&unfold(t, mode)).into_shape_with_order((sizes[0], sizes[1], sizes[2]));
    let mut out = folded.unwrap_or_default();
    out.swap_axes(0, mode);
    out.as_standard_layout().into_owned()
}
