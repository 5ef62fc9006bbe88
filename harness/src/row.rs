//! One measurement: a method on a matrix. The fields are the columns of results.csv.

use crate::lights::LIGHTS;
use serde::{Deserialize, Serialize};

/// Whether a measurement came to an end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Every figure was measured.
    Ok,
    /// [`Row::reason`] says why there are no figures.
    #[default]
    Failed,
}

/// A line of results.csv. Units are in the names; figures are empty where they do not exist.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Scene, mesh or matrix file.
    pub scene: String,
    /// Signal; `file` for a matrix file.
    pub signal: String,
    /// Light basis.
    pub basis: String,
    /// The method's label.
    pub method: String,
    /// Transform and codec without parameters.
    pub family: String,
    /// Whether there are figures.
    pub status: Status,
    /// Why there are none.
    pub reason: String,
    /// Surface points.
    pub samples: usize,
    /// Rows of each sample.
    pub responses: usize,
    /// Columns.
    pub lights: usize,
    /// Elements that are not 0.
    pub non_zeros: usize,
    /// Compressing, on all threads, median, s.
    pub encode_s: Option<f64>,
    /// Distance between the quartiles of the same, where there were at least three runs.
    pub encode_spread_s: Option<f64>,
    /// The most memory held while compressing, the result included and T not.
    pub peak_encode_bytes: Option<u64>,
    /// What relighting holds in memory.
    pub resident_bytes: Option<u64>,
    /// The `.prt` file.
    pub file_bytes: Option<u64>,
    /// Resident bytes for each non-zero element of the matrix.
    pub bytes_per_non_zero: Option<f64>,
    /// Multiplications of relighting with one channel.
    pub multiplications: Option<u64>,
    /// Additions of the same.
    pub additions: Option<u64>,
    /// Both, multiplications by 1 and -1 being free.
    pub flops_value_aware: Option<u64>,
    /// Σ(T-T̃)²/ΣT².
    pub error: Option<f64>,
    /// The same, weighted over the sphere.
    pub error_sphere: Option<f64>,
    /// max |T-T̃|.
    pub error_max: Option<f64>,
    /// Σ(y-ỹ)²/Σy² under the built-in sky, all channels.
    pub error_relit_sky: Option<f64>,
    /// The same under the built-in room.
    pub error_relit_room: Option<f64>,
    /// Σ(y_t - y_t-1 - ỹ_t + ỹ_t-1)²/Σ(y_t - y_t-1)² of relit output while the sky turns: what flickers.
    pub flicker: Option<f64>,
    /// Of a picture under the sky, or of a light field in its own light: relative squared error of linear radiance.
    pub picture_error: Option<f64>,
    /// Of the same picture, 8 bits a channel; none where it is exact.
    pub picture_psnr_db: Option<f64>,
    /// Of the same picture: mean FLIP, 0 to 1.
    pub picture_flip: Option<f64>,
    /// Relighting one channel on one thread, median, ms.
    pub relight_1_ms: Option<f64>,
    /// Distance between the quartiles of the same.
    pub relight_1_spread_ms: Option<f64>,
    /// Relighting one channel on all threads, median, ms.
    pub relight_all_ms: Option<f64>,
    /// Distance between the quartiles of the same.
    pub relight_all_spread_ms: Option<f64>,
    /// Relighting three channels on one thread, median, ms.
    pub relight_rgb_1_ms: Option<f64>,
    /// Distance between the quartiles of the same.
    pub relight_rgb_1_spread_ms: Option<f64>,
    /// Relighting three channels on all threads, median, ms.
    pub relight_rgb_all_ms: Option<f64>,
    /// Distance between the quartiles of the same.
    pub relight_rgb_all_spread_ms: Option<f64>,
    /// The fewest timed runs behind one of the medians.
    pub runs: usize,
    /// "All" threads.
    pub threads: usize,
    /// CRC-32 of the matrix.
    pub fingerprint: String,
    /// Version, commit and CRC-32 of the program.
    pub program: String,
}

impl Row {
    /// Whether both measure the same method on the same scene, in whatever circumstances.
    pub fn same_subject(&self, other: &Row) -> bool {
        let subject = |r: &Row| [&r.scene, &r.signal, &r.method].map(String::clone);
        // A row that failed before its matrix was there has no basis and no samples; a file is the same one at any size.
        let early = |r: &Row| !r.is_ok() && r.samples == 0;
        let same = (self.samples == other.samples && self.basis == other.basis) || self.signal == "file";
        subject(self) == subject(other) && (same || early(self) || early(other))
    }

    /// Whether the circumstances are the same too, so that it need not be measured again.
    pub fn same_measurement(&self, other: &Row) -> bool {
        self.same_subject(other)
            && self.threads == other.threads
            && self.fingerprint == other.fingerprint
            && self.program == other.program
    }

    /// The same subject without figures, and why.
    pub fn failed(self, reason: impl Into<String>) -> Row {
        Row { status: Status::Failed, reason: reason.into(), ..self }
    }

    /// Errors of relit output, in the order of [`LIGHTS`].
    pub fn relit_errors(&self) -> [Option<f64>; LIGHTS.len()] {
        [self.error_relit_sky, self.error_relit_room]
    }

    /// The place of the figure under each of [`LIGHTS`].
    pub fn relit_errors_mut(&mut self) -> [&mut Option<f64>; LIGHTS.len()] {
        [&mut self.error_relit_sky, &mut self.error_relit_room]
    }

    /// Multiplications and additions.
    pub fn flops(&self) -> Option<u64> {
        Some(self.multiplications? + self.additions?)
    }

    /// Whether it has figures.
    pub fn is_ok(&self) -> bool {
        self.status == Status::Ok
    }
}
