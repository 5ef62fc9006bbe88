//! Numbers of any method: sums, steps, scales.

mod bits;
mod range;
mod scale;
mod sums;

use super::case::Part;

pub(super) const PART: Part = Part {
    name: "numbers",
    title: "Numbers of all methods",
    cases: &[sums::CASE, range::CASE, scale::LARGE, scale::SMALL, scale::DENORMAL, bits::CASE],
};
