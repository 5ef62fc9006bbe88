//! Eight bits for numbers of many sizes.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::{Array2, Axis};
use prt_transfer::Result;

pub(super) const CASE: Case = Case {
    name: "range",
    title: "Eight bits for rows of very different sizes",
    source: "Ng et al. 2003, §5: coefficients quantised",
    parameter: "ratio of the largest row to the smallest",
    values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
    quantity: "Σ(T-T̃)²/ΣT² of the worst row",
    printed: Form { name: "one step for all", figure: printed },
    here: Form { name: "truncate:bits=8, a step for each row", figure: here },
    bound: |_| 1e-4,
    promise: "1e-4 in every row",
    breaks: Some(10.0),
};

fn rows(ratio: f64) -> Array2<f64> {
    let mut rows = ground::noise(16, 64, 92);
    for (i, mut row) in rows.outer_iter_mut().enumerate() {
        row *= ratio.powf(-(i as f64) / 15.0);
    }
    rows
}

fn worst(found: &Array2<f64>, rows: &Array2<f64>) -> f64 {
    let of = |(a, b): (ndarray::ArrayView1<f64>, ndarray::ArrayView1<f64>)| {
        ground::distance(a.insert_axis(Axis(0)), b.insert_axis(Axis(0)))
    };
    found.outer_iter().zip(rows.outer_iter()).map(of).fold(0.0, f64::max)
}

fn printed(ratio: f64) -> Result<f64> {
    let rows = rows(ratio);
    let step = rows.iter().fold(0f64, |most, v| most.max(v.abs())) / 127.0;
    Ok(worst(&rows.mapv(|v| (v / step).round() * step), &rows))
}

fn here(ratio: f64) -> Result<f64> {
    let (rows, matrix) = (rows(ratio), ground::plain(rows(ratio).view())?);
    let compressed = ground::encoded("truncate:terms=64:bits=8", &matrix)?;
    Ok(worst(&ground::decoded(&compressed).mapv(f64::from), &rows))
}
