//! Figure 6: the chair by biclusters, clustered PCA and wavelets of about as many bytes. The paper shows pictures; errors can be measured.

use super::{methods, spec};
use crate::figures::stage::{Stage, Subject};
use crate::figures::{Drawing, Figure};
use crate::row::Row;
use crate::scenes::Up;
use crate::tables::beside::{Beside, Cell, Column, Line};
use anyhow::Context;
use prt_transfer::{ResponseBasis, TransferMatrix};

pub(super) const FIGURE: Figure = Figure {
    name: "figure6",
    table: Some("Figure 6: beside clustered PCA and wavelets at about equal bytes (minutes, and 8 GB)"),
    draw,
};

const CHAIR: &str = "chair";
const BICLUSTER: &str = "bicluster";
/// The paper's rows for each of its 32 clusters.
const MEMBERS: f64 = 16_101.0 * 64.0 / 32.0;

/// What is printed of a method, and what it is here.
pub(super) struct Printed {
    method: &'static str,
    mb: Option<f64>,
    encode: Cell,
    picture: &'static str,
    pub(super) ours: Vec<String>,
}

fn columns() -> Vec<Column> {
    vec![
        Column::bytes("resident_bytes", "memory"),
        Column::new("bytes_a_row", "B a row"),
        Column::new("error_sphere", "error"),
        Column::new("error_relit_sky", "sky"),
        Column::new("error_relit_room", "room"),
        Column::new("encode_s", "encode s"),
        Column::new("picture", "picture"),
    ]
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let scenes = &stage.chosen.scenes;
    if !scenes.is_empty() && scenes.iter().all(|scene| scene != CHAIR) {
        return Ok(Drawing::default());
    }
    // The smallest chair: clustered PCA holds every row with all of its elements.
    let subject = rows_of(stage, &stage.computed((CHAIR.into(), Some(1), Up::Z), &spec())?)?;
    let own = stage.rows(&subject, &[BICLUSTER.into()])?.remove(0);
    let bytes = own.resident_bytes.map_or(0.0, |bytes| bytes as f64);
    let mut printed = printed(subject.samples() as f64, subject.dimension() as f64, bytes);
    if !stage.chosen.methods.is_empty() {
        // Instead of all of ours but the first, which is at hand.
        let [biclusters, others @ ..] = &mut printed;
        biclusters.ours.extend(methods(stage)?.into_iter().filter(|method| method != BICLUSTER));
        others.iter_mut().for_each(|of| of.ours.clear());
    }
    let others: Vec<String> =
        printed.iter().flat_map(|of| of.ours.clone()).filter(|method| method != BICLUSTER).collect();
    let measured = stage.rows(&subject, &others)?;
    let rows: Vec<&Row> = std::iter::once(&own).chain(&measured).collect();
    Ok(Drawing { beside: vec![beside(subject.title(), lines(&printed, &rows))], ..Drawing::default() })
}

/// Every row by itself, as the paper clusters them.
fn rows_of(stage: &Stage, chair: &Subject) -> anyhow::Result<Subject> {
    let (starts, columns, values) = chair.matrix().as_csr().context("visibility is sparse")?;
    let basis = chair.matrix().basis().clone();
    let matrix = TransferMatrix::from_csr(starts.to_vec(), columns.to_vec(), values.to_vec(), 1, basis)?;
    stage.given(CHAIR, &spec(), matrix.with_responses(ResponseBasis::LocalDirections { edge: 1 })?)
}

/// At the paper's settings, and at as many bytes as our biclusters take.
pub(super) fn printed(rows: f64, lights: f64, bytes: f64) -> [Printed; 3] {
    let clusters = (rows / MEMBERS).ceil().max(1.0);
    // A mean of 4-byte numbers for each cluster, and a byte for each row's cluster.
    let means = ((bytes - rows) / (4.0 * lights)).floor().clamp(1.0, 256.0);
    [
        Printed {
            method: "biclustering",
            mb: Some(36.4),
            encode: Cell::Nothing,
            picture: "as the reference",
            ours: vec![BICLUSTER.into()],
        },
        Printed {
            method: "clustered PCA, 32 x 8",
            mb: None,
            encode: "above 36000".into(),
            picture: "severe artefacts",
            ours: vec![format!("cpca:clusters={clusters}"), format!("vq:clusters={means}")],
        },
        Printed {
            method: "12 wavelets a row",
            mb: Some(37.1),
            encode: Cell::Nothing,
            picture: "severe artefacts",
            ours: vec![wavelets(12), wavelets(1)],
        },
    ]
}

/// Each coefficient in a byte and its place in two: 12 of each of 16,101 x 64 rows are the 37.1 MB that are printed.
fn wavelets(terms: usize) -> String {
    format!("haar+truncate:terms={terms}:bits=8")
}

pub(super) fn beside(subject: String, lines: Vec<Line>) -> Beside {
    Beside {
        addition: "",
        title: "Figure 6: other methods of about as many bytes, on the chair".into(),
        subjects: vec![subject],
        head: "method",
        columns: columns(),
        lines,
        why: "The paper shows pictures and prints sizes alone (that of clustered PCA is not legible in our copy). Its \
              chair has 1.03 M rows of 6,144 texels, which clustered PCA would need 25 GB for: ours is the smallest \
              chair, with as many rows a cluster. vq and one wavelet a row are what the rivals can be in about as many \
              bytes as our biclusters take, which are fewer than the paper's. Errors are over the sphere.",
    }
}

pub(super) fn lines(printed: &[Printed], rows: &[&Row]) -> Vec<Line> {
    let of = |method: &String| {
        let row = rows.iter().find(|row| row.method == *method)?;
        let bytes = row.resident_bytes.filter(|_| row.is_ok());
        let cells = vec![
            bytes.into(),
            bytes.map(|bytes| bytes as f64 / row.samples.max(1) as f64).into(),
            row.error_sphere.into(),
            row.error_relit_sky.into(),
            row.error_relit_room.into(),
            row.encode_s.into(),
        ];
        let cells = if row.is_ok() { Ok(cells) } else { Err(row.reason.clone()) };
        Some(Line::ours(method.clone(), (CHAIR, method.as_str()), cells))
    };
    let block = |of_paper: &Printed| {
        let bytes = of_paper.mb.map(|mb| 1e6 * mb);
        let a_row = bytes.map(|bytes| bytes / (32.0 * MEMBERS));
        let [none, sky, room] = [const { Cell::Nothing }; 3];
        let cells = vec![bytes.into(), a_row.into(), none, sky, room, of_paper.encode.clone(), of_paper.picture.into()];
        std::iter::once(Line::printed(of_paper.method, cells))
            .chain(of_paper.ours.iter().filter_map(of))
            .collect::<Vec<_>>()
    };
    printed.iter().flat_map(block).collect()
}
