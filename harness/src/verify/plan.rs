//! Which rows can be verified, by which files; and why the others cannot.

use crate::bench::Group;
use crate::cache;
use crate::fingerprint;
use crate::row::Row;
use std::path::{Path, PathBuf};

/// A row and its files.
pub(super) struct Work {
    pub(super) row: Row,
    /// The compressed matrix.
    pub(super) encoded: PathBuf,
    /// The matrix: .npz or .npy.
    pub(super) matrix: PathBuf,
}

/// Every row that has figures, one way or the other.
pub(super) struct Plan {
    pub(super) works: Vec<Work>,
    /// Rows that cannot be verified, and why.
    pub(super) left_out: Vec<(Row, String)>,
}

impl Plan {
    pub(super) fn new(out: &Path, groups: &[Group], rows: &[Row]) -> Plan {
        let mut plan = Plan { works: Vec::new(), left_out: Vec::new() };
        for row in rows.iter().filter(|row| row.is_ok()) {
            match files(out, groups, row) {
                Ok((encoded, matrix)) => plan.works.push(Work { row: row.clone(), encoded, matrix }),
                Err(reason) => plan.left_out.push((row.clone(), reason)),
            }
        }
        plan
    }

    /// Why there is nothing to do.
    pub(super) fn first_reason(&self) -> String {
        let reason = |(row, reason): &(Row, String)| format!("{}, {reason}", row.method);
        self.left_out.first().map_or_else(|| "none has figures".into(), reason)
    }
}

/// The compressed matrix and the matrix of a row.
fn files(out: &Path, groups: &[Group], row: &Row) -> Result<(PathBuf, PathBuf), String> {
    if row.program != fingerprint::program() {
        return Err("measured by another program".into());
    }
    let of_matrix = |group: &&Group| group.rows.iter().any(|r| r.is_ok() && same_matrix(r, row));
    let Some(group) = groups.iter().find(of_matrix) else { return Err("of a matrix that this run has not".into()) };
    let encoded = cache::encoded(out, &group.file_name, &row.method);
    if !encoded.exists() {
        return Err(format!("{} is not there", encoded.display()));
    }
    Ok((encoded, matrix(out, group, row)?))
}

fn same_matrix(a: &Row, b: &Row) -> bool {
    let of = |r: &Row| [&r.scene, &r.signal, &r.basis, &r.fingerprint].map(String::clone);
    of(a) == of(b)
}

/// A matrix of the user's is where it is, any other beside the results.
fn matrix(out: &Path, group: &Group, row: &Row) -> Result<PathBuf, String> {
    let kept = |extension| out.join("matrices").join(format!("{}.{extension}", group.file_name));
    let candidates =
        if row.signal == "file" { vec![PathBuf::from(&row.scene)] } else { vec![kept("npz"), kept("npy")] };
    let readable = |path: &PathBuf| {
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz") || e.eq_ignore_ascii_case("npy"))
    };
    match candidates.iter().find(|path| path.exists()) {
        Some(path) if readable(path) => Ok(path.clone()),
        Some(path) => Err(format!("{} is neither .npz nor .npy", path.display())),
        None => Err(format!("{} is not there", candidates[0].display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Status;

    #[test]
    fn what_cannot_be_verified_is_left_out_with_its_reason() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let row = |scene: &str, method: &str| Row {
            scene: scene.into(),
            method: method.into(),
            status: Status::Ok,
            program: fingerprint::program().into(),
            ..Row::default()
        };
        let group = |name: &str| Group {
            title: String::new(),
            file_name: format!("{name}-9"),
            rows: vec![row(name, "csr"), row(name, "dense")],
            ..Group::default()
        };
        for name in ["encoded", "matrices"] {
            std::fs::create_dir(out.join(name)).unwrap();
        }
        let there = ["encoded/teapot-9-csr.prt", "encoded/chair-9-csr.prt", "matrices/teapot-9.npy"];
        there.iter().for_each(|name| std::fs::write(out.join(name), "").unwrap());
        let old = Row { program: "0.0.9".into(), ..row("teapot", "f16") };
        let rows = [
            row("teapot", "csr"),
            row("teapot", "dense"),
            row("chair", "csr"),
            row("blob", "csr"),
            old,
            row("teapot", "vq").failed("no room"),
        ];
        let plan = Plan::new(out, &[group("teapot"), group("chair")], &rows);
        let [Work { row, encoded, matrix }] = &plan.works[..] else { panic!("{}", plan.works.len()) };
        assert_eq!((row, encoded, matrix), (&rows[0], &out.join(there[0]), &out.join(there[2])));
        let reasons: Vec<(&str, &str, &str)> = plan
            .left_out
            .iter()
            .map(|(row, reason)| (&row.scene[..], &row.method[..], reason.rsplit('/').next().unwrap()))
            .collect();
        let expected = [
            ("teapot", "dense", "teapot-9-dense.prt is not there"),
            ("chair", "csr", "chair-9.npz is not there"),
            ("blob", "csr", "of a matrix that this run has not"),
            ("teapot", "f16", "measured by another program"),
        ];
        assert_eq!(reasons, expected);
    }
}
