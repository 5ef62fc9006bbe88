//! `truncate`: keeps the largest coefficients.

use crate::encoded::EncodedTruncate;
use crate::keep::{Kept, Rule};
use crate::stored::Rounding;
use crate::threshold::Threshold;
use prt_transfer::footprint::{Extent, Footprint, by};
use prt_transfer::{Codec, Configure, Params, Progress, Result, TransferMatrix};

prt_transfer::choices! {
    /// How the kept coefficients lie in memory.
    pub enum Order {
        /// Row by row: each response sums its own terms.
        Rows = "rows",
        /// Column by column within blocks of rows: a light coefficient that is 0 costs nothing (Ng et al. 2003, sparse
        /// light times sparse matrix).
        Columns = "columns",
    }
}

prt_transfer::params! {
    /// The largest coefficients of each row, or of the whole matrix; all others become 0.
    pub struct TruncateParams: "truncate" {
        /// Coefficients kept of each row at most; 0 = no limit; none = 64, or no limit where energy or max_error is given.
        terms: Option<usize> = None,
        /// Share of each row's sum of squares to keep, above 0 to 1, with the fewest coefficients (but no more than terms).
        energy: Option<f64> = None,
        /// Bound on Σ(C-C̃)²/ΣC² over the whole matrix, 0 to 1, met with the fewest coefficients; excludes terms and energy.
        max_error: Option<f64> = None,
        /// Bits of a stored value: 32 (exact), or 16 or 8, which are whole multiples of a step that each row has of its own.
        bits: u32 = 32,
        /// How they lie in memory: rows, or columns, which skips light coefficients of 0.
        order: Order = Order::Rows,
    }
}

/// Coefficients per row where nothing else is asked for.
const DEFAULT_TERMS: usize = 64;

/// The codec. In orthonormal coordinates (`haar`) keeping the largest is the best approximation of so many terms, and the
/// energy of what is dropped is the squared error (Parseval).
///
/// `max_error` bounds the error of the decoded matrix in the coordinates that the codec is given, the rounding of `bits` included.
/// With `bits=32` no smaller number of coefficients meets it, up to one part in a million of the bound, which is left unused
/// so that the bound also holds after an orthonormal transform has rounded to `f32`. `energy` is about what is
/// dropped; the rounding of `bits` comes on top.
pub struct Truncate(TruncateParams);

impl Configure for Truncate {
    type Params = TruncateParams;

    fn new(params: TruncateParams) -> Result<Truncate> {
        if let Some(energy) = params.energy.filter(|e| !(*e > 0.0 && *e <= 1.0)) {
            return Err(TruncateParams::refuse("energy", energy, "above 0 and at most 1"));
        }
        if let Some(bound) = params.max_error.filter(|e| !(0.0..=1.0).contains(e)) {
            return Err(TruncateParams::refuse("max_error", bound, "from 0 to 1"));
        }
        if let (Some(bound), true) = (params.max_error, params.terms.is_some() || params.energy.is_some()) {
            return Err(TruncateParams::refuse("max_error", bound, "none where terms or energy is given"));
        }
        if ![8, 16, 32].contains(&params.bits) {
            return Err(TruncateParams::refuse("bits", params.bits, "8, 16 or 32"));
        }
        Ok(Truncate(params))
    }

    fn params(&self) -> &TruncateParams {
        &self.0
    }
}

impl Truncate {
    fn rule(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Rule> {
        let TruncateParams { terms, energy, max_error, bits, .. } = self.0;
        if let Some(bound) = max_error {
            let threshold = Threshold::choose(matrix, Rounding::of_bits(bits), bound, progress)?;
            return threshold.map(Rule::Threshold).map_err(|least| {
                let expected = format!("at least {least:e}, what bits={bits} costs on this matrix");
                TruncateParams::refuse("max_error", bound, expected)
            });
        }
        let default = if energy.is_some() { 0 } else { DEFAULT_TERMS };
        let terms = Some(terms.unwrap_or(default)).filter(|&t| t > 0);
        Ok(Rule::PerRow { terms: terms.unwrap_or(usize::MAX), energy })
    }
}

/// What a threshold is sought in, bytes.
const HISTOGRAM: u64 = 17_000_000;

impl Codec for Truncate {
    type Encoded = EncodedTruncate;

    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedTruncate> {
        let rule = self.rule(matrix, progress)?;
        let kept = Kept::gather(matrix, &rule, Rounding::of_bits(self.0.bits), progress)?;
        EncodedTruncate::new(matrix.shape(), kept, self.0.bits, self.0.order)
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // Kept elements in blocks, put together, and stored.
        let TruncateParams { terms, energy, max_error, .. } = self.0;
        let default = if energy.or(max_error).is_some() { 0 } else { DEFAULT_TERMS };
        let terms = Some(terms.unwrap_or(default)).filter(|&t| t > 0);
        let of_rows = |terms: usize| extent.rows().saturating_mul(terms as u64);
        let kept = terms.map_or(extent.non_zeros, |terms| extent.non_zeros.min(of_rows(terms)));
        let sought = if max_error.is_some() { HISTOGRAM } else { 0 };
        let peak = by(22.0, kept).max(sought) + by(40.0, extent.rows());
        Some(Footprint { peak, result: by(8.0, kept) + by(8.0, extent.rows()) })
    }
}
