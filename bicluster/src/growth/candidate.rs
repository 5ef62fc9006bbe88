//! A bicluster while it grows, and the influence of every row and column on it.
//!
//! The influence of a row is element·(match + nnz - l) - row, that of a column element·(match + nnz - r) - column, where
//! match and nnz count its elements in the bicluster's columns (rows) that equal t_k, and those that are not zero: an element equal
//! to t_k saves one, a zero costs one, as it leaves -t_k, another saves nothing. Insertion gains the influence, deletion loses it.
//! A key is match + nnz, so r and l enter all influences alike and only keys are kept: a row that comes or goes touches the keys of
//! the columns in its support, a column those of the rows in its own.

use super::block::{Block, Entry};
use super::cost::Cost;
use super::select::RowQueue;

pub(super) const NONE: u32 = u32::MAX;

/// A step of Algorithm 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operation {
    InsertRow(u32),
    DeleteRow(u32),
    InsertColumn(u32),
    DeleteColumn(u32),
}

#[derive(Debug)]
pub(super) struct Candidate {
    pub(super) cost: Cost,
    /// J, in order of insertion.
    pub(super) rows: Vec<u32>,
    /// K, in order of insertion.
    pub(super) columns: Vec<u32>,
    pub(super) row_keys: Vec<u32>,
    pub(super) column_keys: Vec<u32>,
    pub(super) has_row: Vec<bool>,
    pub(super) has_column: Vec<bool>,
    /// Whether a column may come in, as a mask of its key: all ones or zero.
    pub(super) open: Vec<u32>,
    /// t_k: of each column the most frequent symbol in J, or [`NONE`].
    pub(super) symbol: Vec<u32>,
    /// How many rows of J have each symbol.
    count: Vec<u32>,
    /// How many columns of K have residuals to be checked.
    pub(super) strict: usize,
    /// Rows and columns whose key is not zero, or has not always been.
    pub(super) touched_rows: Vec<u32>,
    pub(super) touched_columns: Vec<u32>,
    pub(super) queue: RowQueue,
    /// (key, column) of the open column with the largest key, where known.
    pub(super) top_column: Option<(u32, u32)>,
}

impl Candidate {
    /// No rows, no columns.
    pub(super) fn new(block: &Block, cost: Cost) -> Candidate {
        let (rows, columns) = (block.rows.len(), block.columns.len());
        Candidate {
            cost,
            rows: Vec::new(),
            columns: Vec::new(),
            row_keys: vec![0; rows],
            column_keys: vec![0; columns],
            has_row: vec![false; rows],
            has_column: vec![false; columns],
            open: vec![u32::MAX; columns],
            symbol: vec![NONE; columns],
            count: vec![0; block.values.len()],
            strict: 0,
            touched_rows: Vec::new(),
            touched_columns: Vec::new(),
            queue: RowQueue::default(),
            top_column: None,
        }
    }

    /// No rows, no columns again; the block may have other elements and more symbols now.
    pub(super) fn clear(&mut self, block: &Block) {
        for row in self.touched_rows.drain(..) {
            self.row_keys[row as usize] = 0;
        }
        for column in self.touched_columns.drain(..).map(|column| column as usize) {
            self.column_keys[column] = 0;
            self.has_column[column] = false;
            self.open[column] = u32::MAX;
            self.symbol[column] = NONE;
        }
        for row in self.rows.drain(..) {
            self.has_row[row as usize] = false;
        }
        self.columns.clear();
        self.count.clear();
        self.count.resize(block.values.len(), 0);
        self.strict = 0;
        self.queue.clear();
        self.top_column = None;
    }

    /// nnz(M) - nnz(residual): match + nnz - r summed over columns.
    pub(super) fn saved(&self) -> i64 {
        let keys: i64 = self.columns.iter().map(|&k| i64::from(self.column_keys[k as usize])).sum();
        keys - self.rows.len() as i64 * self.columns.len() as i64
    }

    /// Eq. 9.
    pub(super) fn gain(&self) -> i64 {
        i64::from(self.cost.element) * self.saved() - self.cost.taken(self.rows.len(), self.columns.len())
    }

    pub(super) fn row_influence(&self, row: u32) -> i64 {
        let key = i64::from(self.row_keys[row as usize]);
        i64::from(self.cost.element) * (key - self.columns.len() as i64) - i64::from(self.cost.row)
    }

    pub(super) fn column_influence(&self, column: u32) -> i64 {
        let key = i64::from(self.column_keys[column as usize]);
        i64::from(self.cost.element) * (key - self.rows.len() as i64) - i64::from(self.cost.column)
    }

    pub(super) fn conduct(&mut self, block: &Block, operation: Operation) {
        match operation {
            Operation::InsertRow(row) => self.insert_row(block, row),
            Operation::DeleteRow(row) => self.delete_row(block, row),
            Operation::InsertColumn(column) => self.insert_column(block, column),
            Operation::DeleteColumn(column) => self.delete_column(block, column),
        }
    }

