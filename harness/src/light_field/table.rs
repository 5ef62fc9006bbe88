//! What is told of all shapes.

use super::shape::Shape;
use crate::number::{bytes, short};
use crate::table::aligned;

/// The table, the bytes of each section beside Eq. 5, and remarks.
pub(super) fn of(shapes: &[Shape]) -> String {
    let titles =
        ["shape", "X x Y", "Z x W", "η", "k", "field", "memory", "file", "F / memory", "error", "trace s", "encode s"];
    let lines = shapes.iter().map(|s| {
        let [eta, k] = match &s.compression.counts {
            Some(c) => [c.clusters.to_string(), c.components.to_string()],
            None => [s.compression.method.clone(), "-".into()],
        };
        vec![
            s.shape.clone(),
            format!("{}x{}", s.compression.texels[0], s.compression.texels[1]),
            format!("{}x{}", s.compression.directions[0], s.compression.directions[1]),
            eta,
            k,
            bytes(s.compression.field_bytes),
            bytes(s.compression.resident_bytes),
            bytes(s.compression.file_bytes),
            short(s.compression.field_bytes as f64 / s.compression.resident_bytes as f64),
            short(s.compression.error_sphere),
            short(s.trace_s),
            short(s.compression.encode_s),
        ]
    });
    let legend = "error: Σ(F-F̃)²/ΣF² over the sphere of what is read back; memory: what looking up holds, F / memory: the ratio to four bytes an element";
    let parts = [aligned(&titles, lines), legend.into(), sections(shapes)];
    parts.into_iter().chain(shapes.iter().flat_map(remarks)).collect::<Vec<_>>().join("\n")
}

/// Numbers that Eq. 5 counts, and bytes of the sections that hold them.
fn sections(shapes: &[Shape]) -> String {
    let titles = ["Eq. 5", "surface ζmk", "view ηζnk", "mean ζm", "ids m", "ratio"];
    let lines = shapes.iter().filter_map(|s| {
        let counts = s.compression.counts.as_ref()?;
        let held = |part: &str| {
            s.compression.sections.iter().filter(|(name, _)| name.contains(part)).map(|(_, bytes)| bytes).sum()
        };
        let cell = |count: u64, part: &str| format!("{count} in {}", bytes(held(part)));
        Some(vec![
            s.shape.clone(),
            cell(counts.surface_map, "surface"),
            cell(counts.view_maps, "views"),
            cell(counts.mean_map, "mean"),
            cell(counts.cluster_ids, "clusters"),
            format!("{} : 1", short(counts.ratio)),
        ])
    });
    format!("\n{}", aligned(&titles, lines))
}

/// What should not go unsaid.
fn remarks(shape: &Shape) -> Vec<String> {
    let mut remarks = Vec::new();
    let Shape { shape: name, clamped, not_finite, gutter_texels, unused_texels, paths, .. } = shape;
    if *clamped > 0 {
        remarks.push(format!("{name}: {clamped} of {paths} paths were cut to the bound of --clamp"));
    }
    if *not_finite > 0 {
        remarks.push(format!("{name}: {not_finite} of {paths} paths brought no finite radiance and count as none"));
    }
    if *gutter_texels + *unused_texels > 0 {
        remarks.push(format!(
            "{name}: {gutter_texels} texels beside the chart hold what is at its rim, {unused_texels} are never looked up"
        ));
    }
    remarks
}
