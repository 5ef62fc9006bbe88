//! Times of short operations: warm-up, many runs, median and spread.

use std::time::{Duration, Instant};

/// How long one figure may take to measure.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Untimed runs before the first timed one, for at least this long and at least once.
    pub warm_up: Duration,
    /// Timed runs go on for at least this long.
    pub time: Duration,
    /// There are at least this many timed runs, however long they take.
    pub least_runs: usize,
    /// And at most this many, however short they are.
    pub most_runs: usize,
}

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Median, ms.
    pub median_ms: f64,
    /// Distance between the quartiles, ms.
    pub spread_ms: f64,
    /// Timed runs.
    pub runs: usize,
}

/// A spread above this part of its median is marked wherever the median is shown.
pub const STEADY: f64 = 0.1;

/// Whether a median is to be read with care.
pub fn is_unsteady(median: Option<f64>, spread: Option<f64>) -> bool {
    median.zip(spread).is_some_and(|(median, spread)| spread > STEADY * median)
}

impl Budget {
    /// At least 7 runs within about `time`, a fifth of it before for warming up.
    pub fn of(time: Duration) -> Budget {
        Budget { warm_up: time / 5, time, least_runs: 7, most_runs: 10_000 }
    }

    /// Runs `work` until the budget is spent; stops at its first error.
    pub fn time<E>(&self, mut work: impl FnMut() -> Result<(), E>) -> Result<Timing, E> {
        let timings = self.race(1, |_| work())?;
        Ok(timings[0])
    }

    /// Runs the works 0 to `count` in turn until the budget of one work, times their number, is spent: whatever slows the
    /// machine for a while slows all of them, so that their medians can be divided by each other. Stops at the first error.
    pub fn race<E>(&self, count: usize, mut work: impl FnMut(usize) -> Result<(), E>) -> Result<Vec<Timing>, E> {
        let share = u32::try_from(count).unwrap_or(u32::MAX);
        let began = Instant::now();
        loop {
            (0..count).try_for_each(&mut work)?;
            if began.elapsed() >= self.warm_up * share {
                break;
            }
        }
        let (began, mut times, mut rounds) = (Instant::now(), vec![Vec::new(); count], 0);
        while rounds < self.least_runs || (began.elapsed() < self.time * share && rounds < self.most_runs) {
            for (i, times) in times.iter_mut().enumerate() {
                let start = Instant::now();
                work(i)?;
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
            rounds += 1;
        }
        Ok(times.iter_mut().map(|times| Timing::of(times)).collect())
    }
}

impl Timing {
    /// Median and quartile distance of `times` in ms, which are sorted; none gives zeros.
    pub fn of(times: &mut [f64]) -> Timing {
        times.sort_by(f64::total_cmp);
        let at = |fraction| quantile(times, fraction);
        Timing { median_ms: at(0.5), spread_ms: at(0.75) - at(0.25), runs: times.len() }
    }
}

/// The value below which `fraction` of ascending values lie, interpolated between its neighbours.
fn quantile(ascending: &[f64], fraction: f64) -> f64 {
    let Some(last) = ascending.len().checked_sub(1) else { return 0.0 };
    let position = fraction * last as f64;
    let (below, above) = (ascending[position.floor() as usize], ascending[position.ceil() as usize]);
    below + (above - below) * position.fract()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_median_and_the_spread_ignore_one_wild_run() {
        let timing = Timing::of(&mut [3.0, 1.0, 1000.0, 2.0, 4.0, 5.0, 2.5]);
        assert_eq!((timing.median_ms, timing.spread_ms, timing.runs), (3.0, 4.5 - 2.25, 7));
    }

    proptest! {
        #[test]
        fn half_of_the_runs_lie_on_each_side_and_scaling_scales(mut times in prop::collection::vec(0.0..100.0f64, 1..30)) {
            let timing = Timing::of(&mut times);
            let below = times.iter().filter(|&&t| t <= timing.median_ms).count();
            let above = times.iter().filter(|&&t| t >= timing.median_ms).count();
            prop_assert!(2 * below >= times.len() && 2 * above >= times.len());
            let doubled = Timing::of(&mut times.iter().map(|t| 2.0 * t).collect::<Vec<_>>());
            prop_assert_eq!((doubled.median_ms, doubled.spread_ms), (2.0 * timing.median_ms, 2.0 * timing.spread_ms));
        }
    }

    #[test]
    fn the_runs_keep_within_their_bounds_and_errors_stop_them() {
        let budget = Budget { warm_up: Duration::ZERO, time: Duration::ZERO, least_runs: 7, most_runs: 9 };
        let mut calls = 0;
        let timing = budget.time(|| {
            calls += 1;
            Ok::<(), ()>(())
        });
        assert_eq!((timing.map(|t| t.runs), calls), (Ok(7), 8));
        let endless = Budget { time: Duration::from_secs(3600), ..budget };
        assert_eq!(endless.time(|| Ok::<(), ()>(())).map(|t| t.runs), Ok(9));
        assert_eq!(budget.time(|| Err("broken")), Err("broken"));
    }

    #[test]
    fn works_of_a_race_take_turns_and_run_equally_often() {
        let budget = Budget { warm_up: Duration::ZERO, time: Duration::ZERO, least_runs: 7, most_runs: 9 };
        let mut order = Vec::new();
        let timings = budget.race(3, |i| {
            order.push(i);
            Ok::<(), ()>(())
        });
        assert_eq!(timings.map(|t| t.iter().map(|t| t.runs).collect::<Vec<_>>()), Ok(vec![7; 3]));
        assert!(order.len() == 3 * 8 && order.iter().enumerate().all(|(at, &i)| i == at % 3), "{order:?}");
        assert_eq!(budget.race(0, |_| Err("broken")), Ok(Vec::new()));
    }
}
