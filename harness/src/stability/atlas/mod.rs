//! The atlas of failure: every known way in which a method fails, driven from harmless to hopeless, by the paper's form and by ours.
//!
//! A case is a file with a [`Case`] in it, and its name in its part.

mod biclusters;
pub mod case;
pub mod chart;
mod clusters;
pub mod csv;
mod eigenvectors;
mod ground;
mod hemisphere;
mod light_fields;
mod lobes;
mod numbers;
mod outcome;
pub mod run;
pub mod table;
mod tensors;
mod wavelets;

pub use outcome::{Atlas, Figure, Outcome, Point};

use crate::interrupt;
use crate::progress::Steps;
use case::{Case, Form, Part};
use prt_transfer::{Error, Result};
use rayon::prelude::*;

/// Every part.
pub static PARTS: [Part; 9] = [
    eigenvectors::PART,
    clusters::PART,
    hemisphere::PART,
    lobes::PART,
    tensors::PART,
    wavelets::PART,
    biclusters::PART,
    light_fields::PART,
    numbers::PART,
];

/// Parts with some of their cases.
pub type Chosen = Vec<(&'static Part, Vec<&'static Case>)>;

/// Cases whose own or whose part's name is among `names`; all of them where there are none.
///
/// # Errors
/// A name that is neither.
pub fn chosen(names: &[String]) -> Result<Chosen> {
    let known =
        || PARTS.iter().flat_map(|part| std::iter::once(part.name).chain(part.cases.iter().map(|case| case.name)));
    if let Some(name) = names.iter().find(|name| known().all(|known| known != *name)) {
        return Err(Error::Unknown { what: "case", name: name.clone(), known: known().collect::<Vec<_>>().join(", ") });
    }
    let is_chosen =
        |part: &Part, case: &Case| names.is_empty() || names.iter().any(|name| name == part.name || name == case.name);
    let cases = |part: &'static Part| part.cases.iter().filter(|case| is_chosen(part, case)).collect::<Vec<_>>();
    Ok(PARTS.iter().map(|part| (part, cases(part))).filter(|(_, cases)| !cases.is_empty()).collect())
}

/// Runs cases, all values of all of them side by side on the current pool.
///
/// # Errors
/// An interruption. What a form fails with is its figure.
pub fn measure(chosen: Chosen, steps: &Steps) -> Result<Atlas> {
    steps.more(chosen.iter().flat_map(|(_, cases)| cases).map(|case| case.values.len()).sum());
    steps.show("where methods fail");
    let point = |case: &Case, value: f64| {
        interrupt::check()?;
        let of = |form: &Form| outcome::figure((form.figure)(value));
        let point = Point { value, printed: of(&case.printed), here: of(&case.here) };
        steps.done(1);
        Ok(point)
    };
    let outcome = |case: &&'static Case| {
        let points = case.values.par_iter().map(|value| point(case, *value)).collect::<Result<_>>()?;
        Ok(Outcome { case, points })
    };
    let of_part = |(part, cases): (_, Vec<_>)| Ok((part, cases.par_iter().map(outcome).collect::<Result<_>>()?));
    Ok(Atlas { parts: chosen.into_par_iter().map(of_part).collect::<Result<_>>()? })
}
