//! How tests run the program.

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
