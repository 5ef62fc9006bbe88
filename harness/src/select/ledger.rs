//! trials.csv: every model that was tried, so that a search that was stopped goes on where it was, and one for another bound begins with what is known.

use super::trial::{Attempt, Trial};
use crate::{files, fingerprint};
use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::path::Path;

/// The file, to which every trial is added.
pub(super) struct Ledger {
    writer: csv::Writer<File>,
    fingerprint: String,
}

/// A line of the file.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Line {
    program: String,
    fingerprint: String,
    method: String,
    error: Option<f64>,
    error_sphere: Option<f64>,
    file_bytes: Option<u64>,
    resident_bytes: Option<u64>,
    relight_ms: Option<f64>,
    seconds: Option<f64>,
    reason: String,
}

impl Ledger {
    /// Opens the file, and says what it knows of the matrix with this fingerprint. Lines of other programs go, and so does one that was cut off.
    ///
    /// # Errors
    /// A file of something else; one that cannot be written.
    pub(super) fn open(path: &Path, fingerprint: String) -> Result<(Ledger, Vec<(String, Attempt)>)> {
        let place = || format!("cannot use {}", path.display());
        let mut lines = if path.exists() { read(path).with_context(place)? } else { Vec::new() };
        lines.retain(|line| line.program == fingerprint::program());
        let ours = lines.iter().filter(|line| line.fingerprint == fingerprint);
        let known = ours.map(|line| (line.method.clone(), line.attempt())).collect();
        // Written anew: what a crash left at the end would swallow the next line.
        let mut whole = csv::Writer::from_writer(Vec::new());
        lines.iter().try_for_each(|line| whole.serialize(line))?;
        files::write_beside(path, &whole.into_inner()?)?;
        let file = OpenOptions::new().append(true).open(path).with_context(place)?;
        let writer = csv::WriterBuilder::new().has_headers(lines.is_empty()).from_writer(file);
        Ok((Ledger { writer, fingerprint }, known))
    }

    /// Adds what came of a label.
    pub(super) fn add(&mut self, method: &str, attempt: &Attempt) -> Result<()> {
        let line = Line {
            program: fingerprint::program().into(),
            fingerprint: self.fingerprint.clone(),
            method: method.into(),
            ..Line::of(attempt)
        };
        self.writer.serialize(line).and_then(|()| Ok(self.writer.flush()?)).context("cannot write trials.csv")
    }
}

/// Every line that is whole.
fn read(path: &Path) -> Result<Vec<Line>> {
    let mut reader = csv::Reader::from_path(path)?;
    let mut own = csv::Writer::from_writer(Vec::new());
    own.serialize(Line::default())?;
    let own = own.into_inner()?;
    let found = reader.headers()?;
    // Of a file that was torn in its first line nothing is lost; anything else is not ours to write over.
    ensure!(
        found.is_empty() || csv::Reader::from_reader(&own[..]).headers()? == found,
        "it is not what prt select writes"
    );
    Ok(reader.deserialize().filter_map(|line| line.ok()).collect())
}

impl Line {
    fn of(attempt: &Attempt) -> Line {
        match attempt {
            Attempt::Failed(why) => Line { reason: why.clone(), ..Line::default() },
            Attempt::Tried(trial) => Line {
                error: Some(trial.error),
                error_sphere: trial.error_sphere,
                file_bytes: Some(trial.file_bytes),
                resident_bytes: Some(trial.resident_bytes),
                relight_ms: trial.relight_ms,
                seconds: Some(trial.seconds),
                ..Line::default()
            },
        }
    }

    fn attempt(&self) -> Attempt {
        match (self.error, self.file_bytes, self.resident_bytes) {
            (Some(error), Some(file_bytes), Some(resident_bytes)) => Attempt::Tried(Trial {
                label: self.method.clone(),
                error,
                error_sphere: self.error_sphere,
                file_bytes,
                resident_bytes,
                relight_ms: self.relight_ms,
                seconds: self.seconds.unwrap_or_default(),
            }),
            _ => Attempt::Failed(self.reason.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trials_are_known_again_to_the_same_program_and_matrix_and_a_torn_line_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.csv");
        let trial = Trial {
            label: "pca".into(),
            error: 1.0 / 3.0,
            file_bytes: 7,
            resident_bytes: 8,
            relight_ms: Some(0.1),
            ..Trial::default()
        };
        let (mut ledger, known) = Ledger::open(&path, "a".into()).unwrap();
        assert!(known.is_empty());
        ledger.add("pca", &Attempt::Tried(trial.clone())).unwrap();
        ledger.add("cta", &Attempt::Failed("no, \"not\" here".into())).unwrap();
        drop(ledger);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("{text}0.1.0,a,vq,0.2")).unwrap();
        assert!(Ledger::open(&path, "b".into()).unwrap().1.is_empty());
        let (mut ledger, _) = Ledger::open(&path, "b".into()).unwrap();
        ledger.add("vq", &Attempt::Failed("too few".into())).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count(), 4, "a header and three lines");
        let (_, known) = Ledger::open(&path, "a".into()).unwrap();
        let [(pca, Attempt::Tried(found)), (cta, Attempt::Failed(why))] = &known[..] else { panic!("{known:?}") };
        std::fs::write(folder.path().join("other.csv"), "a,b\n1,2\n").unwrap();
        assert!(Ledger::open(&folder.path().join("other.csv"), "a".into()).is_err());
        assert_eq!((pca.as_str(), found, cta.as_str(), why.as_str()), ("pca", &trial, "cta", "no, \"not\" here"));
    }

    #[test]
    fn whatever_the_bytes_a_ledger_is_refused_or_tells_what_it_knows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.csv");
        let (mut ledger, _) = Ledger::open(&path, "a".into()).unwrap();
        ledger.add("pca", &Attempt::Failed("too few".into())).unwrap();
        ledger.add("vq", &Attempt::Tried(Trial::default())).unwrap();
        drop(ledger);
        let whole = std::fs::read(&path).unwrap();
        let mut opened = [0, 0];
        for at in (0..whole.len()).step_by(5) {
            let cut = whole[..at].to_vec();
            let changed = |byte: u8| [&whole[..at], &[byte], &whole[at + 1..]].concat();
            for bytes in [cut, changed(b'"'), changed(b','), changed(0xff), changed(b'9')] {
                std::fs::write(&path, bytes).unwrap();
                opened[usize::from(Ledger::open(&path, "a".into()).is_ok())] += 1;
            }
        }
        assert!(opened[0] > 0 && opened[1] > 0, "{opened:?}");
    }
}
