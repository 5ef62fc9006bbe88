//! The table of bounds.

use super::case::Part;
use super::outcome::{Atlas, Figure, Outcome};
use crate::number::short;
use crate::table::aligned;

/// What the columns mean.
pub(super) const LEGEND: &str = "here, bound: where ours comes closest to its bound; printed: the paper's form at the last value;\n\
breaks at: the first value at which the paper's form is beyond the bound, - where it never is";

/// A case as text.
pub struct Row {
    /// Of the parameter, from harmless to hopeless.
    pub range: String,
    /// Ours where it comes closest to its bound.
    pub here: String,
    /// The bound there.
    pub bound: String,
    /// The paper's form at the last value.
    pub printed: String,
    /// The first value at which that is beyond the bound.
    pub breaks: Option<String>,
    /// Whether ours keeps its bound everywhere.
    pub kept: bool,
}

impl Row {
    /// Of an outcome.
    pub fn of(outcome: &Outcome) -> Row {
        let ends = [outcome.points.first(), outcome.points.last()].map(|p| p.map_or(String::new(), |p| mark(p.value)));
        let figure = |figure: &Figure| figure.as_ref().map_or_else(|_| "none".into(), |figure| short(*figure));
        let tightest = outcome.tightest();
        Row {
            range: ends.join(" … "),
            here: tightest.map_or(String::new(), |point| figure(&point.here)),
            bound: tightest.map_or(String::new(), |point| short(outcome.bound(point))),
            printed: outcome.points.last().map_or(String::new(), |point| figure(&point.printed)),
            breaks: outcome.breaks().map(mark),
            kept: outcome.violations().next().is_none(),
        }
    }
}

/// A value of a parameter, as it is written in a case.
pub fn mark(value: f64) -> String {
    let (plain, power) = (value.to_string(), format!("{value:e}"));
    if plain.len() <= power.len() { plain } else { power }
}

/// The same for a page of Markdown, with what is driven and promised.
pub(super) fn markdown(atlas: &Atlas, machine: &str) -> String {
    let line = |(part, outcome): (&Part, &Outcome)| {
        let Row { range, here, bound, printed, breaks, kept } = Row::of(outcome);
        let case = outcome.case;
        let (breaks, verdict) = (breaks.unwrap_or_else(|| "–".into()), if kept { "kept" } else { "**broken**" });
        let cells = [
            format!("{}/{}: {}", part.name, case.name, case.title),
            format!("{}: {range}", case.parameter),
            case.quantity.into(),
            format!("{}: {printed}", case.printed.name),
            breaks,
            format!("{}: {here}", case.here.name),
            format!("{bound}, {verdict}: {}", case.promise),
        ];
        // A bar would end the cell.
        format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | "))
    };
    let lines: String = atlas.outcomes().map(line).collect();
    format!("{MARKDOWN}{lines}\n{machine}\n")
}

const MARKDOWN: &str = "| case | driven | less is better | as printed, at the end | beyond the bound from | here, where it is nearest to its bound | bound |\n\
| --- | --- | --- | --- | --- | --- | --- |\n";

/// A line for each case, and where ours failed.
pub(super) fn text(atlas: &Atlas) -> String {
    let titles = ["part", "case", "from … to", "printed", "breaks at", "here", "bound", ""];
    let mut previous = "";
    let line = |(part, outcome): (&Part, &Outcome)| {
        let Row { range, here, bound, printed, breaks, kept } = Row::of(outcome);
        // Once for all cases of a part.
        let name = if std::mem::replace(&mut previous, part.name) == part.name { "" } else { part.name };
        let verdict = if kept { "kept" } else { "BROKEN" };
        let breaks = breaks.unwrap_or_else(|| "-".into());
        vec![name.into(), outcome.case.name.into(), range, printed, breaks, here, bound, verdict.into()]
    };
    let lines: Vec<Vec<String>> = atlas.outcomes().map(line).collect();
    let broken = atlas.violated().flat_map(|outcome| {
        outcome.violations().map(|point| {
            let found = point.here.as_ref().map_or_else(String::clone, f64::to_string);
            format!("{} at {}: {found}; promised: {}", outcome.case.name, point.value, outcome.case.promise)
        })
    });
    std::iter::once(aligned(&titles, lines.into_iter())).chain(broken).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::super::{PARTS, Point};
    use super::*;

    #[test]
    fn a_case_beyond_its_bound_is_told_with_its_promise_and_one_within_is_not() {
        let outcome = |here: f64| {
            let (case, value) = (&PARTS[0].cases[0], PARTS[0].cases[0].values[0]);
            Outcome { case, points: vec![Point { value, printed: Err("infinite".into()), here: Ok(here) }] }
        };
        for (here, broken) in [(0.0, false), (1.0, true)] {
            let atlas = Atlas { parts: vec![(&PARTS[0], vec![outcome(here)])] };
            let (text, page) = (text(&atlas), markdown(&atlas, "here"));
            assert_eq!(text.contains("BROKEN") && text.contains("promised: 1e-6"), broken, "{text}");
            assert_eq!(
                (text.contains("kept"), page.contains("kept"), page.contains("**broken**")),
                (!broken, !broken, broken)
            );
            // Seven cells, whatever bars there are in what is printed.
            let line = page.lines().nth(2).unwrap().replace("\\|", "");
            assert_eq!(line.matches('|').count(), 8, "{line}");
        }
    }

    #[test]
    fn a_value_is_written_as_short_as_it_can_be() {
        let marks = [1.0, 1024.0, 0.999999, 1e-8, 1e5, 0.1].map(mark);
        assert_eq!(marks, ["1", "1024", "0.999999", "1e-8", "1e5", "0.1"]);
    }
}
