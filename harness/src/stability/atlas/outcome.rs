//! What came of a case: both forms at every value, and whether ours kept its bound.

use super::case::{Case, Part};

/// A finite number, or why there is none.
pub type Figure = Result<f64, String>;

/// Both forms at one value.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Of the parameter.
    pub value: f64,
    /// The paper's form.
    pub printed: Figure,
    /// Ours.
    pub here: Figure,
}

/// One case.
pub struct Outcome {
    /// Which one.
    pub case: &'static Case,
    /// In the case's order.
    pub points: Vec<Point>,
}

/// Cases by parts.
pub struct Atlas {
    /// In the order of [`super::PARTS`].
    pub parts: Vec<(&'static Part, Vec<Outcome>)>,
}

/// What a form came to.
pub(super) fn figure(found: prt_transfer::Result<f64>) -> Figure {
    match found {
        Ok(figure) if figure.is_finite() => Ok(figure),
        Ok(figure) => Err(if figure.is_nan() { "not a number" } else { "infinite" }.into()),
        Err(error) => Err(error.to_string()),
    }
}

impl Outcome {
    /// The most that ours may come to at a point.
    pub fn bound(&self, point: &Point) -> f64 {
        (self.case.bound)(point.value)
    }

    fn keeps(&self, point: &Point, figure: &Figure) -> bool {
        figure.as_ref().is_ok_and(|figure| *figure <= self.bound(point))
    }

    /// Where ours is beyond its bound.
    pub fn violations(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| !self.keeps(point, &point.here))
    }

    /// The first value at which the paper's form is beyond the bound.
    pub fn breaks(&self) -> Option<f64> {
        self.points.iter().find(|point| !self.keeps(point, &point.printed)).map(|point| point.value)
    }

    /// Where ours comes closest to its bound, or is farthest beyond it.
    pub fn tightest(&self) -> Option<&Point> {
        let share = |point: &Point| match &point.here {
            Ok(0.0) => 0.0,
            Ok(figure) => figure / self.bound(point),
            Err(_) => f64::INFINITY,
        };
        self.points.iter().max_by(|a, b| share(a).total_cmp(&share(b)))
    }
}

impl Atlas {
    /// Every case of every part.
    pub fn outcomes(&self) -> impl Iterator<Item = (&'static Part, &Outcome)> {
        self.parts.iter().flat_map(|(part, outcomes)| outcomes.iter().map(|outcome| (*part, outcome)))
    }

    /// Cases in which ours is beyond its bound somewhere.
    pub fn violated(&self) -> impl Iterator<Item = &Outcome> {
        self.outcomes().map(|(_, outcome)| outcome).filter(|outcome| outcome.violations().next().is_some())
    }
}
