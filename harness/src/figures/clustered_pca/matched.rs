//! What Figures 10 and 11 print, beside ours: of as many components, and at equal relight time and equal bytes.

use crate::figures::outcome::{Cost, MEMORY, Outcome, RELIGHT};
use crate::figures::setting::Curve;
use crate::tables::beside::{Beside, Cell, Column, Line};

/// Components of CPCA that all others are compared with.
const BASE: usize = 8;
const CPCA: &str = "CPCA";

/// A method of Figure 10: its curve, the paper's setting, SE and Hz.
pub(super) type Printed = (&'static str, &'static str, f64, f64);
pub(super) const FIGURE_10: [Printed; 4] = [
    ("PCA", "n' = 20", 101_304.0, 45.7),
    ("VQ", "m_c = 1792", 14_799.0, 41.8),
    (CPCA, "m_c = 256, n' = 8", 294.4, 45.5),
    ("uncompressed", "exact", 0.0, 3.7),
];
/// Components of each cluster in Figure 11, and SE and Hz of the Buddha and of the bird.
pub(super) const FIGURE_11: [(usize, [(f64, f64); 2]); 4] = [
    (2, [(40_353.5, 40.4), (9510.75, 58.9)]),
    (4, [(21_077.5, 36.4), (2353.09, 57.1)]),
    (BASE, [(8524.1, 24.2), (294.421, 45.5)]),
    (12, [(4413.01, 18.7), (66.7495, 31.9)]),
];
/// The models of Figure 11.
pub(super) const MODELS: [&str; 2] = ["Buddha", "bird"];

fn columns(of_base: &'static str) -> Vec<Column> {
    vec![
        Column::new("squared_error", "SE"),
        Column::new("of_base", of_base),
        Column::new("paper_hz", "Hz"),
        Column::new("relight_1_ms", "relight ms"),
        Column::bytes("resident_bytes", "memory"),
    ]
}

/// Figure 10: every method where it costs what CPCA does; what is exact at its own cost.
pub(super) fn figure10(subject: String, curves: &[Curve], outcomes: &[Outcome]) -> Beside {
    let base = of_components(curves, outcomes, BASE);
    let cells = |error: Option<f64>, costs: [Cell; 2]| {
        let ratio = error.zip(base.and_then(Outcome::squared_error)).map(|(error, base)| error / base);
        [error.into(), ratio.into(), Cell::Nothing].into_iter().chain(costs).collect::<Vec<Cell>>()
    };
    let at_equal = |curve: &str, (name, cost): (&str, &Cost), costs: fn(f64) -> [Cell; 2]| {
        let target = base.and_then(cost.of);
        let found = target.and_then(|target| Some((target, at_cost(&on(curves, outcomes, curve), cost, target)?)));
        let found = found.map(|(target, error)| cells(Some(error), costs(target)));
        Line::ours(name, (curve, name), found.ok_or_else(|| format!("{curve} does not reach the cost of {CPCA}")))
    };
    let lines = FIGURE_10.iter().flat_map(|&(curve, setting, error, hz)| {
        let printed = vec![Cell::Printed(error), (error / FIGURE_10[2].2).into(), Cell::Printed(hz)];
        let exact = on(curves, outcomes, curve).into_iter().find(|o| o.setting.size.is_none());
        let ours = match exact {
            Some(o) => {
                let costs = [o.row.relight_1_ms.into(), o.row.resident_bytes.into()];
                vec![Line::ours("ours", (curve, o.row.method.as_str()), Ok(cells(o.squared_error(), costs)))]
            }
            None => vec![
                at_equal(curve, ("equal relight time", &RELIGHT), |ms| [ms.into(), Cell::Nothing]),
                at_equal(curve, ("equal bytes", &MEMORY), |mb| [Cell::Nothing, (1e6 * mb).into()]),
            ],
        };
        std::iter::once(Line::printed(format!("{curve} {setting}"), printed)).chain(ours)
    });
    Beside {
        addition: "-paper",
        title: "Figure 10: PCA, VQ and clustered PCA at equal cost (Sloan et al. 2003)".into(),
        subjects: vec![subject],
        head: "method",
        columns: columns("of CPCA's"),
        lines: lines.collect(),
        why: "The paper matches frame rates of a graphics card alone; ours are read between neighbours in cost, of the \
              product on one thread and of memory. Mesh and BRDF are others, the paper not saying which anisotropic one \
              it has, and a small scene has fewer clusters, which favours the rivals.",
    }
}

/// A model of Figure 11: its title, and the curves that were measured on it; the reason where it is not there.
pub(super) type Model = Result<(String, Vec<Curve>, Vec<Outcome>), String>;

/// Figure 11: SE over the components of each cluster, for each of its models.
pub(super) fn figure11(models: &[Model; 2]) -> Beside {
    let lines = models.iter().enumerate().flat_map(|(model, measured)| {
        let of = move |components: usize| match measured {
            Ok((_, curves, outcomes)) => Ok(of_components(curves, outcomes, components)),
            Err(reason) => Err(reason.clone()),
        };
        let base = of(BASE).ok().flatten().and_then(Outcome::squared_error);
        FIGURE_11.iter().flat_map(move |&(components, printed)| {
            let (error, hz) = printed[model];
            let cells = vec![Cell::Printed(error), (error / FIGURE_11[2].1[model].0).into(), Cell::Printed(hz)];
            let cells_of = |o: &Outcome| {
                let error = o.squared_error();
                let ratio = error.zip(base).map(|(error, base)| error / base);
                vec![error.into(), ratio.into(), Cell::Nothing, o.row.relight_1_ms.into(), o.row.resident_bytes.into()]
            };
            let name = format!("{}, n' = {components}", MODELS[model]);
            let found = of(components).and_then(|o| o.ok_or_else(|| "a cluster has too few samples".into()));
            let method = found.as_ref().map_or("", |o| &o.row.method).to_string();
            let ours = match &found {
                Ok(o) => Line::ours("ours", (MODELS[model], method), Ok(cells_of(o))),
                Err(reason) => Line::ours(name.clone(), (MODELS[model], method), Err(reason.clone())),
            };
            [Line::printed(name, cells), ours]
        })
    });
    let title = |(name, model): (&&str, &Model)| Some(format!("{name}: {}", model.as_ref().ok()?.0));
    Beside {
        addition: "-components",
        title: "Figure 11: clustered PCA over the components of a cluster (Sloan et al. 2003)".into(),
        subjects: MODELS.iter().zip(models).filter_map(title).collect(),
        head: "model",
        columns: columns("of n' = 8"),
        lines: lines.collect(),
        why: "SE is a sum over all vertices of another mesh: its fall alone compares. It falls less here where a small \
              scene has fewer clusters of as many samples. The paper's Buddha is lit by itself too, ours is not.",
    }
}

pub(super) fn on<'a>(curves: &[Curve], outcomes: &'a [Outcome], name: &str) -> Vec<&'a Outcome> {
    outcomes.iter().filter(|o| o.row.is_ok() && curves[o.curve].name == name).collect()
}

/// CPCA of so many components.
fn of_components<'a>(curves: &[Curve], outcomes: &'a [Outcome], components: usize) -> Option<&'a Outcome> {
    let has = |o: &&Outcome| o.setting.size.is_some_and(|size| size.components == components);
    on(curves, outcomes, CPCA).into_iter().find(has)
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
