//! How many components each cluster gets, by what they save and what they cost.
//!
//! Within a cluster the gains descend and every component costs the same, so that taking the best rate first, over all clusters, is
//! optimal up to the last one taken.

use crate::params::Allocation;
use crate::spectra::Spectrum;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// What is paid for: numbers of members' weights and of representatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prices {
    /// Of one weight.
    pub(crate) weight: f64,
    /// Of one vector.
    pub(crate) vector: f64,
}

impl Prices {
    pub(crate) fn of(allocation: Allocation, weight_bytes: usize, vector_bytes: usize) -> Prices {
        match allocation {
            Allocation::Paper => Prices { weight: 1.0, vector: 0.0 },
            Allocation::Bytes => Prices { weight: weight_bytes as f64, vector: vector_bytes as f64 },
        }
    }

    /// Of a component of a cluster with so many members.
    pub(crate) fn component(&self, members: usize) -> f64 {
        members as f64 * self.weight + self.vector
    }
}

/// The next component of a cluster.
struct Next {
    rate: f64,
    cluster: usize,
}

impl Ord for Next {
    fn cmp(&self, other: &Next) -> Ordering {
        self.rate.total_cmp(&other.rate).then(other.cluster.cmp(&self.cluster))
    }
}
impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Next) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Next {
    fn eq(&self, other: &Next) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Next {}

/// Components by cluster, best rate first; `take` is asked with the cluster for each, and answers whether it gets it.
fn greedy(spectra: &[Spectrum], prices: Prices, mut take: impl FnMut(usize, f64) -> Take) -> Vec<usize> {
    let mut counts = vec![0usize; spectra.len()];
    let next = |cluster: usize, count: usize| {
        let spectrum = &spectra[cluster];
        let gain = *spectrum.squares.get(count).filter(|gain| **gain > 0.0)?;
        Some(Next { rate: gain / prices.component(spectrum.members), cluster })
    };
    let mut heap: BinaryHeap<Next> = (0..spectra.len()).filter_map(|cluster| next(cluster, 0)).collect();
    while let Some(Next { cluster, .. }) = heap.pop() {
        match take(cluster, spectra[cluster].squares[counts[cluster]]) {
            Take::It => {
                counts[cluster] += 1;
                heap.extend(next(cluster, counts[cluster]));
            }
            Take::NoMoreOfThis => {}
            Take::Nothing => break,
        }
    }
    counts
}

enum Take {
    It,
    NoMoreOfThis,
    Nothing,
}

/// As many components as a budget pays for.
pub(crate) fn within(spectra: &[Spectrum], prices: Prices, budget: f64) -> Vec<usize> {
    let mut left = budget;
    greedy(spectra, prices, |cluster, _| {
        let price = prices.component(spectra[cluster].members);
        if price > left {
            return Take::NoMoreOfThis;
        }
        left -= price;
        Take::It
    })
}

/// The components that leave no more than `error`, at the least price: the last ones that are not needed are given back.
pub(crate) fn down_to(spectra: &[Spectrum], prices: Prices, error: f64) -> Vec<usize> {
    let mut left: f64 = spectra.iter().map(|s| s.tail(0)).sum();
    let mut counts = greedy(spectra, prices, |_, gain| {
        if left <= error {
            return Take::Nothing;
        }
        left -= gain;
        Take::It
    });
    let last = |cluster: &usize, counts: &[usize]| Some(spectra[*cluster].squares[counts[*cluster].checked_sub(1)?]);
    let mut order: Vec<usize> = (0..spectra.len()).filter(|c| counts[*c] > 0).collect();
    order.sort_by(|a, b| {
        let price = |c: &usize| prices.component(spectra[*c].members);
        price(b).total_cmp(&price(a)).then(a.cmp(b))
    });
    // Summed anew: what was subtracted step by step may have lost the smallest.
    let mut left: f64 = spectra.iter().zip(&counts).map(|(s, count)| s.tail(*count)).sum();
    for cluster in order {
        if let Some(gain) = last(&cluster, &counts).filter(|gain| left + gain <= error) {
            left += gain;
            counts[cluster] -= 1;
        }
    }
    counts
}

/// The price of an allocation, representatives' means included.
pub(crate) fn price(spectra: &[Spectrum], counts: &[usize], prices: Prices) -> f64 {
    let of =
        |(spectrum, count): (&Spectrum, &usize)| prices.vector + *count as f64 * prices.component(spectrum.members);
    spectra.iter().zip(counts).map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spectra() -> impl Strategy<Value = Vec<Spectrum>> {
        let one = (1usize..40, prop::collection::vec(0.0f64..10.0, 0..5)).prop_map(|(members, mut squares)| {
            squares.sort_by(|a, b| b.total_cmp(a));
            Spectrum { members, squares }
        });
        prop::collection::vec(one, 1..4)
    }

    /// Every allocation there is.
    fn all(spectra: &[Spectrum]) -> Vec<Vec<usize>> {
        spectra.iter().fold(vec![vec![]], |all, s| {
            let longer = |counts: Vec<usize>| (0..=s.squares.len()).map(move |c| [&counts[..], &[c]].concat());
            all.into_iter().flat_map(longer).collect()
        })
    }

    fn left(spectra: &[Spectrum], counts: &[usize]) -> f64 {
        spectra.iter().zip(counts).map(|(s, c)| s.tail(*c)).sum()
    }

    proptest! {
        #[test]
        fn a_budget_is_kept_and_spent_within_one_component_of_the_optimum(spectra in spectra(), budget in 0.0f64..400.0) {
            let prices = Prices { weight: 2.0, vector: 30.0 };
            let counts = within(&spectra, prices, budget);
            let spent = |c: &[usize]| price(&spectra, c, prices) - price(&spectra, &vec![0; spectra.len()], prices);
            prop_assert!(spent(&counts) <= budget + 1e-9);
            let affordable = all(&spectra).into_iter().filter(|c| spent(c) <= budget);
            let best = affordable.map(|c| left(&spectra, &c)).fold(f64::INFINITY, f64::min);
            let largest = spectra.iter().flat_map(|s| &s.squares).copied().fold(0.0, f64::max);
            prop_assert!(left(&spectra, &counts) <= best + largest + 1e-9);
        }

        #[test]
        fn a_bound_is_kept_within_one_component_of_the_least_price(spectra in spectra(), part in 0.0f64..1.0) {
            let prices = Prices { weight: 2.0, vector: 30.0 };
            let error = part * left(&spectra, &vec![0; spectra.len()]);
            let counts = down_to(&spectra, prices, error);
            prop_assert!(left(&spectra, &counts) <= error * (1.0 + 1e-12));
            let good = all(&spectra).into_iter().filter(|c| left(&spectra, c) <= error);
            let best = good.map(|c| price(&spectra, &c, prices)).fold(f64::INFINITY, f64::min);
            let dearest = spectra.iter().map(|s| prices.component(s.members)).fold(0.0, f64::max);
            prop_assert!(price(&spectra, &counts, prices) <= best + dearest + 1e-9);
        }

        #[test]
        fn more_components_go_where_members_are_few_if_weights_alone_cost(gain in 1.0f64..9.0) {
            let of = |members| Spectrum { members, squares: vec![gain; 4] };
            let counts = within(&[of(100), of(10)], Prices::of(Allocation::Paper, 4, 100), 40.0);
            prop_assert_eq!(counts, vec![0, 4]);
        }
    }
}
