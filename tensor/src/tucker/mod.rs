//! Tucker decompositions of arrays of any number of modes.
//!
//! T ≈ T̃ = G ×_1 U_1 ×_2 … ×_N U_N with a core G (R_1 x … x R_N) and factors U_n (I_n x R_n) of orthonormal columns, G being T in the
//! coordinates of the factors. Then ‖T - T̃‖² = ‖T‖² - ‖G‖². Four algorithms ([`Algorithm`]) find the factors; whichever it was, what
//! they return is in the form of a HOSVD: slices of the core in each mode are orthogonal to one another and descend in norm, and of
//! each column of a factor the element of largest magnitude is positive.
//!
//! | algorithm | squared error | cost, in products of T with a factor |
//! | --- | --- | --- |
//! | `hosvd` | at most the sum of tails of all modes, so at most N times the least | N Gram matrices, one projection |
//! | `st-hosvd` | the same bound, as a rule less | Gram matrices of an array that shrinks from mode to mode |
//! | `hooi` | at most that of `st-hosvd`: each factor is the best with the others fixed | N projections for each sweep |
//! | `randomised` | close to `st-hosvd` where singular values decay | as `st-hosvd`, of R + oversampling instead of I columns |
//!
//! Data are f32; Gram matrices, sums, core and factors f64. Squaring is safe there: what a Gram matrix cannot see, 1e-13 of the
//! energy, is the rounding of f32 itself. Nothing is unfolded, results are the same on any number of threads.
//!
//! Vectors of a mode cost as much as the eigenvectors of a matrix of its size, or of the product of the others where that is smaller:
//! 0.3 s at 1024, some 10 s at 3300. From 1024 on iterating comes first where at most a sixteenth of them is wanted: it finds those of
//! a spectrum that decays. Where it does not end all are computed; but above 4096, where ranks are given, what it found is taken and
//! [`Report::converged`] is false.
//!
//! ```
//! use ndarray::Array3;
//! use prt_tensor::tucker::{Decomposer, Ranks, TuckerParams};
//! use prt_transfer::progress::Quiet;
//!
//! // A smooth function of three variables.
//! let t = Array3::from_shape_fn((20, 30, 40), |(i, j, k)| (1.0 + i as f32 + 0.5 * j as f32 + 0.25 * k as f32).recip()).into_dyn();
//! let tucker = Decomposer::new(TuckerParams { ranks: Ranks::MaxError(1e-6), ..Default::default() })?.decompose(t.view(), &Quiet)?;
//!
//! let near = tucker.reconstruct();
//! let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
//! let error = squares(&mut t.iter().zip(&near).map(|(t, near)| f64::from(*t) - near)) / squares(&mut t.iter().map(|t| f64::from(*t)));
//! assert!(error <= 1e-6 && (error - tucker.relative_error()).abs() < 1e-12);
//! // 24,000 numbers in less than 500.
//! assert!(tucker.numbers() < 500, "{:?}", tucker.ranks());
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod decompose;
mod hooi;
mod krylov;
mod leading;
mod model;
mod params;
mod report;
mod truncate;
mod unfold;

pub use decompose::Decomposer;
pub use params::{Algorithm, Order, Ranks, TuckerParams};
pub use report::Report;

pub(crate) use leading::leading_rows;

use model::Model;
use ndarray::{Array2, ArrayD};

/// Core and factors of an array.
#[derive(Clone, Debug)]
pub struct Tucker {
    model: Model,
    energy: f64,
    relative_error: f64,
    report: Report,
}

impl Tucker {
    /// G, R_1 x … x R_N.
    pub fn core(&self) -> &ArrayD<f64> {
        &self.model.core
    }

    /// U_n, I_n x R_n, of orthonormal columns.
    pub fn factors(&self) -> &[Array2<f64>] {
        &self.model.factors
    }

    /// R_n.
    pub fn ranks(&self) -> &[usize] {
        self.model.core.shape()
    }

    /// Elements of core and factors.
    pub fn numbers(&self) -> usize {
        self.model.core.len() + self.model.factors.iter().map(Array2::len).sum::<usize>()
    }

    /// T̃ = G ×_1 U_1 … ×_N U_N, I_1 x … x I_N.
    pub fn reconstruct(&self) -> ArrayD<f64> {
        self.model.reconstruct()
    }

    /// ‖T‖².
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// ‖T - T̃‖²/‖T‖², 0 for an array of zeros: from energies (exact to 1e-14 or so) above 1e-8, else measured.
    pub fn relative_error(&self) -> f64 {
        self.relative_error
    }

    /// How it went.
    pub fn report(&self) -> &Report {
        &self.report
    }
}
