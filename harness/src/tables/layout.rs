//! A table as papers print it, quantities downwards and scenes across, and the same as one line of CSV a measurement.

use super::quantity::{BASELINE, Measured, OF_MATRIX, OF_METHOD, Quantity};
use super::survey::Survey;
use crate::machine::Machine;
use crate::row::Row;
use crate::table::aligned;

/// One table, ready to be written.
pub struct Layout<'a> {
    title: &'a str,
    surveys: &'a [Survey],
    methods: &'a [String],
}

/// What stands in a cell that has no figure.
const NOTHING: &str = "-";

impl<'a> Layout<'a> {
    /// Of these scenes, each measured by these methods.
    pub fn new(title: &'a str, surveys: &'a [Survey], methods: &'a [String]) -> Layout<'a> {
        Layout { title, surveys, methods }
    }

    /// Aligned for a terminal.
    pub fn terminal(&self) -> String {
        let parts = [format!("\n{}", self.title), aligned(&self.titles(), self.lines().into_iter())];
        parts.into_iter().chain(self.failures()).collect::<Vec<_>>().join("\n")
    }

    /// As a section of Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule = format!("| --- |{}\n", " ---: |".repeat(self.titles().len() - 1));
        let lines: String = self.lines().iter().map(|cells| line(cells)).collect();
        let failures: String = self.failures().iter().map(|failure| format!("- {failure}\n")).collect();
        format!("## {}\n\n{}{rule}{lines}\n{failures}", self.title, line(&self.titles()))
    }

    /// One line for each scene and method, with the machine in every line.
    pub fn csv(&self, machine: &Machine) -> anyhow::Result<Vec<u8>> {
        let quantities = || OF_MATRIX.iter().chain(&OF_METHOD);
        let printed: Vec<&str> = quantities().map(|q| q.name).filter(|name| self.prints(name)).collect();
        let mut writer = csv::Writer::from_writer(Vec::new());
        let head = ["scene", "subject", "method", "status", "reason"].map(String::from).into_iter();
        let ours = quantities().map(|q| q.name.to_string());
        let papers = printed.iter().map(|name| format!("paper_{name}"));
        writer.write_record(head.chain(ours).chain(papers).chain(["error".into(), "machine".into()]))?;
        let text = |figure: Option<f64>| figure.map_or(String::new(), |f| f.to_string());
        for survey in self.surveys {
            for row in &survey.rows {
                let status = if row.is_ok() { "ok" } else { "failed" };
                let subject = survey.subject.as_deref().unwrap_or_default();
                let head = [survey.scene.name, subject, &row.method, status, &row.reason].map(String::from).into_iter();
                let ours = quantities().map(|q| text(survey.figure(row, q)));
                let papers = printed.iter().map(|name| text(survey.scene.printed(name)));
                writer.write_record(head.chain(ours).chain(papers).chain([text(row.error), machine.line()]))?;
            }
        }
        Ok(writer.into_inner()?)
    }

    /// Whether the paper prints a quantity for any of the scenes.
    fn prints(&self, quantity: &str) -> bool {
        self.surveys.iter().any(|survey| survey.scene.printed(quantity).is_some())
    }

    fn titles(&self) -> Vec<String> {
        let titles = self.surveys.iter().flat_map(|survey| match &survey.subject {
            Some(subject) if survey.scene.printed.is_empty() => vec![subject.clone()],
            Some(subject) => vec![subject.clone(), "paper".into()],
            None => vec![format!("{} (paper)", survey.scene.name)],
        });
        std::iter::once(String::new()).chain(titles).collect()
    }

    /// The matrix's quantities, then those of each method under its label.
    fn lines(&self) -> Vec<Vec<String>> {
        let of_matrix = OF_MATRIX.iter().map(|quantity| self.line(quantity, Survey::known));
        let of_methods = self.methods.iter().flat_map(|method| {
            let label = std::iter::once(format!("[{method}]"));
            let label = label.chain(std::iter::repeat_n(String::new(), self.titles().len() - 1)).collect();
            let of = OF_METHOD.iter().map(move |quantity| self.line(quantity, |survey| survey.by(method)));
            std::iter::once(label).chain(of)
        });
        of_matrix.chain(of_methods).collect()
    }

    fn line(&self, quantity: &Quantity, row: impl Fn(&Survey) -> Option<&Row>) -> Vec<String> {
        let text = |figure: Option<f64>| figure.map_or(NOTHING.into(), quantity.text);
        let cells = self.surveys.iter().flat_map(|survey| {
            let ours = survey.subject.is_some().then(|| text(row(survey).and_then(|row| survey.figure(row, quantity))));
            let paper = (!survey.scene.printed.is_empty()).then(|| text(survey.scene.printed(quantity.name)));
            ours.into_iter().chain(paper)
        });
        std::iter::once(quantity.title.to_string()).chain(cells).collect()
    }

    /// Why there are no figures; one sentence where a scene failed by all methods for the same reason.
    fn failures(&self) -> Vec<String> {
        let mut told: Vec<String> = Vec::new();
        for survey in self.surveys {
            let name = survey.subject.as_deref().unwrap_or(survey.scene.name);
            let Some(first) = survey.rows.first() else { continue };
            if survey.rows.iter().all(|row| !row.is_ok() && row.reason == first.reason) {
                told.push(format!("{name}: {}", first.reason));
            } else {
                let failed = survey.rows.iter().filter(|row| !row.is_ok());
                told.extend(failed.map(|row| format!("{name}, {}: {}", row.method, row.reason)));
            }
        }
        told
    }
}

impl Survey {
    /// The figure of a row; none of a matrix that never was.
    fn figure(&self, row: &Row, quantity: &Quantity) -> Option<f64> {
        let baseline = self.by(BASELINE).filter(|row| row.is_ok());
        (row.samples > 0).then(|| (quantity.of)(Measured { row, baseline })).flatten()
    }

    fn by(&self, method: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.method == method)
    }

    /// Any row: they all know the matrix.
    fn known(&self) -> Option<&Row> {
        self.rows.first()
    }
}
