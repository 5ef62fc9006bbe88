use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::block::{Block, Entry};
use super::candidate::{Candidate, Operation};
use super::*;

type Rows = Vec<Vec<(u32, f32)>>;

const COLUMNS: usize = 12;
const CASES: u32 = 2_000;

/// Values that visibility has, and values made to break sums.
const QUARTERS: [f32; 4] = [0.25, 0.5, 0.75, 1.0];
const HOSTILE: [f32; 16] = [
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

/// Rows that share patterns, as biclusters need, with one value for most of a column and exceptions.
fn patterned(values: &'static [f32]) -> impl Strategy<Value = Rows> {
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

fn random(values: &'static [f32]) -> impl Strategy<Value = Rows> {
    vec(vec(prop_oneof![2 => Just(0.0), 3 => select(values)], COLUMNS), 1..20).prop_map(|dense| sparse(&dense))
}

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

fn matrices() -> impl Strategy<Value = Rows> {
    prop_oneof![
        patterned(&[1.0]),
        patterned(&QUARTERS),
        patterned(&HOSTILE),
        banded(),
        random(&QUARTERS),
        random(&HOSTILE),
        any_finite()
    ]
}

fn sparse(dense: &[impl AsRef<[f32]>]) -> Rows {
    let row = |row: &[f32]| (0u32..).zip(row.iter().copied()).filter(|e| e.1 != 0.0).collect();
    dense.iter().map(|r| row(r.as_ref())).collect()
}

fn options() -> impl Strategy<Value = Options> {
    let seeds = select(&[Seeds::Random, Seeds::Longest, Seeds::Best][..]);
    (seeds, any::<u64>(), select(&[Objective::Flops, Objective::Bytes][..]))
        .prop_map(|(seeds, seed, objective)| Options { seeds, seed, objective })
}

fn costs() -> impl Strategy<Value = Cost> {
    let of = |objective| [Cost::of_elements(objective), Cost::of_memberships(objective)];
    select([of(Objective::Flops), of(Objective::Bytes)].concat())
}

fn non_zeros(rows: &Rows) -> i64 {
    rows.iter().map(|row| row.len() as i64).sum()
}

/// Values of biclusters and leftover at each element, as `f64` bits in the order given, and in the reverse.
fn sums(grown: &Grown, rows: usize) -> Vec<[Vec<f64>; COLUMNS]> {
    let mut terms: Vec<[Vec<f64>; COLUMNS]> = vec![Default::default(); rows];
    for b in &grown.biclusters {
        for (&row, &(column, value)) in b.rows.iter().flat_map(|row| b.columns.iter().map(move |term| (row, term))) {
            terms[row as usize][column as usize].push(value.into());
        }
    }
    for (row, rest) in terms.iter_mut().zip(&grown.leftover) {
        rest.iter().for_each(|&(column, value)| row[column as usize].push(value.into()));
    }
    terms
}

/// Eq. 9 by its words: M, its residual, their non-zeros.
fn gain(block: &Block, rows: &[u32], terms: &[Entry], cost: &Cost) -> i64 {
    let (mut held, mut residual) = (0, 0);
    for (&row, term) in rows.iter().flat_map(|row| terms.iter().map(move |term| (row, term))) {
        let v = block.value(row, term.column);
        held += i64::from(v != 0.0);
        residual += i64::from(v != block.values[term.symbol as usize]);
    }
    let [r, l] = [rows.len() as i64, terms.len() as i64];
    i64::from(cost.element) * (held - residual)
        - i64::from(cost.row) * r
        - i64::from(cost.column) * l
        - i64::from(cost.base)
}

/// All insertions that residuals allow and all deletions, with their changes of Eq. 9 at the column values of now.
fn influences(block: &Block, c: &Candidate) -> Vec<(i64, Operation)> {
    let (rows, terms) = (c.sorted_rows(), c.terms());
    let now = gain(block, &rows, &terms, &c.cost);
    let exact = |row: u32, term: &Entry| {
        let dictionary = &block.columns[term.column as usize].dictionary;
        dictionary.residual(block.value(row, term.column), block.values[term.symbol as usize]).is_some()
    };
    let mut all = Vec::new();
    for row in 0..block.rows.len() as u32 {
        let (others, gained) = toggled(&rows, row);
        let change = gain(block, &others, &terms, &c.cost) - now;
        if !gained {
            all.push((change, Operation::DeleteRow(row)));
        } else if terms.iter().all(|term| exact(row, term)) {
            all.push((change, Operation::InsertRow(row)));
        }
    }
    for column in (0..block.columns.len() as u32).filter(|&k| c.symbol[k as usize] != super::candidate::NONE) {
        let (others, gained) = toggled(&c.columns, column);
        let others: Vec<_> = others.iter().map(|&k| c.term(k)).collect();
        let change = gain(block, &rows, &others, &c.cost) - now;
        if !gained {
            all.push((change, Operation::DeleteColumn(column)));
        } else if rows.iter().all(|&row| exact(row, &c.term(column))) {
            all.push((change, Operation::InsertColumn(column)));
        }
    }
    all
}

fn toggled(items: &[u32], item: u32) -> (Vec<u32>, bool) {
    let mut others: Vec<_> = items.iter().copied().filter(|&other| other != item).collect();
    let gained = others.len() == items.len();
    others.extend(gained.then_some(item));
    (others, gained)
}

fn kept(c: &Candidate, operation: Operation) -> i64 {
    match operation {
        Operation::InsertRow(row) => c.row_influence(row),
        Operation::DeleteRow(row) => -c.row_influence(row),
        Operation::InsertColumn(column) => c.column_influence(column),
        Operation::DeleteColumn(column) => -c.column_influence(column),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn influences_kept_are_the_changes_of_equation_9(
        rows in matrices(), cost in costs(), steps in vec((any::<u16>(), any::<bool>()), 1..24),
    ) {
        let block = Block::new(&rows, COLUMNS);
        let mut c = Candidate::new(cost);
        c.clear(&block);
        for (pick, greedy) in steps {
            let all = influences(&block, &c);
            for &(change, operation) in &all {
                prop_assert_eq!(kept(&c, operation), change, "{:?}", operation);
            }
            let before = gain(&block, &c.sorted_rows(), &c.terms(), &cost);
            prop_assert_eq!(c.gain(), before);
            // The best, or any: then deletions and changes of value are met more often than greed would meet them.
            let next = if greedy { c.select(&block) } else { all.get(usize::from(pick) % all.len().max(1)).copied() };
            let Some((change, operation)) = next else { continue };
            c.conduct(&block, operation);
            prop_assert!(gain(&block, &c.sorted_rows(), &c.terms(), &cost) >= before + change);
        }
    }

    #[test]
    fn the_best_operation_is_selected(rows in matrices(), cost in costs(), row: u16, column: u16) {
        let block = Block::new(&rows, COLUMNS);
        let row = usize::from(row) % rows.len();
        prop_assume!(!rows[row].is_empty());
        let mut c = Candidate::new(cost);
        c.clear(&block);
        c.insert_row(&block, row as u32);
        c.insert_column(&block, block.rows[row][usize::from(column) % rows[row].len()].column);
        // A column refused once stays closed, so the best of all is a bound, met unless one was.
        loop {
            let best = influences(&block, &c).into_iter().map(|(change, _)| change).max().unwrap_or(0);
            let selected = c.select(&block);
            let refused = (0..block.columns.len()).any(|k| c.open[k] == 0 && !c.has_column[k]);
            match selected {
                Some((change, operation)) => {
                    prop_assert!(change > 0 && change <= best && (change == best || refused));
                    c.conduct(&block, operation);
                }
                None => break prop_assert!(best <= 0 || refused),
            }
        }
    }

    #[test]
    fn biclusters_and_leftover_sum_to_the_input_in_any_order(rows in matrices(), options in options()) {
        let grown = grow(&rows, COLUMNS, &options);
        let mut dense = vec![[0f32; COLUMNS]; rows.len()];
        rows.iter().zip(&mut dense).for_each(|(row, dense)| row.iter().for_each(|&(column, value)| dense[column as usize] = value));
        for (terms, input) in sums(&grown, rows.len()).iter().flatten().zip(dense.iter().flatten()) {
            prop_assert_eq!(terms.iter().sum::<f64>(), f64::from(*input));
            prop_assert_eq!(terms.iter().rev().sum::<f64>(), f64::from(*input));
            let mut sorted = terms.clone();
            sorted.sort_by(f64::total_cmp);
            prop_assert_eq!(sorted.iter().sum::<f64>(), f64::from(*input));
        }
    }

    #[test]
    fn every_bicluster_gains(rows in matrices(), options in options()) {
        let cost = Cost::of_elements(options.objective);
        let grown = grow(&rows, COLUMNS, &options);
        let mut rest = Grown { biclusters: Vec::new(), leftover: rows.clone() };
        let mut left = non_zeros(&rows);
        for b in &grown.biclusters {
            let negative = b.columns.iter().map(|&(column, value)| (column, -value)).collect();
            rest.biclusters.push(Bicluster { rows: b.rows.clone(), columns: negative });
            let now = sums(&rest, rows.len()).iter().flatten().filter(|terms| terms.iter().sum::<f64>() != 0.0).count() as i64;
            prop_assert!(i64::from(cost.element) * (left - now) > cost.taken(b.rows.len(), b.columns.len()));
            left = now;
        }
        prop_assert_eq!(left, non_zeros(&grown.leftover));
    }

    #[test]
    fn lists_are_ascending_and_name_what_there_is(rows in matrices(), options in options()) {
        let grown = grow(&rows, COLUMNS, &options);
        for b in &grown.biclusters {
            prop_assert!(b.rows.is_sorted_by(|a, b| a < b) && b.rows.iter().all(|&row| (row as usize) < rows.len()));
            prop_assert!(b.columns.is_sorted_by(|a, b| a.0 < b.0) && b.columns.iter().all(|term| term.1 != 0.0));
        }
        prop_assert_eq!(grown.leftover.len(), rows.len());
        for row in &grown.leftover {
            prop_assert!(row.is_sorted_by(|a, b| a.0 < b.0) && row.iter().all(|e| e.1 != 0.0 && e.1.is_finite()));
        }
    }

    #[test]
    fn memberships_are_kept_too(rows in patterned(&[1.0]), options in options()) {
        let grown = grow_memberships(&rows, COLUMNS, &options);
        let there = |terms: &Vec<f64>| terms.iter().sum::<f64>();
        let dense: Vec<_> = sums(&grown, rows.len()).iter().map(|row| row.each_ref().map(|terms| there(terms) as f32)).collect();
        prop_assert_eq!(sparse(&dense), rows);
    }

    #[test]
    fn values_that_all_differ_share_nothing(rows in 1..24usize, options in options()) {
        let value = |row, column| 1.0 + (row * COLUMNS + column) as f32 / 7.0;
        let rows: Rows = (0..rows).map(|r| (0..COLUMNS).map(|c| (c as u32, value(r, c))).collect()).collect();
        prop_assert_eq!(grow(&rows, COLUMNS, &options), Grown { biclusters: Vec::new(), leftover: rows });
    }

    #[test]
    fn a_constant_block_is_one_bicluster(r in 3..20u32, l in 3..COLUMNS as u32, value in select(&HOSTILE[..]), options in options()) {
        let columns: Vec<_> = (0..l).map(|column| (column, value)).collect();
        let grown = grow(&vec![columns.clone(); r as usize], COLUMNS, &options);
        prop_assert_eq!(grown.biclusters, vec![Bicluster { rows: (0..r).collect(), columns }]);
        prop_assert!(grown.leftover.iter().all(Vec::is_empty));
    }

    #[test]
    fn a_seed_gives_the_same_biclusters_again(rows in matrices(), options in options()) {
        prop_assert_eq!(grow(&rows, COLUMNS, &options), grow(&rows, COLUMNS, &options));
    }
}

#[test]
fn nothing_grows_from_nothing() {
    for seeds in [Seeds::Random, Seeds::Longest, Seeds::Best] {
        let options = Options { seeds, seed: 0, objective: Objective::Flops };
        for rows in [vec![], vec![vec![]; 3]] {
            assert_eq!(grow(&rows, 0, &options), Grown { biclusters: vec![], leftover: rows });
        }
    }
}

#[test]
fn an_element_is_restored_where_naive_residuals_lose_it() {
    // 1e-30 + 1e30 - 1e30: each residual is an f32, their sum is not 1e-30.
    let mut rows: Rows = vec![vec![(0, 1e30), (1, 1.0), (2, 1.0), (3, 1.0)]; 6];
    rows.extend(vec![vec![(0, 1e-30), (1, 1.0), (2, 1.0), (3, 1.0)]; 6]);
    rows.extend(vec![vec![(1, 1.0), (2, 1.0), (3, 1.0)]; 6]);
    for seed in 0..50 {
        let grown = grow(&rows, 4, &Options { seeds: Seeds::Best, seed, objective: Objective::Flops });
        for (terms, row) in sums(&grown, rows.len()).iter().zip(&rows) {
            let sum: f64 = terms[0].iter().sum();
            assert_eq!(sum as f32, if row[0].0 == 0 { row[0].1 } else { 0.0 });
        }
    }
}
