//! Table 2, the paper's two columns as lines, each with ours of its kinds below it.

use super::table2::{HAAR, KINDS, Line};
use crate::tables::beside::{self, Beside, Cell, Column};

const MB: f64 = (1 << 20) as f64;

/// A column of the paper's table.
struct Printed {
    name: &'static str,
    /// Of 2^20 bytes.
    mb: f64,
    error: f64,
    /// Frames per second as the view and as the light moves.
    hz: [f64; 2],
    /// Ours that are like it.
    kinds: [&'static str; 2],
}

static PRINTED: [Printed; 2] = [
    Printed { name: "All-frequency CPCA", mb: 48.41, error: 0.0309, hz: [13.34, 1.65], kinds: [KINDS[0], KINDS[1]] },
    Printed { name: "SRBF and CTA", mb: 13.18, error: 0.0375, hz: [51.12, 13.27], kinds: [KINDS[2], KINDS[3]] },
];

/// The paper's lines, each with ours.
pub(super) fn beside(subject: String, lines: &[Line]) -> Beside {
    let block = |printed: &Printed| {
        let [view_hz, light_hz] = printed.hz.map(Cell::Printed);
        let [size, memory] = [Cell::Nothing, Cell::Nothing];
        let cells = vec![size, (printed.mb * MB).into(), memory, Cell::Printed(printed.error), view_hz, light_hz];
        let ours = lines.iter().filter(|line| printed.kinds.contains(&line.kind)).map(ours);
        std::iter::once(beside::Line::printed(printed.name, cells)).chain(ours).collect::<Vec<_>>()
    };
    Beside {
        addition: "",
        title: "Table 2: all-frequency CPCA, and SRBF with CTA, at about equal bytes (Tsai and Shih 2006)".into(),
        subjects: vec![subject],
        head: "method",
        columns: vec![
            Column::whole("size", "size"),
            Column::bytes("file_bytes", "file"),
            Column::bytes("resident_bytes", "memory"),
            Column::new("error_sphere", "error"),
            Column::new("paper_view_hz", "Hz, view"),
            Column::new("paper_light_hz", "Hz, light"),
            Column::new("encode_s", "encode s"),
            Column::new("relight_rgb_all_ms", "relight ms"),
        ],
        lines: PRINTED.iter().flat_map(block).collect(),
        why: "The paper's sizes differ fourfold, ours are about the same: 1, 2 and 4 times the least that CPCA of whole \
              samples can use on a mesh of 3,000 vertices, numbers of 16 bits in all. 24xcpca is the paper's rival, each \
              of 24 segments of 256 wavelet coefficients compressed by itself. cpca is of haar:scale=sphere, iterative. \
              Relighting starts with texels, which srbf+cta has to turn into lobes first.",
    }
}

fn ours(line: &Line) -> beside::Line {
    let cells = line.figures.as_ref().map(|f| {
        let [view_hz, light_hz] = [Cell::Nothing, Cell::Nothing];
        let sizes = [line.size.into(), f.file_bytes.into(), f.resident_bytes.into(), f.error.into(), view_hz, light_hz];
        sizes.into_iter().chain([f.encode_s.into(), f.relight_ms.into()]).collect()
    });
    beside::Line::ours(short(&line.method), (line.kind, line.method.as_str()), cells.map_err(Clone::clone))
}

/// Without what all lines share.
fn short(method: &str) -> String {
    let shared = [&format!("{HAAR}+"), ":mode=iterative", ":weights=i16", ":representatives=i16"];
    shared.iter().fold(method.to_string(), |method, part| method.replace(part, ""))
}
