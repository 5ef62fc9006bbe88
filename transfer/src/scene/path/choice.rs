//! One of several, with given probabilities, from a uniform number: inversion, so that stratified numbers stay so.

/// A discrete distribution.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    /// Probability of the entry or one before it, up to 1.
    cumulative: Vec<f64>,
}

impl Choice {
    /// Probabilities in proportion to the weights, which are finite and not negative; `None` where they add up to 0.
    pub(super) fn new(weights: impl IntoIterator<Item = f64>) -> Option<Choice> {
        let sums = weights.into_iter().scan(0.0, |sum, weight| {
            *sum += weight;
            Some(*sum)
        });
        let mut cumulative: Vec<f64> = sums.collect();
        let total = *cumulative.last()?;
        cumulative.iter_mut().for_each(|sum| *sum /= total);
        (total > 0.0).then_some(Choice { cumulative })
    }

    /// The entry for `u` from [0, 1), and what `u` still is worth: uniform in [0, 1) again. Entries of weight 0 are never picked.
    pub(super) fn pick(&self, u: f64) -> (usize, f64) {
        let at = self.cumulative.partition_point(|&sum| sum <= u).min(self.cumulative.len() - 1);
        let rest = (u - self.before(at)) / self.probability(at);
        (at, rest.clamp(0.0, 1.0 - f64::EPSILON))
    }

    pub(super) fn probability(&self, at: usize) -> f64 {
        self.cumulative[at] - self.before(at)
    }

    fn before(&self, at: usize) -> f64 {
        if at == 0 { 0.0 } else { self.cumulative[at - 1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_entry_takes_its_share_of_the_interval_and_none_of_weight_zero_is_picked() {
        let weights = [0.0, 3.0, 0.0, 1.0, 4.0, 0.0];
        let choice = Choice::new(weights).unwrap();
        let (n, mut counts, mut rests) = (8000, [0; 6], [0.0; 6]);
        for k in 0..n {
            let (at, rest) = choice.pick((f64::from(k) + 0.5) / f64::from(n));
            counts[at] += 1;
            rests[at] += rest;
        }
        assert_eq!(counts, [0, 3000, 0, 1000, 4000, 0]);
        for k in [1, 3, 4] {
            assert!((rests[k] / f64::from(counts[k]) - 0.5).abs() < 1e-9, "the rest is uniform");
            assert!((choice.probability(k) - weights[k] / 8.0).abs() < 1e-15);
        }
        assert_eq!([choice.pick(0.0).0, choice.pick(1.0 - f64::EPSILON).0], [1, 4]);
        assert!(Choice::new([0.0; 4]).is_none() && Choice::new([]).is_none());
    }
}
