//! The one way to lay out a table of a paper: what is printed is a line, what was measured in its place the lines below it.

use crate::machine::Machine;
use crate::number::{self, short};
use crate::table::{aligned, wrapped};

/// A quantity.
#[derive(Clone, Copy)]
pub struct Column {
    /// In the CSV.
    pub name: &'static str,
    /// For people, with its unit; empty for what programs alone read.
    pub title: &'static str,
    /// How people read it.
    pub show: fn(f64) -> String,
}

/// What stands in a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Cell {
    /// Not printed, or not measured.
    #[default]
    Nothing,
    /// A figure, shown as the column shows them.
    Figure(f64),
    /// A figure in the digits of the print.
    Printed(f64),
    /// What is no figure.
    Words(String),
}

/// A line of the paper's table, or one that was measured in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// As people read it.
    name: String,
    is_printed: bool,
    /// Scene, mesh, shape or light.
    subject: String,
    /// A label; the paper's lines may have none.
    method: String,
    /// Under the columns, or the reason why there are none.
    cells: Result<Vec<Cell>, String>,
}

/// A table: ours beside theirs.
pub struct Beside {
    /// What is added to the figure's name in the name of the file.
    pub addition: &'static str,
    /// What stands above it.
    pub title: String,
    /// What was measured, a line each.
    pub subjects: Vec<String>,
    /// Over the names of lines.
    pub head: &'static str,
    /// Over their cells.
    pub columns: Vec<Column>,
    /// The paper's, each with ours below it.
    pub lines: Vec<Line>,
    /// Why ours differ, in a sentence or two.
    pub why: &'static str,
}

impl Column {
    /// Three digits of it are enough for people.
    pub const fn new(name: &'static str, title: &'static str) -> Column {
        Column { name, title, show: short }
    }

    /// A count.
    pub const fn whole(name: &'static str, title: &'static str) -> Column {
        Column { name, title, show: |value| format!("{value:.0}") }
    }

    /// Bytes, with a decimal unit.
    pub const fn bytes(name: &'static str, title: &'static str) -> Column {
        Column { name, title, show: |value| number::bytes(value.round() as u64) }
    }
}

impl From<f64> for Cell {
    fn from(figure: f64) -> Cell {
        Cell::Figure(figure)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Cell {
        Cell::Figure(count as f64)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Cell {
        Cell::Figure(count as f64)
    }
}

impl From<&str> for Cell {
    fn from(words: &str) -> Cell {
        Cell::Words(words.into())
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(cell: Option<T>) -> Cell {
        cell.map_or(Cell::Nothing, T::into)
    }
}

impl Cell {
    fn shown(&self, column: &Column) -> String {
        match self {
            Cell::Nothing => "-".into(),
            Cell::Figure(figure) => (column.show)(*figure),
            Cell::Printed(figure) => figure.to_string(),
            Cell::Words(words) => words.clone(),
        }
    }

    fn exact(&self) -> String {
        match self {
            Cell::Nothing => String::new(),
            Cell::Figure(figure) | Cell::Printed(figure) => figure.to_string(),
            Cell::Words(words) => words.clone(),
        }
    }
}

impl Line {
    /// What is printed for a subject.
    pub fn printed(subject: impl Into<String>, cells: Vec<Cell>) -> Line {
        let subject = subject.into();
        let name = format!("{subject}, the paper's");
        Line { name, is_printed: true, subject, method: String::new(), cells: Ok(cells) }
    }

    /// What was measured for a subject by a method, under a name that is short enough for people; or why nothing was.
    pub fn ours(
        name: impl Into<String>,
        (subject, method): (impl Into<String>, impl Into<String>),
        cells: Result<Vec<Cell>, String>,
    ) -> Line {
        Line { name: name.into(), is_printed: false, subject: subject.into(), method: method.into(), cells }
    }

    /// Whether something was measured.
    pub fn is_measured(&self) -> bool {
        !self.is_printed && self.cells.is_ok()
    }

    fn cell(&self, column: usize) -> &Cell {
        const NOTHING: &Cell = &Cell::Nothing;
        self.cells.as_ref().ok().and_then(|cells| cells.get(column)).unwrap_or(NOTHING)
    }
}

impl Beside {
    /// Aligned for a terminal.
    pub fn terminal(&self) -> String {
        let indented = |line: &Line| format!("{}{}", if line.is_printed { "" } else { "  " }, line.name);
        let lines = self.lines.iter().map(|line| self.shown(indented(line), line));
        let head = std::iter::once(format!("\n{}", self.title)).chain(self.subjects.iter().cloned());
        let parts = head.chain([aligned(&self.titles(), lines)]).chain(self.failures()).chain([wrapped(self.why)]);
        parts.collect::<Vec<_>>().join("\n")
    }

    /// As a section of Markdown; what is printed stands out.
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let bold = |line: &Line| if line.is_printed { format!("**{}**", line.name) } else { line.name.clone() };
        let titles = self.titles();
        let rule = format!("| --- |{}\n", " ---: |".repeat(titles.len() - 1));
        let lines: String = self.lines.iter().map(|of| line(self.shown(bold(of), of))).collect();
        let subjects: String = self.subjects.iter().map(|subject| format!("{subject}\n\n")).collect();
        let remarks: String = self.failures().map(|failure| format!("- {failure}\n")).collect();
        format!("## {}\n\n{subjects}{}{rule}{lines}\n{remarks}\n{}\n", self.title, line(titles), self.why)
    }

    /// One line for each of the table's, with the machine in those that were measured.
    pub fn csv(&self, machine: &Machine) -> anyhow::Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let head = ["source", "subject", "method", "status", "reason"].into_iter();
        writer.write_record(head.chain(self.columns.iter().map(|column| column.name)).chain(["machine"]))?;
        for line in &self.lines {
            let status = if line.cells.is_ok() { "ok" } else { "failed" };
            let (source, machine) =
                if line.is_printed { ("paper", String::new()) } else { ("measured", machine.line()) };
            let reason = line.cells.as_ref().err().cloned().unwrap_or_default();
            let head = [source.into(), line.subject.clone(), line.method.clone(), status.into(), reason];
            let cells = (0..self.columns.len()).map(|column| line.cell(column).exact());
            writer.write_record(head.into_iter().chain(cells).chain([machine]))?;
        }
        Ok(writer.into_inner()?)
    }

    /// Whether anything was measured.
    pub fn is_measured(&self) -> bool {
        self.lines.iter().any(Line::is_measured)
    }

    fn visible(&self) -> impl Iterator<Item = (usize, &Column)> {
        self.columns.iter().enumerate().filter(|(_, column)| !column.title.is_empty())
    }

    fn titles(&self) -> Vec<String> {
        let titles = self.visible().map(|(_, column)| column.title.to_string());
        std::iter::once(self.head.to_string()).chain(titles).collect()
    }

    fn shown(&self, name: String, line: &Line) -> Vec<String> {
        let cells = self.visible().map(|(at, column)| line.cell(at).shown(column));
        std::iter::once(name).chain(cells).collect()
    }

    /// Why there are no figures; lines that failed for the same reason one after the other are told once.
    fn failures(&self) -> impl Iterator<Item = String> {
        let failed = self.lines.iter().filter_map(|line| Some((line, line.cells.as_ref().err()?)));
        let mut told: Vec<(&Line, &String)> = failed.collect();
        told.dedup_by(|next, last| next.1 == last.1 && next.0.subject == last.0.subject);
        told.into_iter().map(|(line, reason)| format!("{}: {reason}", line.name))
    }
}
