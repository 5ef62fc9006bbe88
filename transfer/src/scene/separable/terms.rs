//! How many terms a BRDF is cut to.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// A number of terms, written `16`, or the fewest that hold a part of the sum of singular values, written `90%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Terms {
    /// This many; at least 1, and at most as many as the BRDF has.
    Count(usize),
    /// The least number whose singular values add up to this percentage of
    /// [all](super::SeparableBrdf::singular_values); above 0, at most 100.
    Percent(f64),
}

impl Terms {
    /// The number of terms that this means for descending singular values.
    pub(super) fn count(self, singular_values: &[f64]) -> Result<usize> {
        // Smaller singular values have functions that quadrature does not determine.
        let rank = singular_values.iter().take_while(|sigma| **sigma > 1e-6 * singular_values[0]).count();
        match self {
            _ if rank == 0 => Err(refuse(&self.to_string(), "none: a black BRDF has no terms".into())),
            Terms::Count(count) if (1..=rank).contains(&count) => Ok(count),
            Terms::Percent(percent) if percent > 0.0 && percent <= 100.0 => {
                let aim = percent / 100.0 * singular_values.iter().sum::<f64>();
                let mut sum = 0.0;
                let reached = singular_values.iter().position(|sigma| {
                    sum += sigma;
                    sum >= aim
                });
                Ok(reached.map_or(rank, |k| k + 1).min(rank))
            }
            Terms::Count(_) => Err(refuse(&self.to_string(), format!("from 1 to {rank}, or a percentage"))),
            Terms::Percent(_) => Err(refuse(&self.to_string(), "above 0 % and at most 100 %".into())),
        }
    }
}

fn refuse(value: &str, expected: String) -> Error {
    Error::Parameter { method: "separable BRDF".into(), name: "terms".into(), value: value.into(), expected }
}

impl FromStr for Terms {
    type Err = Error;

    fn from_str(text: &str) -> Result<Terms> {
        let parsed = match text.strip_suffix('%') {
            Some(percent) => percent.parse().ok().filter(|p: &f64| p.is_finite()).map(Terms::Percent),
            None => text.parse().ok().map(Terms::Count),
        };
        parsed.ok_or_else(|| refuse(text, "a whole number such as 16, or a percentage such as 90%".into()))
    }
}

impl fmt::Display for Terms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Terms::Count(count) => write!(f, "{count}"),
            Terms::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}
