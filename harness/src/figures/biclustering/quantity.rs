//! Quantities that the tables print or ours add: by one name in the CSV and in what is printed of a scene.

use crate::row::Row;
use crate::tables::beside::{Cell, Column};

/// A finished measurement, and that of the compact sparse matrix on the same scene.
#[derive(Clone, Copy)]
pub(super) struct Measured<'a> {
    /// The method's.
    pub(super) row: &'a Row,
    /// That of what others are compared with, where it was measured.
    pub(super) baseline: Option<&'a Row>,
}

/// A column, and its figure of a measurement.
pub(super) struct Quantity {
    pub(super) column: Column,
    of: fn(Measured) -> Option<f64>,
}

/// Of the matrix, then of a method on it.
pub(super) const QUANTITIES: [Quantity; 17] = [
    quantity(Column::whole("vertices", "vertices"), |m| Some(m.row.samples as f64)),
    quantity(Column::new("nnz_millions", "nnz M"), |m| Some(m.row.non_zeros as f64 / 1e6)),
    quantity(Column::new("mflops", ""), |m| Some(plain_flops(m) / 1e6)),
    quantity(Column::new("reduced_mflops", "MFLOP"), |m| Some(flops(m)? / 1e6)),
    quantity(Column::new("computation_percent", "% FLOP"), |m| percent(flops(m)?, plain_flops(m))),
    quantity(Column::new("dense_u8_mb", ""), |m| Some(elements(m) / 1e6)),
    quantity(Column::new("resident_mb", "MB"), |m| Some(resident(m)? / 1e6)),
    quantity(Column::new("data_u8_percent", "% dense"), |m| percent(resident(m)?, elements(m))),
    quantity(Column::new("file_mb", "file MB"), |m| Some(m.row.file_bytes? as f64 / 1e6)),
    quantity(Column::new("compact_mb", ""), |m| Some(compact_bytes(m)? / 1e6)),
    quantity(Column::new("data_compact_percent", "% compact"), |m| percent(resident(m)?, compact_bytes(m)?)),
    quantity(Column::new("encode_s", "enc s"), |m| m.row.encode_s),
    quantity(Column::new("peak_encode_mb", ""), |m| Some(m.row.peak_encode_bytes? as f64 / 1e6)),
    quantity(Column::new("relight_1_ms", "relit ms"), |m| m.row.relight_1_ms),
    quantity(Column::new("relight_all_ms", ""), |m| m.row.relight_all_ms),
    quantity(Column::new("times_compact", "speedup"), |m| Some(m.baseline?.relight_1_ms? / m.row.relight_1_ms?)),
    quantity(Column::new("error", ""), |m| m.row.error),
];

const fn quantity(column: Column, of: fn(Measured) -> Option<f64>) -> Quantity {
    Quantity { column, of }
}

/// A line of figures.
pub(super) fn cells(measured: Measured) -> Vec<Cell> {
    QUANTITIES.iter().map(|quantity| (quantity.of)(measured).into()).collect()
}

/// A line of what is printed, by name.
pub(super) fn printed(figures: &[(&str, f64)]) -> Vec<Cell> {
    let of = |name: &str| figures.iter().find(|(known, _)| *known == name).map(|(_, figure)| Cell::Printed(*figure));
    QUANTITIES.iter().map(|quantity| of(quantity.column.name).unwrap_or_default()).collect()
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
