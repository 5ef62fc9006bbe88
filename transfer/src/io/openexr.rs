//! OpenEXR through the `exr` crate, block by block.
//!
//! The crate's own image reader trusts some numbers inside a block, so that a damaged file could abort the program by asking
//! for gigabytes. Here each block's claims are checked before the crate decompresses it.

use super::broken;
use super::image::{Precision, affordable};
use crate::error::{Error, Result};
use crate::image::Image;
use exr::block::chunk::{Chunk, CompressedBlock, TileCoordinates};
use exr::block::reader::ChunksReader;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::attribute::ChannelList;
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Layer, LayerAttributes, LineOrder, MetaData,
    SampleType, Vec2, WritableImage,
};
use half::f16;
use rayon::prelude::*;
use std::collections::HashSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

pub(super) fn read(bytes: &[u8]) -> Result<Image> {
    let file = exr::block::read(Cursor::new(bytes), false).map_err(wrong)?;
    file.headers().iter().try_for_each(|header| check(header, bytes.len()))?;
    let found = file.headers().iter().enumerate().find_map(|(i, header)| Some((i, colour(&header.channels)?)));
    let Some((layer, channels)) = found else {
        let names = file.headers().iter().flat_map(|h| &h.channels.list).map(|c| c.name.to_string());
        let expected = "R, G and B, or Y, without sub-sampling";
        return Err(broken("exr", "channels", expected, names.collect::<Vec<_>>().join(", ")));
    };
    let header = &file.headers()[layer];
    let display = header.shared_attributes.display_window;
    let Vec2(width, height) = display.size;
    affordable("exr", width, height, 12, bytes.len())?;
    // Where the data window lies inside the display window.
    let offset = header.own_attributes.layer_position - display.position;
    let wanted = |_: &MetaData, tile: TileCoordinates, block: BlockIndex| {
        block.layer == layer && tile.is_largest_resolution_level()
    };
    let mut chunks = file.filter_chunks(false, wanted).map_err(wrong)?;
    let compressed = chunks.by_ref().collect::<exr::error::Result<Vec<Chunk>>>().map_err(wrong)?;
    let meta = chunks.meta_data();
    let blocks = compressed.into_par_iter().map(|chunk| decompress(chunk, meta, layer)).collect::<Result<Vec<_>>>()?;
    let mut places = HashSet::new();
    if let Some(twice) = blocks.iter().find(|block| !places.insert(block.index.pixel_position)) {
        let Vec2(x, y) = twice.index.pixel_position;
        return Err(broken("exr", "blocks", "each block once", format!("two at {x}, {y}")));
    }
    let mut image = Image { width, height, pixels: vec![[0.0; 3]; width * height] };
    blocks.iter().for_each(|block| place(block, &meta.headers[layer].channels, channels, offset, &mut image));
    Ok(image)
}

/// Sizes that the file's own length makes plausible.
fn check(header: &Header, length: usize) -> Result<()> {
    if header.deep {
        return Err(broken("exr", "header", "flat pixels", "deep data"));
    }
    // Each chunk has an 8-byte offset in a table and at least 8 bytes of its own.
    if header.chunk_count > length / 16 {
        let most = format!("at most {} chunks in a file of {length} bytes", length / 16);
        return Err(broken("exr", "header", most, header.chunk_count.to_string()));
    }
    let pixel = header.channels.bytes_per_pixel;
    let Vec2(width, height) = header.layer_size;
    affordable("exr", width, height, pixel, length)?;
    let Vec2(width, height) = header.max_block_pixel_size();
    affordable("exr", width, height, pixel, length)
}

/// Positions of R, G, B in a list without sub-sampling: plain names, else Y three times, else the first named group that has
/// all three (`Combined.R`).
fn colour(channels: &ChannelList) -> Option<[usize; 3]> {
    if channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return None;
    }
    let names: Vec<String> = channels.list.iter().map(|c| c.name.to_string()).collect();
    let find = |prefix: &str, letter: &str| names.iter().position(|name| *name == format!("{prefix}{letter}"));
    let group = |prefix: &str| Some([find(prefix, "R")?, find(prefix, "G")?, find(prefix, "B")?]);
    let prefixes = || names.iter().filter_map(|name| name.strip_suffix('R')).filter(|prefix| prefix.ends_with('.'));
    group("").or_else(|| find("", "Y").map(|y| [y; 3])).or_else(|| prefixes().find_map(group))
}

