//! From linear radiance to a picture that a screen shows: exposure, a tone curve, sRGB in 8 bits.

use super::Image;
use super::difference::covered;
use crate::error::Result;

/// Share of the covered pixels that automatic exposure leaves below [`BRIGHT`].
const PERCENTILE: f64 = 0.95;

/// Where automatic exposure puts that pixel: linear, 1 is white.
const BRIGHT: f64 = 0.6;

crate::choices! {
    /// The curve from exposed radiance to light on the screen, for each of R, G and B.
    pub enum Tone {
        /// Radiance as it is; everything from 1 on is white.
        Clip = "clip",
        /// The film-like curve of Narkowicz (2015), fitted to the ACES reference rendering transform: a steep middle
        /// and a long shoulder; 1 becomes 0.80 and 8 almost white.
        Filmic = "filmic",
    }
}

impl Tone {
    /// Light on the screen, from 0 to 1, for exposed radiance `x`; negative radiance is black.
    pub fn curve(self, x: f64) -> f64 {
        let x = x.max(0.0);
        let y = match self {
            Tone::Clip => x,
            // Above 1e6 the quotient of squares has long been at its limit, and beyond 1e150 it would be ∞/∞.
            Tone::Filmic => {
                let x = x.min(1e6);
                (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
            }
        };
        y.min(1.0)
    }
}

/// Pixels as a screen shows them: sRGB (IEC 61966-2-1), 8 bits a channel, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Several pictures in a row, from left to right, at the top of one that holds them all; what is below the shorter
    /// ones is black.
    pub fn beside(pictures: &[Picture]) -> Picture {
        let height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
        let line = |y: usize| {
            let of = move |p: &Picture| p.pixels.get(y * p.width..(y + 1) * p.width).map(<[_]>::to_vec);
            pictures.iter().flat_map(move |p| of(p).unwrap_or_else(|| vec![[0; 3]; p.width]))
        };
        let pixels = (0..height).flat_map(line).collect();
        Picture { width: pictures.iter().map(|p| p.width).sum(), height, pixels }
    }
}

impl Image {
    /// The picture at `exposure` stops: radiance times 2^exposure, through the curve, rounded to 8 bits of sRGB.
    pub fn develop(&self, exposure: f64, tone: Tone) -> Picture {
        let scale = exposure.exp2();
        let code = |c: f32| srgb(tone.curve(f64::from(c) * scale));
        let pixels = self.pixels.iter().map(|pixel| pixel.map(code)).collect();
        Picture { width: self.width, height: self.height, pixels }
    }

    /// The exposure in stops at which the luminance of the 95th percentile of the covered pixels (those whose
    /// `coverage` is 1; every pixel where there is none) becomes 0.6 of white; 0 where it has no light.
    ///
    /// # Errors
    /// A coverage that is not one number a pixel.
    pub fn automatic_exposure(&self, coverage: &[f32]) -> Result<f64> {
        let mut values: Vec<f32> = covered(self.pixels.len(), coverage)?.map(|i| luminance(self.pixels[i])).collect();
        if values.is_empty() {
            values = self.pixels.iter().map(|&pixel| luminance(pixel)).collect();
        }
        let place = (PERCENTILE * values.len() as f64) as usize;
        let bright = if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(place, f32::total_cmp).1 };
        Ok(if bright > 0.0 { (BRIGHT / f64::from(bright)).log2() } else { 0.0 })
    }
}

/// Luminance of linear RGB with the primaries of sRGB and Rec. 709.
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The 8-bit sRGB code nearest to linear light from 0 to 1.
pub fn srgb(linear: f64) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

/// Linear light from 0 to 1 of an 8-bit sRGB code.
pub fn linear(code: u8) -> f64 {
    let c = f64::from(code) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_code_comes_back_from_its_light_and_none_is_skipped() {
        assert!((0..=255).all(|code| srgb(linear(code)) == code));
        // Half way between two codes is where rounding changes.
        for code in 0..255u8 {
            let middle = linear(code).midpoint(linear(code + 1));
            assert!([code, code + 1].contains(&srgb(middle)));
        }
    }

    #[test]
    fn curves_rise_from_black_to_white() {
        for tone in [Tone::Clip, Tone::Filmic] {
            let values: Vec<f64> = (0..4000).map(|i| tone.curve(i as f64 * 0.004)).collect();
            assert_eq!((values[0], tone.curve(-3.0), tone.curve(f64::MAX)), (0.0, 0.0, 1.0));
            assert!(values.windows(2).all(|pair| pair[0] <= pair[1]) && values[3999] > 0.99);
        }
        assert!((Tone::Filmic.curve(1.0) - 2.54 / 3.16).abs() < 1e-12);
    }

    #[test]
    fn a_stop_doubles_the_light() {
        let image = Image { width: 1, height: 2, pixels: vec![[0.1, 0.2, 0.4], [0.05, 0.1, 0.2]] };
        let picture = image.develop(1.0, Tone::Clip);
        assert_eq!(picture.pixels[1], image.develop(0.0, Tone::Clip).pixels[0]);
        assert_eq!(picture.pixels[0], [0.2, 0.4, 0.8].map(srgb));
    }

    #[test]
    fn pictures_side_by_side_keep_their_pixels() {
        let picture = |width, height, code: u8| Picture { width, height, pixels: vec![[code; 3]; width * height] };
        let both = Picture::beside(&[picture(2, 1, 7), picture(1, 2, 9)]);
        let codes: Vec<u8> = both.pixels.iter().map(|p| p[0]).collect();
        assert_eq!((both.width, both.height, codes), (3, 2, vec![7, 7, 9, 0, 0, 9]));
        assert_eq!(Picture::beside(&[]).pixels.len(), 0);
    }

    #[test]
    fn automatic_exposure_looks_at_covered_pixels_and_undoes_any_scale() {
        let pixels: Vec<[f32; 3]> = (0..200).map(|i| [if i < 100 { i as f32 } else { 1e6 }; 3]).collect();
        let image = Image { width: 20, height: 10, pixels };
        let coverage: Vec<f32> = (0..200).map(|i| if i < 100 { 1.0 } else { 0.5 }).collect();
        let exposure = image.automatic_exposure(&coverage).unwrap();
        assert!((95.0 * exposure.exp2() - BRIGHT).abs() < 1e-4, "{exposure}");
        let brighter = Image { pixels: image.pixels.iter().map(|p| p.map(|c| 8.0 * c)).collect(), ..image.clone() };
        assert!((brighter.automatic_exposure(&coverage).unwrap() - exposure + 3.0).abs() < 1e-6);
        let black = Image { pixels: vec![[0.0; 3]; 200], ..image.clone() };
        assert_eq!(black.automatic_exposure(&coverage).unwrap(), 0.0);
        assert!(image.automatic_exposure(&[0.0; 200]).unwrap() < exposure, "of all pixels");
        assert!(image.automatic_exposure(&[1.0; 3]).is_err());
    }
}
