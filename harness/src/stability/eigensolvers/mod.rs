//! `prt stability eigensolvers`: what the solvers behind principal components lose more than they must, and how long they take.

mod outcome;
pub mod spectra;

use super::Stability;
use crate::machine::Machine;
use crate::progress::Steps;
use crate::timing::Budget;
use crate::{cache, files, interrupt, terminal};
use anyhow::ensure;
use ndarray::{Array2, ArrayView2};
use outcome::Outcome;
use prt_cpca::Solver;
use prt_transfer::params::Value;
use prt_transfer::{Error, Result};
use spectra::{Known, SPECTRA, Spectrum};
use std::time::Duration;

/// On the command line.
pub(super) const NAME: &str = "eigensolvers";

const SOLVERS: [Solver; 5] = [Solver::Power, Solver::Krylov, Solver::Gram, Solver::Svd, Solver::Auto];
/// Samples of a cluster of a glossy signal, and numbers of each: 24 x 25.
const SIZE: (usize, usize) = (136, 600);
/// Components that are sought.
const COMPONENTS: [usize; 5] = [1, 2, 4, 8, 16];
const SEED: u64 = 5;
/// Time for each figure.
const BUDGET: Duration = Duration::from_millis(60);

/// Leading right singular vectors of `rows` (m x n), one a row; fewer than `components` where the solver finds no more.
fn leading(
    solver: Solver,
    rows: ArrayView2<f64>,
    components: usize,
    start: Option<ArrayView2<f64>>,
) -> Result<Array2<f64>> {
    Ok(solver.solver().leading(rows, components, start)?.vectors)
}

/// Runs the study: `--method` names solvers, `--sweep` spectra.
pub(super) fn run(arguments: &Stability, threads: usize) -> anyhow::Result<()> {
    ensure!(arguments.vertices.is_none(), "--vertices: {NAME} are measured on matrices of {} x {}", SIZE.0, SIZE.1);
    let (solvers, spectra) = (chosen_solvers(&arguments.methods)?, chosen_spectra(&arguments.sweeps)?);
    let (out, machine) = (cache::make(arguments.out.clone())?, Machine::here(threads));
    let steps = Steps::new(spectra.len() * COMPONENTS.len() * solvers.len());
    let mut outcomes = Vec::new();
    for spectrum in &spectra {
        steps.show(spectrum.name);
        outcomes.extend(measured(spectrum, SIZE, &COMPONENTS, &solvers, Budget::of(BUDGET), &steps)?);
    }
    steps.finish();
    let path = |extension| out.join(format!("{NAME}.{extension}"));
    let chart = outcome::chart(&spectra, &solvers, SIZE, &outcomes);
    files::write_beside(&path("csv"), &outcome::csv(&outcomes, SIZE, &machine)?)?;
    files::write_beside(&path("svg"), chart.svg(Some(&machine)).as_bytes())?;
    files::write_beside(&path("png"), &chart.png(&machine)?)?;
    terminal::say(outcome::table(&spectra, &solvers, &outcomes))?;
    ensure!(outcomes.iter().any(|o| o.lost.is_ok()), "no solver ended; {} says why", path("csv").display());
    let (legend, machine) = (outcome::LEGEND, machine.line());
    terminal::say(format!("\n{legend}\n{machine}\n{NAME}.csv, .svg and .png are in {}", out.display()))
}

