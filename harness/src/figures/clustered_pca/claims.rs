//! What the paper says of Figures 2 and 3, which are curves without numbers, beside what ours do.

use super::matched::{at_cost, on};
use crate::figures::outcome::{Cost, MEMORY, NUMBERS, Outcome, RELIGHT};
use crate::figures::setting::Curve;
use crate::tables::beside::{Beside, Cell, Column, Line};

/// Figure 2: where each curve comes to lie below the one before it.
pub(super) fn figure2(subject: String, curves: &[Curve], outcomes: &[Outcome]) -> Beside {
    let pairs = curves.windows(2).filter(|pair| pair[1].settings.iter().any(|s| s.size.is_some()));
    let lines = pairs.flat_map(|pair| {
        let name = format!("{} below {}", pair[1].name, pair[0].name);
        let [before, after] = [0, 1].map(|i| on(curves, outcomes, &pair[i].name));
        let from = |cost: &Cost, unit: f64| crossing(&before, &after, cost).map(|at| unit * at);
        let cells = [from(&NUMBERS, 1.0), from(&MEMORY, 1e6), from(&RELIGHT, 1.0)].map(Cell::from);
        let ours = Line::ours("ours, from", (pair[1].name.as_str(), "cpca"), Ok(cells.into()));
        [Line::printed(name, vec!["eventually".into()]), ours]
    });
    Beside {
        addition: "-paper",
        title: "Figure 2: at equal numbers, equal bytes and equal time (Sloan et al. 2003)".into(),
        subjects: vec![subject],
        head: "curve",
        columns: vec![
            Column::whole("numbers", "numbers"),
            Column::bytes("resident_bytes", "memory"),
            Column::new("relight_1_ms", "relight ms"),
        ],
        lines: lines.collect(),
        why: "The paper has curves without figures, and says that each begins above the one before it and crosses below \
              with more clusters. Its cost is the number of numbers; memory and the time of the product stand beside it. \
              Where there is '-' both curves do not go so far: it has twelve times as many vertices as a built-in scene.",
    }
}

/// Figure 3: how many components more the other way of encoding needs for as low an error.
pub(super) fn figure3(subject: String, curves: &[Curve], outcomes: &[Outcome]) -> Beside {
    const CLAIMS: [(&str, &str, &str); 2] =
        [("iterative", "static", "1 to 4"), ("adaptive, the paper's rule", "iterative", "about 1")];
    let lines = CLAIMS.iter().flat_map(|&(better, worse, printed)| {
        let other = on(curves, outcomes, worse);
        let ours = on(curves, outcomes, better).into_iter().filter_map(move |o| {
            let components = o.setting.size?.components;
            let more = components_for(&other, o.squared_error()?).map(|n| n - components as f64);
            let cells = [more, o.squared_error(), o.row.relight_1_ms].map(Cell::from).into_iter();
            let cells = cells.chain([o.row.resident_bytes.into()]).collect();
            Some(Line::ours(format!("n' = {components}"), (better, o.row.method.as_str()), Ok(cells)))
        });
        std::iter::once(Line::printed(format!("{better}; {worse} needs"), vec![printed.into()])).chain(ours)
    });
    Beside {
        addition: "-paper",
        title: "Figure 3: what better clusters are worth in components (Sloan et al. 2003)".into(),
        subjects: vec![subject],
        head: "encoding",
        columns: vec![
            Column::new("more_components", "components more"),
            Column::new("squared_error", "SE"),
            Column::new("relight_1_ms", "relight ms"),
            Column::bytes("resident_bytes", "memory"),
        ],
        lines: lines.collect(),
        why: "The paper has curves without figures; the numbers are its text's. At equal n' all ways of encoding take about \
              as many bytes. On a built-in scene there are few clusters, whose static members are nearly the best ones; \
              where there is '-' the other's curve ends before.",
    }
}

/// The least cost at which `after` lies below `before`.
pub(super) fn crossing(before: &[&Outcome], after: &[&Outcome], cost: &Cost) -> Option<f64> {
    let below = |o: &&Outcome| {
        let at = (cost.of)(o)?;
        (o.squared_error()? < at_cost(before, cost, at)?).then_some(at)
    };
    after.iter().filter_map(below).min_by(f64::total_cmp)
}

/// Components of each cluster for such an error, on the straight line between the logarithms of its neighbours' errors.
pub(super) fn components_for(curve: &[&Outcome], error: f64) -> Option<f64> {
    let point = |o: &&Outcome| Some((o.setting.size?.components as f64, o.squared_error()?.ln()));
    let points: Vec<(f64, f64)> = curve.iter().filter_map(point).collect();
    let pair = points.windows(2).find(|pair| pair[1].1 <= error.ln() && error.ln() <= pair[0].1)?;
    let [(first, above), (second, below)] = [pair[0], pair[1]];
    let share = if above > below { (above - error.ln()) / (above - below) } else { 0.0 };
    Some(first + share * (second - first))
}
