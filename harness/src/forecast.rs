//! How long a run still takes: from what each of its steps was thought to take, corrected by what the finished ones took.

use std::time::Duration;

/// Weight of the first guess, in seconds of it: the correction is gentle until as much has been measured.
const TRUST: f64 = 5.0;

/// Steps in their order, each with a guess.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Of the steps ahead, s; the next one last.
    ahead: Vec<f64>,
    /// Guesses of the finished steps together, s.
    guessed: f64,
    /// What they took, s.
    taken: f64,
}

impl Forecast {
    /// A run of so many steps, by guesses in seconds.
    pub fn new(mut guesses: Vec<f64>) -> Forecast {
        guesses.reverse();
        Forecast { ahead: guesses, guessed: 0.0, taken: 0.0 }
    }

    /// The next step is finished and took so long.
    pub fn took(&mut self, time: Duration) {
        if let Some(guess) = self.ahead.pop() {
            self.guessed += guess;
            self.taken += time.as_secs_f64();
        }
    }

    /// The next steps need not be done: they say nothing of how fast this machine is.
    pub fn skip(&mut self, steps: usize) {
        self.ahead.truncate(self.ahead.len().saturating_sub(steps));
    }

    /// What the steps ahead will take, as far as the finished ones can tell.
    pub fn left(&self) -> Duration {
        let pace = (self.taken + TRUST) / (self.guessed + TRUST);
        Duration::from_secs_f64(pace * self.ahead.iter().sum::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_machine_that_is_three_times_slower_is_told_from_its_first_steps() {
        let mut forecast = Forecast::new(vec![10.0; 20]);
        assert_eq!(forecast.left(), Duration::from_secs(200));
        (0..10).for_each(|_| forecast.took(Duration::from_secs(30)));
        let left = forecast.left().as_secs_f64();
        assert!((280.0..300.0).contains(&left), "{left}");
    }

    proptest! {
        #[test]
        fn steps_that_take_what_was_guessed_leave_the_sum_of_the_others(guesses in prop::collection::vec(0.1..9.0f64, 1..40), done in 0usize..40) {
            let done = done.min(guesses.len());
            let mut forecast = Forecast::new(guesses.clone());
            guesses[..done].iter().for_each(|g| forecast.took(Duration::from_secs_f64(*g)));
            let left: f64 = guesses[done..].iter().sum();
            prop_assert!((forecast.left().as_secs_f64() - left).abs() < 1e-6);
        }

        #[test]
        fn what_is_skipped_is_not_waited_for_and_changes_no_pace(guesses in prop::collection::vec(0.1..9.0f64, 3..40)) {
            let mut forecast = Forecast::new(guesses.clone());
            forecast.skip(2);
            prop_assert!((forecast.left().as_secs_f64() - guesses[2..].iter().sum::<f64>()).abs() < 1e-6);
            forecast.skip(guesses.len());
            forecast.took(Duration::from_secs(1000));
            prop_assert_eq!(forecast.left(), Duration::ZERO);
        }
    }
}
