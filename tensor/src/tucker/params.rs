//! What a decomposition is asked for.

use prt_transfer::{Error, Result};

prt_transfer::choices! {
    /// How factors are found.
    pub enum Algorithm {
        /// Leading left singular vectors of each mode of the array (De Lathauwer, De Moor and Vandewalle 2000a).
        Hosvd = "hosvd",
        /// Mode after mode, each of what those before it left: cheaper, and as a rule more exact (Vannieuwenhoven, Vandebril and
        /// Meerbergen 2012).
        Sequential = "st-hosvd",
        /// From there, factors in turn, each the best with the others fixed (De Lathauwer, De Moor and Vandewalle 2000b).
        Hooi = "hooi",
        /// As `Sequential` with singular vectors of a random sketch (Halko, Martinsson and Tropp 2011; Minster, Saibaba and Kilmer 2020).
        Randomised = "randomised",
    }
}

/// How large the core is.
#[derive(Clone, Debug, PartialEq)]
pub enum Ranks {
    /// So many columns of each factor, each at least 1; fewer where fewer represent the same.
    Given(Vec<usize>),
    /// As few as keep this bound on ‖T - T̃‖²/‖T‖², from 1e-12 to 1. Nothing can be left out: no slice of the core is small enough.
    MaxError(f64),
}

/// In which order `Sequential`, `Randomised` and the start of `Hooi` truncate modes.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// By ascending size, so that the largest modes are decomposed when the array is small (Vannieuwenhoven et al., §6.4).
    Ascending,
    /// These: each mode once.
    Given(Vec<usize>),
}

/// A Tucker decomposition's parameters.
///
/// ```
/// use prt_tensor::tucker::{Algorithm, Decomposer, Ranks, TuckerParams};
///
/// let params = TuckerParams { algorithm: Algorithm::Hooi, ranks: Ranks::Given(vec![2, 2, 2]), ..Default::default() };
/// assert!(Decomposer::new(params).is_ok());
/// assert!(Decomposer::new(TuckerParams { ranks: Ranks::Given(vec![2, 0]), ..Default::default() }).is_err());
/// assert!(Decomposer::new(TuckerParams { ranks: Ranks::MaxError(2.0), ..Default::default() }).is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TuckerParams {
    /// How factors are found.
    pub algorithm: Algorithm,
    /// How many columns they have.
    pub ranks: Ranks,
    /// In which order modes are truncated; `Hosvd` knows none.
    pub order: Order,
    /// Sweeps of `Hooi` over all modes at most, 1 to 10000.
    pub sweeps: usize,
    /// `Hooi` ends at a sweep that lowers the error by no more than this part of it, 0 to 1 (without 1).
    pub tolerance: f64,
    /// Columns of a sketch beyond the rank, 1 to 1000.
    pub oversampling: usize,
    /// Multiplications of a sketch by X Xᵀ, 0 to 100: each makes small singular values smaller and costs two reads of the array.
    pub power_iterations: usize,
    /// Of sketches.
    pub seed: u64,
}

impl Default for TuckerParams {
    fn default() -> TuckerParams {
        TuckerParams {
            algorithm: Algorithm::Sequential,
            ranks: Ranks::MaxError(1e-3),
            order: Order::Ascending,
            sweeps: 50,
            tolerance: 1e-4,
            oversampling: 8,
            power_iterations: 1,
            seed: 0,
        }
    }
}

/// The least bound on the relative squared error: squares of singular values are known to some 1e-13 of their sum.
const LEAST_ERROR: f64 = 1e-12;

impl TuckerParams {
    /// Refuses what no array can be decomposed with.
    pub(super) fn check(&self) -> Result<()> {
        match &self.ranks {
            Ranks::Given(ranks) if ranks.contains(&0) => {
                return Err(refuse("ranks", format!("{ranks:?}"), "1 or more for each mode"));
            }
            Ranks::MaxError(error) if !(LEAST_ERROR..=1.0).contains(error) => {
                return Err(refuse("max_error", error, format!("from {LEAST_ERROR:e} to 1")));
            }
            _ => {}
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(refuse("tolerance", self.tolerance, "from 0 to below 1"));
        }
        let [sweeps, oversampling, powers] = [self.sweeps, self.oversampling, self.power_iterations];
        for (name, value, [least, most]) in [
            ("sweeps", sweeps, [1, 10_000]),
            ("oversampling", oversampling, [1, 1000]),
            ("power_iterations", powers, [0, 100]),
        ] {
            if !(least..=most).contains(&value) {
                return Err(refuse(name, value, format!("from {least} to {most}")));
            }
        }
        Ok(())
    }

    /// The modes of an array of this shape, in order. Refuses ranks and orders of another number of modes.
    pub(super) fn modes(&self, shape: &[usize]) -> Result<Vec<usize>> {
        if shape.is_empty() {
            return Err(Error::Unsupported {
                what: "Tucker decomposition".into(),
                expected: "one mode or more".into(),
                found: "an array of none".into(),
            });
        }
        if let Ranks::Given(ranks) = &self.ranks {
            Error::expect_size("ranks of a Tucker decomposition", shape.len(), ranks.len())?;
        }
        let mut ascending: Vec<usize> = (0..shape.len()).collect();
        match &self.order {
            Order::Ascending => ascending.sort_by_key(|mode| shape[*mode]),
            Order::Given(order) => {
                let mut sorted = order.clone();
                sorted.sort_unstable();
                if sorted != ascending {
                    return Err(refuse("order", format!("{order:?}"), format!("each of {ascending:?} once")));
                }
                return Ok(order.clone());
            }
        }
        Ok(ascending)
    }
}

fn refuse(name: &str, value: impl ToString, expected: impl Into<String>) -> Error {
    Error::Parameter { method: "tucker".into(), name: name.into(), value: value.to_string(), expected: expected.into() }
}
