//! stability.csv: a line for each form at each value, and an atlas from it where nothing has changed since.

use super::outcome::{Atlas, Figure, Outcome, Point};
use super::{PARTS, case};
use crate::machine::Machine;
use serde::{Deserialize, Serialize};

/// A line of the file.
#[derive(Serialize, Deserialize)]
struct Line {
    part: String,
    case: String,
    value: f64,
    printed: Option<f64>,
    /// Why there is none.
    printed_failed: String,
    here: Option<f64>,
    here_failed: String,
    bound: f64,
    /// Whether ours is a number within the bound.
    kept: bool,
    machine: String,
}

/// The file.
pub fn to_csv(atlas: &Atlas, machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (part, outcome) in atlas.outcomes() {
        for point in &outcome.points {
            let (printed, printed_failed) = halves(&point.printed);
            let (here, here_failed) = halves(&point.here);
            let bound = outcome.bound(point);
            writer.serialize(Line {
                part: part.name.into(),
                case: outcome.case.name.into(),
                value: point.value,
                printed,
                printed_failed,
                here,
                here_failed,
                bound,
                kept: here.is_some_and(|here| here <= bound),
                machine: machine.line(),
            })?;
        }
    }
    Ok(writer.into_inner()?)
}

/// All of it, where the file has every point of every case and was written by this commit on this machine today; what was built from
/// changed sources is never the same.
pub fn from_csv(bytes: &[u8], machine: &Machine) -> Option<Atlas> {
    if machine.commit.ends_with("-dirty") || machine.commit == "unknown" {
        return None;
    }
    let lines: Vec<Line> = csv::Reader::from_reader(bytes).deserialize().collect::<Result<_, _>>().ok()?;
    let mut lines = lines.into_iter();
    let mut outcome = |part: &case::Part, case: &'static case::Case| {
        let points = case.values.iter().map(|value| {
            let line = lines.next()?;
            let same = line.part == part.name && line.case == case.name && line.value == *value;
            let same = same && line.machine == machine.line();
            let [printed, here] = [(line.printed, line.printed_failed), (line.here, line.here_failed)].map(whole);
            same.then_some(Point { value: *value, printed, here })
        });
        Some(Outcome { case, points: points.collect::<Option<_>>()? })
    };
    let parts =
        PARTS.iter().map(|part| Some((part, part.cases.iter().map(|c| outcome(part, c)).collect::<Option<_>>()?)));
    Some(Atlas { parts: parts.collect::<Option<_>>()? })
}

fn halves(figure: &Figure) -> (Option<f64>, String) {
    match figure {
        Ok(figure) => (Some(*figure), String::new()),
        Err(why) => (None, why.clone()),
    }
}

fn whole((figure, why): (Option<f64>, String)) -> Figure {
    figure.ok_or(why)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn atlas(figure: fn(usize) -> Figure) -> Atlas {
        let outcome = |case: &'static case::Case| {
            let point = |(i, value): (usize, &f64)| Point { value: *value, printed: figure(i), here: Ok(0.0) };
            Outcome { case, points: case.values.iter().enumerate().map(point).collect() }
        };
        Atlas { parts: PARTS.iter().map(|part| (part, part.cases.iter().map(outcome).collect())).collect() }
    }

    #[test]
    fn a_file_comes_back_whole_where_the_program_is_the_same_and_not_otherwise() {
        let machine = Machine { commit: "0123456789ab", ..Machine::here(2) };
        let written = atlas(|i| if i == 1 { Err("infinite, or so".into()) } else { Ok(0.1 + i as f64) });
        let bytes = to_csv(&written, &machine).unwrap();
        let read = from_csv(&bytes, &machine).unwrap();
        for ((_, a), (_, b)) in written.outcomes().zip(read.outcomes()) {
            assert!(a.case.name == b.case.name && a.points == b.points);
        }
        for commit in ["ba9876543210", "0123456789ab-dirty", "unknown"] {
            assert!(from_csv(&bytes, &Machine { commit, ..machine.clone() }).is_none(), "{commit}");
        }
        assert!(from_csv(&bytes[..bytes.len() / 2], &machine).is_none());
        assert!(from_csv(b"part,case\n", &machine).is_none());
    }
}
