//! Surface light fields: Miandji et al. 2011.

mod interpolation;
mod poles;
mod seam;

use super::case::Part;

pub(super) const PART: Part = Part {
    name: "light-fields",
    title: "Surface light fields",
    cases: &[poles::CASE, interpolation::CASE, seam::CASE],
};
