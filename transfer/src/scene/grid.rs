//! Up to 64 x 64 directions in rows and columns.
//!
//! A row meets a triangle in one span of columns, between two of its edges: eight rows of 64 directions are answered by
//! three multiplications and additions.

use super::bvh::WIDTH;
use super::directions::TILE;
use super::edges::{Edges, ROUNDING, UNDERFLOW};
use super::sweep::{Free, Rectangle, View};
use super::visibility_kernel::Lanes;

/// Rows of 64 directions at whole columns; room for reading eight rows from any row.
pub(crate) struct Grid {
    rows: [u64; TILE + WIDTH],
}

/// The half plane where `F > 0` cut by rows: columns from, or up to, `at + row·slope`, give or take `doubt`.
#[derive(Clone, Copy)]
struct Cut {
    rising: bool,
    at: f32,
    slope: f32,
    doubt: f32,
}

impl Cut {
    #[inline(always)]
    fn new(constant: f32, per_column: f32, per_row: f32, bound: f32) -> Cut {
        // A line (nearly) along the rows is turned by less than the bound, so that it crosses each row somewhere.
        let least = bound * (1.0 / TILE as f32);
        let per_column = if per_column.abs() < least { least.copysign(per_column) } else { per_column };
        let inverse = 1.0 / per_column;
        Cut {
            rising: per_column > 0.0,
            at: -constant * inverse,
            slope: -per_row * inverse,
            doubt: 2.0 * bound * inverse.abs(),
        }
    }
}

/// First and last column inside all cuts, for eight rows; certainly inside, and perhaps inside.
#[inline(always)]
fn spans<L: Lanes, const N: usize>(cuts: &[Cut; N], row: usize) -> [[L; 2]; 2] {
    let rows = L::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) + L::splat(row as f32);
    let (low, high) = (L::splat(0.0), L::splat((TILE - 1) as f32));
    let [mut sure, mut perhaps] = [[low, high]; 2];
    for cut in cuts {
        let column = rows.mul_add(L::splat(cut.slope), L::splat(cut.at));
        let doubt = L::splat(cut.doubt);
        if cut.rising {
            sure[0] = (column + doubt).max(sure[0]);
            perhaps[0] = (column - doubt).max(perhaps[0]);
        } else {
            sure[1] = (column - doubt).min(sure[1]);
            perhaps[1] = (column + doubt).min(perhaps[1]);
        }
    }
    [sure, perhaps].map(|[first, last]| [first.ceil(), last.floor()])
}

/// Eight rows of directions inside all cuts.
#[inline(always)]
fn inside<L: Lanes, const N: usize>(
    cuts: &[Cut; N],
    row: usize,
    wanted: &[u64],
    exact: impl Fn(usize, usize) -> bool,
) -> [u64; WIDTH] {
    let [sure, perhaps] = spans::<L, N>(cuts, row);
    let mut masks = L::spans(sure[0], sure[1]);
    let differ = sure[0].ne(perhaps[0]).or(sure[1].ne(perhaps[1]));
    if differ.and(perhaps[0].le(perhaps[1])).signs() != 0 {
        let perhaps = L::spans(perhaps[0], perhaps[1]);
        for (k, mask) in masks.iter_mut().enumerate() {
            let mut doubtful = perhaps[k] & !*mask & wanted[row + k];
            while doubtful != 0 {
                let bit = doubtful.trailing_zeros() as usize;
                doubtful &= doubtful - 1;
                *mask |= u64::from(exact(row + k, bit)) << bit;
            }
        }
    }
    masks
}

impl Grid {
    /// The directions above the horizon.
    #[inline(always)]
    pub(crate) fn new<L: Lanes>(view: &View<L>) -> Grid {
        let window = view.window;
        let mut rows = [0; TILE + WIDTH];
        let tiles = window.first_tile..window.first_tile + window.size[1];
        rows.iter_mut().zip(tiles).for_each(|(row, tile)| *row = view.directions.filled(tile));
        let n: [f32; 3] = [0, 1, 2].map(|k| view.sign[k] * view.normal[view.axis[k]]);
        let constant = n[2] + n[0] * window.corner[0] + n[1] * window.corner[1];
        let bound = ROUNDING * view.normal.abs().max_element() + UNDERFLOW;
        let horizon = [Cut::new(constant, n[0] / window.scale, n[1] / window.scale, bound)];
        for row in (0..window.size[1]).step_by(WIDTH) {
            let above = inside::<L, 1>(&horizon, row, &rows, |row, bit| {
                view.directions.direction(window.first_tile + row, bit).dot(view.normal) > 0.0
            });
            rows[row..row + WIDTH].iter_mut().zip(above).for_each(|(row, above)| *row &= above);
        }
        Grid { rows }
    }
}

impl<L: Lanes> Free<L> for Grid {
    #[inline(always)]
    fn count(&self) -> u64 {
        self.rows.iter().map(|row| u64::from(row.count_ones())).sum()
    }

    #[inline(always)]
    fn meets(&self, rectangle: Rectangle) -> bool {
        let (columns, rows) = (rectangle.columns(), rectangle.rows());
        for row in rows.step_by(4) {
            let [a, b, c, d] = [self.rows[row], self.rows[row + 1], self.rows[row + 2], self.rows[row + 3]];
            if (a | b | c | d) & columns != 0 {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn hide(&mut self, edges: &Edges, lane: usize, rectangle: Rectangle, hits: impl Fn(usize, usize) -> bool) {
        let cut = |i: usize| {
            Cut::new(edges.constant[i][lane], edges.per_column[i][lane], edges.per_row[i][lane], edges.bound[i][lane])
        };
        let cuts = [cut(0), cut(1), cut(2)];
        for row in rectangle.rows().step_by(WIDTH) {
            let hidden = inside::<L, 3>(&cuts, row, &self.rows, &hits);
            self.rows[row..row + WIDTH].iter_mut().zip(hidden).for_each(|(row, hidden)| *row &= !hidden);
        }
    }

    #[inline(always)]
    fn store(&self, out: &mut [u64]) {
        out.copy_from_slice(&self.rows[..out.len()]);
    }
}
