//! Error-bounded mode, the future work of the paper (§VII): elements whose error is small and whose cost is not are changed or
//! dropped until a budget of squared error is used up; what remains is compressed exactly.
//!
//! Two things break the sums that rows could share. An element of a rare value is a symbol of its own: in the order of its
//! error each is rounded to 0 or to the value that its column mostly has in its block, the paper's t_k. A term of few leaves
//! costs a row as much as one of many: with what is left of the budget, terms are dropped from rows in the order of their energy.
//! Every change of a kind saves about as much as any other, so that the order is that of the saving per unit of error.

use crate::distinct::Distinct;
use crate::lay_out::{partition, rows, with_rows};
use crate::pairs;
use crate::params::Objective;
use crate::symbols::{Leaf, Symbols};
use prt_transfer::{Progress, Result, TransferMatrix};
use rayon::prelude::*;
use std::collections::HashMap;

/// Part of the budget that is left for rounding in the sums of squares.
const SLACK: f64 = 1e-9;
/// How often a budget for dropping terms is tried.
const RETRIES: usize = 4;

/// A distinct row of the matrix and its elements.
type Rows = Vec<(u32, Vec<Leaf>)>;

/// A change of one distinct row: its squared error in all rows that equal it, the row's place, and what is changed there.
struct Change {
    error: f64,
    block: u32,
    row: u32,
    /// Which element, or which term.
    at: u32,
    /// The element's new value.
    value: f32,
}

/// A matrix whose squared error, relative to that of `matrix`, is at most `bound`.
pub(crate) fn approximate(
    matrix: &TransferMatrix,
    bound: f64,
    objective: Objective,
    progress: &dyn Progress,
) -> Result<TransferMatrix> {
    let budget = bound * (1.0 - SLACK) * energy(matrix);
    let (rounded, spent) = round(matrix, budget, progress)?;
    // An element that was rounded and then dropped may weigh more than both together: then less may be dropped.
    let mut left = budget - spent;
    for _ in 0..RETRIES {
        let dropped = drop_terms(&rounded, left, objective, progress)?;
        let error = squared_error(matrix, &dropped);
        if error <= budget {
            return Ok(dropped);
        }
        left = (left - 2.0 * (error - budget)).max(0.5 * left);
    }
    Ok(rounded)
}

fn energy(matrix: &TransferMatrix) -> f64 {
    let row = |row| matrix.row(row).non_zeros().map(|(_, v)| f64::from(v).powi(2)).sum::<f64>();
    (0..matrix.rows()).map(row).sum()
}

/// Σ(a-b)² of two sparse matrices of one shape.
fn squared_error(a: &TransferMatrix, b: &TransferMatrix) -> f64 {
    let (mut difference, mut sum) = (vec![0f64; a.lights()], 0.0);
    for row in 0..a.rows() {
        a.row(row).non_zeros().for_each(|(c, v)| difference[c] += f64::from(v));
        b.row(row).non_zeros().for_each(|(c, v)| difference[c] -= f64::from(v));
        for (column, _) in a.row(row).non_zeros().chain(b.row(row).non_zeros()) {
            sum += std::mem::take(&mut difference[column]).powi(2);
        }
    }
    sum
}

/// How often each distinct row occurs.
fn multiplicities(distinct: &Distinct) -> Vec<f64> {
    let mut rows = vec![0f64; distinct.first.len()];
    distinct.kind.iter().for_each(|&kind| {
        if let Some(rows) = rows.get_mut(kind as usize) {
            *rows += 1.0;
        }
    });
    rows
}

/// Rounds elements to 0 or their column's most frequent value; returns the error as well.
fn round(matrix: &TransferMatrix, budget: f64, progress: &dyn Progress) -> Result<(TransferMatrix, f64)> {
    let (distinct, _, kinds) = partition(matrix, progress)?;
    let times = multiplicities(&distinct);
    let mut blocks: Vec<Rows> = kinds
        .into_par_iter()
        .map(|kinds| kinds.iter().copied().zip(rows(matrix, &distinct, &kinds)).collect())
        .collect();
    let changes = |(block, rows): (usize, &Rows)| {
        let usual = most_frequent(rows);
        let mut changes = Vec::new();
        for (row, (kind, elements)) in rows.iter().enumerate() {
            for (at, &(column, old)) in elements.iter().enumerate() {
                let to = usual[&column];
                let value = if (old - to).abs() < old.abs() { to } else { 0.0 };
                if value != old {
                    let error = (f64::from(old) - f64::from(value)).powi(2) * times[*kind as usize];
                    changes.push(Change { error, block: block as u32, row: row as u32, at: at as u32, value });
                }
            }
        }
        changes
    };
    let changes: Vec<Change> = blocks.par_iter().enumerate().flat_map_iter(changes).collect();
    let (chosen, spent) = cheapest(changes, budget);
    chosen.iter().for_each(|c| blocks[c.block as usize][c.row as usize].1[c.at as usize].1 = c.value);
    Ok((rebuild(matrix, &distinct, blocks.into_iter().flatten())?, spent))
}

