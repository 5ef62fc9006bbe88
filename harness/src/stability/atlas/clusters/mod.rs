//! Clusters of samples and components in them: Sloan et al. 2003.

mod allocation;
mod cancellation;
mod duplicates;
mod seeds;
mod tiny;

use super::case::Part;

pub(super) const PART: Part = Part {
    name: "clusters",
    title: "Clustered principal components",
    cases: &[cancellation::CASE, tiny::CASE, duplicates::CASE, seeds::CASE, allocation::CASE],
};
