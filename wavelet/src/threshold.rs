//! One threshold for a whole matrix: the fewest elements that keep an error bound.
//!
//! Dropping the smallest magnitudes first is optimal, so the choice is one number τ. It is found without sorting: the bits of a
//! non-negative `f32` ascend with its value, so a histogram of the squared error by the upper 16 bits finds the upper half of
//! τ, and one by the lower 16 bits, over those that share the upper half, finds the rest.

use crate::stored::Rounding;
use prt_transfer::{Progress, Result, TransferMatrix};
use rayon::prelude::*;
use std::ops::Range;

/// Elements above a magnitude are kept, and of those equal to it as many as the bound needs, spread evenly over the rows.
pub(crate) struct Threshold {
    /// The bits of τ. Magnitudes with smaller bits are dropped.
    bits: u32,
    /// Elements of magnitude τ in the rows before each row, and in all rows at the end.
    ties_before: Vec<u64>,
    /// How many of them are kept.
    ties_kept: u64,
}

/// The part of the bound that is used: dropping costs what it costs up to the rounding of sums and of transforms.
const USED: f64 = 1.0 - 1e-6;

/// Parts that a histogram of so many rows is summed over: not by threads, so that its rounding does not depend on them.
fn parts(rows: usize) -> usize {
    (rows / 256).clamp(1, 32)
}

/// Squared error by half of the magnitude's bits.
struct Histogram {
    /// What dropping the elements of each of the 2^16 halves adds to the squared error.
    cost: Vec<f64>,
    /// Σ C².
    energy: f64,
    /// Squared error when everything is kept.
    rounding: f64,
}

fn magnitude_bits(value: f32) -> u32 {
    value.abs().to_bits()
}

impl Threshold {
    /// The threshold that keeps Σ(C-C̃)² ≤ bound·ΣC²; the inner error is the least bound that `rounding` allows.
    pub(crate) fn choose(
        matrix: &TransferMatrix,
        rounding: Rounding,
        bound: f64,
        progress: &dyn Progress,
    ) -> Result<Result<Threshold, f64>> {
        progress.start("select", 3 * matrix.rows() as u64);
        let coarse = Histogram::sum(matrix, rounding, progress, |bits| Some(bits >> 16))?;
        let budget = USED * bound * coarse.energy;
        if budget < coarse.rounding {
            return Ok(Err(coarse.rounding / (USED * coarse.energy)));
        }
        let (upper, budget) = coarse.first_above(budget - coarse.rounding);
        let fine = Histogram::sum(matrix, rounding, progress, |bits| (bits >> 16 == upper).then_some(bits & 0xffff))?;
        let (lower, budget) = fine.first_above(budget);
        let bits = (upper << 16).saturating_add(lower);
        let ties_before = ties(matrix, bits, progress)?;
        let total = ties_before[matrix.rows()];
        // A tie costs at most τ². A saturating cast: τ may be 0 where there are no ties.
        let dropped = (budget / f64::from(f32::from_bits(bits)).powi(2)).floor() as u64;
        Ok(Ok(Threshold { bits, ties_before, ties_kept: total.saturating_sub(dropped) }))
    }

    /// Reduces the non-zero elements (column, value) of a row to those that are kept.
    pub(crate) fn reduce(&self, row: usize, elements: &mut Vec<(u32, f32)>) {
        // The ties kept among the first t of all ties: t·kept/total, so that no row loses more than its share.
        let total = self.ties_before[self.ties_before.len() - 1].max(1);
        let share = |t: u64| (u128::from(t) * u128::from(self.ties_kept) / u128::from(total)) as u64;
        let mut quota = share(self.ties_before[row + 1]) - share(self.ties_before[row]);
        elements.retain(|&(_, value)| {
            let bits = magnitude_bits(value);
            let tie = bits == self.bits && quota > 0;
            quota -= u64::from(tie);
            tie || bits > self.bits
        });
    }
}

/// Elements whose magnitude has these bits: before each row, and in all.
fn ties(matrix: &TransferMatrix, bits: u32, progress: &dyn Progress) -> Result<Vec<u64>> {
    let count = |row| {
        progress.advance(1)?;
        Ok(matrix.row(row).non_zeros().filter(|&(_, v)| magnitude_bits(v) == bits).count() as u64)
    };
    let mut before: Vec<u64> = (0..matrix.rows()).into_par_iter().map(count).collect::<Result<_>>()?;
    let mut sum = 0;
    for count in &mut before {
        sum += std::mem::replace(count, sum);
    }
    before.push(sum);
    Ok(before)
}

impl Histogram {
    /// Over all elements, by the half that `half` finds in the bits of a magnitude; it leaves out those without one.
    fn sum(
        matrix: &TransferMatrix,
        rounding: Rounding,
        progress: &dyn Progress,
        half: impl Fn(u32) -> Option<u32> + Sync,
    ) -> Result<Histogram> {
        let rows = matrix.rows();
        let count = parts(rows);
        let part = |i: usize| rows * i / count..rows * (i + 1) / count;
        let parts: Vec<Histogram> = (0..count)
            .into_par_iter()
            .map(|i| Histogram::of_rows(matrix, part(i), rounding, progress, &half))
            .collect::<Result<_>>()?;
        let mut all = Histogram { cost: vec![0.0; 1 << 16], energy: 0.0, rounding: 0.0 };
        for part in parts {
            all.cost.iter_mut().zip(part.cost).for_each(|(sum, cost)| *sum += cost);
            all.energy += part.energy;
            all.rounding += part.rounding;
        }
        Ok(all)
    }

    fn of_rows(
        matrix: &TransferMatrix,
        rows: Range<usize>,
        rounding: Rounding,
        progress: &dyn Progress,
        half: &impl Fn(u32) -> Option<u32>,
    ) -> Result<Histogram> {
        let mut sums = Histogram { cost: vec![0.0; 1 << 16], energy: 0.0, rounding: 0.0 };
        for row in rows {
            let row = matrix.row(row);
            let step = rounding.step(row.non_zeros().map(|(_, v)| v));
            for (_, value) in row.non_zeros() {
                let square = f64::from(value).powi(2);
                let kept = (f64::from(value) - f64::from(rounding.decoded(value, step))).powi(2);
                sums.energy += square;
                sums.rounding += kept;
                if let Some(half) = half(magnitude_bits(value)) {
                    sums.cost[half as usize] += (square - kept).max(0.0);
                }
            }
            progress.advance(1)?;
        }
        Ok(sums)
    }

    /// The first half whose elements cannot all be dropped within `budget`, and what is left of it after all before; the last
    /// half where every element can be dropped.
    fn first_above(&self, mut budget: f64) -> (u32, f64) {
        let last = self.cost.len() - 1;
        for (half, cost) in self.cost[..last].iter().enumerate() {
            if *cost > budget {
                return (half as u32, budget);
            }
            budget -= cost;
        }
        (last as u32, budget)
    }
}
