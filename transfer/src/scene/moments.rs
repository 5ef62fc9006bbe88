//! Moments of visibility: what a point sees, in spherical harmonics.

use crate::error::Result;
use crate::scene::signal::{Samples, Visible};
use crate::sh::Harmonics;
use rayon::prelude::*;

/// `V_k = Σ w y_k` over the samples that are seen, `w` their solid angles: ∫ V(ω) y_k(ω) dω by the midpoint rule.
///
/// A tile of samples is a piece of a row of a cube face, in which what is seen makes a few runs: sums are kept for the beginning of
/// every tile to each of its lanes, so that a run costs a difference however long it is.
pub struct VisibilityMoments {
    coefficients: usize,
    /// Sums of the tile's lanes before this one, `TILE + 1` of them a tile.
    before: Vec<f64>,
}

/// Lanes of a tile.
const TILE: usize = crate::scene::directions::TILE;

impl VisibilityMoments {
    /// Of bands 0 to `order`-1.
    pub fn new(samples: &Samples, order: usize) -> Result<VisibilityMoments> {
        let harmonics = Harmonics::new(order)?;
        let n = harmonics.coefficients();
        let tiles = samples.lanes().len() / TILE;
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
