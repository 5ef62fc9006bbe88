//! What a command says: results on standard output, one sentence of failure on standard error.

use std::io::{ErrorKind, Write, stderr, stdout};

/// Prints a result and a line end. A reader that has had enough (a closed pipe) is no failure.
pub fn say(text: impl AsRef<str>) -> anyhow::Result<()> {
    match writeln!(stdout().lock(), "{}", text.as_ref()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(anyhow::Error::new(error).context("cannot write to standard output"))
        }
        _ => Ok(()),
    }
}

/// Prints `value` as indented JSON.
pub fn say_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    say(serde_json::to_string_pretty(value)?)
}

/// Prints a remark where a person reads it and a program does not. Nothing can be done about a failure.
pub fn remark(text: impl AsRef<str>) {
    let _ = writeln!(stderr().lock(), "{}", text.as_ref());
}
