//! The numbers of one sample: points of Owen-scrambled Sobol sequences (Burley, "Practical Hash-based Owen Scrambling", 2020).
//!
//! Four numbers make a set. Set 0 is the caller's (where in a pixel); the k-th reflection of a path has set 2k - 1 for its direction and
//! 2k for the light that it looks for. Every set is the sequence's first four dimensions, shuffled and scrambled by itself: Burley's
//! padding. Higher dimensions of one sequence are worse in few samples and hardly better in many, and there is no end to the sets. The
//! first two numbers of a set are the best: they choose a direction.

use crate::random::Random;
use sobol_burley::sample_4d;

/// Bits of an index in one sequence; what is above selects another.
const INDEX_BITS: u32 = 16;

/// One sample of a sequence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sequence {
    index: u32,
    seed: u32,
}

impl Sequence {
    /// Sample `index` of the sequence that `key` names, among those of a seed.
    pub(super) fn new(seed: u64, key: u64, index: u32) -> Sequence {
        let block = u64::from(index >> INDEX_BITS);
        let seed = [seed, key, block].into_iter().fold(0, |hash, part| Random(hash ^ part).bits());
        Sequence { index: index & ((1 << INDEX_BITS) - 1), seed: (seed >> 32) as u32 }
    }

    /// The four numbers of a set, in [0, 1).
    pub(super) fn set(&self, set: usize) -> [f64; 4] {
        let seed = self.seed ^ (set as u32).wrapping_mul(0x9e37_79b9);
        sample_4d(self.index, 0, seed).map(f64::from)
    }

    /// For the direction of the `bounce`-th reflection, counted from 1: where in a part of the BRDF (2), which part, and whether the path
    /// goes on.
    pub(super) fn scattering(&self, bounce: usize) -> [f64; 4] {
        self.set(2 * bounce - 1)
    }

    /// For the light that the `bounce`-th reflection looks for: where on it (2), which, and one to spare.
    pub(super) fn light(&self, bounce: usize) -> [f64; 4] {
        self.set(2 * bounce)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_of_every_block_is_stratified_and_no_two_are_alike() {
        let mut firsts = Vec::new();
        for first in [0u32, 1 << INDEX_BITS, u32::MAX - 255] {
            for set in [0, 1, 63, 64, 65, 1000, 1 << 30] {
                let points: Vec<_> = (0..256).map(|k| Sequence::new(3, 9, first + k).set(set)).collect();
                // 256 points of an elementary net: one in every 256th along each dimension.
                for k in 0..4 {
                    let mut cells: Vec<_> = points.iter().map(|p| (p[k] * 256.0) as usize).collect();
                    cells.sort_unstable();
                    assert_eq!(cells, (0..256).collect::<Vec<_>>(), "{first} {set} {k}");
                }
                firsts.push(points[0]);
            }
        }
        firsts.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(firsts.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn keys_and_seeds_name_sequences_of_their_own() {
        let at = |seed, key, index| Sequence::new(seed, key, index).set(5);
        assert_eq!(at(1, 2, 3), at(1, 2, 3));
        for other in [at(2, 2, 3), at(1, 3, 3), at(1, 2, 4), at(2, 1, 3)] {
            assert_ne!(other, at(1, 2, 3));
        }
    }
}
