//! MatrixMarket files, `.mtx`: a text of one element per line.
//!
//! Read: `coordinate` and `array`, `real`, `integer` and `pattern` (1), `general`, `symmetric` and `skew-symmetric`;
//! elements given twice are summed. Written: `coordinate real general`, every `f32` with the digits that read back the
//! same.

use super::element::overflow;
use super::matrix::Description;
use super::triplets::{Triplets, lights, rows_of};
use super::{atomic, broken, open};
use crate::error::{Error, Result};
use crate::matrix::TransferMatrix;
use std::io::BufRead;
use std::path::Path;

#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
}

/// The first line, and the sizes after the comments.
struct Banner {
    coordinate: bool,
    pattern: bool,
    symmetry: Symmetry,
}

/// Reads a matrix: sparse from `coordinate`, dense from `array`.
pub fn read(path: impl AsRef<Path>, description: &Description) -> Result<TransferMatrix> {
    let path = path.as_ref();
    read_from(open(path)?, description).map_err(|e| e.in_file(path))
}

/// As [`read`], from any source.
pub fn read_from(source: impl BufRead, description: &Description) -> Result<TransferMatrix> {
    let mut lines = Lines { source, number: 0, text: String::new() };
    let banner = lines.banner()?;
    if banner.coordinate { lines.coordinate(&banner, description) } else { lines.array(&banner, description) }
}

/// Writes `coordinate real general`. Responses and basis are not kept.
pub fn write(path: impl AsRef<Path>, matrix: &TransferMatrix) -> Result<()> {
    atomic::write(path, |file| {
        writeln!(file, "%%MatrixMarket matrix coordinate real general")?;
        writeln!(file, "{} {} {}", matrix.rows(), matrix.lights(), matrix.non_zeros())?;
        for row in 0..matrix.rows() {
            for (column, value) in matrix.row(row).non_zeros() {
                let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
                let shorter = if exponent.len() < plain.len() { exponent } else { plain };
                writeln!(file, "{} {} {shorter}", row + 1, column + 1)?;
            }
        }
        Ok(())
    })
}

/// Lines that carry something, with their numbers.
struct Lines<R> {
    source: R,
    number: usize,
    text: String,
}

impl<R: BufRead> Lines<R> {
    fn broken(&self, expected: impl Into<String>, found: impl Into<String>) -> Error {
        broken("mtx", format!("line {}", self.number), expected, found)
    }
    fn next_line(&mut self) -> Result<bool> {
        self.text.clear();
        self.number += 1;
        let read = self.source.read_line(&mut self.text);
        read.map(|length| length > 0).map_err(|e| self.broken("a line of text", e.to_string()))
    }
    /// The next line that is neither blank nor a comment; `expected` says what should be there.
    fn content(&mut self, expected: impl Fn() -> String) -> Result<()> {
        loop {
            if !self.next_line()? {
                return Err(self.broken(expected(), "the end of the file"));
            }
            let text = self.text.trim();
            if !text.is_empty() && !text.starts_with('%') {
                return Ok(());
            }
        }
    }
    fn end(&mut self) -> Result<()> {
        while self.next_line()? {
            let text = self.text.trim();
            if !text.is_empty() && !text.starts_with('%') {
                return Err(self.broken("no more elements", text.chars().take(40).collect::<String>()));
            }
        }
        Ok(())
    }

    fn banner(&mut self) -> Result<Banner> {
        self.next_line()?;
        let line = self.text.to_ascii_lowercase();
        let words: Vec<&str> = line.split_whitespace().collect();
        let [mark, object, format, field, symmetry] = words[..] else {
            return Err(self.broken("%%MatrixMarket matrix coordinate real general", shown(&self.text)));
        };
        if (mark, object) != ("%%matrixmarket", "matrix") {
            return Err(self.broken("%%MatrixMarket matrix", format!("{mark} {object}")));
        }
        let coordinate = match format {
            "coordinate" => true,
            "array" => false,
            _ => return Err(self.broken("coordinate or array", format)),
        };
        if !matches!(field, "real" | "double" | "integer" | "pattern") || (field == "pattern" && !coordinate) {
            return Err(self.broken("real, integer or (coordinates only) pattern", field));
        }
        let symmetry = match symmetry {
            "general" => Symmetry::General,
            "symmetric" => Symmetry::Symmetric,
            "skew-symmetric" => Symmetry::Skew,
            _ => return Err(self.broken("general, symmetric or skew-symmetric", symmetry)),
        };
        Ok(Banner { coordinate, pattern: field == "pattern", symmetry })
    }

