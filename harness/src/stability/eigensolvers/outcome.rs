//! What a solver lost and took.

use super::spectra::Spectrum;
use crate::charts::curves::{Curves, Dot, Plane};
use crate::machine::Machine;
use crate::number;
use crate::table::aligned;
use prt_cpca::Solver;
use prt_transfer::params::Value;

/// One solver on one spectrum.
pub(super) struct Outcome {
    pub(super) spectrum: &'static Spectrum,
    pub(super) solver: Solver,
    /// That were sought.
    pub(super) components: usize,
    /// ‖F - F VᵀV‖² / ‖F‖², or why the solver failed.
    pub(super) lost: Result<f64, String>,
    /// The optimum of the same.
    pub(super) least: f64,
    /// On one thread.
    pub(super) median_ms: Option<f64>,
}

/// What the table and the chart show.
pub(super) const LEGEND: &str = "excess: (‖F - F VᵀV‖² - Σ_{i>k} s_i²) / ‖F‖², what is lost beyond what k components must lose; below 1e-14 is rounding\n\
time: one thread, median, ms";

/// Excess that cannot be told from rounding; the chart's lowest line.
const ROUNDING: f64 = 1e-14;

impl Outcome {
    /// (‖F - F VᵀV‖² - Σ_{i>k} s_i²) / ‖F‖²; below 0 by rounding.
    pub(super) fn excess(&self) -> Option<f64> {
        self.lost.as_ref().ok().map(|lost| lost - self.least)
    }
}

/// A panel for each spectrum, a curve for each solver over the number of components.
pub(super) fn chart(
    spectra: &[&'static Spectrum],
    solvers: &[Solver],
    (rows, columns): (usize, usize),
    outcomes: &[Outcome],
) -> Curves {
    let dot = |o: &Outcome| Dot {
        x: o.median_ms.unwrap_or(f64::NAN),
        y: o.excess().map_or(f64::NAN, |excess| excess.max(ROUNDING)),
        label: String::new(),
    };
    let plane = |spectrum: &&'static Spectrum| {
        let of = |solver: &Solver| {
            let on = outcomes.iter().filter(|o| o.spectrum.name == spectrum.name && o.solver == *solver);
            on.map(dot).collect()
        };
        let (upwards, across) = (format!("{}: excess error", spectrum.title), "one thread, ms (median)".into());
        Plane { upwards, across, curves: solvers.iter().map(of).collect(), references: Vec::new() }
    };
    Curves {
        title: "Eigen-solvers: what is lost beyond the optimum, against time".into(),
        subject: format!("{rows} x {columns}, 1 to 16 components along each line; what lies at 10⁻¹⁴ is rounding"),
        apart: false,
        remark: None,
        names: solvers.iter().map(Value::show).collect(),
        planes: spectra.iter().map(plane).collect(),
    }
}

/// Excess and time of each solver for the most components; reasons of those that failed.
pub(super) fn table(spectra: &[&'static Spectrum], solvers: &[Solver], outcomes: &[Outcome]) -> String {
    let names = solvers.iter().flat_map(|solver| [solver.show(), "ms".into()]);
    let titles: Vec<String> = ["spectrum".into(), "k".into()].into_iter().chain(names).collect();
    let most = outcomes.iter().map(|o| o.components).max().unwrap_or(0);
    let short = |figure: Option<f64>| figure.map_or_else(|| "-".into(), number::short);
    let lines = spectra.iter().map(|spectrum| {
        let cells = solvers.iter().flat_map(|solver| {
            let on = |o: &&Outcome| o.spectrum.name == spectrum.name && o.solver == *solver && o.components == most;
            let o = outcomes.iter().find(on);
            let excess = o.and_then(Outcome::excess).map(|excess| if excess < ROUNDING { 0.0 } else { excess });
            [short(excess), short(o.and_then(|o| o.median_ms))]
        });
        [spectrum.name.into(), most.to_string()].into_iter().chain(cells).collect()
    });
    let lines: Vec<Vec<String>> = lines.collect();
    let failed = outcomes.iter().filter_map(|o| Some((o, o.lost.as_ref().err()?)));
    let failed = failed.map(|(o, why)| format!("{}, {} of {}: {why}", o.spectrum.name, o.solver.show(), o.components));
    std::iter::once(aligned(&titles, lines.into_iter())).chain(failed).collect::<Vec<_>>().join("\n")
}

/// One line for each outcome, with the machine in every line.
pub(super) fn csv(outcomes: &[Outcome], (rows, columns): (usize, usize), machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "spectrum",
        "solver",
        "components",
        "rows",
        "columns",
        "status",
        "reason",
        "lost",
        "least",
        "excess",
        "median_ms",
        "machine",
    ])?;
    let text = |figure: Option<f64>| figure.map_or(String::new(), |f| f.to_string());
    for o in outcomes {
        let (status, reason) = o.lost.as_ref().map_or_else(|why| ("failed", why.as_str()), |_| ("ok", ""));
        let head = [o.spectrum.name.into(), o.solver.show()].into_iter();
        let sizes = [o.components, rows, columns].map(|n| n.to_string());
        let words = [status, reason].map(String::from);
        let figures = [o.lost.as_ref().ok().copied(), Some(o.least), o.excess(), o.median_ms].map(text);
        writer.write_record(head.chain(sizes).chain(words).chain(figures).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
