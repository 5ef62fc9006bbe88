//! What was found: verified.csv, a table for people, the first row that disagrees.

use super::check::{self, Check};
use super::decoder::Answer;
use crate::files;
use crate::number::short;
use crate::registry::{self, registry};
use crate::row::Row;
use crate::table;
use prt_transfer::Label;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// What the decoder found of a row.
pub(super) struct Finding {
    row: Row,
    codec: String,
    /// Why there are no figures.
    failure: Option<String>,
    checks: Vec<Check>,
}

/// Of all rows.
pub(super) struct Findings {
    pub(super) rows: Vec<Finding>,
    /// Rows that were not verified, and why.
    pub(super) left_out: Vec<(Row, String)>,
}

/// A line of verified.csv.
#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    signal: &'a str,
    basis: &'a str,
    method: &'a str,
    /// The column of results.csv; empty where nothing could be compared.
    figure: &'a str,
    /// In results.csv.
    ours: Option<f64>,
    /// By the decoder.
    theirs: Option<f64>,
    deviation: Option<f64>,
    tolerance: Option<f64>,
    /// Empty where the row was not verified.
    ok: Option<bool>,
    /// Why there are no figures.
    remark: &'a str,
}

impl Finding {
    pub(super) fn new(row: &Row, answer: &Answer) -> anyhow::Result<Finding> {
        let label: Label = row.method.parse()?;
        let failure = answer.failure.clone().or_else(|| other_method(&row.method, &answer.label));
        let checks = if failure.is_none() { check::of(row, &label, answer) } else { Vec::new() };
        Ok(Finding { row: row.clone(), codec: answer.codec.clone(), failure, checks })
    }

    /// A sentence on the first figure that disagrees.
    fn disagreement(&self) -> Option<String> {
        let Row { scene, signal, method, .. } = &self.row;
        let of = |said: String| format!("{scene} {signal} {method}: {said}");
        if let Some(failure) = &self.failure {
            return Some(of(failure.clone()));
        }
        let check = self.checks.iter().find(|check| !check.is_ok())?;
        // With an exponent where a person would write one.
        let number = |f: f64| if f.fract() == 0.0 { f.to_string() } else { format!("{f:?}") };
        let [ours, theirs] = [check.ours, check.theirs].map(|f| f.map_or_else(|| "nothing".into(), number));
        Some(of(format!("{} is {ours} in results.csv, {theirs} by decode.py", check.figure)))
    }
}

/// What is wrong with a file of another method than the row's.
fn other_method(row: &str, file: &str) -> Option<String> {
    let shortest = |label: &str| registry::method(&registry(), label).map(|method| method.label().to_string());
    match (shortest(row), shortest(file)) {
        (Ok(row), Ok(file)) if row == file => None,
        _ => Some(format!("its file is of {file}")),
    }
}

impl Findings {
    /// A line for each figure of each row, and for each row without.
    pub(super) fn write(&self, path: &Path) -> anyhow::Result<()> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for Finding { row, failure, checks, .. } in &self.rows {
            for check in checks {
                writer.serialize(line(row, Some(check), Some(check.is_ok()), ""))?;
            }
            if let Some(failure) = failure {
                writer.serialize(line(row, None, Some(false), failure))?;
            }
        }
        for (row, reason) in &self.left_out {
            writer.serialize(line(row, None, None, &format!("not verified: {reason}")))?;
        }
        Ok(files::write_beside(path, &writer.into_inner()?)?)
    }

    /// The first row that disagrees, and how.
    pub(super) fn first_disagreement(&self) -> Option<String> {
        self.rows.iter().find_map(Finding::disagreement)
    }

    /// Codec by codec how many rows agree and what deviates most; then what was not verified.
    pub(super) fn text(&self) -> String {
        let mut codecs: BTreeMap<&str, Vec<&Finding>> = BTreeMap::new();
        for finding in self.rows.iter().filter(|finding| finding.failure.is_none()) {
            codecs.entry(&finding.codec).or_default().push(finding);
        }
        let lines = codecs.iter().map(|(codec, findings)| {
            let checks = || findings.iter().flat_map(|finding| &finding.checks);
            let [rows, figures] = [findings.len(), checks().count()].map(|n| n.to_string());
            let agree = findings.iter().filter(|f| f.disagreement().is_none()).count().to_string();
            let exceeds = |check: &Check| (check.deviation(), check.tolerance().max(f64::MIN_POSITIVE));
            let share = |check: &Check| exceeds(check).0 / exceeds(check).1;
            let worst = checks().filter(|c| c.deviation() > 0.0).max_by(|a, b| share(a).total_cmp(&share(b)));
            let [figure, deviation, tolerance] = match worst {
                Some(check) => [check.figure.into(), short(check.deviation()), short(check.tolerance())],
                None => ["none", "0", "-"].map(String::from),
            };
            vec![codec.to_string(), rows, agree, figures, figure, deviation, tolerance]
        });
        let titles = ["verified", "rows", "agree", "figures", "worst of them", "deviates", "tolerance"];
        let left_out = self
            .left_out
            .iter()
            .map(|(row, reason)| format!("not verified: {} {} {}, {reason}", row.scene, row.signal, row.method));
        std::iter::once(format!("\n{}", table::aligned(&titles, lines))).chain(left_out).collect::<Vec<_>>().join("\n")
    }
}

