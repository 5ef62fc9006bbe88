//! Where a family of methods fails, as data: sweeps over one parameter of a matrix each.

use crate::signal::Spec;
use prt_transfer::{Result, TransferMatrix};

/// The sweeps that show where the methods of a paper fail.
pub struct Study {
    /// Its name on the command line.
    pub name: &'static str,
    /// What is measured when nobody says otherwise.
    pub methods: &'static [&'static str],
    /// The built-in scene that every sweep starts from.
    pub scene: &'static str,
    /// Its signal.
    pub spec: fn() -> Spec,
    /// Its sweeps.
    pub sweeps: &'static [Sweep],
}

/// Matrices that differ in one parameter. The same base and value give the same matrix.
pub struct Sweep {
    /// On the command line and for file names.
    pub name: &'static str,
    /// What the parameter does.
    pub title: &'static str,
    /// Name of the parameter, unit included.
    pub parameter: &'static str,
    /// The values that are measured on this base, in order.
    pub values: fn(&TransferMatrix) -> Vec<f64>,
    /// The matrix at a value of the parameter.
    pub matrix: fn(&TransferMatrix, f64) -> Result<TransferMatrix>,
}

/// 1, 2, 4, … as long as they are below `most`, then `most` itself.
pub(super) fn doublings(most: usize) -> Vec<f64> {
    let doubled = std::iter::successors(Some(1usize), |n| n.checked_mul(2)).take_while(|n| *n < most);
    doubled.chain([most]).map(|n| n as f64).collect()
}