/// The most frequent value of each column, the one of the smallest bits among equals.
fn most_frequent(rows: &Rows) -> HashMap<u32, f32> {
    let mut elements: Vec<(u32, u32)> =
        rows.iter().flat_map(|(_, row)| row.iter().map(|&(c, v)| (c, v.to_bits()))).collect();
    elements.sort_unstable();
    let mut usual: HashMap<u32, (usize, f32)> = HashMap::new();
    for group in elements.chunk_by(|a, b| a == b) {
        let best = usual.entry(group[0].0).or_default();
        if group.len() > best.0 {
            *best = (group.len(), f32::from_bits(group[0].1));
        }
    }
    usual.into_iter().map(|(column, (_, value))| (column, value)).collect()
}

/// The changes of least error that `budget` pays for, and what they cost.
fn cheapest(mut changes: Vec<Change>, budget: f64) -> (Vec<Change>, f64) {
    changes.par_sort_unstable_by(|a, b| {
        a.error.total_cmp(&b.error).then((a.block, a.row, a.at).cmp(&(b.block, b.row, b.at)))
    });
    let mut spent = 0.0;
    let affordable = changes.iter().take_while(|change| {
        let affordable = spent + change.error <= budget;
        spent += if affordable { change.error } else { 0.0 };
        affordable
    });
    let count = affordable.count();
    changes.truncate(count);
    (changes, spent)
}

/// Drops terms of little energy from rows.
fn drop_terms(
    matrix: &TransferMatrix,
    budget: f64,
    objective: Objective,
    progress: &dyn Progress,
) -> Result<TransferMatrix> {
    let (distinct, _, kinds) = partition(matrix, progress)?;
    let times = multiplicities(&distinct);
    progress.start("approximate", distinct.first.len() as u64);
    let searched: Vec<(Vec<u32>, Terms)> = kinds
        .into_par_iter()
        .map(|kinds| {
            let terms = Terms::of(&rows(matrix, &distinct, &kinds), objective);
            progress.advance(kinds.len() as u64)?;
            Ok((kinds, terms))
        })
        .collect::<Result<_>>()?;
    let changes = |(block, (kinds, terms)): (usize, &(Vec<u32>, Terms))| {
        let mut changes = Vec::new();
        for (row, symbols) in terms.rows.iter().enumerate() {
            let times = times[kinds[row] as usize];
            changes.extend(symbols.iter().enumerate().map(|(at, &symbol)| Change {
                error: times * terms.energy[usize::from(symbol)],
                block: block as u32,
                row: row as u32,
                at: at as u32,
                value: 0.0,
            }));
        }
        changes
    };
    let changes: Vec<Change> = searched.par_iter().enumerate().flat_map_iter(changes).collect();
    let mut dropped: Vec<Vec<Vec<u32>>> = searched.iter().map(|(kinds, _)| vec![Vec::new(); kinds.len()]).collect();
    for change in cheapest(changes, budget).0 {
        dropped[change.block as usize][change.row as usize].push(change.at);
    }
    let left = searched.into_par_iter().zip(dropped).flat_map_iter(|((kinds, terms), dropped)| {
        let rows: Vec<Vec<Leaf>> = (0..kinds.len()).map(|row| terms.without(row, &dropped[row])).collect();
        kinds.into_iter().zip(rows)
    });
    rebuild(matrix, &distinct, left.collect::<Rows>().into_iter())
}

/// Rows of a block as terms.
struct Terms {
    leaves: Vec<Leaf>,
    pairs: Vec<pairs::Pair>,
    rows: Vec<Vec<u16>>,
    left: Vec<Vec<Leaf>>,
    /// Σv² of the leaves of each symbol.
    energy: Vec<f64>,
}

impl Terms {
    fn of(rows: &[Vec<Leaf>], objective: Objective) -> Terms {
        let Symbols { leaves, mut rows, left } = Symbols::of(rows, 0);
        let pairs = pairs::merge(&mut rows, leaves.len(), objective.least_rows());
        let mut energy: Vec<f64> = leaves.iter().map(|&(_, v)| f64::from(v).powi(2)).collect();
        for pair in &pairs {
            energy.push(pair.iter().map(|&s| energy[usize::from(s)]).sum());
        }
        Terms { leaves, pairs, rows, left, energy }
    }

    /// The elements of a row without those of the terms at `dropped`.
    fn without(&self, row: usize, dropped: &[u32]) -> Vec<Leaf> {
        let kept = (0..).zip(&self.rows[row]).filter(|(at, _)| !dropped.contains(at));
        let mut open: Vec<u16> = kept.map(|(_, &symbol)| symbol).collect();
        let mut elements = self.left[row].clone();
        while let Some(symbol) = open.pop().map(usize::from) {
            match self.leaves.get(symbol) {
                Some(&leaf) => elements.push(leaf),
                None => open.extend(self.pairs[symbol - self.leaves.len()]),
            }
        }
        elements.sort_unstable_by_key(|leaf| leaf.0);
        elements
    }
}

/// The matrix whose distinct rows are replaced.
fn rebuild(
    matrix: &TransferMatrix,
    distinct: &Distinct,
    rows: impl Iterator<Item = (u32, Vec<Leaf>)>,
) -> Result<TransferMatrix> {
    let mut elements = vec![Vec::new(); distinct.first.len()];
    rows.for_each(|(kind, row)| elements[kind as usize] = row);
    with_rows(matrix, distinct, &elements)
}
