//! What is left of a block of rows, by row and by column, with symbols for values.

use super::dictionary::Dictionary;

/// An element of a row. A symbol stands for one value of one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) column: u32,
    pub(super) symbol: u32,
}

/// An element of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) row: u32,
    pub(super) symbol: u32,
}

/// A column that some row of the block has.
#[derive(Debug)]
pub(super) struct Column {
    /// The caller's number.
    pub(super) id: u32,
    /// Its elements, by ascending row.
    pub(super) cells: Vec<Cell>,
    pub(super) dictionary: Dictionary,
}

#[derive(Debug)]
pub(super) struct Block {
    /// Elements of each row, by ascending column.
    pub(super) rows: Vec<Vec<Entry>>,
    /// Columns by ascending number.
    pub(super) columns: Vec<Column>,
    /// The value of each symbol.
    pub(super) values: Vec<f32>,
}

impl Block {
    pub(super) fn new(rows: &[Vec<(u32, f32)>], columns: usize) -> Block {
        let mut bits: Vec<Vec<u32>> = vec![Vec::new(); columns];
        for (id, value) in rows.iter().flat_map(|row| non_zeros(row)) {
            bits[id as usize].push(value.to_bits());
        }
        let mut local = vec![0; columns];
        let mut block = Block { rows: Vec::with_capacity(rows.len()), columns: Vec::new(), values: Vec::new() };
        for (id, bits) in (0u32..).zip(bits).filter(|(_, bits)| !bits.is_empty()) {
            local[id as usize] = block.columns.len() as u32;
            let cells = Vec::with_capacity(bits.len());
            block.columns.push(Column { id, cells, dictionary: Dictionary::new(bits, &mut block.values) });
        }
        for (i, row) in (0u32..).zip(rows) {
            let entries: Vec<_> = non_zeros(row).map(|(id, value)| block.entry(local[id as usize], value)).collect();
            for entry in &entries {
                block.columns[entry.column as usize].cells.push(Cell { row: i, symbol: entry.symbol });
            }
            block.rows.push(entries);
        }
        block
    }

    fn entry(&mut self, column: u32, value: f32) -> Entry {
        let symbol = self.columns[column as usize].dictionary.symbol(value, &mut self.values);
        Entry { column, symbol }
    }

    /// The element at `row` and `column`.
    pub(super) fn value(&self, row: u32, column: u32) -> f32 {
        let row = &self.rows[row as usize];
        row.binary_search_by_key(&column, |e| e.column).map_or(0.0, |at| self.values[row[at].symbol as usize])
    }

    /// Whether the element at `row` less the value of `term` is exact.
    pub(super) fn allows(&self, row: u32, term: Entry) -> bool {
        let dictionary = &self.columns[term.column as usize].dictionary;
        dictionary.roomy()
            || dictionary.residual(self.value(row, term.column), self.values[term.symbol as usize]).is_some()
    }

    /// Subtracts `terms` (by ascending column) from each of `rows` (ascending), all of which [`Block::allows`].
    pub(super) fn subtract(&mut self, rows: &[u32], terms: &[Entry]) {
        for &row in rows {
            let old = std::mem::take(&mut self.rows[row as usize]);
            let mut rest = Vec::with_capacity(old.len() + terms.len());
            let mut old = old.into_iter().peekable();
            for term in terms {
                rest.extend(std::iter::from_fn(|| old.next_if(|e| e.column < term.column)));
                let held = old.next_if(|e| e.column == term.column).map(|e| e.symbol);
                rest.extend(self.rest(held, *term));
            }
            rest.extend(old);
            self.rows[row as usize] = rest;
        }
        for term in terms {
            let old = std::mem::take(&mut self.columns[term.column as usize].cells);
            let mut rest = Vec::with_capacity(old.len() + rows.len());
            let mut old = old.into_iter().peekable();
            for &row in rows {
                rest.extend(std::iter::from_fn(|| old.next_if(|cell| cell.row < row)));
                let held = old.next_if(|cell| cell.row == row).map(|cell| cell.symbol);
                rest.extend(self.rest(held, *term).map(|entry| Cell { row, symbol: entry.symbol }));
            }
            rest.extend(old);
            self.columns[term.column as usize].cells = rest;
        }
    }

    /// What `term` leaves of an element.
    fn rest(&mut self, held: Option<u32>, term: Entry) -> Option<Entry> {
        if held == Some(term.symbol) {
            return None;
        }
        let held = held.map_or(0.0, |symbol| self.values[symbol as usize]);
        let dictionary = &self.columns[term.column as usize].dictionary;
        let rest = dictionary.residual(held, self.values[term.symbol as usize]);
        Some(self.entry(term.column, rest.expect("no row is in a bicluster with a column that it may not have")))
    }
}

fn non_zeros(row: &[(u32, f32)]) -> impl Iterator<Item = (u32, f32)> {
    row.iter().copied().filter(|&(_, value)| value != 0.0)
}
