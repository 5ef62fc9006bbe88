//! Surface light fields: Miandji et al. 2011.

mod interpolation;
mod poles;
mod seam;

use super::case::Part;
use prt_slf::{Interpolation, Rows, Sphere, SurfaceLightField};
use prt_transfer::texels::{Border, Texels};
use prt_transfer::{Result, Shape};

pub(super) const PART: Part = Part {
    name: "light-fields",
    title: "Surface light fields",
    cases: &[poles::CASE, interpolation::CASE, seam::CASE],
};

/// A field of one grey texel, with a radiance in each direction of the sphere.
fn field(sphere: Sphere, radiance: &[f32], interpolation: Interpolation) -> Result<SurfaceLightField<Rows>> {
    let rows = Rows::new([radiance; 3].concat(), Shape::new(1, 3, radiance.len())?)?;
    SurfaceLightField::new(Texels { width: 1, height: 1, border: Border::Clamp }, sphere, rows, interpolation)
}
