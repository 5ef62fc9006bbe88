//! Selection of the operation with the largest influence.
//!
//! Row keys change only when columns do, and one value of l is in all influences: rows wait in buckets by key, and serve all
//! insertions between two changes of columns. A row that rises is put into a higher bucket too; when the lower one is reached, it is
//! in or not allowed. Column
//! keys only rise while rows come in, so the best column is known without a queue until a column comes in or a row goes.

use super::block::Block;
use super::candidate::{Candidate, NONE, Operation};

/// Rows outside J by key.
#[derive(Debug, Default)]
pub(super) struct RowQueue {
    /// Rows by the key that they had when they were put there.
    buckets: Vec<Vec<u32>>,
    /// One past the last bucket that may have rows.
    end: usize,
    /// Whether every row worth inserting is in the bucket of its key.
    complete: bool,
    /// (key, row) of the row of J with the least key, where known.
    least: Option<(u32, u32)>,
}

impl RowQueue {
    pub(super) fn clear(&mut self) {
        self.buckets[..self.end].iter_mut().for_each(Vec::clear);
        self.end = 0;
        self.complete = true;
        self.least = None;
    }

    /// Keys have fallen, or a row has left J.
    pub(super) fn forget(&mut self) {
        self.complete = false;
        self.least = None;
    }

    /// Whether rows that rise are to be put; if not, all are when the queue is next asked.
    pub(super) fn is_complete(&self) -> bool {
        self.complete
    }

    /// Keys are about to rise to `most` at the most.
    pub(super) fn reserve(&mut self, most: usize) {
        self.least = None;
        if self.buckets.len() <= most {
            self.buckets.resize_with(most + 1, Vec::new);
        }
    }

    /// A row has risen to `key`, for which there is a bucket.
    pub(super) fn put(&mut self, key: u32, row: u32) {
        self.buckets[key as usize].push(row);
        self.end = self.end.max(key as usize + 1);
    }

    /// A row came into J.
    pub(super) fn inserted(&mut self, key: u32, row: u32) {
        self.least = self.least.map(|least| least.min((key, row)));
    }
}

impl Candidate {
    /// The operation that gains most, and its gain, if any gains.
    pub(super) fn select(&mut self, block: &Block) -> Option<(i64, Operation)> {
        let mut best = (0, None);
        let mut offer = |gain: i64, operation| {
            if gain > best.0 {
                best = (gain, Some(operation));
            }
        };
        if let Some(row) = self.next_row(block) {
            offer(self.row_influence(row), Operation::InsertRow(row));
        }
        if let Some(column) = self.next_column(block) {
            offer(self.column_influence(column), Operation::InsertColumn(column));
        }
        if let Some(row) = self.least_row() {
            offer(-self.row_influence(row), Operation::DeleteRow(row));
        }
        if let Some(&column) = self.columns.iter().min_by_key(|&&k| self.column_keys[k as usize]) {
            offer(-self.column_influence(column), Operation::DeleteColumn(column));
        }
        best.1.map(|operation| (best.0, operation))
    }

    /// The least key at which insertion of a row gains.
    pub(super) fn worthy_key(&self) -> u32 {
        self.columns.len() as u32 + self.cost.row / self.cost.element + 1
    }

    /// The row outside with the largest key, of those worth inserting that are allowed.
    fn next_row(&mut self, block: &Block) -> Option<u32> {
        if !self.queue.complete {
            self.refill_queue();
        }
        while let Some(key) = self.queue.end.checked_sub(1) {
            while let Some(&row) = self.queue.buckets[key].last() {
                if !self.has_row[row as usize] && self.fits(block, row) {
                    return Some(row);
                }
                self.queue.buckets[key].pop();
            }
            self.queue.end = key;
        }
        None
    }

    fn refill_queue(&mut self) {
        self.queue.clear();
        self.queue.reserve(2 * self.columns.len());
        let worthy = self.worthy_key();
        for &row in &self.touched_rows {
            let key = self.row_keys[row as usize];
            if key >= worthy && !self.has_row[row as usize] {
                self.queue.put(key, row);
            }
        }
    }

    /// Whether `row` may have all columns.
    fn fits(&self, block: &Block, row: u32) -> bool {
        self.strict == 0 || self.columns.iter().all(|&column| block.allows(row, self.term(column)))
    }

    /// The row of J with the least key.
    fn least_row(&mut self) -> Option<u32> {
        if self.queue.least.is_none() {
            self.queue.least = self.rows.iter().map(|&row| (self.row_keys[row as usize], row)).min();
        }
        self.queue.least.map(|(_, row)| row)
    }

    /// The column outside with the largest key among those allowed. One that is not allowed is closed for good.
    fn next_column(&mut self, block: &Block) -> Option<u32> {
        loop {
            let top = self.top_column.unwrap_or_else(|| self.scan());
            self.top_column = Some(top);
            if top.1 == NONE {
                return None;
            }
            if self.allows(block, self.term(top.1)) {
                return Some(top.1);
            }
            self.open[top.1 as usize] = 0;
            self.top_column = None;
        }
    }

    fn scan(&self) -> (u32, u32) {
        let key = |&column: &u32| (self.column_keys[column as usize] & self.open[column as usize], column);
        self.touched_columns.iter().map(key).filter(|&(key, _)| key > 0).max().unwrap_or((0, NONE))
    }
}
