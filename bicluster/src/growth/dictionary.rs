//! The distinct values of a column as small integers, and the residuals that stay exact.
//!
//! An element v is written as t_1 + t_2 + … + rest. Let 2^g be the largest power of two of which all values of the column
//! are multiples. All terms are then multiples of 2^g, and as long as each is below 2^(g+40) in magnitude, every partial sum in
//! the order of the biclusters, v - rest, is a multiple of 2^g below 2^(g+41): `f64`, of 53 bits, adds without rounding (in
//! any order too, up to 2^12 terms). In a column whose values do not fit one such grid no residual is taken: an element
//! either equals t_k or stays out of the bicluster.

/// Bits of a column's grid.
const GRID_BITS: i32 = 40;
/// Bits of an `f32`.
const BITS: i32 = 24;

/// Values of a column and their symbols: numbers of (column, value) pairs.
#[derive(Debug)]
pub(super) struct Dictionary {
    /// (bits of the value, symbol) by ascending bits.
    symbols: Vec<(u32, u32)>,
    /// 2^g.
    unit: f64,
    /// What residuals stay below in magnitude: 2^(g+40), or 0 where the input's values do not.
    limit: f64,
    /// Whether the difference of any two values, and of zero and any, is exact.
    roomy: bool,
}

impl Dictionary {
    /// Of `bits` of the column's values, finite and not zero, in any order; the value of each symbol goes to `values`.
    pub(super) fn new(mut bits: Vec<u32>, values: &mut Vec<f32>) -> Dictionary {
        bits.sort_unstable();
        bits.dedup();
        let symbols = bits.iter().copied().zip(values.len() as u32..).collect();
        let own: Vec<f32> = bits.into_iter().map(f32::from_bits).collect();
        values.extend(&own);

        let low = own.iter().copied().map(lowest_bit).min().unwrap_or(0);
        let limit = f64::from(low + GRID_BITS).exp2();
        let fits = own.iter().all(|value| f64::from(value.abs()) < limit);
        let unit = f64::from(low).exp2();
        let mut dictionary = Dictionary { symbols, unit, limit: if fits { limit } else { 0.0 }, roomy: false };
        dictionary.roomy = own.iter().all(|&value| dictionary.is_roomy(value));
        dictionary
    }

    /// The symbol of `value`; if it is new, `values` gets it.
    pub(super) fn symbol(&mut self, value: f32, values: &mut Vec<f32>) -> u32 {
        let bits = value.to_bits();
        match self.symbols.binary_search_by_key(&bits, |&(bits, _)| bits) {
            Ok(at) => self.symbols[at].1,
            Err(at) => {
                let symbol = values.len() as u32;
                values.push(value);
                self.symbols.insert(at, (bits, symbol));
                self.roomy &= self.is_roomy(value);
                symbol
            }
        }
    }

    /// Whether `value` less a value as large is exact: 24 bits above the grid hold it, and so does the range of `f32`.
    fn is_roomy(&self, value: f32) -> bool {
        let twice = 2.0 * f64::from(value.abs());
        twice < self.unit * f64::from(BITS).exp2() && twice <= f64::from(f32::MAX)
    }

    pub(super) fn roomy(&self) -> bool {
        self.roomy
    }

    /// v - t, where it may be left: v = t, or v - t is on the grid and an `f32`.
    pub(super) fn residual(&self, v: f32, t: f32) -> Option<f32> {
        // Exact: both are multiples of 2^g within 40 bits, or equal, or the limit is 0.
        let difference = f64::from(v) - f64::from(t);
        let exact = difference == 0.0 || (difference.abs() < self.limit && f64::from(difference as f32) == difference);
        exact.then_some(difference as f32)
    }

    pub(super) fn symbols(&self) -> impl Iterator<Item = u32> {
        self.symbols.iter().map(|&(_, symbol)| symbol)
    }
}

/// The exponent of the lowest bit that is set in `value`, finite and not zero.
fn lowest_bit(value: f32) -> i32 {
    let bits = value.to_bits();
    let (exponent, fraction) = ((bits >> 23 & 0xff) as i32, bits & 0x7f_ffff);
    match exponent {
        0 => fraction.trailing_zeros() as i32 - 149,
        _ => (fraction | 0x80_0000).trailing_zeros() as i32 + exponent - 150,
    }
}
