//! Table 1 as people and as programs read it.

use super::table1::{Measured, TITLE};
use crate::figures::outcome::Outcome;
use crate::machine::Machine;
use crate::number;
use crate::table::aligned;

/// Seconds and SE of both ways of encoding, the paper's or ours.
struct Pair([Option<(f64, f64)>; 2]);

impl Pair {
    /// Seconds and SE of either, then iterative over static.
    fn cells(&self) -> [Option<f64>; 6] {
        let [of_static, iterative] = self.0;
        let ratio = |part: fn((f64, f64)) -> f64| Some(part(iterative?) / part(of_static?));
        let (seconds, error) = (|pair: (f64, f64)| pair.0, |pair: (f64, f64)| pair.1);
        [
            of_static.map(seconds),
            of_static.map(error),
            iterative.map(seconds),
            iterative.map(error),
            ratio(seconds),
            ratio(error),
        ]
    }
}

impl Measured {
    fn papers(&self) -> Pair {
        Pair(self.line.printed.map(|printed| Some((printed.seconds, printed.error))))
    }

    fn ours(&self) -> Pair {
        let pair = |o: &Outcome| o.row.is_ok().then(|| Some((o.row.encode_s?, o.squared_error()?))).flatten();
        Pair([0, 1].map(|i| self.outcomes.get(i).and_then(pair)))
    }

    fn failures(&self) -> Vec<String> {
        let name = format!("{} {}", self.line.model, self.line.brdf);
        let missing = self.subject.as_ref().err().map(|reason| format!("{name}: {reason}"));
        let failed = self.outcomes.iter().filter(|o| !o.row.is_ok());
        missing.into_iter().chain(failed.map(|o| format!("{name}, {}: {}", o.row.method, o.row.reason))).collect()
    }
}

/// Two lines for each of the paper's: its own figures, then ours; then what failed.
pub(super) fn text(lines: &[Measured]) -> String {
    let titles = ["model", "m_p", "m_c", "n'", "static s", "SE", "iterative s", "SE", "time, it./st.", "SE, it./st."];
    let short = |figure: Option<f64>| figure.map_or_else(|| "-".into(), number::short);
    let rows = lines.iter().flat_map(|measured| {
        let line = measured.line;
        let sizes = |samples: usize, clusters: usize| [samples, clusters, line.components].map(|n| n.to_string());
        let paper = std::iter::once(format!("{} {} {}", line.model, line.brdf, line.matrix))
            .chain(sizes(line.mesh.vertices, line.clusters))
            .chain(as_printed(measured.papers().cells()));
        let samples = measured.outcomes.first().map_or(0, |o| o.row.samples);
        let scene =
            measured.subject.as_ref().map_or("not measured", |title| title.split(" · ").next().unwrap_or(title));
        let ours = std::iter::once(format!("  ours: {scene}"))
            .chain(sizes(samples, measured.clusters))
            .chain(measured.ours().cells().map(short));
        [paper.collect(), ours.collect()]
    });
    let failures = lines.iter().flat_map(Measured::failures);
    let table = aligned(&titles, rows.collect::<Vec<_>>().into_iter());
    [format!("\n{TITLE}"), table].into_iter().chain(failures).collect::<Vec<_>>().join("\n")
}

/// Digits as they are printed, but for the ratios, which are not.
fn as_printed([a, b, c, d, time, error]: [Option<f64>; 6]) -> impl Iterator<Item = String> {
    let printed = [a, b, c, d].map(|figure| figure.map_or_else(|| "-".into(), |f| f.to_string()));
    let ratios = [time, error].map(|figure| figure.map_or_else(|| "-".into(), number::short));
    printed.into_iter().chain(ratios)
}

/// A line for each of the paper's, with the machine in every line.
pub(super) fn csv(lines: &[Measured], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let figures = ["static_s", "static_se", "iterative_s", "iterative_se", "time_ratio", "se_ratio"];
    let head = ["model", "brdf", "matrix", "components", "paper_samples", "paper_clusters"].map(String::from);
    let ours = ["subject", "samples", "clusters", "reason"].map(String::from);
    let papers = figures.map(|name| format!("paper_{name}"));
    let head = head.into_iter().chain(papers).chain(ours).chain(figures.map(String::from));
    writer.write_record(head.chain(["static_error", "iterative_error", "machine"].map(String::from)))?;
    let text = |figure: Option<f64>| figure.map_or(String::new(), |f| f.to_string());
    for measured in lines {
        let line = measured.line;
        let head = [line.model.into(), line.brdf.into(), line.matrix.into(), line.components.to_string()];
        let sizes = [line.mesh.vertices, line.clusters].map(|n| n.to_string());
        let samples = measured.outcomes.first().map_or(0, |o| o.row.samples);
        let subject = measured.subject.clone().unwrap_or_default();
        let ours = [subject, samples.to_string(), measured.clusters.to_string(), measured.failures().join("; ")];
        let errors = [0, 1].map(|i| text(measured.outcomes.get(i).and_then(|o| o.row.error)));
        let cells = head.into_iter().chain(sizes).chain(measured.papers().cells().map(text)).chain(ours);
        writer.write_record(cells.chain(measured.ours().cells().map(text)).chain(errors).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
