//! `biscale`: local incident radiance of every vertex in the pixel basis (Sun et al., all-frequency bi-scale radiance
//! transfer, §IV-A). Rows are (vertex, local direction), columns cubemap texels. A texel contributes to the one local direction
//! that is nearest to its centre, and its element is the part of its samples that are visible: a value k / 4^m.

use crate::basis::LightBasis;
use crate::error::Result;
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::scene::hemisphere::LocalDirections;
use crate::scene::signal::{Sampling, Surface, Traced, for_each_point};
use glam::Vec3;

/// The rows of one vertex: elements per row, and all of them in order.
struct VertexRows {
    lengths: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f32>,
}

/// The matrix `(points · edge²) x (6 · resolution²)`, `edge` local directions along an edge of the concentric square.
pub fn biscale(
    surface: &Surface,
    sampling: &Sampling,
    edge: usize,
    progress: &dyn Progress,
) -> Result<(TransferMatrix, Traced)> {
    let local = LocalDirections::new(edge)?;
    let samples = sampling.samples()?;
    let basis = LightBasis::Cubemap { resolution: sampling.resolution };
    let centres: Vec<Vec3> =
        basis.directions().into_iter().flatten().map(|d| Vec3::from_array(d.map(|c| c as f32))).collect();
    let share = 1.0 / sampling.samples_per_texel() as f32;
    let (vertices, traced) = for_each_point(surface, &samples, progress, |point, visible| {
        let frame = &surface.frames[point];
        let mut counts = vec![0u16; centres.len()];
        visible.for_each(|lane| counts[samples.lanes()[lane].texel as usize] += 1);
        let mut rows: Vec<Vec<(u32, f32)>> = vec![Vec::new(); edge * edge];
        for (texel, &count) in counts.iter().enumerate().filter(|(_, c)| **c > 0) {
            let row = local.nearest(frame.to_local(centres[texel]));
            rows[row].push((texel as u32, f32::from(count) * share));
        }
        VertexRows {
            lengths: rows.iter().map(|r| r.len() as u32).collect(),
            columns: rows.iter().flatten().map(|e| e.0).collect(),
            values: rows.iter().flatten().map(|e| e.1).collect(),
        }
    })?;
    let non_zeros = vertices.iter().map(|v| v.values.len()).sum();
    let mut offsets = Vec::with_capacity(vertices.len() * edge * edge + 1);
    let (mut columns, mut values) = (Vec::with_capacity(non_zeros), Vec::with_capacity(non_zeros));
    offsets.push(0);
    // Consumed one by one, so that both copies never exist whole.
    for vertex in vertices {
        for length in vertex.lengths {
            offsets.push(offsets[offsets.len() - 1] + length as usize);
        }
        columns.extend(vertex.columns);
        values.extend(vertex.values);
    }
    Ok((TransferMatrix::from_csr(offsets, columns, values, edge * edge, basis)?, traced))
}