fn decompress(chunk: Chunk, meta: &MetaData, layer: usize) -> Result<UncompressedBlock> {
    if chunk.layer_index != layer {
        return Err(broken("exr", "blocks", format!("a block of part {layer}"), chunk.layer_index.to_string()));
    }
    let header = &meta.headers[layer];
    if matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        check_dwa(&chunk.compressed_block, header)?;
    }
    // The crate asserts where it could return an error (B44 differences that wrap, in builds that check overflow).
    let decoded = catch_unwind(AssertUnwindSafe(|| UncompressedBlock::decompress_chunk(chunk, meta, false)));
    let block = decoded.map_err(|_| broken("exr", "blocks", "compressed pixels", "damaged ones"))?.map_err(wrong)?;
    if block.index.level != Vec2(0, 0) {
        return Err(broken("exr", "blocks", "the largest level", format!("level {:?}", block.index.level)));
    }
    Ok(block)
}

/// The counters that open a DWA block (all but the first, the version, and the last, the kind of coding) may not exceed what
/// its pixels, padded to 8 x 8, can need: the crate allocates what they say.
fn check_dwa(block: &CompressedBlock, header: &Header) -> Result<()> {
    let tile = header.get_block_data_indices(block).map_err(wrong)?;
    let Vec2(width, height) = header.get_absolute_block_pixel_coordinates(tile).map_err(wrong)?.size;
    let payload = match block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Err(broken("exr", "blocks", "flat pixels", "deep data")),
    };
    // Pixels that would not shrink are stored as they are.
    if payload.len() == width * height * header.channels.bytes_per_pixel {
        return Ok(());
    }
    let samples = width.next_multiple_of(8) * height.next_multiple_of(8) * header.channels.list.len();
    // Four bytes a sample; run lengths of incompressible bytes add one in 127.
    let limit = samples as u64 * 5 + 1024;
    let counters = payload.as_chunks::<8>().0.iter().map(|&c| u64::from_le_bytes(c));
    match counters.take(10).skip(1).find(|&count| count > limit) {
        Some(count) => Err(broken("exr", "blocks", format!("DWA counters of at most {limit}"), count.to_string())),
        None => Ok(()),
    }
}

/// Copies a block's pixels to where they lie inside the display window.
fn place(
    block: &UncompressedBlock,
    list: &ChannelList,
    channels: [usize; 3],
    Vec2(left, top): Vec2<i32>,
    image: &mut Image,
) {
    for line in block.lines(list) {
        let Vec2(x, y) = line.location.position;
        let (x, y) = (x as i64 + i64::from(left), y as i64 + i64::from(top));
        if !(0..image.height as i64).contains(&y) {
            continue;
        }
        let row = &mut image.pixels[y as usize * image.width..][..image.width];
        for c in (0..3).filter(|&c| channels[c] == line.location.channel) {
            let mut put = |i: usize, value: f32| {
                if let Some(pixel) = usize::try_from(x + i as i64).ok().and_then(|x| row.get_mut(x)) {
                    pixel[c] = value;
                }
            };
            let words = line.value.as_chunks::<4>().0.iter().enumerate();
            match list.list[line.location.channel].sample_type {
                SampleType::F16 => {
                    let halves = line.value.as_chunks::<2>().0.iter().enumerate();
                    halves.for_each(|(i, &h)| put(i, f16::from_ne_bytes(h).to_f32()));
                }
                SampleType::F32 => words.for_each(|(i, &w)| put(i, f32::from_ne_bytes(w))),
                SampleType::U32 => words.for_each(|(i, &w)| put(i, u32::from_ne_bytes(w) as f32)),
            }
        }
    }
}

pub(super) fn bytes(image: &Image, precision: Precision) -> Result<Vec<u8>> {
    let channels = ["R", "G", "B"].iter().enumerate().map(|(c, name)| {
        let values = image.pixels.iter().map(|pixel| pixel[c]);
        let samples = match precision {
            Precision::Half => FlatSamples::F16(values.map(f16::from_f32).collect()),
            Precision::Single => FlatSamples::F32(values.collect()),
        };
        AnyChannel::new(*name, samples)
    });
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort(channels.collect());
    let layer = Layer::new((image.width, image.height), LayerAttributes::default(), encoding, channels);
    let mut file = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer).write().to_buffered(&mut file).map_err(wrong)?;
    Ok(file.into_inner())
}

fn wrong(error: exr::error::Error) -> Error {
    broken("exr", "image", "an OpenEXR file", error.to_string())
}
