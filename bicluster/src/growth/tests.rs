use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::block::{Block, Entry};
use super::candidate::{Candidate, Operation};
use super::*;
use matrices::{COLUMNS, HOSTILE, Rows, matrices, patterned, sparse};

mod matrices;

const CASES: u32 = 2_000;

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

/// What biclusters, in their order, and leftover say of each element.
fn terms(grown: &Grown, rows: usize) -> Vec<[Vec<f64>; COLUMNS]> {
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
    let mut all = Vec::new();
    for row in 0..block.rows.len() as u32 {
        let (others, gained) = toggled(&rows, row);
        let change = gain(block, &others, &terms, &c.cost) - now;
        if !gained {
            all.push((change, Operation::DeleteRow(row)));
        } else if terms.iter().all(|term| is_exact(block, row, term)) {
            all.push((change, Operation::InsertRow(row)));
        }
    }
    for column in (0..block.columns.len() as u32).filter(|&k| c.symbol[k as usize] != super::candidate::NONE) {
        let (others, gained) = toggled(&c.columns, column);
        let others: Vec<_> = others.iter().map(|&k| c.term(k)).collect();
        let change = gain(block, &rows, &others, &c.cost) - now;
        if !gained {
            all.push((change, Operation::DeleteColumn(column)));
        } else if rows.iter().all(|&row| is_exact(block, row, &c.term(column))) {
            all.push((change, Operation::InsertColumn(column)));
        }
    }
    all
}

fn is_exact(block: &Block, row: u32, term: &Entry) -> bool {
    let dictionary = &block.columns[term.column as usize].dictionary;
    dictionary.residual(block.value(row, term.column), block.values[term.symbol as usize]).is_some()
}

/// `items` without `item`, or with it, and whether with.
fn toggled(items: &[u32], item: u32) -> (Vec<u32>, bool) {
    let mut others: Vec<_> = items.iter().copied().filter(|&other| other != item).collect();
    let gained = others.len() == items.len();
    others.extend(gained.then_some(item));
    (others, gained)
}

fn influence(c: &Candidate, operation: Operation) -> i64 {
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
    fn influences_are_the_changes_of_equation_9_and_the_best_is_selected(
        rows in matrices(), cost in costs(), steps in vec((any::<u16>(), any::<bool>()), 1..24),
    ) {
        let block = Block::new(&rows, COLUMNS);
        let mut c = Candidate::new(&block, cost);
        for (pick, greedy) in steps {
            let all = influences(&block, &c);
            for &(change, operation) in &all {
                prop_assert_eq!(influence(&c, operation), change, "{:?}", operation);
            }
            let (now, selected) = (gain(&block, &c.sorted_rows(), &c.terms(), &cost), c.select(&block));
            prop_assert_eq!(c.gain(), now);
            // A column that was refused stays closed, even if rows that forbade it have gone.
            let closed = |operation| matches!(operation, Operation::InsertColumn(k) if c.open[k as usize] == 0);
            let best = all.iter().filter(|&&(_, operation)| !closed(operation)).map(|&(change, _)| change).max();
            prop_assert_eq!(selected.map(|(change, _)| change), best.filter(|&change| change > 0));
            // Steps that are not the best lead to more deletions and changes of value than greed would.
            let next = if greedy { selected } else { all.get(usize::from(pick) % all.len()).copied() };
            let Some((change, operation)) = next else { continue };
            c.conduct(&block, operation);
            let (rows, terms) = (c.sorted_rows(), c.terms());
            prop_assert!(gain(&block, &rows, &terms, &cost) >= now + change);
            prop_assert!(terms.iter().all(|term| rows.iter().all(|&row| is_exact(&block, row, term))));
        }
        c.clear(&block);
        let new = Candidate::new(&block, cost);
        prop_assert_eq!((c.row_keys, c.column_keys, c.has_row, c.has_column), (new.row_keys, new.column_keys, new.has_row, new.has_column));
        prop_assert_eq!((c.open, c.symbol, c.strict), (new.open, new.symbol, new.strict));
    }

    #[test]
    fn biclusters_and_leftover_sum_to_the_input_in_any_order(rows in matrices(), options in options()) {
        let grown = grow(&rows, COLUMNS, &options);
        let mut dense = vec![[0f32; COLUMNS]; rows.len()];
        rows.iter().zip(&mut dense).for_each(|(row, dense)| row.iter().for_each(|&(column, value)| dense[column as usize] = value));
        for (terms, input) in terms(&grown, rows.len()).iter().flatten().zip(dense.iter().flatten()) {
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
            let now = terms(&rest, rows.len()).iter().flatten().filter(|terms| terms.iter().sum::<f64>() != 0.0).count() as i64;
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
        let dense: Vec<_> = terms(&grown, rows.len()).iter().map(|row| row.each_ref().map(|terms| terms.iter().sum::<f64>() as f32)).collect();
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
        for (terms, row) in terms(&grown, rows.len()).iter().zip(&rows) {
            let sum: f64 = terms[0].iter().sum();
            assert_eq!(sum as f32, if row[0].0 == 0 { row[0].1 } else { 0.0 });
        }
    }
}
