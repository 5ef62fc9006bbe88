//! What a model must keep, and what is least among those that keep it.

use super::trial::Trial;
use crate::number;
use clap::ValueEnum;
use std::cmp::Ordering;

/// What a model must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// An error of at most so much.
    Error(f64),
    /// At most so many bytes.
    Bytes(u64),
    /// Relighting one channel on one thread in at most so many ms.
    Relight(f64),
}

/// Which bytes count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Storage {
    /// At rest: the .prt file.
    #[default]
    File,
    /// What relighting holds in memory.
    Resident,
}

/// Which error counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Norm {
    /// Σ(T-T̃)²/ΣT².
    #[default]
    Coefficients,
    /// The same over the sphere, and over the hemisphere of exit radiance.
    Sphere,
}

/// A bound, and how what it bounds is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The bound.
    pub bound: Bound,
    /// Which bytes count.
    pub storage: Storage,
    /// Which error counts.
    pub norm: Norm,
}

/// The logarithm of an error below which none has to be told from another.
pub(super) const NEXT_TO_EXACT: f64 = -18.0;
/// The logarithm of an error that is none.
const EXACT: f64 = -40.0;

impl Goal {
    /// The bytes of a trial that count.
    pub fn bytes(&self, trial: &Trial) -> u64 {
        match self.storage {
            Storage::File => trial.file_bytes,
            Storage::Resident => trial.resident_bytes,
        }
    }

    /// The error of a trial that counts; infinite where it has none of that kind.
    pub fn error(&self, trial: &Trial) -> f64 {
        match self.norm {
            Norm::Coefficients => trial.error,
            Norm::Sphere => trial.error_sphere.unwrap_or(f64::INFINITY),
        }
    }

    /// The logarithm of what is bounded over its bound: at most 0 where the bound is kept.
    pub fn excess(&self, trial: &Trial) -> f64 {
        match self.bound {
            Bound::Error(bound) => ratio(self.error(trial), bound),
            Bound::Bytes(bound) => ratio(self.bytes(trial) as f64, bound as f64),
            Bound::Relight(bound) => ratio(trial.relight_ms.unwrap_or(f64::INFINITY), bound),
        }
    }

    /// The logarithm of what is least in the best model.
    pub fn price(&self, trial: &Trial) -> f64 {
        match self.bound {
            Bound::Error(_) => ratio(self.bytes(trial) as f64, 1.0),
            Bound::Bytes(_) | Bound::Relight(_) => ratio(self.error(trial), 1.0),
        }
    }

    /// By how much the price of a model is above that of another, as a part of it. Errors of next to nothing are not told apart.
    pub fn gap(&self, trial: &Trial, other: &Trial) -> f64 {
        let price = |trial: &Trial| self.price(trial).max(NEXT_TO_EXACT);
        (price(trial) - price(other)).exp_m1()
    }

    /// Whether the bound is kept.
    pub fn keeps(&self, trial: &Trial) -> bool {
        // Not by the logarithm: a figure that equals its bound keeps it.
        match self.bound {
            Bound::Error(bound) => self.error(trial) <= bound,
            Bound::Bytes(bound) => self.bytes(trial) <= bound,
            Bound::Relight(bound) => trial.relight_ms.is_some_and(|ms| ms <= bound),
        }
    }

    /// Whether a larger model rather keeps the bound than a smaller one.
    pub fn is_kept_by_large_models(&self) -> bool {
        matches!(self.bound, Bound::Error(_))
    }

    /// The better of two is less: those that keep the bound first, then by price, error and bytes; else the one nearer to the bound.
    pub fn order(&self, a: &Trial, b: &Trial) -> Ordering {
        let kept = self.keeps(b).cmp(&self.keeps(a));
        let by_price = || {
            let [error, bytes] = [self.error(a).total_cmp(&self.error(b)), self.bytes(a).cmp(&self.bytes(b))];
            self.price(a).total_cmp(&self.price(b)).then(error).then(bytes)
        };
        match self.keeps(a) && self.keeps(b) {
            true => by_price(),
            false => kept.then_with(|| self.excess(a).total_cmp(&self.excess(b))).then_with(by_price),
        }
    }

    /// The bound in words.
    pub fn text(&self) -> String {
        let of = match self.norm {
            Norm::Coefficients => "",
            Norm::Sphere => " over the sphere",
        };
        match self.bound {
            Bound::Error(error) => format!("an error{of} of at most {}", short(error)),
            Bound::Bytes(bytes) => format!("at most {} {}", number::bytes(bytes), self.place()),
            Bound::Relight(ms) => format!("relit within {} ms on one thread", short(ms)),
        }
    }

    /// Where the bytes are that count.
    pub fn place(&self) -> &'static str {
        match self.storage {
            Storage::File => "on disk",
            Storage::Resident => "in memory",
        }
    }

    /// What is bounded of a trial, in words.
    pub fn reached(&self, trial: &Trial) -> String {
        match self.bound {
            Bound::Error(_) => format!("an error of {}", number::short(self.error(trial))),
            Bound::Bytes(_) => number::bytes(self.bytes(trial)),
            Bound::Relight(_) => trial.relight_ms.map_or("no time".into(), |ms| format!("{} ms", number::short(ms))),
        }
    }
}

fn ratio(value: f64, bound: f64) -> f64 {
    if value > 0.0 { (value / bound).ln().max(EXACT) } else { EXACT }
}

/// A bound as it was given, without digits that nobody wrote.
fn short(value: f64) -> String {
    if (1e-2..1e5).contains(&value) { value.to_string() } else { format!("{value:e}") }
}

/// A number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("expected a number above 0".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_keeps_the_bound_is_better_than_any_other_and_then_the_cheaper_one() {
        let trial = |error: f64, file_bytes: u64| Trial { error, file_bytes, ..Trial::default() };
        let goal = |bound| Goal { bound, storage: Storage::File, norm: Norm::Coefficients };
        let (fine, coarse, exact) = (trial(1e-3, 900), trial(0.1, 100), trial(0.0, 5000));
        for (bound, order) in [
            (Bound::Error(1e-2), [&fine, &exact, &coarse]),
            (Bound::Error(1e-3), [&fine, &exact, &coarse]),
            (Bound::Error(1.0), [&coarse, &fine, &exact]),
            (Bound::Bytes(1000), [&fine, &coarse, &exact]),
            (Bound::Bytes(99), [&coarse, &fine, &exact]),
        ] {
            let mut trials = [&exact, &coarse, &fine];
            trials.sort_by(|a, b| goal(bound).order(a, b));
            assert_eq!(trials, order, "{bound:?}");
        }
    }
}
