//! Quantities that papers' tables print: by one name on the command line's tables, in the CSV and in a paper's data.

use crate::number;
use crate::row::Row;

/// A finished measurement, and that of the compact sparse matrix on the same scene.
#[derive(Clone, Copy)]
pub struct Measured<'a> {
    /// The method's.
    pub row: &'a Row,
    /// [`BASELINE`]'s, where it was measured.
    pub baseline: Option<&'a Row>,
}

/// A line of a table.
pub struct Quantity {
    /// Column of the CSV; what the paper prints has the same name with `paper_` before it.
    pub name: &'static str,
    /// For people, unit included.
    pub title: &'static str,
    /// The figure of a measurement.
    pub of: fn(Measured) -> Option<f64>,
    /// How a person reads it.
    pub text: fn(f64) -> String,
}

/// What compression is compared with besides the dense matrix.
pub const BASELINE: &str = "compact";

/// Of the matrix, whatever the method.
pub const OF_MATRIX: [Quantity; 6] = [
    quantity("vertices", "vertices", |m| Some(m.row.samples as f64), whole),
    quantity("nnz_millions", "nnz(T), M", |m| Some(m.row.non_zeros as f64 / 1e6), number::short),
    quantity("mflops", "2·nnz(T), MFLOP", |m| Some(plain_flops(m) / 1e6), number::short),
    quantity("dense_u8_mb", "dense, 1 B an element, MB", |m| Some(elements(m) / 1e6), number::short),
    quantity("dense_f32_mb", "dense, 4 B an element, MB", |m| Some(4.0 * elements(m) / 1e6), number::short),
    quantity("compact_mb", "compact CSR, MB", |m| Some(compact_bytes(m)? / 1e6), number::short),
];

/// Of a method on the matrix.
pub const OF_METHOD: [Quantity; 12] = [
    quantity("reduced_mflops", "reduced to, MFLOP", |m| Some(flops(m)? / 1e6), number::short),
    quantity("computation_percent", "computation, %", |m| percent(flops(m)?, plain_flops(m)), number::short),
    quantity("resident_mb", "reduced to, in memory, MB", |m| Some(resident(m)? / 1e6), number::short),
    quantity("file_mb", "reduced to, file, MB", |m| Some(m.row.file_bytes? as f64 / 1e6), number::short),
    quantity("data_u8_percent", "data, % of dense at 1 B", |m| percent(resident(m)?, elements(m)), number::short),
    quantity(
        "data_f32_percent",
        "data, % of dense at 4 B",
        |m| percent(resident(m)?, 4.0 * elements(m)),
        number::short,
    ),
    quantity("data_compact_percent", "data, % of compact", |m| percent(resident(m)?, compact_bytes(m)?), number::short),
    quantity("encode_s", "encode, s", |m| m.row.encode_s, number::short),
    quantity(
        "peak_encode_mb",
        "peak memory of encode, MB",
        |m| Some(m.row.peak_encode_bytes? as f64 / 1e6),
        number::short,
    ),
    quantity("relight_1_ms", "relight, 1 thread, ms", |m| m.row.relight_1_ms, number::short),
    quantity("relight_all_ms", "relight, all threads, ms", |m| m.row.relight_all_ms, number::short),
    quantity(
        "times_compact",
        "times as fast as compact",
        |m| Some(m.baseline?.relight_1_ms? / m.row.relight_1_ms?),
        number::short,
    ),
];

const fn quantity(
    name: &'static str,
    title: &'static str,
    of: fn(Measured) -> Option<f64>,
    text: fn(f64) -> String,
) -> Quantity {
    Quantity { name, title, of, text }
}

fn whole(value: f64) -> String {
    format!("{value:.0}")
}

/// The plain sparse product: one multiplication and one addition for each non-zero.
fn plain_flops(m: Measured) -> f64 {
    2.0 * m.row.non_zeros as f64
}

fn flops(m: Measured) -> Option<f64> {
    Some(m.row.flops()? as f64)
}

fn elements(m: Measured) -> f64 {
    let Row { samples, responses, lights, .. } = m.row;
    *samples as f64 * *responses as f64 * *lights as f64
}

fn resident(m: Measured) -> Option<f64> {
    Some(m.row.resident_bytes? as f64)
}

fn compact_bytes(m: Measured) -> Option<f64> {
    Some(m.baseline?.resident_bytes? as f64)
}

fn percent(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| 100.0 * part / whole)
}
