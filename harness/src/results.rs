//! results.csv: every finished measurement of a folder, written whole after each.

use crate::files;
use crate::row::Row;
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};

/// The rows of one file.
pub struct Results {
    path: PathBuf,
    rows: Vec<Row>,
}

impl Results {
    /// Reads the file; one that does not exist is empty.
    pub fn open(path: impl Into<PathBuf>) -> anyhow::Result<Results> {
        let path = path.into();
        let place = || format!("cannot use {}", path.display());
        let rows = if path.exists() { from_csv(&files::read_bytes(&path)?).with_context(place)? } else { Vec::new() };
        Ok(Results { path, rows })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Every row, in the order of the file.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The finished measurement that makes `planned` superfluous; a failure is tried again.
    pub fn finished(&self, planned: &Row) -> Option<&Row> {
        self.rows.iter().find(|row| row.is_ok() && row.same_measurement(planned))
    }

    /// Adds a row in place of an older one of the same subject, and writes the file.
    pub fn put(&mut self, row: Row) -> anyhow::Result<()> {
        match self.rows.iter_mut().find(|old| old.same_subject(&row)) {
            Some(old) => *old = row,
            None => self.rows.push(row),
        }
        Ok(files::write_beside(&self.path, &to_csv(&self.rows)?)?)
    }
}

/// A header line and one line a row.
pub fn to_csv(rows: &[Row]) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    Ok(writer.into_inner()?)
}

/// The rows that [`to_csv`] wrote.
///
/// # Errors
/// Other columns; a line that is not a row.
pub fn from_csv(bytes: &[u8]) -> anyhow::Result<Vec<Row>> {
    let mut reader = csv::Reader::from_reader(bytes);
    let header = to_csv(&[Row::default()])?;
    let expected: Vec<&str> = str::from_utf8(&header)?.lines().next().unwrap_or_default().split(',').collect();
    if !reader.headers()?.iter().eq(expected.iter().copied()) {
        bail!("it has other columns than this version writes; move it away or choose another --out");
    }
    Ok(reader.deserialize().collect::<Result<_, _>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Status;
    use proptest::prelude::*;

    fn row(method: &str) -> Row {
        Row { scene: "a, \"b\"\nc".into(), method: method.into(), status: Status::Ok, ..Row::default() }
    }

    proptest! {
        #[test]
        fn whatever_is_written_reads_back_bit_for_bit(
            text in ".*",
            number in prop::option::of(prop::num::f64::POSITIVE | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL),
            count in prop::option::of(any::<u64>()),
        ) {
            let written = Row { reason: text, error: number, encode_s: number, file_bytes: count, ..row("csr") };
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("results.csv");
            Results::open(&path).unwrap().put(written.clone()).unwrap();
            prop_assert_eq!(Results::open(&path).unwrap().rows, vec![written]);
        }
    }

    #[test]
    fn a_row_takes_the_place_of_its_subject_and_counts_only_in_its_circumstances() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.csv");
        let mut results = Results::open(&path).unwrap();
        let old = Row { program: "1".into(), ..row("csr") };
        let new = Row { program: "2".into(), threads: 2, fingerprint: "f".into(), ..row("csr") };
        for row in [&old, &row("dense"), &new] {
            results.put(row.clone()).unwrap();
        }
        let results = Results::open(&path).unwrap();
        assert_eq!(results.rows, [new.clone(), row("dense")]);
        assert_eq!(results.finished(&Row { error: Some(1.0), ..new.clone() }), Some(&new));
        for other in [
            Row { program: "1".into(), ..new.clone() },
            Row { threads: 1, ..new.clone() },
            Row { fingerprint: "g".into(), ..new.clone() },
            Row { basis: "sh:5".into(), ..new.clone() },
        ] {
            assert_eq!(results.finished(&other), None);
        }
    }

    #[test]
    fn a_file_with_other_columns_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.csv");
        std::fs::write(&path, "scene,method\na,b\n").unwrap();
        let message = Results::open(&path).err().map(|e| format!("{e:#}")).unwrap_or_default();
        assert!(message.contains("results.csv: it has other columns"), "{message}");
    }
}
