//! Runs of equal values: intervals of columns, grouped by row and value.

use crate::error::Result;
use crate::flops::Count;
use crate::kernel::{self, BLOCK_ROWS, Column, Dictionary, Half, Integer, Plain, Stored};
use crate::matrix::Shape;
use crate::narrow::{Narrow, ValueSections, Values, Whole, with_columns, with_values};
use crate::sections::{Sink, Source, broken};
use rayon::prelude::*;
use std::ops::Range;

const HEADER: &str = "header/runs";
const BLOCKS: &str = "index/run_blocks";
const ROWS: &str = "index/run_rows";
const COUNTS: &str = "index/run_counts";
const STARTS: &str = "index/run_starts";
const LENGTHS: &str = "index/run_lengths";
const VALUES: ValueSections = ValueSections { header: HEADER, codes: "weights/run_values", table: "weights/run_table" };

/// A group is what one row has of one value; its intervals are that value's runs there.
pub(super) struct Intervals {
    /// Groups and intervals before every block of [`BLOCK_ROWS`] rows.
    pub(super) blocks: Vec<[u64; 2]>,
    /// The row of each group within its block, ascending.
    pub(super) rows: Vec<u8>,
    /// Intervals of each group.
    pub(super) counts: Whole,
    /// The value of each group.
    pub(super) values: Values,
    /// The first column of each interval.
    pub(super) starts: Whole,
    /// Columns of each interval.
    pub(super) lengths: Whole,
}

impl Intervals {
    /// Bytes of its sections, the header's apart.
    pub(super) fn bytes(&self) -> usize {
        let groups = self.rows.len() + self.counts.bytes() + self.values.bytes();
        groups + self.starts.bytes() + self.lengths.bytes() + size_of_val(&self.blocks[..])
    }

    /// Blocks of rows.
    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Groups of a block, and its first interval.
    fn block(&self, block: usize) -> (Range<usize>, usize) {
        let [group, interval] = self.blocks[block];
        let end = self.blocks.get(block + 1).map_or(self.rows.len(), |next| next[0] as usize);
        (group as usize..end, interval as usize)
    }

