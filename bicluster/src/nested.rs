//! Biclusters as shared sums: level 1 is the paper's, level 2 biclusters the memberships of rows in biclusters.

use crate::block::{Block, Code};
use crate::growth::{Bicluster, Grown, Options, grow, grow_memberships};
use crate::symbols::{Leaf, SYMBOLS, Symbols};

/// How much more than its elements a row's terms may hold, in sums of magnitudes.
const CANCELLATION: f64 = 16.0;

impl Block {
    /// Grows biclusters of elements, and where `twice` says so of their memberships.
    pub(crate) fn grow(
        kinds: Vec<u32>,
        rows: Vec<Vec<Leaf>>,
        options: &Options,
        twice: bool,
        bytes_per_element: f64,
    ) -> Block {
        let columns = rows.iter().flatten().map(|leaf| leaf.0 as usize + 1).max().unwrap_or(0);
        let grown = grow(&rows, columns, options);
        let (biclusters, leftover) = without_cancellation(&rows, grown);
        // A sum of one leaf is that leaf.
        let (sums, single): (Vec<_>, Vec<_>) = biclusters.into_iter().partition(|b| b.columns.len() > 1);
        let count = sums.len();
        let mut lists: Vec<Vec<Leaf>> = sums.iter().map(|b| b.columns.clone()).collect();
        lists.extend(leftover);
        for bicluster in single {
            bicluster.rows.iter().for_each(|&row| lists[count + row as usize].extend(&bicluster.columns));
        }
        let mut symbols = Symbols::of(&lists, count);
        let mut terms = symbols.rows.split_off(count);
        let left = symbols.left.split_off(count);
        let leaves = symbols.leaves.len();
        // An element that is left twice, as a sum of one leaf and as its residual, has no place in a sparse row.
        let twice_left = left.iter().any(|row| row.windows(2).any(|w| w[0].0 == w[1].0));
        if leaves + count > SYMBOLS || twice_left {
            return Block::plain(kinds, rows);
        }
        for (symbol, bicluster) in (leaves..).zip(&sums) {
            bicluster.rows.iter().for_each(|&row| terms[row as usize].push(symbol as u16));
        }
        let mut code = Code { leaves: symbols.leaves, sums: symbols.rows, rows: terms };
        if twice {
            code.rows.iter_mut().for_each(|row| row.sort_unstable());
            if code.rows.iter().all(|row| row.is_sorted_by(|a, b| a < b)) {
                code.grow(options);
            }
        }
        Block::new(kinds, rows, code, left, bytes_per_element)
    }
}

/// Takes rows out of their biclusters that would have to subtract again much more than they hold: relighting would lose the
/// digits of what remains.
fn without_cancellation(rows: &[Vec<Leaf>], grown: Grown) -> (Vec<Bicluster>, Vec<Vec<Leaf>>) {
    let magnitude = |leaves: &[Leaf]| leaves.iter().map(|l| f64::from(l.1.abs())).sum::<f64>();
    let Grown { mut biclusters, mut leftover } = grown;
    let mut passing: Vec<f64> = leftover.iter().map(|row| magnitude(row)).collect();
    for bicluster in &biclusters {
        let own = magnitude(&bicluster.columns);
        bicluster.rows.iter().for_each(|&row| passing[row as usize] += own);
    }
    let keeps: Vec<bool> = rows.iter().zip(&passing).map(|(row, &sum)| sum <= CANCELLATION * magnitude(row)).collect();
    for bicluster in &mut biclusters {
        bicluster.rows.retain(|&row| keeps[row as usize]);
    }
    biclusters.retain(|b| !b.rows.is_empty());
    for (row, _) in keeps.iter().enumerate().filter(|(_, keeps)| !**keeps) {
        leftover[row].clone_from(&rows[row]);
    }
    (biclusters, leftover)
}

impl Code {
    /// Biclusters the rows' terms: sums of sums.
    fn grow(&mut self, options: &Options) {
        let first = self.leaves.len() + self.sums.len();
        let memberships: Vec<Vec<Leaf>> =
            self.rows.iter().map(|row| row.iter().map(|&s| (s.into(), 1.0)).collect()).collect();
        let grown = grow_memberships(&memberships, first, options);
        // Terms can only be added. A row that would have to take one away again keeps what it had.
        let ones = |leaves: &[Leaf]| leaves.iter().all(|leaf| leaf.1 == 1.0);
        let mut covered: Vec<bool> = grown.leftover.iter().map(|row| ones(row)).collect();
        for bicluster in grown.biclusters.iter().filter(|b| !ones(&b.columns)) {
            bicluster.rows.iter().for_each(|&row| covered[row as usize] = false);
        }
        let mut terms: Vec<Vec<u16>> =
            grown.leftover.iter().map(|row| row.iter().map(|l| l.0 as u16).collect()).collect();
        for bicluster in grown.biclusters {
            let rows: Vec<usize> = bicluster.rows.iter().map(|&r| r as usize).filter(|&row| covered[row]).collect();
            let symbols: Vec<u16> = bicluster.columns.iter().map(|c| c.0 as u16).collect();
            let sum = self.leaves.len() + self.sums.len();
            if symbols.len() > 1 && rows.len() > 1 && sum < SYMBOLS {
                self.sums.push(symbols);
                rows.iter().for_each(|&row| terms[row].push(sum as u16));
            } else {
                rows.iter().for_each(|&row| terms[row].extend(&symbols));
            }
        }
        for (row, terms) in terms.into_iter().enumerate().filter(|(row, _)| covered[*row]) {
            self.rows[row] = terms;
        }
    }
}
