//! Matrices to grow biclusters in: with and without patterns, with values that sum exactly and values that do not.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

pub(super) type Rows = Vec<Vec<(u32, f32)>>;

pub(super) const COLUMNS: usize = 12;

/// Values that visibility has, and values made to break sums.
const QUARTERS: [f32; 4] = [0.25, 0.5, 0.75, 1.0];
pub(super) const HOSTILE: [f32; 16] = [
    0.1,
    0.2,
    -0.1,
    1.0 / 3.0,
    1e30,
    -1e30,
    1e-30,
    1e-45,
    1e-40,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    16_777_216.0,
    16_777_215.0,
    1.0,
    1.000_000_1,
];

/// On one grid, but their differences are not all of 24 bits.
const WIDE: [f32; 4] = [1.0, 8_388_609.0, 16_777_218.0, 4_194_304.5];

/// Rows that share patterns, as biclusters need, with one value for most of a column and exceptions.
pub(super) fn patterned(values: &'static [f32]) -> impl Strategy<Value = Rows> {
    let patterns = vec(vec(prop_oneof![3 => Just(true), 2 => Just(false)], COLUMNS), 1..4);
    let usual = vec(select(values), COLUMNS);
    let exceptions = vec((0..40usize, 0..COLUMNS, prop_oneof![1 => Just(0.0), 2 => select(values)]), 0..24);
    (patterns, usual, vec(1..8usize, 1..40), exceptions).prop_map(|(patterns, usual, members, exceptions)| {
        let mut dense: Vec<[f32; COLUMNS]> = vec![[0.0; COLUMNS]; members.len()];
        for (row, member) in dense.iter_mut().zip(&members) {
            for (p, pattern) in patterns.iter().enumerate().filter(|(p, _)| member >> p & 1 == 1) {
                let _ = p;
                pattern
                    .iter()
                    .zip(&usual)
                    .zip(row.iter_mut())
                    .filter(|((set, _), _)| **set)
                    .for_each(|((_, v), e)| *e = *v);
            }
        }
        for (row, column, value) in exceptions {
            let rows = dense.len();
            dense[row % rows][column] = value;
        }
        sparse(&dense)
    })
}

fn banded() -> impl Strategy<Value = Rows> {
    (1..40usize, 1..COLUMNS, select(&QUARTERS[..])).prop_map(|(rows, width, value)| {
        (0..rows).map(|r| (r..r + width).filter(|&c| c < COLUMNS).map(|c| (c as u32, value)).collect()).collect()
    })
}

/// Elements independent of each other.
fn random(values: &'static [f32]) -> impl Strategy<Value = Rows> {
    vec(vec(prop_oneof![2 => Just(0.0), 3 => select(values)], COLUMNS), 1..20).prop_map(|dense| sparse(&dense))
}

/// Any bits that are finite: rows of few kinds, with elements left out.
fn any_finite() -> impl Strategy<Value = Rows> {
    let value = any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |v| v.is_finite());
    (vec(vec(value, COLUMNS), 1..4), vec(0..4usize, 1..24), vec(any::<u16>(), 24)).prop_map(|(kinds, rows, masks)| {
        let row = |(kind, mask): (&usize, &u16)| {
            let kind = &kinds[kind % kinds.len()];
            std::array::from_fn::<f32, COLUMNS, _>(|c| if mask >> c & 1 == 1 { kind[c] } else { 0.0 })
        };
        sparse(&rows.iter().zip(&masks).map(row).collect::<Vec<_>>())
    })
}

/// All of them.
pub(super) fn matrices() -> impl Strategy<Value = Rows> {
    prop_oneof![
        patterned(&[1.0]),
        patterned(&QUARTERS),
        patterned(&HOSTILE),
        patterned(&WIDE),
        banded(),
        random(&QUARTERS),
        random(&HOSTILE),
        random(&WIDE),
        any_finite()
    ]
}

pub(super) fn sparse(dense: &[impl AsRef<[f32]>]) -> Rows {
    let row = |row: &[f32]| (0u32..).zip(row.iter().copied()).filter(|e| e.1 != 0.0).collect();
    dense.iter().map(|r| row(r.as_ref())).collect()
}
