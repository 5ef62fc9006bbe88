//! Up to 64 directions anywhere in a window.

use super::bvh::WIDTH;
use super::directions::TILE;
use super::edges::Edges;
use super::sweep::{Free, Rectangle, View};
use super::visibility_kernel::Lanes;

/// One tile of directions anywhere in the window.
pub(crate) struct Scattered<'a> {
    free: u64,
    places: &'a [[f32; TILE]; 2],
}

impl<'a> Scattered<'a> {
    /// The directions above the horizon.
    #[inline(always)]
    pub(crate) fn new<L: Lanes>(view: &View<L>, places: &'a [[f32; TILE]; 2]) -> Self {
        let tile = view.window.first_tile;
        let above = |bit: &usize| view.directions.direction(tile, *bit).dot(view.normal) > 0.0;
        let free = (0..TILE).filter(above).fold(0, |mask, bit| mask | 1 << bit);
        Scattered { free: free & view.directions.filled(tile), places }
    }
}

impl<L: Lanes> Free<L> for Scattered<'_> {
    #[inline(always)]
    fn count(&self) -> u64 {
        u64::from(self.free.count_ones())
    }

    #[inline(always)]
    fn meets(&self, _: Rectangle) -> bool {
        self.free != 0
    }

    #[inline(always)]
    fn hide(&mut self, edges: &Edges, lane: usize, _: Rectangle, hits: impl Fn(usize, usize) -> bool) {
        let (columns, _) = self.places[0].as_chunks::<WIDTH>();
        let (rows, _) = self.places[1].as_chunks::<WIDTH>();
        for (k, (columns, rows)) in columns.iter().zip(rows).enumerate() {
            let (columns, rows) = (L::load(columns), L::load(rows));
            // The least F over the three edges, lessened and raised by its bound.
            let [mut sure, mut perhaps] = [L::splat(f32::INFINITY); 2];
            for i in 0..3 {
                let [constant, per_column, per_row, bound] =
                    [&edges.constant, &edges.per_column, &edges.per_row, &edges.bound].map(|x| L::splat(x[i][lane]));
                let value = columns.mul_add(per_column, rows.mul_add(per_row, constant));
                sure = sure.min(value - bound);
                perhaps = perhaps.min(value + bound);
            }
            let zero = L::splat(0.0);
            let mut hidden = u64::from(sure.gt(zero).signs());
            let mut doubtful = u64::from(zero.le(perhaps).signs()) & !hidden & (self.free >> (k * WIDTH));
            while doubtful != 0 {
                let bit = doubtful.trailing_zeros() as usize;
                doubtful &= doubtful - 1;
                hidden |= u64::from(hits(0, k * WIDTH + bit)) << bit;
            }
            self.free &= !(hidden << (k * WIDTH));
        }
    }

    #[inline(always)]
    fn store(&self, out: &mut [u64]) {
        out[0] = self.free;
    }
}
