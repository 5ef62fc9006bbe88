//! What a label says of the transform.

use crate::icosphere::COUNTS;
use crate::kernel::Kernel;
use prt_transfer::params::Value;
use prt_transfer::{Params, Result};

prt_transfer::choices! {
    /// What the columns of C multiply.
    pub enum Coordinates {
        /// Orthonormal functions of the lobes' span: squared error of a row of C is squared error over the sphere, and rounding is
        /// not amplified by the condition of the lobes.
        Orthonormal = "orthonormal",
        /// The lobes themselves, as in the paper.
        Lobes = "lobes",
    }
}

/// Where lobes stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Centers {
    /// So many vertices of a subdivided icosahedron.
    Count(usize),
    /// Where [`crate::Srbf::with_centers`] was told; a file lists them.
    Given,
}

impl Value for Centers {
    fn parse(text: &str) -> Option<Centers> {
        if text == "given" { Some(Centers::Given) } else { text.parse().ok().map(Centers::Count) }
    }
    fn show(&self) -> String {
        match self {
            Centers::Count(count) => count.to_string(),
            Centers::Given => "given".into(),
        }
    }
    fn expected() -> String {
        format!("{} or given", COUNTS.map(|count| count.to_string()).join(", "))
    }
}

/// What is added to the diagonal of the Gram matrix before it is factored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ridge {
    /// The smallest that bounds the condition, 0 where it is bounded already.
    Auto,
    /// This share of the mean of the diagonal.
    Share(f64),
}

impl Value for Ridge {
    fn parse(text: &str) -> Option<Ridge> {
        if text == "auto" { Some(Ridge::Auto) } else { f64::parse(text).map(Ridge::Share) }
    }
    fn show(&self) -> String {
        match self {
            Ridge::Auto => "auto".into(),
            Ridge::Share(share) => share.show(),
        }
    }
    fn expected() -> String {
        "auto or a number from 0 to 1".into()
    }
}

prt_transfer::params! {
    /// Spherical radial basis functions: lobes spread over the sphere, fitted to texels by least squares over the sphere.
    pub struct SrbfParams: "srbf" {
        /// Lobes: 12, 42, 162, 642 or 2562 vertices of a subdivided icosahedron; or given, by the library.
        centers: Centers = Centers::Count(642),
        /// The kernel's λ, of all lobes; none = from the least angle between centres, so that 642 have a standard deviation of π/40 rad.
        bandwidth: Option<f64> = None,
        /// The lobe: gaussian or abel-poisson.
        kernel: Kernel = Kernel::Gaussian,
        /// Added to the Gram matrix, as a share of its mean diagonal, 0 to 1; auto = the smallest by which its condition is at most 1e8,
        /// none where it is already.
        ridge: Ridge = Ridge::Auto,
        /// What is stored: orthonormal (coordinates in which error is error over the sphere) or lobes (the paper's coefficients).
        coordinates: Coordinates = Coordinates::Orthonormal,
    }
}

/// Refuses parameters outside their ranges.
pub(super) fn check(params: &SrbfParams) -> Result<()> {
    if let Centers::Count(count) = params.centers
        && !COUNTS.contains(&count)
    {
        return Err(SrbfParams::refuse("centers", count, Centers::expected()));
    }
    if let Ridge::Share(share) = params.ridge
        && !(0.0..=1.0).contains(&share)
    {
        return Err(SrbfParams::refuse("ridge", share, Ridge::expected()));
    }
    let Some(bandwidth) = params.bandwidth else { return Ok(()) };
    if params.centers == Centers::Given {
        return Err(SrbfParams::refuse("bandwidth", bandwidth, "none where centers=given: each of them has its own"));
    }
    let [low, high] = params.kernel.bandwidths();
    if !(low..=high).contains(&bandwidth) {
        let expected = format!("none or from {low} to {high} for kernel={}", params.kernel.show());
        return Err(SrbfParams::refuse("bandwidth", bandwidth, expected));
    }
    Ok(())
}
