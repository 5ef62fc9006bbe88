//! The largest of many numbers, in time proportional to their count.
//!
//! A number's magnitude and place travel as one integer. Integers have one order, so what is kept never depends on
//! threads: larger magnitudes come first, and of equal ones the smaller place.

/// A magnitude and its place as an integer that sorts in the order of keeping.
pub(crate) fn key(number: f32, place: u32) -> u64 {
    // The bits of a non-negative float ascend with its value; inverted they descend.
    u64::from(!number.abs().to_bits()) << 32 | u64::from(place)
}

/// The place of a key.
pub(crate) fn place(key: u64) -> u32 {
    key as u32
}

/// The magnitude of a key, squared.
fn energy(key: u64) -> f64 {
    f64::from(f32::from_bits(!((key >> 32) as u32))).powi(2)
}

/// Keeps the `terms` largest, in any order.
pub(crate) fn keep_terms(keys: &mut Vec<u64>, terms: usize) {
    if terms < keys.len() {
        keys.select_nth_unstable(terms);
        keys.truncate(terms);
    }
}

/// Keeps the fewest whose dropped rest has a sum of squares of at most `budget`, in any order.
pub(crate) fn keep_energy(keys: &mut Vec<u64>, budget: f64) {
    // Bisection: keys before `kept` stay, those from `end` are dropped and paid for, those between are open.
    let (mut kept, mut end, mut budget) = (0, keys.len(), budget);
    while kept < end {
        let middle = (kept + end) / 2;
        keys[kept..end].select_nth_unstable(middle - kept);
        let cost: f64 = keys[middle..end].iter().copied().map(energy).sum();
        if cost <= budget {
            budget -= cost;
            end = middle;
        } else {
            kept = middle + 1;
        }
    }
    keys.truncate(end);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The same by sorting.
    fn sorted(numbers: &[f32]) -> Vec<u64> {
        let mut keys: Vec<u64> = numbers.iter().enumerate().map(|(i, &v)| key(v, i as u32)).collect();
        keys.sort_by(|&a, &b| {
            let (x, y) = (numbers[place(a) as usize].abs(), numbers[place(b) as usize].abs());
            y.total_cmp(&x).then(place(a).cmp(&place(b)))
        });
        keys
    }

    proptest! {
        #[test]
        fn the_kept_are_the_first_of_the_sorted(numbers in prop::collection::vec(-4i8..=4, 0..40), terms in 0usize..45, budget in 0u32..200) {
            let numbers: Vec<f32> = numbers.into_iter().map(f32::from).collect();
            let (order, mut keys) = (sorted(&numbers), sorted(&numbers));
            keys.reverse();
            let mut by_energy = keys.clone();
            keep_terms(&mut keys, terms);
            keys.sort_unstable();
            prop_assert_eq!(&keys[..], &order[..terms.min(order.len())]);

            keep_energy(&mut by_energy, budget.into());
            by_energy.sort_unstable();
            let rest = |kept: usize| order[kept..].iter().map(|&k| numbers[place(k) as usize].powi(2)).sum::<f32>();
            let fewest = (0..=order.len()).find(|&kept| rest(kept) <= budget as f32).unwrap();
            prop_assert_eq!(&by_energy[..], &order[..fewest]);
        }
    }
}
