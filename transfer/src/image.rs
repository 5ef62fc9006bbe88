//! Images of linear radiance.

/// RGB pixels in rows from the top, linear radiance in W/m²/sr (or relative to it).
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<[f32; 3]>,
}
