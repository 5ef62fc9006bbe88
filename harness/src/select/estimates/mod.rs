//! How many components or coefficients a matrix is likely to need, told from its numbers alone: where a search begins, never where it ends.

mod gavish_donoho;
mod mdl;
mod spectrum;
mod tail;

use spectrum::Spectrum;

use super::bound::{Bound, Goal, Norm};
use super::trial::Trial;
use crate::interrupt::Unseen;
use crate::measure::Reference;
use crate::registry::families::Counts;
use anyhow::Result;
use prt_transfer::{Label, Registry};
use std::collections::HashMap;

/// An estimate, and what came of it.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Whose it is.
    pub by: &'static str,
    /// What it counts.
    pub of: &'static str,
    /// How many.
    pub number: usize,
    /// The model that was tried for it.
    pub checked: Option<Trial>,
    /// Whether that keeps the bound.
    pub enough: Option<bool>,
    /// How many the same configuration needs in truth, as far as the search came.
    pub needed: Option<String>,
}

/// What estimates are made of, once for each light transform.
#[derive(Default)]
pub(super) struct Spectra {
    components: HashMap<String, Spectrum>,
    /// What is left of the square by the number of coefficients that each row keeps.
    terms: HashMap<String, Vec<f64>>,
}

impl Spectra {
    /// Where to begin with the method of a label whose first axis counts something, the best guess first.
    pub(super) fn guesses(
        &mut self,
        counts: Counts,
        registry: &Registry,
        label: &Label,
        reference: &Reference,
        goal: &Goal,
    ) -> Result<Vec<Estimate>> {
        match counts {
            Counts::Components => self.components(registry, label, reference, goal),
            Counts::Terms => self.terms(registry, label, reference, goal),
            Counts::Bound | Counts::Other => Ok(Vec::new()),
        }
    }

    fn components(
        &mut self,
        registry: &Registry,
        label: &Label,
        reference: &Reference,
        goal: &Goal,
    ) -> Result<Vec<Estimate>> {
        let clusters = label.codec.params.iter().find(|(name, _)| name == "clusters").map(|(_, value)| value.as_str());
        // Several clusters share out what is in one spectrum here.
        if clusters.is_some_and(|clusters| clusters != "1") {
            return Ok(Vec::new());
        }
        let stage = label.transform.to_string();
        if !self.components.contains_key(&stage) {
            let transformed = registry.method(label)?.transformed(reference.matrix(), &Unseen)?;
            let matrix = transformed.coefficients().unwrap_or(reference.matrix());
            let spectrum = match (goal.norm, transformed.coefficients()) {
                (Norm::Sphere, None) => Spectrum::of(matrix, Some(reference.metric()))?,
                _ => Spectrum::of(matrix, None)?,
            };
            self.components.insert(stage.clone(), spectrum);
        }
        let spectrum = &self.components[&stage];
        let estimate = |by, number| Estimate::new(by, "components", number);
        let mut estimates = Vec::new();
        if let Bound::Error(bound) = goal.bound {
            estimates.push(estimate(tail::NAME, tail::needed(&spectrum.tails(), bound * spectrum.whole)));
        }
        // A model of one cluster among others begins where it must, and is not worth more.
        if clusters.is_none() {
            estimates.push(estimate(mdl::NAME, mdl::rank(&spectrum.values, spectrum.observations)));
            estimates.push(estimate(gavish_donoho::NAME, gavish_donoho::rank(spectrum)));
        }
        Ok(estimates)
    }

    fn terms(
        &mut self,
        registry: &Registry,
        label: &Label,
        reference: &Reference,
        goal: &Goal,
    ) -> Result<Vec<Estimate>> {
        let Bound::Error(bound) = goal.bound else { return Ok(Vec::new()) };
        let stage = label.transform.to_string();
        if !self.terms.contains_key(&stage) {
            let transformed = registry.method(label)?.transformed(reference.matrix(), &Unseen)?;
            let tails = tail::of_rows(transformed.coefficients().unwrap_or(reference.matrix()));
            self.terms.insert(stage.clone(), tails);
        }
        let tails = &self.terms[&stage];
        Ok(vec![Estimate::new(tail::NAME, "coefficients", tail::needed(tails, bound * tails[0]))])
    }
}

impl Estimate {
    fn new(by: &'static str, of: &'static str, number: usize) -> Estimate {
        Estimate { by, of, number, checked: None, enough: None, needed: None }
    }
}

#[cfg(test)]
mod tests;
