//! Relighting with shared sums.
//!
//! Symbols are looked up without bounds checks: [`Sums`] whose symbols all exist are the only ones there are, since
//! [`Sums::new`] numbers what it lays out and the reader of a file refuses others ([`Sums::check`]).

use crate::sums::{Columns, LANES, Sums};
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};
use prt_transfer::kernel::pack;
use prt_transfer::{Count, Encoded, NoCount, Result};
use rayon::prelude::*;

/// Rows that a thread gathers at a time.
const ROWS: usize = 1 << 14;

/// Products of all rows that differ behind a leading zero, for up to `N` channels.
pub(crate) fn products<const N: usize>(sums: &Sums, lights: ArrayView2<f32>) -> Result<Vec<[f32; N]>> {
    let mut products = vec![[0.0; N]; sums.products() + 1];
    let packed = pack(lights);
    let (mut parts, mut after) = (Vec::with_capacity(sums.blocks.len()), &mut products[1..]);
    for block in sums.starts.windows(2) {
        let (part, next) = after.split_at_mut(block[1].product - block[0].product);
        parts.push(part);
        after = next;
    }
    parts.into_par_iter().enumerate().for_each_init(Vec::new, |symbols, (block, out)| {
        run(sums, block, &packed, symbols, out, &mut NoCount);
    });
    if let Some(rest) = &sums.rest {
        let mut of_rest = Array2::zeros((sums.products(), lights.ncols()));
        rest.apply_into(lights, of_rest.view_mut())?;
        let of_rest = of_rest.axis_iter(Axis(0)).into_par_iter();
        products[1..].par_iter_mut().zip(of_rest).with_min_len(ROWS).for_each(|(product, rest)| {
            product.iter_mut().zip(rest).for_each(|(y, rest)| *y += rest);
        });
    }
    Ok(products)
}

/// The products of one block. `symbols` is scratch.
pub(crate) fn run<const N: usize, C: Count>(
    sums: &Sums,
    block: usize,
    lights: &[[f32; N]],
    symbols: &mut Vec<[f32; N]>,
    out: &mut [[f32; N]],
    count: &mut C,
) {
    let (start, end) = (sums.starts[block], sums.starts[block + 1]);
    symbols.clear();
    symbols.reserve(end.leaf - start.leaf + end.sum - start.sum);
    let mut leaf = 0;
    for (&factor, &run) in sums.factors[start.run..end.run].iter().zip(&sums.runs[start.run..end.run]) {
        let run = start.leaf + leaf..start.leaf + run as usize;
        leaf = run.end - start.leaf;
        if factor != 1.0 {
            count.multiply(run.len());
            count.factors(run.clone().map(|_| factor));
        }
        match &sums.columns {
            Columns::U16(columns) => leaves(columns[run].iter().map(|&c| c.into()), factor, lights, symbols),
            Columns::U32(columns) => leaves(columns[run].iter().map(|&c| c as usize), factor, lights, symbols),
        }
    }
    let inputs = &sums.inputs[start.input..end.input];
    count.add(inputs.len() - (end.sum - start.sum));
    match sums.arities[..] {
        [] => inputs.as_chunks::<2>().0.iter().for_each(|pair| {
            // SAFETY: a sum has only terms that come before it in its block, as the module's documentation says.
            let [a, b] = pair.map(|s| unsafe { *symbols.get_unchecked(usize::from(s)) });
            symbols.push(std::array::from_fn(|c| a[c] + b[c]));
        }),
        _ => {
            let mut rest = inputs;
            for &arity in &sums.arities[start.sum..end.sum] {
                let (terms, after) = rest.split_at(arity.into());
                rest = after;
                symbols.push(add_up(terms.iter().copied(), symbols));
            }
        }
    }
    let (mut terms, mut out) = (&sums.terms[start.term..end.term], out);
    for &[arity, rows] in &sums.groups[start.group..end.group] {
        let (arity, rows) = (arity as usize, rows as usize);
        let (group, rest) = terms.split_at(arity * rows);
        let (products, after) = std::mem::take(&mut out).split_at_mut(rows);
        (terms, out) = (rest, after);
        count.add(rows * (arity - 1));
        let lanes = rows / LANES * LANES;
        let (interleaved, single) = group.split_at(lanes * arity);
        let (of_lanes, of_single) = products.split_at_mut(lanes);
        for (terms, out) in interleaved.chunks_exact(arity * LANES).zip(of_lanes.as_chunks_mut::<LANES>().0) {
            *out = [[0.0; N]; LANES];
            for terms in terms.as_chunks::<LANES>().0 {
                for (out, &term) in out.iter_mut().zip(terms) {
                    // SAFETY: rows have only symbols of their block, all of which are there by now.
                    let symbol = unsafe { symbols.get_unchecked(usize::from(term)) };
                    (0..N).for_each(|c| out[c] += symbol[c]);
                }
            }
        }
        for (terms, out) in single.chunks_exact(arity).zip(of_single) {
            *out = add_up(terms.iter().copied(), symbols);
        }
    }
}

#[inline(always)]
fn leaves<const N: usize>(
    columns: impl Iterator<Item = usize>,
    factor: f32,
    lights: &[[f32; N]],
    symbols: &mut Vec<[f32; N]>,
) {
    if factor == 1.0 {
        symbols.extend(columns.map(|c| lights[c]));
    } else {
        symbols.extend(columns.map(|c| lights[c].map(|x| factor * x)));
    }
}

#[inline(always)]
fn add_up<const N: usize>(terms: impl Iterator<Item = u16>, symbols: &[[f32; N]]) -> [f32; N] {
    terms.fold([0.0; N], |sum, term| {
        let symbol = symbols[usize::from(term)];
        std::array::from_fn(|c| sum[c] + symbol[c])
    })
}

/// Gives each row its product.
pub(crate) fn gather<const N: usize>(sums: &Sums, products: &[[f32; N]], mut out: ArrayViewMut2<f32>) {
    out.axis_chunks_iter_mut(Axis(0), ROWS).into_par_iter().zip(sums.slots.par_chunks(ROWS)).for_each(
        |(mut rows, slots)| {
            let width = rows.ncols();
            match (rows.as_slice_mut(), width) {
                (Some(out), 1) => gather_rows::<1, N>(out, slots, products),
                (Some(out), 2) => gather_rows::<2, N>(out, slots, products),
                (Some(out), 3) => gather_rows::<3, N>(out, slots, products),
                (Some(out), 4) => gather_rows::<4, N>(out, slots, products),
                _ => rows.outer_iter_mut().zip(slots).for_each(|(mut row, &slot)| {
                    row.iter_mut().zip(products[slot as usize]).for_each(|(y, p)| *y = p);
                }),
            }
        },
    );
}

/// [`gather`] for `W` channels without gaps: a copy of a width known only at run time would be a call.
fn gather_rows<const W: usize, const N: usize>(out: &mut [f32], slots: &[u32], products: &[[f32; N]]) {
    for (out, &slot) in out.as_chunks_mut::<W>().0.iter_mut().zip(slots) {
        out.iter_mut().zip(products[slot as usize]).for_each(|(y, p)| *y = p);
    }
}
