//! A field compressed, written, read back and compared.

use crate::error_sums::{self, relative};
use crate::{files, memory};
use prt_slf::EncodedSlf;
use prt_transfer::{
    Compressed, Label, LightBasis, Metric, Progress, Registry, ResponseBasis, Restore, Result, Source, TransferMatrix,
};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Figures of a compressed field. The names are a promise to programs that read them.
#[derive(Clone, Debug, Serialize)]
pub struct Compression {
    /// X and Y.
    pub texels: [usize; 2],
    /// Z and W.
    pub directions: [usize; 2],
    /// The method.
    pub method: String,
    /// η and k, and what Eq. 5 counts; of `slf` alone.
    pub counts: Option<Counts>,
    /// Of F: 4 X Y Z W bytes a channel.
    pub field_bytes: u64,
    /// What looking up holds in memory.
    pub resident_bytes: u64,
    /// The file.
    pub file_bytes: u64,
    /// Bytes in memory by section.
    pub sections: Vec<(String, u64)>,
    /// Σ (F − F̃)² / Σ F² of elements.
    pub error: f64,
    /// The same over the sphere: by solid angle.
    pub error_sphere: f64,
    /// Wall clock of compressing, s.
    pub encode_s: f64,
    /// The most memory held while compressing beside the field.
    pub peak_encode_bytes: Option<u64>,
    /// What the codec has to say.
    pub note: Option<String>,
}

/// What Eq. 5 counts, in numbers.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Counts {
    /// η.
    pub clusters: usize,
    /// k.
    pub components: usize,
    /// ζ m k
    pub surface_map: u64,
    /// η ζ n k
    pub view_maps: u64,
    /// ζ m
    pub mean_map: u64,
    /// m
    pub cluster_ids: u64,
    /// ζ m n over their sum.
    pub ratio: f64,
}

/// Compresses a field into a file; the figures of what is read back.
pub fn compressed(
    matrix: &TransferMatrix,
    method: &Label,
    registry: &Registry,
    path: &Path,
    progress: &dyn Progress,
) -> anyhow::Result<Compression> {
    let method = registry.method(method)?;
    let began = Instant::now();
    let (encoded, peak_encode_bytes) = memory::peak_of(|| method.encode(matrix, progress));
    let (encoded, encode_s) = (encoded?, began.elapsed().as_secs_f64());
    let (note, file_bytes) = (encoded.note(), files::write_prt(path, &encoded, progress)?.file);
    drop(encoded);
    let read = files::read_prt(path, registry)?;
    let metric = Metric::of(matrix)?;
    let (whole, sums) = (error_sums::of_matrix(matrix, &metric), error_sums::of_difference(matrix, &read, &metric));
    let (texels, directions) = sizes(matrix);
    Ok(Compression {
        texels,
        directions,
        method: method.label().to_string(),
        counts: as_slf(&read)?.map(|slf| Counts::of(&slf)),
        field_bytes: 4 * matrix.rows() as u64 * matrix.lights() as u64,
        resident_bytes: read.resident_bytes() as u64,
        file_bytes,
        sections: read.held().sizes().map(|(name, bytes)| (name.into(), bytes as u64)).collect(),
        error: relative(sums.squares, whole.squares),
        error_sphere: relative(sums.weighted, whole.weighted),
        encode_s,
        peak_encode_bytes,
        note,
    })
}

/// X x Y and Z x W of a field.
fn sizes(matrix: &TransferMatrix) -> ([usize; 2], [usize; 2]) {
    let texels = match matrix.responses() {
        ResponseBasis::Radiance { texels, .. } => [texels.width, texels.height],
        _ => [matrix.shape().samples, 1],
    };
    match *matrix.basis() {
        LightBasis::LatLong { width, height } => (texels, [width, height]),
        ref basis => (texels, [basis.lights(), 1]),
    }
}

/// What `slf` made of a field, for looking it up; `None` where another method did.
pub fn as_slf(compressed: &Compressed) -> Result<Option<EncodedSlf>> {
    let header = compressed.header();
    if header.tag != EncodedSlf::TAG || header.label.transform.name != "identity" {
        return Ok(None);
    }
    let mut source = Source::new(compressed.sections().into_sections())?;
    EncodedSlf::read(header.shape, &mut source).map(Some)
}

impl Counts {
    fn of(slf: &EncodedSlf) -> Counts {
        let counts = slf.counts();
        Counts {
            clusters: slf.clusters(),
            components: slf.components(),
            surface_map: counts.surface,
            view_maps: counts.views,
            mean_map: counts.mean,
            cluster_ids: counts.ids,
            ratio: slf.ratio(),
        }
    }
}
