//! Seeds: where biclusters start, and which of them are kept.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::block::{Block, Entry};
use super::candidate::Candidate;
use super::cost::Cost;
use super::{Bicluster, Grown};
use prt_transfer::random::Random;

/// Rows from which the partner of a seed is taken.
const PARTNERS: usize = 4;
/// Starts tried in a row by [`Search::best`].
const TRIES: usize = 4;
/// What the first biclusters of [`Search::best`] save for what they take, at least.
const BAR: f64 = 8.0;
/// How often each row is refused, on average, while the bar falls by a factor e.
const PATIENCE: f64 = 1.0 / 3.0;

pub(super) struct Search {
    block: Block,
    cost: Cost,
    random: Random,
    /// The one that grows, and the best of its rivals.
    candidate: Candidate,
    best: Candidate,
    biclusters: Vec<Bicluster>,
}

impl Search {
    pub(super) fn new(block: Block, cost: Cost, seed: u64) -> Search {
        let (candidate, best) = (Candidate::new(&block, cost), Candidate::new(&block, cost));
        Search { block, cost, random: Random(seed), candidate, best, biclusters: Vec::new() }
    }

    /// A random element of a random row, much as in the paper, until as many in sequence as there are rows left have come to
    /// nothing. Where one column cannot pay for a row (memberships), no element grows: there a random row that shares it comes in too.
    pub(super) fn random(&mut self) {
        let partners = usize::from(self.cost.row >= self.cost.element);
        let mut rows = self.all_rows();
        let mut failures = 0;
        while failures < rows.len() {
            let Some(row) = self.pick_row(&mut rows) else { continue };
            if self.start(row, partners) > 0 {
                self.keep();
                failures = 0;
            } else {
                failures += 1;
            }
        }
    }

    /// The row with the most elements left, until each has failed to start a bicluster once.
    pub(super) fn longest(&mut self) {
        let mut rows: BinaryHeap<_> = (0u32..).zip(&self.block.rows).map(|(i, row)| (row.len(), Reverse(i))).collect();
        while let Some((length, Reverse(row))) = rows.pop() {
            let now = self.block.rows[row as usize].len();
            if now > 0 && now != length {
                rows.push((now, Reverse(row)));
            } else if now > 0 && self.start(row, PARTNERS) > 0 {
                self.keep();
                rows.push((self.block.rows[row as usize].len(), Reverse(row)));
            }
        }
    }

    /// Random rows, of each the best of several starts, judged by what a bicluster saves for what it takes. One is kept if
    /// that is over a bar; the bar falls with each that is refused, to 1, where all that gain are kept.
    pub(super) fn best(&mut self) {
        let mut rows = self.all_rows();
        let mut bar = BAR;
        let fall = 1.0 - 1.0 / (PATIENCE * rows.len() as f64);
        let mut failures = 0;
        while failures < rows.len() {
            let Some(row) = self.pick_row(&mut rows) else { continue };
            let worth = self.best_of(row);
            if worth > 1.0 && worth >= bar {
                std::mem::swap(&mut self.candidate, &mut self.best);
                self.keep();
                failures = 0;
            } else if bar > 1.0 {
                bar *= fall;
            } else {
                failures += 1;
            }
        }
    }

    /// Grows several from `row`; the best is in `best`.
    fn best_of(&mut self, row: u32) -> f64 {
        let mut best = 0.0;
        for _ in 0..TRIES {
            let worth = if self.start(row, PARTNERS) > 0 { self.worth() } else { 0.0 };
            if worth > best {
                best = worth;
                std::mem::swap(&mut self.candidate, &mut self.best);
            }
        }
        best
    }

    /// What the bicluster saves for what it takes, over 1 if it gains.
    fn worth(&self) -> f64 {
        let taken = self.cost.taken(self.candidate.rows.len(), self.candidate.columns.len());
        i64::from(self.cost.element) as f64 * self.candidate.saved() as f64 / taken as f64
    }

    fn all_rows(&self) -> Vec<u32> {
        (0..self.block.rows.len() as u32).collect()
    }

    /// A random one of `rows`; `None` if it was empty, and then it is no longer there, as an empty row stays empty.
    fn pick_row(&mut self, rows: &mut Vec<u32>) -> Option<u32> {
        let at = self.random.below(rows.len());
        if self.block.rows[rows[at] as usize].is_empty() {
            rows.swap_remove(at);
            return None;
        }
        Some(rows[at])
    }

    /// Grows a bicluster from a random element of `row` and, of so many random rows with the same element, the one that
    /// shares most with it. Returns the gain.
    fn start(&mut self, row: u32, partners: usize) -> i64 {
        let seed = *self.random.pick(&self.block.rows[row as usize]);
        let partner = self.partner(row, seed, partners);
        self.candidate.clear(&self.block);
        self.candidate.insert_row(&self.block, row);
        if let Some(partner) = partner {
            self.candidate.insert_row(&self.block, partner);
        }
        self.candidate.insert_column(&self.block, seed.column);
        while let Some((_, operation)) = self.candidate.select(&self.block) {
            self.candidate.conduct(&self.block, operation);
        }
        self.candidate.gain()
    }

    fn partner(&mut self, row: u32, seed: Entry, draws: usize) -> Option<u32> {
        let cells = &self.block.columns[seed.column as usize].cells;
        let drawn =
            (0..draws).map(|_| self.random.pick(cells)).filter(|cell| cell.row != row && cell.symbol == seed.symbol);
        let row = &self.block.rows[row as usize];
        drawn.map(|cell| cell.row).max_by_key(|&other| shared(row, &self.block.rows[other as usize]))
    }

    /// Moves the candidate from what is left to the biclusters.
    fn keep(&mut self) {
        let (rows, terms) = (self.candidate.sorted_rows(), self.candidate.terms());
        self.block.subtract(&rows, &terms);
        let columns = terms.iter().map(|term| self.outside(term)).collect();
        self.biclusters.push(Bicluster { rows, columns });
    }

    fn outside(&self, entry: &Entry) -> (u32, f32) {
        (self.block.columns[entry.column as usize].id, self.block.values[entry.symbol as usize])
    }

    pub(super) fn finish(self) -> Grown {
        let leftover =
            self.block.rows.iter().map(|row| row.iter().map(|entry| self.outside(entry)).collect()).collect();
        Grown { biclusters: self.biclusters, leftover }
    }
}

/// How many elements two rows share.
fn shared(a: &[Entry], b: &[Entry]) -> usize {
    let mut b = b.iter().peekable();
    let held = |entry: &&Entry| {
        while b.next_if(|other| other.column < entry.column).is_some() {}
        b.peek() == Some(entry)
    };
    a.iter().filter(held).count()
}
