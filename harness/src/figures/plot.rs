//! From outcomes to a chart.

use super::outcome::{Cost, Outcome};
use super::setting::{Curve, Setting};
use crate::charts::curves::{Curves, Dot, Plane};

/// What all panels have upwards.
const UPWARDS: &str = "relative squared error";

/// Error over each of `costs`; a curve for each of `curves`, and an upright line for each setting that keeps every sample as it is.
/// `label` is written beside a setting's marker, and `remark` says what it is.
pub fn plot(
    (title, subject, remark): (&str, String, Option<&str>),
    curves: &[Curve],
    outcomes: &[Outcome],
    costs: &[Cost],
    label: impl Fn(&Setting) -> String,
) -> Curves {
    let finished = || outcomes.iter().filter(|o| o.row.is_ok());
    let drawn: Vec<usize> =
        (0..curves.len()).filter(|&i| finished().any(|o| o.curve == i && o.setting.size.is_some())).collect();
    let dot = |o: &Outcome, cost: &Cost| Dot {
        x: (cost.of)(o).unwrap_or(f64::NAN),
        y: o.row.error.unwrap_or(f64::NAN),
        label: label(&o.setting),
    };
    let plane = |cost: &Cost| Plane {
        upwards: UPWARDS.into(),
        across: cost.title.into(),
        curves: drawn.iter().map(|&i| finished().filter(|o| o.curve == i).map(|o| dot(o, cost)).collect()).collect(),
        references: finished()
            .filter(|o| o.setting.size.is_none())
            .filter_map(|o| Some(((cost.of)(o)?, format!("{}, exact", o.row.method))))
            .collect(),
    };
    Curves {
        title: title.into(),
        subject,
        remark: remark.map(String::from),
        names: drawn.iter().map(|&i| curves[i].name.clone()).collect(),
        apart: false,
        planes: costs.iter().map(plane).collect(),
    }
}