    /// Value and columns of every run of a row.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = (f32, Range<usize>)> + '_ {
        let (groups, mut interval) = self.block(row / BLOCK_ROWS);
        let rows = &self.rows[groups.clone()];
        let below = |r: usize| groups.start + rows.partition_point(|&row| usize::from(row) < r);
        let mine = below(row % BLOCK_ROWS)..below(row % BLOCK_ROWS + 1);
        interval += (groups.start..mine.start).map(|g| self.counts.at(g)).sum::<usize>();
        mine.flat_map(move |group| {
            let first = interval;
            interval += self.counts.at(group);
            (first..interval).map(move |i| (self.values.at(group), self.columns(i)))
        })
    }

    fn columns(&self, interval: usize) -> Range<usize> {
        let start = self.starts.at(interval);
        start..start + self.lengths.at(interval)
    }

    /// Adds Σ value · Σ (P\[end\] − P\[start\]) over the groups of each row of a block to the row's sum.
    pub(super) fn add_block<const N: usize, C: Count>(
        &self,
        block: usize,
        prefix: &[[f64; N]],
        sums: &mut [[f64; N]; BLOCK_ROWS],
        count: &mut C,
    ) {
        let (groups, mut first) = self.block(block);
        let (mut ends, mut lights) = ([0u32; BLOCK_ROWS], [[0f64; N]; BLOCK_ROWS]);
        for from in groups.clone().step_by(BLOCK_ROWS) {
            let groups = from..groups.end.min(from + BLOCK_ROWS);
            let (ends, lights) = (&mut ends[..groups.len()], &mut lights[..groups.len()]);
            let mut end = 0;
            with_columns!(&self.counts, counts => {
                for (e, count) in ends.iter_mut().zip(&counts[groups.clone()]) {
                    end += count.at() as u32;
                    *e = end;
                }
            });
            with_columns!(&self.starts, s => with_columns!(&self.lengths, l => {
                // SAFETY: `split` and `check_apart` see to intervals that end at lights or before, and `check_groups` to ends
                // that ascend to the block's last; prefix has lights + 1 entries.
                unsafe { kernel::interval_sums(ends, &s[first..], &l[first..], prefix, lights) }
            }));
            with_values!(&self.values, v => {
                let v = v.from(groups.start);
                for (i, (light, &row)) in lights.iter().zip(&self.rows[groups.clone()]).enumerate() {
                    // SAFETY: there is a value for every group.
                    let value = f64::from(unsafe { v.at(i) });
                    sums[usize::from(row)].iter_mut().zip(light).for_each(|(sum, light)| *sum += value * light);
                }
            });
            count.add(2 * end as usize);
            count.multiply_add(groups.len());
            count.factors(groups.map(|g| self.values.at(g)));
            first += end as usize;
        }
    }

    pub(super) fn write(&self, sink: &mut Sink) {
        let (kind, exponent) = self.values.kind();
        sink.put(HEADER, &[kind, exponent, self.counts.width(), self.starts.width(), self.lengths.width()]);
        sink.put(BLOCKS, &self.blocks);
        sink.put(ROWS, &self.rows);
        self.counts.write(sink, COUNTS);
        self.values.write(sink, VALUES);
        self.starts.write(sink, STARTS);
        self.lengths.write(sink, LENGTHS);
    }

    /// Whether a file has runs at all.
    pub(super) fn are_in(source: &Source) -> bool {
        source.has(HEADER)
    }

    pub(super) fn read(shape: Shape, source: &mut Source) -> Result<Intervals> {
        let header: Vec<i32> = source.take_exact(HEADER, 5)?;
        let blocks: Vec<[u64; 2]> = source.take_exact(BLOCKS, shape.rows().div_ceil(BLOCK_ROWS))?;
        let rows: Vec<u8> = source.take(ROWS)?;
        let counts = Whole::read(source, COUNTS, HEADER, header[2])?;
        let values = Values::read(source, VALUES, header[0], header[1], rows.len())?;
        let starts = Whole::read(source, STARTS, HEADER, header[3])?;
        let lengths = Whole::read(source, LENGTHS, HEADER, header[4])?;
        let same = |section, expected, found| match expected == found {
            true => Ok(()),
            false => Err(broken(section, format!("{expected} numbers"), format!("{found} numbers"))),
        };
        same(COUNTS, rows.len(), counts.len())?;
        same(LENGTHS, starts.len(), lengths.len())?;
        let intervals = Intervals { blocks, rows, counts, values, starts, lengths };
        intervals.check_groups(shape)?;
        Ok(intervals)
    }

    /// Blocks begin where the groups and intervals before them end, and name rows that they have, ascending.
    fn check_groups(&self, shape: Shape) -> Result<()> {
        let mut interval = 0;
        for (block, &[group, first]) in self.blocks.iter().enumerate() {
            let end = self.blocks.get(block + 1).map_or(self.rows.len() as u64, |next| next[0]);
            if group > end || end > self.rows.len() as u64 || first != interval as u64 || (block == 0 && group != 0) {
                let expected = format!("groups ascending to {}, {interval} runs before block {block}", self.rows.len());
                return Err(broken(BLOCKS, expected, format!("{group}, {end} and {first}")));
            }
            let groups = group as usize..end as usize;
            let (rows, has) = (&self.rows[groups.clone()], BLOCK_ROWS.min(shape.rows() - block * BLOCK_ROWS));
            if !rows.is_sorted() || rows.last().is_some_and(|&row| usize::from(row) >= has) {
                return Err(broken(ROWS, format!("rows ascending below {has} in block {block}"), format!("{rows:?}")));
            }
            // No overflow: counts are below 2^32, and checked against the runs there are before the next is added.
            for group in groups {
                if self.counts.at(group) == 0 {
                    return Err(broken(COUNTS, "at least one run", format!("none for group {group}")));
                }
                interval += self.counts.at(group);
                if interval > self.starts.len() {
                    break;
                }
            }
        }
        match (interval == self.starts.len(), self.blocks.is_empty() && !self.rows.is_empty()) {
            (true, false) => Ok(()),
            _ => Err(broken(COUNTS, format!("{} runs in all", self.starts.len()), format!("{interval} or more"))),
        }
    }

    /// No two runs of a row share a column, nor does a run share one with a single element, and none goes beyond the lights.
    pub(super) fn check_apart(&self, shape: Shape, singles: &Narrow) -> Result<()> {
        (0..shape.rows()).into_par_iter().try_for_each_init(Vec::new, |ranges, row| {
            ranges.clear();
            ranges.extend(self.row(row).map(|(_, range)| (range.start, range.end)));
            ranges.extend(singles.row_columns(row).map(|col| (col, col + 1)));
            ranges.sort_unstable();
            let apart = ranges.windows(2).all(|w| w[0].1 <= w[1].0) && ranges.iter().all(|r| r.0 < r.1);
            if apart && ranges.last().is_none_or(|r| r.1 <= shape.lights) {
                return Ok(());
            }
            let found = format!("{:?}", &ranges[..ranges.len().min(8)]);
            Err(broken(
                STARTS,
                format!("runs and single elements apart and below {} in row {row}", shape.lights),
                found,
            ))
        })
    }
}
