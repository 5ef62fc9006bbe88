//! Moments of visibility: what a point sees, in spherical harmonics.

use crate::error::{Error, Result};
use crate::scene::signal::{Samples, Visible};
use crate::sh::Harmonics;
use rayon::prelude::*;

/// `V_k = Σ w y_k` over the samples that are seen, `w` their solid angles: ∫ V(ω) y_k(ω) dω by the midpoint rule.
///
/// A tile of samples is a piece of a row of a cube face, in which what is seen makes a few runs: sums are kept for the
/// beginning of every tile to each of its lanes, so that a run costs a difference however long it is.
pub struct VisibilityMoments {
    coefficients: usize,
    /// Sums of the tile's lanes before this one, `TILE + 1` of them a tile.
    before: Vec<f64>,
}

/// Sums that are kept at most: 8 GB.
const MAX_SUMS: usize = 1 << 30;

/// Lanes of a tile.
const TILE: usize = crate::scene::directions::TILE;

impl VisibilityMoments {
    /// Of bands 0 to `order`-1.
    pub fn new(samples: &Samples, order: usize) -> Result<VisibilityMoments> {
        let harmonics = Harmonics::new(order)?;
        let n = harmonics.coefficients();
        let tiles = samples.lanes().len() / TILE;
        let (limit, found) = (MAX_SUMS as u64, tiles as u64 * (TILE as u64 + 1) * n as u64);
        if found > limit {
            let what = format!("moments of visibility, {} samples x {n} harmonics", samples.lanes().len());
            return Err(Error::TooLarge { what, limit, found });
        }
        let mut before = vec![0f64; tiles * (TILE + 1) * n];
        before.par_chunks_exact_mut((TILE + 1) * n).zip(samples.lanes().par_chunks_exact(TILE)).for_each(
            |(sums, lanes)| {
                let mut y = vec![0f64; n];
                for (lane, sample) in lanes.iter().enumerate() {
                    let (done, next) = sums[lane * n..].split_at_mut(n);
                    harmonics.evaluate(sample.direction.to_array().map(f64::from), &mut y);
                    // A lane without a sample has no solid angle, and no direction to be told apart from NaN.
                    let weighted = |y: f64| if sample.solid_angle > 0.0 { sample.solid_angle * y } else { 0.0 };
                    next.iter_mut().zip(done).zip(&y).for_each(|((next, done), &y)| *next = *done + weighted(y));
                }
            },
        );
        Ok(VisibilityMoments { coefficients: n, before })
    }

    /// Coefficients: order².
    pub fn coefficients(&self) -> usize {
        self.coefficients
    }

    /// `out[k]` = V_k of what is seen; `out.len()` = order².
    pub fn sum_into(&self, visible: &Visible, out: &mut [f64]) {
        out.fill(0.0);
        let n = self.coefficients;
        for (sums, &mask) in self.before.chunks_exact((TILE + 1) * n).zip(visible.masks()) {
            let (mut rest, mut lane) = (mask, 0);
            while rest != 0 {
                let first = lane + rest.trailing_zeros() as usize;
                let seen = (mask >> first).trailing_ones() as usize;
                lane = first + seen;
                // A shift by all 64 bits is none.
                rest = mask.checked_shr(lane as u32).unwrap_or(0);
                let (from, to) = (&sums[first * n..][..n], &sums[lane * n..][..n]);
                out.iter_mut().zip(to.iter().zip(from)).for_each(|(out, (to, from))| *out += to - from);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::signal::Sampling;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn sums_of_runs_are_sums_of_lanes(resolution in 1usize..20, supersampling in 0u32..3, seed in any::<u64>(), rough in any::<bool>()) {
            let samples = Sampling { resolution, supersampling }.samples().unwrap();
            let moments = VisibilityMoments::new(&samples, 4).unwrap();
            // Noise, and long runs; never a lane that is not there.
            let word = |tile: u64| {
                let noise = (seed ^ tile).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_mul(0xD6E8_FEB8_6659_FD93);
                if rough { noise } else { u64::MAX << (noise >> 58) }
            };
            let masks: Vec<u64> =
                (0..samples.directions().tiles()).map(|t| word(t as u64) & samples.directions().filled(t)).collect();
            let visible = Visible { masks: &masks };
            let (mut found, mut expected, mut y) = (vec![f64::NAN; 16], vec![0f64; 16], vec![0f64; 16]);
            moments.sum_into(&visible, &mut found);
            for lane in visible.lanes() {
                let sample = &samples.lanes()[lane];
                crate::sh::evaluate(4, sample.direction.to_array().map(f64::from), &mut y).unwrap();
                expected.iter_mut().zip(&y).for_each(|(e, y)| *e += sample.solid_angle * y);
            }
            for (found, expected) in found.iter().zip(&expected) {
                prop_assert!((found - expected).abs() < 1e-10, "{found} {expected}");
            }
        }
    }
}
