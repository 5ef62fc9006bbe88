//! Table 1, the paper's lines, each with ours below it.

use super::table1::{LINES, Line as Row, OfFields, PAPERS_PICTURES, Pictures};
use crate::light_field::{Counts, Shape};
use crate::machine::Machine;
use crate::tables::beside::{Beside, Cell, Column, Line};
use prt_transfer::params::Value;
use prt_transfer::responses::Directions;

/// Shapes: sizes, ratios and times.
pub(super) fn of_shapes(shapes: &[(Directions, Shape)]) -> Beside {
    let block = |row: &Row| {
        let named = |(_, shape): &&(Directions, Shape)| row.ours.contains(&shape.shape.as_str());
        std::iter::once(of_paper(row)).chain(shapes.iter().filter(named).map(ours)).collect::<Vec<_>>()
    };
    Beside {
        addition: "-paper",
        title: "Table 1: surface light fields of a Cornell box (Miandji et al. 2011)".into(),
        subjects: Vec::new(),
        head: "shape",
        columns: vec![
            Column::whole("X", "X"),
            Column::whole("Y", "Y"),
            Column::whole("Z", "Z"),
            Column::whole("W", "W"),
            Column::whole("components", "k"),
            Column::whole("clusters", "η"),
            Column::new("ratio_eq5", "Eq. 5"),
            Column::new("field_over_file", "F / file"),
            Column::new("error_sphere", "error"),
            Column::new("trace_min", "trace min"),
            Column::new("encode_s", "encode s"),
        ],
        lines: LINES.iter().flat_map(block).collect(),
        why: "The paper's scene was not published, ours is like its picture; it traced photons and gathered on a \
              quad-core Xeon, here paths are traced on all threads. Its ratios follow from Eq. 5, its text having η = \
              512 where its table has 256; it prints no error, and most of ours is the noise of tracing. A matte shape \
              is one number a texel here, its mean, which Eq. 5 counts apart.",
    }
}

fn of_paper(row: &Row) -> Line {
    let [x, y, z, w] = row.sizes;
    // Eq. 5 for three channels, a number for each id.
    let [m, n, k, eta] = [x * y, z * w, row.components, row.clusters].map(|v| v as f64);
    let ratio = 3.0 * m * n / (3.0 * m * k + 3.0 * eta * n * k + 4.0 * m);
    let sizes = [x, y, z, w, row.components, row.clusters].map(Cell::from);
    let [file, error, ratio] = [Cell::Nothing, Cell::Nothing, ratio.into()];
    let figures = [ratio, file, error, Cell::Printed(row.minutes), Cell::Printed(row.encode_s)];
    Line::printed(row.shape, sizes.into_iter().chain(figures).collect())
}

fn ours((frame, shape): &(Directions, Shape)) -> Line {
    let made = &shape.compression;
    let of_counts = |figure: fn(&Counts) -> f64| Cell::from(made.counts.as_ref().map(figure));
    let sizes = [made.texels, made.directions].concat().into_iter().map(Cell::from);
    let figures = [
        of_counts(|c| c.components as f64),
        of_counts(|c| c.clusters as f64),
        of_counts(|c| c.ratio),
        (made.field_bytes as f64 / made.file_bytes as f64).into(),
        made.error_sphere.into(),
        (shape.trace_s / 60.0).into(),
        made.encode_s.into(),
    ];
    let name = format!("{}{}", shape.shape, if *frame == Directions::Reflected { ", reflected" } else { "" });
    Line::ours(name, (titled(*frame, shape), made.method.as_str()), Ok(sizes.chain(figures).collect()))
}

fn titled(frame: Directions, shape: &Shape) -> String {
    format!("{}, directions {}", shape.shape, frame.show())
}

/// Pictures of the whole scene.
pub(super) fn of_pictures(pictures: &Pictures) -> Beside {
    let Pictures { side, samples: [from_fields, of_paths], paths_s, of_fields } = pictures;
    let [papers, minutes] = PAPERS_PICTURES;
    let printed = |name: &str, samples: usize, seconds: f64| {
        Line::printed(
            name,
            vec![1024_usize.into(), samples.into(), Cell::Printed(seconds), (60.0 * minutes / seconds).into()],
        )
    };
    let paths = vec![(*side).into(), (of_paths * of_paths).into(), (*paths_s).into(), 1.0.into()];
    let fields = of_fields.iter().map(|OfFields { frame, seconds, error, psnr }| {
        let name = format!("from fields, directions {}", frame.show());
        let samples = from_fields * from_fields;
        let figures = [*seconds, paths_s / seconds, *error, *psnr].map(Cell::from);
        let cells = [(*side).into(), samples.into()].into_iter().chain(figures).collect();
        Line::ours(name.clone(), (name, ""), Ok(cells))
    });
    let first = [printed("of photons", 256, 60.0 * minutes), Line::ours("of paths", ("of paths", ""), Ok(paths))];
    Beside {
        addition: "-pictures",
        title: "Table 1: pictures of the scene (Miandji et al. 2011)".into(),
        subjects: Vec::new(),
        head: "picture",
        columns: vec![
            Column::whole("side", "pixels along a side"),
            Column::whole("samples", "samples"),
            Column::new("seconds", "seconds"),
            Column::new("paths_over_this", "paths / this"),
            Column::new("error", "error"),
            Column::new("psnr_db", "PSNR dB"),
        ],
        lines: first.into_iter().chain([printed("from fields", 8, papers)]).chain(fields).collect(),
        why: "Errors are against our paths, whose noise they include; the paper shows pictures. Its reference took \
              400,000 photons, 64 gathering rays.",
    }
}

/// A line for each shape, with all that is known of it.
pub(super) fn csv(shapes: &[(Directions, Shape)], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let named = |(frame, shape): &(Directions, Shape)| Shape { shape: titled(*frame, shape), ..shape.clone() };
    crate::light_field::csv_of(&shapes.iter().map(named).collect::<Vec<_>>(), machine)
}
