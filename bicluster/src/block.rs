//! One block of rows, compressed on its own.

use crate::pairs::{self, Pair};
use crate::params::Objective;
use crate::symbols::{Leaf, Symbols};
use std::collections::BTreeSet;

/// What became of a block.
pub(crate) struct Block {
    /// Which of the matrix's distinct rows it holds.
    pub(crate) kinds: Vec<u32>,
    code: Option<Code>,
    /// For each row the elements that no sum covers, columns ascending.
    pub(crate) left: Vec<Vec<Leaf>>,
}

/// Leaves, sums and rows in symbols: leaf i is symbol i, sum j symbol leaves + j.
pub(crate) struct Code {
    /// By [`crate::symbols::key`].
    pub(crate) leaves: Vec<Leaf>,
    /// Symbols that each sum adds up, all of them before the sum itself.
    pub(crate) sums: Vec<Vec<u16>>,
    /// Symbols that each row adds up.
    pub(crate) rows: Vec<Vec<u16>>,
}

impl Block {
    /// Finds shared sums of any depth.
    pub(crate) fn search(kinds: Vec<u32>, rows: Vec<Vec<Leaf>>, objective: Objective, bytes_per_element: f64) -> Block {
        let Symbols { leaves, rows: mut terms, left } = Symbols::of(&rows, 0);
        let pairs = pairs::merge(&mut terms, leaves.len(), objective.least_rows());
        Block::new(kinds, rows, code(leaves, pairs, terms), left, bytes_per_element)
    }

    /// Applies the pairs of an earlier search.
    pub(crate) fn replay(kinds: Vec<u32>, rows: Vec<Vec<Leaf>>, pairs: Vec<Pair>) -> Option<Block> {
        let Symbols { leaves, rows: mut terms, left } = Symbols::of(&rows, 0);
        let known = |(i, pair): (usize, &Pair)| usize::from(pair[1]) < leaves.len() + i && pair[0] < pair[1];
        if leaves.len() + pairs.len() > crate::symbols::SYMBOLS || !pairs.iter().enumerate().all(known) {
            return None;
        }
        pairs::replay(&mut terms, leaves.len(), &pairs);
        Some(Block { kinds, code: Some(code(leaves, pairs, terms)), left })
    }

    /// Keeps `code` where it takes fewer bytes and less time than the elements themselves.
    pub(crate) fn new(
        kinds: Vec<u32>,
        rows: Vec<Vec<Leaf>>,
        code: Code,
        left: Vec<Vec<Leaf>>,
        bytes_per_element: f64,
    ) -> Block {
        let count = |rows: &[Vec<Leaf>]| rows.iter().map(Vec::len).sum::<usize>();
        let elements = count(&rows) as f64;
        let pays = code.bytes() as f64 + count(&left) as f64 * bytes_per_element < elements * bytes_per_element
            && elements > (code.steps() + count(&left)) as f64;
        if pays { Block { kinds, code: Some(code), left } } else { Block::plain(kinds, rows) }
    }

    /// A block without sums.
    pub(crate) fn plain(kinds: Vec<u32>, rows: Vec<Vec<Leaf>>) -> Block {
        Block { kinds, code: None, left: rows }
    }

    pub(crate) fn code(&self) -> Option<&Code> {
        self.code.as_ref()
    }
}

fn code(leaves: Vec<Leaf>, pairs: Vec<Pair>, rows: Vec<Vec<u16>>) -> Code {
    Code { leaves, sums: pairs.into_iter().map(Vec::from).collect(), rows }
}

impl Code {
    /// Time to relight, where an element of a sparse row takes one step: one for an index that is followed, one more for a
    /// leaf and for a sum, which are stored, two more for a row, whose product is stored and fetched again.
    fn steps(&self) -> usize {
        self.indices() + self.leaves.len() + self.sums.len() + 2 * self.rows.len()
    }
    /// Indices that relighting follows.
    fn indices(&self) -> usize {
        self.leaves.len() + self.sums.iter().chain(&self.rows).map(Vec::len).sum::<usize>()
    }
    /// Memory: two bytes for an index, eight for each run of leaves and for each group of rows with as many terms, twelve for
    /// the block, two for the terms of a sum that has not two.
    fn bytes(&self) -> usize {
        let runs = self.leaves.chunk_by(|a, b| a.1 == b.1).count();
        let groups: BTreeSet<usize> = self.rows.iter().map(Vec::len).collect();
        let arities = if self.sums.iter().all(|s| s.len() == 2) { 0 } else { 2 * self.sums.len() };
        2 * self.indices() + 8 * (runs + groups.len()) + 12 + arities
    }
}
