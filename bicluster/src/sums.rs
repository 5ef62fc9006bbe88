//! Shared sums as relighting holds them: per block of rows its leaves, the sums of them and of earlier sums, and for each row
//! that differs from all others the symbols that add up to it.
//!
//! The paper's Algorithm 2 is the same with one level of sums: bicluster products first, then a gather per row.

use crate::block::{Block, Code};
use crate::distinct::EMPTY;
use crate::symbols::Leaf;
use prt_transfer::compact::EncodedCompact;
use prt_transfer::{Encoded, Shape};

/// Rows that are summed side by side, one in each lane: their terms are interleaved.
pub(crate) const LANES: usize = 8;

/// All blocks, array by array.
pub(crate) struct Sums {
    pub(crate) shape: Shape,
    /// For each row the number of its product, counted from 1; 0 where it has none.
    pub(crate) slots: Vec<u32>,
    /// For each block: runs of leaves with one factor, sums, groups of rows with as many terms; zeros where nothing is shared.
    pub(crate) blocks: Vec<[u32; 3]>,
    /// The factor of each run of leaves.
    pub(crate) factors: Vec<f32>,
    /// Where each run ends, in leaves of its block.
    pub(crate) runs: Vec<u32>,
    /// The light coefficient of each leaf.
    pub(crate) columns: Columns,
    /// Terms of each sum; empty where every sum has two.
    pub(crate) arities: Vec<u16>,
    /// The terms of the sums: leaves and earlier sums of the same block.
    pub(crate) inputs: Vec<u16>,
    /// For each group of rows: terms of a row, rows.
    pub(crate) groups: Vec<[u32; 2]>,
    /// The terms of the rows, those of [`LANES`] rows interleaved; the rest of a group row by row.
    pub(crate) terms: Vec<u16>,
    /// The region of each column, where the sums can be found again from rows and pairs; else empty.
    pub(crate) regions: Vec<u16>,
    /// Elements that no sum covers, a row for each product.
    pub(crate) rest: Option<Box<EncodedCompact>>,
    /// Where each block starts in the arrays: follows from them.
    pub(crate) starts: Vec<Start>,
}

/// Light coefficients in the narrowest width.
pub(crate) enum Columns {
    U16(Vec<u16>),
    U32(Vec<u32>),
}

impl Columns {
    pub(crate) fn up_to(lights: usize) -> Columns {
        if lights <= 1 << 16 { Columns::U16(Vec::new()) } else { Columns::U32(Vec::new()) }
    }
    pub(crate) fn push(&mut self, column: u32) {
        match self {
            Columns::U16(columns) => columns.push(column as u16),
            Columns::U32(columns) => columns.push(column),
        }
    }
    pub(crate) fn at(&self, index: usize) -> usize {
        match self {
            Columns::U16(columns) => columns[index].into(),
            Columns::U32(columns) => columns[index] as usize,
        }
    }
    pub(crate) fn len(&self) -> usize {
        match self {
            Columns::U16(columns) => columns.len(),
            Columns::U32(columns) => columns.len(),
        }
    }
}

/// Positions in the arrays of [`Sums`].
#[derive(Clone, Copy, Default, Debug, PartialEq)]
pub(crate) struct Start {
    pub(crate) run: usize,
    pub(crate) leaf: usize,
    pub(crate) sum: usize,
    pub(crate) input: usize,
    pub(crate) group: usize,
    pub(crate) term: usize,
    pub(crate) product: usize,
}

impl Sums {
    /// Lays blocks out, and returns the distinct row behind each product: those with terms first, in their order. `kind` says
    /// of each row of the matrix which distinct row it equals.
    pub(crate) fn new(shape: Shape, kind: &[u32], blocks: &[Block], regions: Vec<u16>) -> (Sums, Vec<u32>) {
        let mut sums = Sums {
            shape,
            slots: Vec::new(),
            blocks: Vec::new(),
            factors: Vec::new(),
            runs: Vec::new(),
            columns: Columns::up_to(shape.lights),
            arities: Vec::new(),
            inputs: Vec::new(),
            groups: Vec::new(),
            terms: Vec::new(),
            regions,
            rest: None,
            starts: Vec::new(),
        };
        let binary = blocks.iter().filter_map(Block::code).all(|c| c.sums.iter().all(|s| s.len() == 2));
        let mut products = Vec::new();
        for block in blocks {
            match block.code() {
                Some(code) => {
                    sums.push(code, binary);
                    products.extend(by_terms(&code.rows).into_iter().map(|row| block.kinds[row]));
                }
                None => sums.blocks.push([0; 3]),
            }
        }
        let kinds = blocks.iter().map(|b| b.kinds.len()).sum();
        let mut slots = vec![0u32; kinds];
        let place = |slots: &mut Vec<u32>, products: &[u32], from: usize| {
            (from as u32 + 1..).zip(&products[from..]).for_each(|(slot, &kind)| slots[kind as usize] = slot);
        };
        place(&mut slots, &products, 0);
        let with_terms = products.len();
        products.extend((0..kinds as u32).filter(|&kind| slots[kind as usize] == 0));
        place(&mut slots, &products, with_terms);
        sums.slots = kind.iter().map(|&k| if k == EMPTY { 0 } else { slots[k as usize] }).collect();
        sums.starts = sums.find_starts().expect("laid out in order");
        sums.shrink();
        (sums, products)
    }

    /// Memory is what the arrays hold.
    fn shrink(&mut self) {
        self.blocks.shrink_to_fit();
        self.factors.shrink_to_fit();
        self.runs.shrink_to_fit();
        match &mut self.columns {
            Columns::U16(columns) => columns.shrink_to_fit(),
            Columns::U32(columns) => columns.shrink_to_fit(),
        }
        self.arities.shrink_to_fit();
        self.inputs.shrink_to_fit();
        self.groups.shrink_to_fit();
        self.terms.shrink_to_fit();
    }