    /// `N` whole numbers of the line of sizes.
    fn sizes<const N: usize>(&mut self, banner: &Banner) -> Result<[u64; N]> {
        let what = if N == 3 { "rows, columns, elements" } else { "rows, columns" };
        self.content(|| what.into())?;
        let sizes: Option<Vec<u64>> = self.text.split_whitespace().map(|w| w.parse().ok()).collect();
        let sizes: [u64; N] =
            sizes.and_then(|s| s.try_into().ok()).ok_or_else(|| self.broken(what, shown(&self.text)))?;
        if banner.symmetry != Symmetry::General && sizes[0] != sizes[1] {
            return Err(self.broken("a square symmetric matrix", shown(&self.text)));
        }
        Ok(sizes)
    }

    fn coordinate(&mut self, banner: &Banner, description: &Description) -> Result<TransferMatrix> {
        let [rows, columns, count] = self.sizes(banner)?;
        lights(columns)?;
        let mut triplets = Triplets { rows: Vec::new(), columns: Vec::new(), values: Vec::new() };
        let mut push = |row: u32, column: u32, value: f32| {
            triplets.rows.push(row);
            triplets.columns.push(column);
            triplets.values.push(value);
        };
        for read in 0..count {
            self.content(|| format!("{count} elements, read {read}"))?;
            let (row, column, value) = self.element(banner, rows, columns)?;
            push(row, column, value);
            if row != column {
                match banner.symmetry {
                    Symmetry::General => {}
                    Symmetry::Symmetric => push(column, row, value),
                    Symmetry::Skew => push(column, row, -value),
                }
            }
        }
        self.end()?;
        triplets.compress((rows, columns))?.matrix(description, Description::default())
    }

    fn element(&self, banner: &Banner, rows: u64, columns: u64) -> Result<(u32, u32, f32)> {
        let mut words = self.text.split_whitespace();
        let mut index = |what: &str, limit: u64| {
            let word = words.next().unwrap_or_default();
            match word.parse::<u64>() {
                Ok(i) if (1..=limit.min(u32::MAX.into())).contains(&i) => Ok((i - 1) as u32),
                _ => Err(self.broken(format!("a {what} from 1 to {limit}"), shown(word))),
            }
        };
        let (row, column) = (index("row", rows)?, index("column", columns)?);
        let value = if banner.pattern { 1.0 } else { self.value(words.next(), row as usize, column as usize)? };
        match words.next() {
            Some(extra) => Err(self.broken("the end of the line", shown(extra))),
            None => Ok((row, column, value)),
        }
    }

    fn value(&self, word: Option<&str>, row: usize, column: usize) -> Result<f32> {
        let word = word.unwrap_or_default();
        let wide: f64 = word.parse().map_err(|_| self.broken("a number", shown(word)))?;
        match wide as f32 {
            value if value.is_finite() => Ok(value),
            _ if wide.is_finite() => Err(overflow("mtx", row, column, wide)),
            _ => Err(Error::NotFinite { row, col: column, value: wide }),
        }
    }

    /// Column after column; of a symmetric matrix only the lower triangle, of a skew one without the diagonal.
    fn array(&mut self, banner: &Banner, description: &Description) -> Result<TransferMatrix> {
        let [rows, columns] = self.sizes(banner)?;
        let lights = lights(columns)?;
        let rows = rows_of(rows, lights)?;
        let first = |column: usize| match banner.symmetry {
            Symmetry::General => 0,
            Symmetry::Symmetric => column,
            Symmetry::Skew => column + 1,
        };
        // Grows with the lines that are there; the full matrix is at most twice as large.
        let mut stored = Vec::new();
        for column in 0..lights {
            for row in first(column)..rows {
                self.content(|| format!("element {}, {}", row + 1, column + 1))?;
                let mut words = self.text.split_whitespace();
                stored.push(self.value(words.next(), row, column)?);
                if let Some(extra) = words.next() {
                    return Err(self.broken("one number on a line", shown(extra)));
                }
            }
        }
        self.end()?;
        let mut values = vec![0f32; rows * lights];
        let mut stored = stored.into_iter();
        for column in 0..lights {
            for (row, value) in (first(column)..rows).zip(&mut stored) {
                values[row * lights + column] = value;
                match banner.symmetry {
                    Symmetry::General => {}
                    Symmetry::Symmetric => values[column * lights + row] = value,
                    Symmetry::Skew => values[column * lights + row] = -value,
                }
            }
        }
        let (responses, basis) = description.and(Description::default(), lights)?;
        TransferMatrix::from_dense(values, rows, responses.responses(), basis)?.with_responses(responses)
    }
}

/// The beginning of what a line holds.
fn shown(text: &str) -> String {
    format!("'{}'", text.trim().chars().take(40).collect::<String>())
}
