//! The table on the terminal, within 120 columns.

use crate::bench::Group;
use crate::number::{bytes, count, short};
use crate::row::Row;
use crate::timing::is_unsteady;
use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Table, TableStyle};

/// A column: its title, and its figure as a person reads it, where there is one.
type Column = (&'static str, fn(&Row) -> Option<String>);

/// The table's columns besides the method.
const COLUMNS: [Column; 11] = [
    ("memory", |r| r.resident_bytes.map(bytes)),
    ("file", |r| r.file_bytes.map(bytes)),
    ("B/nnz", |r| r.bytes_per_non_zero.map(short)),
    ("FLOPs", |r| r.flops().map(count)),
    ("error", |r| r.error.map(short)),
    ("sphere", |r| r.error_sphere.map(short)),
    ("sky", |r| r.error_relit_sky.map(short)),
    ("room", |r| r.error_relit_room.map(short)),
    ("enc s", |r| timed(r.encode_s, r.encode_spread_s)),
    ("1 thr", |r| timed(r.relight_1_ms, r.relight_1_spread_ms)),
    ("all", |r| timed(r.relight_all_ms, r.relight_all_spread_ms)),
];

/// What stands before a time that was not the same twice.
const UNSTEADY: &str = "~";

/// What the columns mean, in a line.
pub const LEGEND: &str = "memory: bytes that relighting holds; file: the .prt; B/nnz: memory by non-zero of T; FLOPs: of \
relighting one channel\nerror: Σ(T-T̃)²/ΣT²; sphere: the same over the sphere; sky, room: of relit output\nenc s: encoding in s; \
1 thr, all: relighting one channel on one thread and on all, median in ms; ~: half of the runs lie more than 10 % apart";

/// Columns of a terminal that everybody has.
const WIDTH: u16 = 120;

/// A median, marked where half of its runs lie further apart than they should.
fn timed(median: Option<f64>, spread: Option<f64>) -> Option<String> {
    let mark = if is_unsteady(median, spread) { UNSTEADY } else { "" };
    Some(format!("{mark}{}", short(median?)))
}

/// Title, rows and the reasons of those that failed.
pub fn of(group: &Group) -> String {
    let titles: Vec<&str> = std::iter::once("method").chain(COLUMNS.iter().map(|(title, _)| *title)).collect();
    let rows = group.rows.iter().map(|row| {
        let figures = COLUMNS.iter().enumerate().map(|(i, (_, figure))| match (row.is_ok(), i) {
            (true, _) => figure(row).unwrap_or_else(|| "-".into()),
            (false, 0) => "failed".into(),
            (false, _) => "-".into(),
        });
        std::iter::once(row.method.clone()).chain(figures).collect()
    });
    let failed = group.rows.iter().filter(|r| !r.is_ok()).map(|r| format!("{}: {}", r.method, r.reason));
    let parts = [format!("\n{}", group.title), aligned(&titles, rows)].into_iter().chain(failed);
    parts.collect::<Vec<_>>().join("\n")
}

/// Lines under their titles within the width of a terminal: the first column to the left, the others to the right.
pub fn aligned<S: ToString>(titles: &[S], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut table = Table::new();
    table
        .load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')))
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(WIDTH);
    let cells = |texts: Vec<String>| {
        let cell = |(i, text): (usize, String)| match i {
            0 => Cell::new(text),
            _ => Cell::new(text).set_alignment(CellAlignment::Right),
        };
        texts.into_iter().enumerate().map(cell).collect::<Vec<_>>()
    };
    table.set_header(cells(titles.iter().map(S::to_string).collect()));
    rows.for_each(|row| {
        table.add_row(cells(row));
    });
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 1));
        // A long label is broken, a figure never.
        if i > 0 {
            column.set_constraint(ColumnConstraint::ContentWidth);
        }
    }
    table.lines().map(|line| line.trim_end().to_string()).collect::<Vec<_>>().join("\n")
}

/// Prose in lines of that width.
pub fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > 0 && line + 1 + word.chars().count() > usize::from(WIDTH) {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(if line.is_empty() { "" } else { " " });
            line.push_str(word);
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Status;

    #[test]
    fn prose_keeps_its_words_in_as_few_lines_as_they_fit_in() {
        let text = "word ".repeat(60);
        let lines: Vec<String> = wrapped(&text).lines().map(String::from).collect();
        assert_eq!(lines.iter().map(|line| line.len()).collect::<Vec<_>>(), [119, 119, 59]);
        assert_eq!((lines.join(" "), wrapped("")), (text.trim().into(), String::new()));
    }

    #[test]
    fn the_widest_figures_fit_in_120_columns_and_a_failure_gives_its_reason() {
        let (number, time, size) = (Some(9.99e-12), Some(9.99e-4), Some(999_999_999_u64));
        let row = Row {
            method: "haar:scale=sphere+truncate:terms=256".into(),
            status: Status::Ok,
            encode_s: time,
            resident_bytes: size,
            file_bytes: size,
            bytes_per_non_zero: Some(12.3),
            multiplications: size,
            additions: size,
            error: number,
            error_sphere: number,
            error_relit_sky: number,
            error_relit_room: number,
            relight_1_ms: time,
            relight_1_spread_ms: Some(9.0e-4),
            relight_all_ms: time,
            relight_all_spread_ms: Some(9.0e-5),
            ..Row::default()
        };
        let failed = Row { method: "dense".into(), ..Row::default() }.failed("would need 9 GB");
        let text = of(&Group { title: "teapot".into(), rows: vec![row, failed], ..Group::default() });
        let widest = text.lines().map(|l| l.chars().count()).max().unwrap();
        assert!(widest <= 120, "{widest}\n{text}");
        assert!(text.contains("1.0e-11"), "no figure is broken\n{text}");
        assert_eq!(text.matches("~1.0e-3").count(), 1, "a spread of 90 % is marked, one of 9 % is not\n{text}");
        assert!(text.ends_with("dense: would need 9 GB"), "{text}");
        assert!(text.lines().any(|l| l.starts_with("dense") && l.contains("failed")), "{text}");
    }
}
