//! The figures of a row: how columns, axes and explanations name them.

use crate::number::{bytes, count, short};
use serde::Serialize;
use serde_json::{Map, Value};

/// A row as JSON, by which a figure is found by its name.
pub(super) type Fields = Map<String, Value>;

/// A figure that rows have; one that no row has is not shown.
#[derive(Debug, Serialize)]
pub(super) struct Quantity {
    /// The row's field.
    pub(super) key: &'static str,
    /// Head of its column.
    pub(super) head: &'static str,
    /// Quantity and unit, as an axis names it.
    pub(super) axis: &'static str,
    /// How it was measured.
    pub(super) how: &'static str,
    pub(super) role: Role,
    format: Format,
    /// The field with the distance between the quartiles of what this is the median of.
    spread: Option<&'static str>,
    /// Whether its column is there unasked.
    pub(super) usual: bool,
}

/// What a figure tells. Errors and costs can be an axis, and less of them is better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Role {
    Error,
    Cost,
    Quality,
}

/// How a figure is written.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
enum Format {
    Number,
    Bytes,
    Count,
}

const fn error(key: &'static str, head: &'static str, axis: &'static str, how: &'static str) -> Quantity {
    Quantity { key, head, axis, how, role: Role::Error, format: Format::Number, spread: None, usual: true }
}

const fn cost(key: &'static str, head: &'static str, axis: &'static str, how: &'static str) -> Quantity {
    Quantity { role: Role::Cost, ..error(key, head, axis, how) }
}

const fn time(
    key: &'static str,
    spread: &'static str,
    head: &'static str,
    axis: &'static str,
    how: &'static str,
) -> Quantity {
    Quantity { spread: Some(spread), ..cost(key, head, axis, how) }
}

impl Quantity {
    const fn of(self, format: Format) -> Quantity {
        Quantity { format, ..self }
    }

    const fn on_demand(self) -> Quantity {
        Quantity { usual: false, ..self }
    }

    /// The figure of a row, if it has one.
    pub(super) fn figure(&self, row: &Fields) -> Option<f64> {
        row.get(self.key)?.as_f64()
    }

    /// The same as a person reads it.
    pub(super) fn text(&self, row: &Fields) -> Option<String> {
        let figure = self.figure(row)?;
        Some(match self.format {
            Format::Number => short(figure),
            Format::Bytes => bytes(figure as u64),
            Format::Count => count(figure as u64),
        })
    }

    /// The spread as a part of the median.
    pub(super) fn spread(&self, row: &Fields) -> Option<f64> {
        let (spread, median) = (row.get(self.spread?)?.as_f64()?, self.figure(row)?);
        (median > 0.0).then(|| spread / median)
    }
}

/// Those of which some row has a figure.
pub(super) fn measured(rows: &[Fields]) -> Vec<&'static Quantity> {
    QUANTITIES.iter().filter(|quantity| rows.iter().any(|row| quantity.figure(row).is_some())).collect()
}

const RELIGHT: &str = "Median of at least seven runs after a warm-up, of the object that was read back from its file.";

/// Every figure in the order of its column.
static QUANTITIES: [Quantity; 22] = [
    cost(
        "resident_bytes",
        "memory",
        "memory that relighting holds, bytes",
        "What the codec stores, section by section, as relighting holds it; what a transform derives from its basis included.",
    )
    .of(Format::Bytes),
    cost(
        "file_bytes",
        "file",
        "size of the file, bytes",
        "The .prt file; its last stage is zstd, equally strong for every method.",
    )
    .of(Format::Bytes),
    cost(
        "bytes_per_non_zero",
        "B/nnz",
        "memory for each non-zero element, bytes",
        "Memory that relighting holds, divided by the elements of the matrix that are not 0.",
    ),
    cost(
        "flops",
        "FLOPs",
        "multiplications and additions of relighting one channel",
        "Counted by the kernels as they run; a product accumulated onto a sum is one of each.",
    )
    .of(Format::Count),
    cost(
        "flops_value_aware",
        "FLOPs ≠ ±1",
        "operations of relighting one channel, products with ±1 being free",
        "Counted by the kernels as they run; multiplications by 1 and -1 are not counted.",
    )
    .of(Format::Count)
    .on_demand(),
    error(
        "error",
        "error",
        "relative squared error of the transfer matrix",
        "Σ(T−T̃)²/ΣT² in f64, over every element decoded from the file.",
    ),
    error(
        "error_sphere",
        "sphere",
        "relative squared error over the sphere",
        "The same with squares divided by the solid angle of their column (times it for biscale, whose light brings it along): \
         the expected error of relit output under light that is white noise over the sphere.",
    ),
    error(
        "error_max",
        "max",
        "largest error of an element, in units of the matrix",
        "max |T−T̃| over every element decoded from the file.",
    )
    .on_demand(),
    error(
        "error_relit_sky",
        "sky",
        "relative squared error of output relit by the sky",
        "Σ(y−ỹ)²/Σy² under a sky with a sun, all channels; an exact method is left with the rounding of its sums.",
    ),
    error(
        "error_relit_room",
        "room",
        "relative squared error of output relit by the room",
        "Σ(y−ỹ)²/Σy² under a room with small lamps, all channels; an exact method is left with the rounding of its sums.",
    ),
    error(
        "picture_error",
        "picture",
        "relative squared error of the picture",
        "Σ(L−L̃)²/ΣL² of linear radiance over the pixels, against the reference picture.",
    )
    .on_demand(),
    Quantity {
        role: Role::Quality,
        ..error(
            "picture_psnr_db",
            "PSNR",
            "peak signal-to-noise ratio of the picture, dB",
            "Of the picture as it is seen, exposed and tone-mapped; more is better.",
        )
    },
    error(
        "picture_flip",
        "FLIP",
        "mean FLIP of the picture",
        "What a viewer notices who flips between both pictures, 0 to 1, mean over the pixels (Andersson et al. 2020).",
    ),
    error(
        "flicker",
        "flicker",
        "relative squared error of change while the light turns",
        "The change of relit output from one step of a turning light to the next, Σ(Δy−Δỹ)²/ΣΔy².",
    ),
    time(
        "encode_s",
        "encode_spread_s",
        "enc s",
        "encoding on all threads, s",
        "Median of up to seven runs on all threads.",
    ),
    cost(
        "peak_encode_bytes",
        "enc mem",
        "peak memory of encoding, bytes",
        "The most that the allocator had given out at once, the result included, but not the matrix nor what a library keeps for each thread.",
    )
    .of(Format::Bytes)
    .on_demand(),
    time(
        "relight_1_ms",
        "relight_1_spread_ms",
        "1 thr",
        "relighting one channel on one thread, ms",
        RELIGHT,
    ),
    time(
        "relight_all_ms",
        "relight_all_spread_ms",
        "all",
        "relighting one channel on all threads, ms",
        RELIGHT,
    ),
    time(
        "relight_rgb_1_ms",
        "relight_rgb_1_spread_ms",
        "RGB 1 thr",
        "relighting three channels on one thread, ms",
        RELIGHT,
    )
    .on_demand(),
    time(
        "relight_rgb_all_ms",
        "relight_rgb_all_spread_ms",
        "RGB all",
        "relighting three channels on all threads, ms",
        RELIGHT,
    )
    .on_demand(),
    cost("multiplications", "mul", "multiplications of relighting one channel", "Counted by the kernels as they run.")
        .of(Format::Count)
        .on_demand(),
    cost("additions", "add", "additions of relighting one channel", "Counted by the kernels as they run.")
        .of(Format::Count)
        .on_demand(),
];
