//! The raw figures of all shapes.

use super::compression::Counts;
use super::shape::Shape;
use crate::machine::Machine;

/// A line for each shape.
pub fn of(shapes: &[Shape], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "shape",
        "X",
        "Y",
        "Z",
        "W",
        "method",
        "clusters",
        "components",
        "surface_map",
        "view_maps",
        "mean_map",
        "cluster_ids",
        "ratio_eq5",
        "field_bytes",
        "resident_bytes",
        "file_bytes",
        "error",
        "error_sphere",
        "trace_s",
        "encode_s",
        "peak_encode_bytes",
        "paths",
        "rays",
        "clamped",
        "not_finite",
        "cpu",
        "threads",
        "commit",
        "date",
    ])?;
    for shape in shapes {
        let made = &shape.compression;
        let [[x, y], [z, w]] = [made.texels, made.directions];
        let of_counts = |figure: fn(&Counts) -> String| made.counts.as_ref().map(figure).unwrap_or_default();
        writer.write_record([
            shape.shape.clone(),
            x.to_string(),
            y.to_string(),
            z.to_string(),
            w.to_string(),
            made.method.clone(),
            of_counts(|c| c.clusters.to_string()),
            of_counts(|c| c.components.to_string()),
            of_counts(|c| c.surface_map.to_string()),
            of_counts(|c| c.view_maps.to_string()),
            of_counts(|c| c.mean_map.to_string()),
            of_counts(|c| c.cluster_ids.to_string()),
            of_counts(|c| c.ratio.to_string()),
            made.field_bytes.to_string(),
            made.resident_bytes.to_string(),
            made.file_bytes.to_string(),
            made.error.to_string(),
            made.error_sphere.to_string(),
            shape.trace_s.to_string(),
            made.encode_s.to_string(),
            made.peak_encode_bytes.map(|b| b.to_string()).unwrap_or_default(),
            shape.paths.to_string(),
            shape.rays.to_string(),
            shape.clamped.to_string(),
            shape.not_finite.to_string(),
            machine.cpu.clone(),
            machine.threads.to_string(),
            machine.commit.to_string(),
            machine.date.clone(),
        ])?;
    }
    Ok(writer.into_inner()?)
}