fn line<'a>(row: &'a Row, check: Option<&Check>, ok: Option<bool>, remark: &'a str) -> Line<'a> {
    let Row { scene, signal, basis, method, .. } = row;
    let (ours, theirs) = check.map_or((None, None), |check| (check.ours, check.theirs));
    let figure = check.map_or("", |check| check.figure);
    let (deviation, tolerance) = (check.map(Check::deviation), check.map(Check::tolerance));
    Line { scene, signal, basis, method, figure, ours, theirs, deviation, tolerance, ok, remark }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(method: &str, error: f64, theirs: f64) -> Finding {
        let row = Row { scene: "teapot".into(), method: method.into(), error: Some(error), ..Row::default() };
        let row = Row { file_bytes: Some(9), error_max: Some(0.0), ..row };
        let answer = Answer {
            label: method.into(),
            codec: "truncate.1".into(),
            file_bytes: 9,
            error: theirs,
            ..Answer::default()
        };
        Finding::new(&row, &answer).unwrap()
    }

    #[test]
    fn the_first_row_that_disagrees_is_named_with_both_figures_and_every_line_is_in_the_file() {
        let other = Answer { label: "csr".into(), ..Answer::default() };
        let broken = Answer { failure: Some("not a .prt file".into()), ..Answer::default() };
        let row = |method: &str| Row { method: method.into(), ..Row::default() };
        let rows = vec![
            finding("truncate:terms=8", 0.25, 0.25),
            finding("truncate:terms=9", 0.2525, 0.25),
            Finding::new(&row("dense"), &other).unwrap(),
            Finding::new(&row("csr"), &broken).unwrap(),
        ];
        let sentences: Vec<Option<String>> = rows.iter().map(Finding::disagreement).collect();
        let expected = [
            None,
            Some("teapot  truncate:terms=9: error is 0.2525 in results.csv, 0.25 by decode.py"),
            Some("  dense: its file is of csr"),
            Some("  csr: not a .prt file"),
        ];
        assert_eq!(sentences, expected.map(|sentence| sentence.map(String::from)));
        let left_out = vec![(row("pca"), "measured by another program".to_string())];
        let findings = Findings { rows, left_out };
        assert_eq!(findings.first_disagreement(), sentences[1]);
        let text = findings.text();
        assert!(
            text.contains("truncate.1") && text.contains("not verified:   pca, measured by another program"),
            "{text}"
        );

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("verified.csv");
        findings.write(&path).unwrap();
        let lines = std::fs::read_to_string(&path).unwrap();
        for part in [
            "scene,signal,basis,method,figure,ours,theirs,deviation,tolerance,ok,remark\n",
            "teapot,,,truncate:terms=8,error,0.25,0.25,0.0,",
            "teapot,,,truncate:terms=9,error,0.2525,0.25,",
            ",,,dense,,,,,,false,its file is of csr\n",
            ",,,pca,,,,,,,not verified: measured by another program\n",
        ] {
            assert!(lines.contains(part), "{part}\n{lines}");
        }
    }

    #[test]
    fn a_label_with_its_defaults_written_out_is_the_method_of_its_file() {
        assert_eq!(other_method("sh:order=5+dense", "sh+dense"), None);
        assert!(other_method("sh:order=4+dense", "sh+dense").is_some());
    }
}