    pub(super) fn insert_row(&mut self, block: &Block, row: u32) {
        self.rows.push(row);
        self.has_row[row as usize] = true;
        self.queue.inserted(self.row_keys[row as usize], row);
        for &Entry { column, symbol } in &block.rows[row as usize] {
            let k = column as usize;
            self.count[symbol as usize] += 1;
            let rise = if self.symbol[k] == symbol { 2 } else { 1 + self.prefer(block, Entry { column, symbol }) };
            let key = self.column_keys[k] + rise;
            self.column_keys[k] = key;
            if let Some(top) = &mut self.top_column
                && key & self.open[k] > top.0
            {
                *top = (key, column);
            }
        }
    }

    pub(super) fn delete_row(&mut self, block: &Block, row: u32) {
        take(&mut self.rows, row);
        self.has_row[row as usize] = false;
        self.queue.forget();
        self.top_column = None;
        for &Entry { column, symbol } in &block.rows[row as usize] {
            let k = column as usize;
            self.count[symbol as usize] -= 1;
            self.column_keys[k] -= 1;
            if self.symbol[k] == symbol {
                let most = block.columns[k].dictionary.symbols().max_by_key(|&s| self.count[s as usize]);
                self.column_keys[k] -= 1;
                self.column_keys[k] += self.prefer(block, Entry { column, symbol: most.unwrap_or(symbol) });
            }
        }
    }

    pub(super) fn insert_column(&mut self, block: &Block, column: u32) {
        self.columns.push(column);
        self.has_column[column as usize] = true;
        self.open[column as usize] = 0;
        self.strict += usize::from(!block.columns[column as usize].dictionary.roomy());
        self.queue.reserve(2 * self.columns.len());
        self.top_column = None;
        let (queues, worthy) = (self.queue.is_complete(), self.worthy_key());
        let t = self.symbol[column as usize];
        for cell in &block.columns[column as usize].cells {
            let key = &mut self.row_keys[cell.row as usize];
            if *key == 0 {
                self.touched_rows.push(cell.row);
            }
            *key += 1 + u32::from(cell.symbol == t);
            if *key >= worthy && queues && !self.has_row[cell.row as usize] {
                self.queue.put(*key, cell.row);
            }
        }
    }

    pub(super) fn delete_column(&mut self, block: &Block, column: u32) {
        take(&mut self.columns, column);
        self.has_column[column as usize] = false;
        self.open[column as usize] = u32::MAX;
        self.strict -= usize::from(!block.columns[column as usize].dictionary.roomy());
        self.queue.forget();
        self.top_column = None;
        let t = self.symbol[column as usize];
        for cell in &block.columns[column as usize].cells {
            self.row_keys[cell.row as usize] -= 1 + u32::from(cell.symbol == t);
        }
    }

    /// Makes `term` the value of its column if more rows have it than the value of now, and says how many more.
    fn prefer(&mut self, block: &Block, term: Entry) -> u32 {
        let old = self.symbol[term.column as usize];
        let now = if old == NONE {
            self.touched_columns.push(term.column);
            0
        } else {
            self.count[old as usize]
        };
        let more = self.count[term.symbol as usize].saturating_sub(now);
        if more == 0 || (self.has_column[term.column as usize] && !self.revalue(block, term)) {
            return 0;
        }
        self.symbol[term.column as usize] = term.symbol;
        more
    }

    /// Updates rows for a new value of a column of K, if all rows of J may have it.
    fn revalue(&mut self, block: &Block, term: Entry) -> bool {
        let allowed = self.allows(block, term);
        if allowed {
            self.queue.forget();
            let old = self.symbol[term.column as usize];
            for cell in &block.columns[term.column as usize].cells {
                let key = &mut self.row_keys[cell.row as usize];
                *key = *key + u32::from(cell.symbol == term.symbol) - u32::from(cell.symbol == old);
            }
        }
        allowed
    }

    /// Whether every row of J may have `term`.
    pub(super) fn allows(&self, block: &Block, term: Entry) -> bool {
        block.columns[term.column as usize].dictionary.roomy() || self.rows.iter().all(|&row| block.allows(row, term))
    }

    /// J, ascending.
    pub(super) fn sorted_rows(&self) -> Vec<u32> {
        let mut rows = self.rows.clone();
        rows.sort_unstable();
        rows
    }

    /// K and its values, by ascending column.
    pub(super) fn terms(&self) -> Vec<Entry> {
        let mut terms: Vec<_> = self.columns.iter().map(|&column| self.term(column)).collect();
        terms.sort_unstable_by_key(|term| term.column);
        terms
    }

    pub(super) fn term(&self, column: u32) -> Entry {
        Entry { column, symbol: self.symbol[column as usize] }
    }
}

/// Takes `item` out of `items`, which have it.
fn take(items: &mut Vec<u32>, item: u32) {
    let at = items.iter().position(|&other| other == item).expect("only what is in is deleted");
    items.swap_remove(at);
}
