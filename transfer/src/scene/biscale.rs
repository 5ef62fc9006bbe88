//! `biscale`: local incident radiance of every vertex in the pixel basis (Sun et al., all-frequency bi-scale radiance
//! transfer, §IV-A). Rows are (vertex, local direction), columns cubemap texels. A texel contributes to the one local
//! direction that is nearest to its centre, and its element is the part of its samples that are visible: a value k /
//! 4^m.

use crate::basis::LightBasis;
use crate::error::Result;
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::responses::ResponseBasis;
use crate::scene::hemisphere::LocalDirections;
use crate::scene::signal::{Sampling, Surface, Traced, Visible, for_each_point};
use glam::Vec3;

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
    let at = |point: usize, visible: &Visible| {
        let frame = &surface.frames[point];
        let mut counts = vec![0u16; centres.len()];
        visible.lanes().for_each(|lane| counts[samples.lanes()[lane].texel as usize] += 1);
        let mut rows: Vec<Vec<(u32, f32)>> = vec![Vec::new(); edge * edge];
        for (texel, &count) in counts.iter().enumerate().filter(|(_, c)| **c > 0) {
            let row = local.nearest(frame.to_local(centres[texel]));
            rows[row].push((texel as u32, f32::from(count) * share));
        }
        Ok(rows)
    };
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    let bytes = size_of::<(u32, f32)>() * basis.lights();
    let traced = for_each_point(surface, &samples, bytes, progress, at, |rows| {
        for row in rows {
            columns.extend(row.iter().map(|e| e.0));
            values.extend(row.iter().map(|e| e.1));
            offsets.push(columns.len());
        }
        Ok(())
    })?;
    let matrix = TransferMatrix::from_csr(offsets, columns, values, edge * edge, basis)?;
    Ok((matrix.with_responses(ResponseBasis::LocalDirections { edge })?, traced))
}
