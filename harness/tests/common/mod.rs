//! How tests run the program.

use prt_harness::files::read_lights;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// A run of the program in a folder.
pub(crate) fn prt(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_prt")).args(arguments).current_dir(folder).output().expect("prt runs")
}

/// Standard output of a run that must succeed.
pub(crate) fn done(arguments: &[&str], folder: &Path) -> String {
    let output = prt(arguments, folder);
    let errors = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    assert_eq!(errors, "", "quiet where standard error is no terminal");
    String::from_utf8(output.stdout).unwrap()
}

#[allow(dead_code, reason = "each file of tests is a crate of its own, and not all compare responses")]
/// Σ (a - b)² / Σ b² of two files of responses.
pub(crate) fn difference(folder: &Path, a: &str, b: &str) -> f64 {
    let [a, b] = [a, b].map(|name| read_lights(&folder.join(name)).unwrap());
    let square = |values: ndarray::Array2<f32>| values.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
    square(&a - &b) / square(b)
}

#[allow(dead_code, reason = "each file of tests is a crate of its own, and not all are refused")]
/// The one sentence of a run that must fail with this code.
pub(crate) fn refused(code: i32, arguments: &[&str], folder: &Path) -> String {
    let output = prt(arguments, folder);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {errors}");
    assert_eq!(output.stdout, b"", "{arguments:?}");
    errors
}

#[allow(dead_code, reason = "each file of tests is a crate of its own, and not all read rows")]
/// The rows of a run, without what a clock says.
pub(crate) fn untimed(rows: &str) -> Vec<Value> {
    let mut rows: Vec<Value> = serde_json::from_str(rows).unwrap();
    for row in &mut rows {
        let clock = |name: &String| name.ends_with("_ms") || name.ends_with("_s") || name == "runs";
        row.as_object_mut().unwrap().retain(|name, _| !clock(name));
    }
    rows
}
