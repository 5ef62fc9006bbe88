//! Bisection along the first axis: where a configuration just keeps the bound.

use super::hunt::Hunt;

/// The first place that keeps a bound is one of `low` to `high`: what is below `low` does not, `high` does or is none.
#[derive(Clone, Copy, Debug)]
struct Bracket {
    low: usize,
    high: usize,
}

impl Bracket {
    /// Places of which nothing is known.
    fn width(&self) -> usize {
        self.high - self.low
    }

    /// The first place is at most `at`, or above it. What contradicts what is known counts for nothing.
    fn learn(&mut self, at: usize, at_most: bool) {
        match at_most {
            true => self.high = self.high.min(at).max(self.low),
            false => self.low = self.low.max(at + 1).min(self.high),
        }
    }
}

impl Hunt<'_, '_> {
    /// Narrows down, in the configuration of `point`, the smallest size that keeps the bound, or the largest where the bound is one of bytes or
    /// time, until its neighbour does not. From a `guess` the steps grow; else the first is in the middle.
    pub(super) fn bisect(&mut self, point: &[usize], guess: Option<usize>) {
        let last = self.log.grid.sizes() - 1;
        let upwards = self.log.goal.is_kept_by_large_models();
        // Places in the order in which models come to keep the bound.
        let place = |at: usize| if upwards { at } else { last - at };
        let at = |at: usize| [&[place(at)], &point[1..]].concat();
        let mut bracket = Bracket { low: 0, high: last + 1 };
        for i in 0..=last {
            if let Some(kept) = self.log.known(&at(i)) {
                bracket.learn(i, kept || (upwards && self.log.is_missing(&at(i))));
            }
        }
        let (mut near, mut step, mut halved) = (guess.map(place), 1, true);
        while bracket.width() > 0 && self.left > 0 {
            let Bracket { low, high } = bracket;
            let middle = low.midpoint(high - 1);
            let next = match near {
                Some(guess) => guess.clamp(low, high - 1),
                // By turns where the bound is expected, and in the middle.
                None if halved => self.expected_crossing(&at, low, high).unwrap_or(middle),
                None => middle,
            };
            let Some(kept) = self.attempt(&at(next)) else { return };
            // Nor is there a model above a size of which there is none: of more harmonics than texels tell apart.
            let down = kept || (upwards && self.log.is_missing(&at(next)));
            bracket.learn(next, down);
            halved = 2 * bracket.width() <= high - low;
            // Steps from the guess grow as long as all lead the same way.
            let same_way = if down { low == 0 } else { high == last + 1 };
            near = near.filter(|_| same_way).map(|_| if down { next.saturating_sub(step) } else { next + step });
            step *= 2;
        }
    }

    /// The first place from `low` to before `high` that is expected to keep the bound; else the last.
    fn expected_crossing(&self, at: &dyn Fn(usize) -> Vec<usize>, low: usize, high: usize) -> Option<usize> {
        let models = self.models()?;
        let excess = |i: usize| models.promise(&self.log.grid.places(&at(i))).excess;
        (low..high).find(|&i| excess(i) <= 0.0).or(high.checked_sub(1))
    }
}
