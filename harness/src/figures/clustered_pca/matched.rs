//! What Figures 10 and 11 print, beside ours at equal cost.

use crate::figures::outcome::{Cost, MEMORY, Outcome, RELIGHT};
use crate::figures::setting::Curve;
use crate::machine::Machine;
use crate::number;
use crate::table::aligned;

/// A method of Figure 10 or 11, and ours.
#[derive(Clone, Debug)]
pub(super) struct Beside {
    figure: &'static str,
    /// Name of the curve.
    curve: &'static str,
    /// The paper's.
    setting: &'static str,
    error: f64,
    hz: f64,
    /// Our SE of the same number of components.
    same: Option<f64>,
    /// Our SE where relighting takes as long as [`BASE`] components of CPCA do.
    at_equal_time: Option<f64>,
    /// Our SE where as much is stored.
    at_equal_memory: Option<f64>,
}

#[cfg(test)]
impl Beside {
    pub(super) fn setting(&self) -> &str {
        self.setting
    }
    pub(super) fn error(&self) -> f64 {
        self.error
    }
}

/// Components of CPCA that all others are compared with.
const BASE: usize = 8;
const CPCA: &str = "CPCA";

/// Curve, setting, its components where ours has the same, SE, Hz.
type Printed = (&'static str, &'static str, Option<usize>, f64, f64);
const FIGURE_10: [Printed; 4] = [
    ("PCA", "n' = 20", None, 101_304.0, 45.7),
    ("VQ", "m_c = 1792", None, 14_799.0, 41.8),
    (CPCA, "m_c = 256, n' = 8", Some(BASE), 294.4, 45.5),
    ("uncompressed", "", None, 0.0, 3.7),
];
/// The bird's.
const FIGURE_11: [Printed; 4] = [
    (CPCA, "n' = 2", Some(2), 9510.75, 58.9),
    (CPCA, "n' = 4", Some(4), 2353.09, 57.1),
    (CPCA, "n' = 8", Some(8), 294.421, 45.5),
    (CPCA, "n' = 12", Some(12), 66.7495, 31.9),
];

/// Every figure that is printed, with ours.
pub(super) fn beside(curves: &[Curve], outcomes: &[Outcome]) -> Vec<Beside> {
    let of = |name: &str| {
        let on = outcomes.iter().filter(|o| o.row.is_ok() && curves[o.curve].name == name);
        on.collect::<Vec<_>>()
    };
    let cpca = |n: usize| of(CPCA).into_iter().find(|o| o.setting.size.is_some_and(|size| size.components == n));
    let base = cpca(BASE);
    let at_equal = |curve: &str, cost: &Cost| at_cost(&of(curve), cost, base.and_then(cost.of)?);
    let ten = FIGURE_10.map(|(curve, setting, same, error, hz)| Beside {
        figure: "figure10",
        curve,
        setting,
        error,
        hz,
        same: same.and_then(cpca).and_then(Outcome::squared_error),
        at_equal_time: at_equal(curve, &RELIGHT),
        at_equal_memory: at_equal(curve, &MEMORY),
    });
    let eleven = FIGURE_11.map(|(curve, setting, same, error, hz)| Beside {
        figure: "figure11",
        curve,
        setting,
        error,
        hz,
        same: same.and_then(cpca).and_then(Outcome::squared_error),
        at_equal_time: None,
        at_equal_memory: None,
    });
    ten.into_iter().chain(eleven).collect()
}

/// SE of a curve where it costs `target`: on the straight line, both logarithmic, between its neighbours in cost. None where the
/// curve does not reach so far, or is exact there.
pub(super) fn at_cost(curve: &[&Outcome], cost: &Cost, target: f64) -> Option<f64> {
    let point = |o: &&Outcome| Some(((cost.of)(o)?.ln(), o.squared_error()?.ln()));
    let mut points: Vec<(f64, f64)> = curve.iter().filter_map(point).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (at, pairs) = (target.ln(), points.iter().zip(points.iter().skip(1)));
    if let Some(here) = points.iter().find(|p| p.0 == at) {
        return Some(here.1.exp());
    }
    let (below, above) = pairs.into_iter().find(|(below, above)| below.0 < at && at < above.0)?;
    let share = (at - below.0) / (above.0 - below.0);
    let error = (below.1 + share * (above.1 - below.1)).exp();
    (error > 0.0).then_some(error)
}

/// One table for each figure; SE as printed and ours, and both as multiples of the base's.
pub(super) fn table(all: &[Beside]) -> String {
    let short = |figure: Option<f64>| figure.map_or_else(|| "-".into(), number::short);
    let of = |figure: &'static str| all.iter().filter(move |b| b.figure == figure);
    let base = |figure: &'static str| of(figure).find(|b| b.setting.ends_with("n' = 8"));
    let printed = |b: &Beside| {
        let times = base(b.figure).map(|base| b.error / base.error);
        [b.curve.into(), b.setting.into(), b.hz.to_string(), b.error.to_string(), short(times)]
    };
    let times = |b: &Beside, error: Option<f64>| {
        let base = base(b.figure).and_then(|base| base.same);
        [short(error), short(error.zip(base).map(|(error, base)| error / base))]
    };
    let ten = of("figure10").map(|b| {
        let ours = [times(b, b.at_equal_time), times(b, b.at_equal_memory)].concat();
        printed(b).into_iter().chain(ours).collect()
    });
    let eleven = of("figure11").map(|b| printed(b).into_iter().chain(times(b, b.same)).collect());
    let papers = ["Figure 10", "paper's setting", "Hz", "SE", "of CPCA's"];
    let ten = aligned(&[&papers[..], &["SE, equal time", "of CPCA's", "SE, equal bytes", "of CPCA's"]].concat(), ten);
    let papers = ["Figure 11", "paper's setting", "Hz", "SE", "of n' = 8"];
    let eleven = aligned(&[&papers[..], &["our SE", "of n' = 8"]].concat(), eleven);
    format!("\n{ten}\n\n{eleven}")
}

/// One line for each figure that is printed, with the machine in every line.
pub(super) fn csv(all: &[Beside], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "figure",
        "curve",
        "paper_setting",
        "paper_squared_error",
        "paper_hz",
        "squared_error",
        "squared_error_at_equal_relight_time",
        "squared_error_at_equal_resident_bytes",
        "machine",
    ])?;
    let text = |figure: Option<f64>| figure.map_or(String::new(), |f| f.to_string());
    for b in all {
        let printed = [b.figure, b.curve, b.setting].map(String::from).into_iter();
        let ours = [b.same, b.at_equal_time, b.at_equal_memory].map(text);
        writer
            .write_record(printed.chain([b.error.to_string(), b.hz.to_string()]).chain(ours).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