    fn push(&mut self, code: &Code, binary: bool) {
        let (runs, first) = (self.runs.len(), self.columns.len());
        for run in code.leaves.chunk_by(|a, b| a.1 == b.1) {
            self.factors.push(run[0].1);
            run.iter().for_each(|leaf| self.columns.push(leaf.0));
            self.runs.push((self.columns.len() - first) as u32);
        }
        for sum in &code.sums {
            self.inputs.extend(sum);
            if !binary {
                self.arities.push(sum.len() as u16);
            }
        }
        let (order, groups) = (by_terms(&code.rows), self.groups.len());
        for group in order.chunk_by(|&a, &b| code.rows[a].len() == code.rows[b].len()) {
            let terms = code.rows[group[0]].len();
            self.groups.push([terms as u32, group.len() as u32]);
            let (lanes, rest) = group.as_chunks::<LANES>();
            for rows in lanes {
                (0..terms).for_each(|t| self.terms.extend(rows.map(|row| code.rows[row][t])));
            }
            rest.iter().for_each(|&row| self.terms.extend(&code.rows[row]));
        }
        let counts = [self.runs.len() - runs, code.sums.len(), self.groups.len() - groups];
        self.blocks.push(counts.map(|n| n as u32));
    }

    /// Terms of a sum, by its number among all.
    pub(crate) fn arity(&self, sum: usize) -> usize {
        self.arities.get(sum).map_or(2, |&n| n.into())
    }

    /// Where each block starts, and where the last one ends; `None` where counts do not add up to the arrays' lengths.
    pub(crate) fn find_starts(&self) -> Option<Vec<Start>> {
        let (mut at, mut starts) = (Start::default(), Vec::with_capacity(self.blocks.len() + 1));
        for &[runs, sums, groups] in &self.blocks {
            starts.push(at);
            let runs = self.runs.get(at.run..at.run + runs as usize)?;
            let groups = self.groups.get(at.group..at.group + groups as usize)?;
            let arities: usize = match self.arities[..] {
                [] => 2 * sums as usize,
                _ => self.arities.get(at.sum..at.sum + sums as usize)?.iter().map(|&n| usize::from(n)).sum(),
            };
            at.run += runs.len();
            if !runs.is_sorted() {
                return None;
            }
            at.leaf += runs.last().map_or(0, |&end| end as usize);
            at.sum += sums as usize;
            at.input += arities;
            at.group += groups.len();
            for &[terms, rows] in groups {
                at.term = at.term.checked_add((terms as usize).checked_mul(rows as usize)?)?;
                at.product += rows as usize;
            }
        }
        starts.push(at);
        let found = [at.run, at.leaf, at.input, at.group, at.term];
        let held = [self.runs.len(), self.columns.len(), self.inputs.len(), self.groups.len(), self.terms.len()];
        (found == held && self.factors.len() == at.run && (self.arities.is_empty() || self.arities.len() == at.sum))
            .then_some(starts)
    }

    /// Products of all rows that differ, those without terms last.
    pub(crate) fn products(&self) -> usize {
        self.rest.as_ref().map_or(self.starts[self.blocks.len()].product, |rest| rest.shape().rows())
    }

    /// The block that a product belongs to, and its terms there.
    pub(crate) fn terms_of(&self, product: usize) -> (usize, Vec<u16>) {
        let block = self.starts.partition_point(|s| s.product <= product) - 1;
        let (mut first, mut term) = (self.starts[block].product, self.starts[block].term);
        let groups = &self.groups[self.starts[block].group..self.starts[block + 1].group];
        for [terms, rows] in groups.iter().map(|g| g.map(|n| n as usize)) {
            if product < first + rows {
                let row = product - first;
                let lanes = rows / LANES * LANES;
                let (start, step) = match row < lanes {
                    true => (row / LANES * LANES * terms + row % LANES, LANES),
                    false => (row * terms, 1),
                };
                return (block, (0..terms).map(|t| self.terms[term + start + t * step]).collect());
            }
            first += rows;
            term += rows * terms;
        }
        (block, Vec::new())
    }

    /// The leaves that a product adds up, in no order; a light coefficient can occur several times.
    pub(crate) fn expand(&self, product: usize, leaf: &mut impl FnMut(Leaf)) {
        if product >= self.starts[self.blocks.len()].product {
            return;
        }
        let (block, mut open) = self.terms_of(product);
        let (start, end) = (self.starts[block], self.starts[block + 1]);
        let leaves = end.leaf - start.leaf;
        while let Some(symbol) = open.pop() {
            let symbol = usize::from(symbol);
            if symbol < leaves {
                let run = self.runs[start.run..end.run].partition_point(|&end| end as usize <= symbol);
                leaf((self.columns.at(start.leaf + symbol) as u32, self.factors[start.run + run]));
            } else {
                let sum = start.sum + symbol - leaves;
                let input = match self.arities[..] {
                    [] => 2 * sum,
                    // Sums of several levels are few: a walk from the block's start is good enough to decode.
                    _ => start.input + (start.sum..sum).map(|s| self.arity(s)).sum::<usize>(),
                };
                open.extend(&self.inputs[input..input + self.arity(sum)]);
            }
        }
    }
}

/// Rows that have terms by their number, those of equal number in their order.
fn by_terms(rows: &[Vec<u16>]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows.len()).filter(|&row| !rows[row].is_empty()).collect();
    order.sort_by_key(|&row| rows[row].len());
    order
}
