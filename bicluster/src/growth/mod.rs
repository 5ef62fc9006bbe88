//! Growth of biclusters in one block of rows: Algorithm 1 of "All-frequency bi-scale radiance transfer", section IV-C.
//!
//! A bicluster is a set of rows J (r of them), a set of columns K (l of them) and one value t_k for each column. Its sum
//! Σ t_k·x_k is taken once and added to each of its rows. What its rows really hold at its columns need not be t_k: an element
//! v leaves the residual v - t_k, which stays in the matrix for later biclusters. Starting from a seed, the row or column
//! whose insertion or deletion saves most ([`Cost`], Eq. 9) is inserted or deleted until none saves anything; then the
//! bicluster is subtracted from what is left (B, not T_b as line 16 prints, or the residual would be lost), and the next grows.
//!
//! **Exactness.** For every element of the input, the values of the biclusters that its row is in, at its column, and what is
//! left of it add up to it exactly. Residuals are taken only where that holds in `f64` arithmetic too (`dictionary`): the
//! values of a column lie on one binary grid of at most 40 bits and the residual is a number of `f32`. A row and a column
//! for which that fails are not allowed into one bicluster unless the element equals t_k.

mod block;
mod candidate;
mod cost;
mod dictionary;
mod search;
mod select;
#[cfg(test)]
mod tests;

pub(crate) use cost::Cost;

use crate::params::{Objective, Seeds};
use block::Block;
use search::Search;

/// One bicluster: every listed row contains, for every (column, value), value·x\[column\] in its sum.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bicluster {
    /// Its rows, ascending.
    pub(crate) rows: Vec<u32>,
    /// Its columns and their values, by ascending column.
    pub(crate) columns: Vec<(u32, f32)>,
}

/// A block as biclusters and a rest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grown {
    /// In the order in which they grew.
    pub(crate) biclusters: Vec<Bicluster>,
    /// For every row the elements that no bicluster accounts for, residuals included, by ascending column.
    pub(crate) leftover: Vec<Vec<(u32, f32)>>,
}

/// How biclusters are looked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Where one starts.
    pub(crate) seeds: Seeds,
    /// Start of the random sequence.
    pub(crate) seed: u64,
    /// What it has to save.
    pub(crate) objective: Objective,
}

/// Biclusters of a block: `rows` of (column, finite value) by ascending column, columns below `columns`. Zeros are dropped.
/// Rows should be distinct (an equal row would cost memberships that a reference to its twin does not).
///
/// For each row and column, the values of its biclusters and its leftover sum to the input's element: exactly, hence to the
/// same bits in `f64` rounded to `f32`, in the order of the biclusters or, up to 4,096 terms, in any order.
pub(crate) fn grow(rows: &[Vec<(u32, f32)>], columns: usize, options: &Options) -> Grown {
    grow_at(rows, columns, options, Cost::of_elements(options.objective))
}

/// [`grow`] where a row is a list of the sums that it adds, each as (sum, 1.0): the second level. A residual here is a sum
/// that is taken away again (-1.0).
pub(crate) fn grow_memberships(rows: &[Vec<(u32, f32)>], columns: usize, options: &Options) -> Grown {
    grow_at(rows, columns, options, Cost::of_memberships(options.objective))
}

fn grow_at(rows: &[Vec<(u32, f32)>], columns: usize, options: &Options, cost: Cost) -> Grown {
    let mut search = Search::new(Block::new(rows, columns), cost, options.seed);
    match options.seeds {
        Seeds::Random => search.random(),
        Seeds::Longest => search.longest(),
        Seeds::Best => search.best(),
    }
    search.finish()
}
