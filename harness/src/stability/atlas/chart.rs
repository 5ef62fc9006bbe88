//! A chart for each part: a panel for each case, with both forms and the bound.

use super::case::Part;
use super::outcome::{Figure, Outcome};
use super::table::mark;
use crate::charts::panels::{Panel, Panels};

/// What is drawn as smaller or larger than this lies on the edge: beyond it there is nothing to tell apart.
const DRAWN: [f64; 2] = [1e-17, 1e12];

/// The lines of every panel.
const NAMES: [&str; 3] = ["as printed, or as a reader would write it", "here", "the bound that ours keeps"];

/// The chart of a part.
pub fn chart(part: &Part, outcomes: &[Outcome]) -> Panels {
    Panels {
        title: format!("{}: what fails, and where", part.title),
        subject: format!(
            "from harmless, left, to hopeless, right; less is better; what is below {:.0e} or above {:.0e} lies there",
            DRAWN[0], DRAWN[1]
        ),
        methods: NAMES.map(String::from).into(),
        panels: outcomes.iter().map(panel).collect(),
    }
}

fn panel(outcome: &Outcome) -> Panel {
    let drawn = |figure: &Figure| figure.as_ref().ok().map(|figure| figure.clamp(DRAWN[0], DRAWN[1]));
    let printed = outcome.points.iter().map(|point| drawn(&point.printed)).collect();
    let here = outcome.points.iter().map(|point| drawn(&point.here)).collect();
    let bound = outcome.points.iter().map(|point| drawn(&Ok(outcome.bound(point)))).collect();
    Panel {
        heading: vec![outcome.case.title.into(), outcome.case.quantity.into()],
        parameter: outcome.case.parameter.into(),
        marks: outcome.points.iter().map(|point| mark(point.value)).collect(),
        values: vec![printed, here, bound],
    }
}