/// Every solver for every number of components on a matrix of a spectrum; solvers take turns, so that their times can be compared.
fn measured(
    spectrum: &'static Spectrum,
    (rows, columns): (usize, usize),
    components: &[usize],
    solvers: &[Solver],
    budget: Budget,
    steps: &Steps,
) -> anyhow::Result<Vec<Outcome>> {
    let known = spectrum.matrix(rows, columns, SEED);
    let mut outcomes = Vec::new();
    for &components in components {
        interrupt::check()?;
        let start = spectrum.start(&known, components);
        let solve =
            |i: usize| leading(solvers[i], known.matrix.view(), components, start.as_ref().map(|start| start.view()));
        let found: Vec<Result<Array2<f64>>> = (0..solvers.len()).map(solve).collect();
        let ended: Vec<usize> = (0..solvers.len()).filter(|&i| found[i].is_ok()).collect();
        let mut times = budget.race(ended.len(), |i| solve(ended[i]).map(drop))?.into_iter();
        for (&solver, found) in solvers.iter().zip(found) {
            let median_ms = if found.is_ok() { times.next().map(|timing| timing.median_ms) } else { None };
            outcomes.push(outcome(spectrum, solver, components, &known, found, median_ms));
        }
        steps.done(solvers.len());
    }
    Ok(outcomes)
}

fn outcome(
    spectrum: &'static Spectrum,
    solver: Solver,
    components: usize,
    known: &Known,
    found: Result<Array2<f64>>,
    median_ms: Option<f64>,
) -> Outcome {
    let lost = found.map(|vectors| known.lost(&vectors)).map_err(|error| error.to_string());
    Outcome { spectrum, solver, components, lost, least: known.least(components), median_ms }
}

fn chosen_solvers(names: &[String]) -> Result<Vec<Solver>> {
    if names.is_empty() {
        return Ok(SOLVERS.into());
    }
    let known = || SOLVERS.map(|solver| solver.show()).join(", ");
    let find = |name: &String| {
        Solver::parse(name).ok_or_else(|| Error::Unknown { what: "solver", name: name.clone(), known: known() })
    };
    names.iter().map(find).collect()
}

fn chosen_spectra(names: &[String]) -> Result<Vec<&'static Spectrum>> {
    if names.is_empty() {
        return Ok(SPECTRA.iter().collect());
    }
    let known = || SPECTRA.iter().map(|s| s.name).collect::<Vec<_>>().join(", ");
    let find = |name: &String| {
        let unknown = || Error::Unknown { what: "spectrum", name: name.clone(), known: known() };
        SPECTRA.iter().find(|spectrum| spectrum.name == name).ok_or_else(unknown)
    };
    names.iter().map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_solver_is_measured_on_every_spectrum_and_stands_in_the_table_the_csv_and_the_chart() {
        let (solvers, spectra) = (chosen_solvers(&[]).unwrap(), chosen_spectra(&[]).unwrap());
        let (size, budget, steps) = ((12, 20), Budget::of(Duration::ZERO), Steps::new(0));
        let all = spectra.iter().flat_map(|s| measured(s, size, &[1, 3], &solvers, budget, &steps).unwrap());
        let outcomes: Vec<Outcome> = all.collect();
        assert_eq!(outcomes.len(), 10 * 2 * 5);
        for o in &outcomes {
            // Nothing beats the optimum; what promises to find it does.
            let excess = o.excess().unwrap();
            assert!(excess > -1e-14 && o.median_ms.is_some(), "{} {}: {excess}", o.spectrum.name, o.solver.show());
            assert!(excess < 1e-12 || o.solver != Solver::Svd, "{}: {excess}", o.spectrum.name);
        }
        let text = outcome::table(&spectra, &solvers, &outcomes);
        assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
        let csv = String::from_utf8(outcome::csv(&outcomes, size, &Machine::here(2)).unwrap()).unwrap();
        assert_eq!(csv.lines().count(), 1 + outcomes.len());
        let svg = outcome::chart(&spectra, &solvers, size, &outcomes).svg(None);
        assert_eq!(svg.matches("<circle").count(), 10 * 2 + 1, "the first solver's, and one in the legend");
    }

    #[test]
    fn an_unknown_solver_or_spectrum_lists_those_that_are_known() {
        let message = chosen_solvers(&["qr".into()]).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains("'qr'") && message.contains("krylov"), "{message}");
        let message = chosen_spectra(&["flat".into()]).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains("'flat'") && message.contains("zero-tail"), "{message}");
    }
}
