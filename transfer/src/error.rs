//! The one error type of the workspace. Every variant carries what was expected, what came, and where.

use std::path::PathBuf;

/// Bytes that a message shows of a text.
const LONGEST: usize = 400;

/// A text that may be a stranger's: cut where it is long, its control characters written out, so that a message stays one line and no file speaks to
/// the terminal.
fn shown(text: &str) -> String {
    let mut shown = String::new();
    for c in text.chars() {
        if shown.len() >= LONGEST {
            shown.push('…');
            break;
        }
        if c.is_control() { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown
}

/// What went wrong, with the numbers that a user needs to mend it. One line says everything: causes are part of the message
/// and not handed out by [`std::error::Error::source`] a second time.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Two sizes that must agree do not. Give the operation arrays of the stated size.
    #[error("{}: expected {expected}, found {found}", shown(what))]
    Shape {
        /// The size that was checked, with its place.
        what: String,
        /// The size that fits.
        expected: usize,
        /// The size that came.
        found: usize,
    },
    /// A NaN or an infinity. Remove it at the source: no method can compress it.
    #[error("row {row}, column {col}: {value} is not a finite number")]
    NotFinite {
        /// Row, counted from 0.
        row: usize,
        /// Column, counted from 0.
        col: usize,
        /// The value that came.
        value: f64,
    },
    /// Columns of a sparse row must ascend strictly (no duplicates) and lie inside the matrix.
    #[error("row {row}: column {col} at position {position} must be above {previous} and below {cols}")]
    Columns {
        /// Row, counted from 0.
        row: usize,
        /// Position among the stored elements of the whole matrix.
        position: usize,
        /// The column that came.
        col: u64,
        /// The column before it; -1 at the start of a row.
        previous: i64,
        /// Columns of the matrix.
        cols: usize,
    },
    /// A parameter outside its range, or not a value of its type.
    #[error("{method}: {}={} must be {expected}", shown(name), shown(value))]
    Parameter {
        /// The codec or transform.
        method: String,
        /// The parameter.
        name: String,
        /// What was given.
        value: String,
        /// What would be accepted.
        expected: String,
    },
    /// A name that nothing here bears. `prt methods` lists what there is.
    #[error("unknown {what} '{}'; known: {known}", shown(name))]
    Unknown {
        /// The kind of name: codec, transform, parameter, scene.
        what: &'static str,
        /// The name that came.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A label that does not follow `transform:name=value+codec:name=value`.
    #[error("label '{}': {}", shown(label), shown(problem))]
    Label {
        /// The whole label.
        label: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Two things that cannot be combined, such as a transform and a basis that it is not defined on.
    #[error("{}: expected {}, found {}", shown(what), shown(expected), shown(found))]
    Unsupported {
        /// The operation.
        what: String,
        /// What it needs.
        expected: String,
        /// What it was given.
        found: String,
    },
    /// A file whose content breaks its format. The file is damaged, cut short, or not of this kind.
    #[error("{format}: {}: expected {}, found {}", shown(place), shown(expected), shown(found))]
    Format {
        /// The format, by its file extension.
        format: &'static str,
        /// Where: byte offset, line, entry or section.
        place: String,
        /// What the format asks for.
        expected: String,
        /// What is there.
        found: String,
    },
    /// The operating system refused an operation on a file.
    #[error("cannot {action} {}: {cause}", path.display())]
    Io {
        /// The operation: read, write, create, rename.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        cause: std::io::Error,
    },
    /// A file failed to parse; the inner error says where.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        cause: Box<Error>,
    },
    /// More than the format or this program can hold.
    #[error("{}: {found} is above the limit of {limit}", shown(what))]
    TooLarge {
        /// The quantity.
        what: String,
        /// The most that is accepted.
        limit: u64,
        /// What came.
        found: u64,
    },
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// The workspace's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// The same error, with the file it came from.
    pub fn in_file(self, path: impl Into<PathBuf>) -> Error {
        match self {
            Error::Io { .. } | Error::File { .. } | Error::Cancelled => self,
            inner => Error::File { path: path.into(), cause: Box::new(inner) },
        }
    }

    /// `Ok` where two sizes agree, [`Error::Shape`] where they do not.
    pub fn expect_size(what: impl Into<String>, expected: usize, found: usize) -> Result<()> {
        if expected == found { Ok(()) } else { Err(Error::Shape { what: what.into(), expected, found }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_says_is_shown_in_one_line_of_bounded_length_without_control_characters() {
        let name = format!("a\n\u{1b}[31m{}", "x".repeat(100_000));
        let message = Error::Unknown { what: "codec", name, known: "csr".into() }.to_string();
        assert!(message.starts_with("unknown codec 'a\\n\\u{1b}[31mxxx") && message.ends_with("x…'; known: csr"));
        assert!(message.len() < 500);
    }
}
