//! Table 1 as people and as programs read it.

use super::table1::{LINES, Line, OfFields, PAPERS_PICTURES, Pictures};
use crate::light_field::Shape;
use crate::machine::Machine;
use crate::number::short;
use crate::table::aligned;
use prt_transfer::params::Value;
use prt_transfer::responses::Directions;

const TITLE: &str = "Table 1: surface light fields of a Cornell box (Miandji et al. 2011)";

/// The paper's lines, each with ours below it.
pub(super) fn text(shapes: &[(Directions, Shape)], pictures: &Pictures) -> String {
    let titles = ["shape", "X", "Y", "Z", "W", "k", "η", "Eq. 5", "F / file", "error", "trace min", "encode s"];
    let lines = LINES.iter().flat_map(|line| {
        let named = |(_, shape): &&(Directions, Shape)| line.ours.contains(&shape.shape.as_str());
        std::iter::once(of_paper(line)).chain(shapes.iter().filter(named).map(ours))
    });
    let table = aligned(&titles, lines);
    [format!("\n{TITLE}"), table, of_pictures(pictures)].join("\n")
}

fn of_paper(line: &Line) -> Vec<String> {
    let Line { shape, sizes: [x, y, z, w], components, clusters, minutes, encode_s, .. } = line;
    // Eq. 5 for three channels, a number for each id.
    let [m, n, k, eta] = [x * y, z * w, *components, *clusters].map(|v| v as f64);
    let ratio = 3.0 * m * n / (3.0 * m * k + 3.0 * eta * n * k + 4.0 * m);
    let sizes = [*x, *y, *z, *w, *components, *clusters].map(|v| v.to_string());
    let figures = [short(ratio), "-".into(), "-".into(), short(*minutes), short(*encode_s)];
    std::iter::once(format!("{shape}, the paper's")).chain(sizes).chain(figures).collect()
}

fn ours((frame, shape): &(Directions, Shape)) -> Vec<String> {
    let counts = shape.compression.counts.as_ref();
    let of_counts = |figure: &dyn Fn(&crate::light_field::Counts) -> String| counts.map_or("-".into(), figure);
    let [[x, y], [z, w]] = [shape.compression.texels, shape.compression.directions];
    vec![
        format!("  {}{}", shape.shape, if *frame == Directions::Reflected { ", reflected" } else { "" }),
        x.to_string(),
        y.to_string(),
        z.to_string(),
        w.to_string(),
        of_counts(&|c| c.components.to_string()),
        of_counts(&|c| c.clusters.to_string()),
        of_counts(&|c| short(c.ratio)),
        short(shape.compression.field_bytes as f64 / shape.compression.file_bytes as f64),
        short(shape.compression.error_sphere),
        short(shape.trace_s / 60.0),
        short(shape.compression.encode_s),
    ]
}

fn of_pictures(pictures: &Pictures) -> String {
    let Pictures { side, samples: [a, b], paths_s, of_fields } = pictures;
    let [papers, minutes] = PAPERS_PICTURES;
    let titles = ["picture", "samples", "seconds", "paths / this", "error", "PSNR dB"];
    let none = || "-".to_string();
    let paper = |name: &str, samples: &str, seconds: f64, ratio: f64| {
        vec![name.into(), samples.into(), short(seconds), short(ratio), none(), none()]
    };
    let mut lines = vec![
        paper("of photons, the paper's", "256", 60.0 * minutes, 1.0),
        paper("from fields, the paper's", "8", papers, 60.0 * minutes / papers),
        vec!["of paths".into(), (b * b).to_string(), short(*paths_s), "1".into(), none(), none()],
    ];
    lines.extend(of_fields.iter().map(|OfFields { frame, seconds, error, psnr }| {
        let name = format!("from fields, directions {}", frame.show());
        let ratio = short(paths_s / seconds);
        vec![name, (a * a).to_string(), short(*seconds), ratio, short(*error), short(*psnr)]
    }));
    format!("\n{side} x {side} pixels\n{}", aligned(&titles, lines.into_iter()))
}

/// A line for each shape.
pub(super) fn csv(shapes: &[(Directions, Shape)], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let named = |(frame, shape): &(Directions, Shape)| Shape {
        shape: format!("{}, directions {}", shape.shape, frame.show()),
        ..shape.clone()
    };
    crate::light_field::csv_of(&shapes.iter().map(named).collect::<Vec<_>>(), machine)
}

/// A line for each picture.
pub(super) fn csv_of_pictures(pictures: &Pictures, machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let Pictures { side, samples: [a, b], paths_s, of_fields } = pictures;
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["picture", "side", "samples", "seconds", "error", "psnr_db", "machine"])?;
    let none = String::new;
    let paths = ["paths".into(), side.to_string(), (b * b).to_string(), paths_s.to_string(), none(), none()];
    writer.write_record(paths.into_iter().chain([machine.line()]))?;
    for OfFields { frame, seconds, error, psnr } in of_fields {
        let head = [format!("fields, directions {}", frame.show()), side.to_string(), (a * a).to_string()];
        let figures = [*seconds, *error, *psnr].map(|f| f.to_string());
        writer.write_record(head.into_iter().chain(figures).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
