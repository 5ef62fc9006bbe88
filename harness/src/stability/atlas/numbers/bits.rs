//! Fewer bits: what rounding to the nearest leaves, and what cutting digits off does.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use prt_transfer::Result;

pub(super) const CASE: Case = Case {
    name: "bits",
    title: "Sixteen, twelve and eight bits",
    source: "Ng et al. 2003, §5; Sloan et al. 2003, §6",
    parameter: "bits of a number",
    values: &[16.0, 12.0, 8.0],
    quantity: "Σ(T-T̃)²/ΣT² of normal numbers",
    printed: Form { name: "digits cut off, one step for all", figure: printed },
    here: Form { name: "truncate:bits=16, f16, truncate:bits=8", figure: here },
    bound: |bits| 2f64.powf(-2.0 * bits) * 4.0 * 4.0 / 3.0,
    promise: "a third of the square of half a step, for numbers up to four standard deviations",
    breaks: Some(16.0),
};

fn rows() -> ndarray::Array2<f64> {
    ground::noise(64, 64, 94)
}

fn printed(bits: f64) -> Result<f64> {
    let rows = rows();
    let step = rows.iter().fold(0f64, |most, v| most.max(v.abs())) / 2f64.powf(bits - 1.0);
    Ok(ground::distance(rows.mapv(|v| (v / step).floor() * step).view(), rows.view()))
}

/// Half precision has a sign, and twelve bits of which the first is not stored.
fn here(bits: f64) -> Result<f64> {
    let label = if bits == 12.0 { "f16".into() } else { format!("truncate:terms=64:bits={bits}") };
    ground::error(&label, &ground::plain(rows().view())?)
}
