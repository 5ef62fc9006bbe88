//! Images of linear radiance, `.exr` and `.hdr`, and pictures, `.png`.
//!
//! Values come as they are in the file: negative ones, infinities and NaN are the caller's to judge.

use super::{atomic, broken, bytes_of, extension, openexr, radiance, unknown_extension};
use crate::error::{Error, Result};
use crate::image::{Image, Picture};
use std::collections::BTreeSet;
use std::path::Path;

/// The number of a sample's bits in a written `.exr`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 16 bits: 11 significant ones, at most 65504; larger values become infinite.
    Half,
    /// 32 bits.
    Single,
}

/// Reads `.exr` or `.hdr`.
pub fn read(path: impl AsRef<Path>) -> Result<Image> {
    let path = path.as_ref();
    let parse = match extension(path).as_str() {
        "exr" => read_exr,
        "hdr" => read_hdr,
        _ => return Err(unknown_extension(path, "image file extension", ".exr, .hdr")),
    };
    parse(&bytes_of(path)?).map_err(|e| e.in_file(path))
}

/// Reads the first layer of an OpenEXR file that has R, G and B, or Y: any compression, scan lines or tiles, 16- and
/// 32-bit floats and 32-bit integers. Alpha and other channels are ignored. The image is the display window: pixels
/// outside the data window are 0. Deep data and sub-sampled colour are refused.
pub fn read_exr(bytes: &[u8]) -> Result<Image> {
    openexr::read(bytes)
}

/// Reads a Radiance picture (`32-bit_rle_rgbe`): run-length encoded, old or new, or flat, in any of the eight
/// orientations.
///
/// A pixel is mantissa · 2^(exponent - 136), the reading that image libraries share (Radiance's own adds half a step to
/// the mantissa), divided by the header's EXPOSURE and COLORCORR as the format demands, so that values are radiance
/// again. CIE XYZ pictures are refused.
pub fn read_hdr(bytes: &[u8]) -> Result<Image> {
    radiance::read(bytes)
}

/// Writes RGB scan lines, deflated (ZIP, 16 lines).
pub fn write_exr(path: impl AsRef<Path>, image: &Image, precision: Precision) -> Result<()> {
    let path = path.as_ref();
    let bytes = exr_bytes(image, precision).map_err(|e| e.in_file(path))?;
    atomic::write(path, |file| file.write_all(&bytes))
}

/// The file that [`write_exr`] makes.
pub fn exr_bytes(image: &Image, precision: Precision) -> Result<Vec<u8>> {
    Error::expect_size("pixels of the image", image.width * image.height, image.pixels.len())?;
    openexr::bytes(image, precision)
}

/// Writes a picture: PNG, 8 bits a channel or, of at most 256 colours, a palette; marked as sRGB.
pub fn write_png(path: impl AsRef<Path>, picture: &Picture) -> Result<()> {
    let path = path.as_ref();
    let bytes = png_bytes(picture).map_err(|e| e.in_file(path))?;
    atomic::write(path, |file| file.write_all(&bytes))
}

/// The file that [`write_png`] makes.
pub fn png_bytes(picture: &Picture) -> Result<Vec<u8>> {
    let Picture { width, height, pixels } = picture;
    Error::expect_size("pixels of the picture", width.saturating_mul(*height), pixels.len())?;
    // The format counts in 31 bits; the encoder refuses 0.
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side(*width), side(*height));
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let indexed = indexed(pixels);
    match &indexed {
        Some((colours, _)) => {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(colours.as_flattened());
            encoder.set_filter(png::Filter::NoFilter);
        }
        None => encoder.set_color(png::ColorType::Rgb),
    }
    let data = indexed.as_ref().map_or(pixels.as_flattened(), |(_, indices)| indices);
    let write = |encoder: png::Encoder<_>| {
        let mut writer = encoder.write_header()?;
        writer.write_image_data(data)?;
        writer.finish()
    };
    write(encoder).map_err(|e| broken("png", "picture", "pixels that the format can hold", e.to_string()))?;
    Ok(bytes)
}

/// The colours of at most 256 and the one of each pixel; `None` of more.
fn indexed(pixels: &[[u8; 3]]) -> Option<(Vec<[u8; 3]>, Vec<u8>)> {
    let mut colours = BTreeSet::new();
    for &pixel in pixels {
        if colours.insert(pixel) && colours.len() > 256 {
            return None;
        }
    }
    let colours: Vec<[u8; 3]> = colours.into_iter().collect();
    let index = |pixel| colours.partition_point(|colour| colour < pixel) as u8;
    let indices = pixels.iter().map(index).collect();
    Some((colours, indices))
}

/// Refuses a size that `length` bytes cannot mean: compression earns a factor of 1000, and 64 MiB come on top so that
/// small files of one colour pass. A file of one colour must be no larger than some 2300 x 2300 pixels.
pub(super) fn affordable(format: &'static str, width: usize, height: usize, pixel: usize, length: usize) -> Result<()> {
    let limit = length.saturating_mul(1000).saturating_add(64 << 20);
    let needed = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(pixel));
    match needed {
        Some(needed) if needed <= limit && width > 0 && height > 0 => Ok(()),
        _ => Err(broken(
            format,
            "header",
            format!("an image of at most {limit} bytes in a file of {length}"),
            format!("{width} x {height} pixels of {pixel} bytes"),
        )),
    }
}
