//! What files promise: everything written reads back, other programs' files are read at their value, and nothing is left
//! half-written.
#![cfg(feature = "io")]

mod atomic;
mod images;
mod matrices;
mod meshes;
mod prt;

/// A folder that goes with the test.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// The message of an error, which must name `place`.
fn names<T>(result: prt_transfer::Result<T>, place: &str) {
    let message = result.err().expect("an error").to_string();
    assert!(message.contains(place), "'{message}' does not name '{place}'");
}
