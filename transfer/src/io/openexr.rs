//! OpenEXR through the `exr` crate.

use super::broken;
use super::image::{Precision, affordable};
use crate::error::{Error, Result};
use crate::image::Image;
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Layer, LayerAttributes, LineOrder,
    ReadChannels, ReadLayers, Vec2, WritableImage,
};
use half::f16;
use std::io::Cursor;

pub(super) fn read(bytes: &[u8]) -> Result<Image> {
    let chunks = exr::block::read(Cursor::new(bytes), false).map_err(wrong)?;
    chunks.headers().iter().try_for_each(|header| check(header, bytes.len()))?;
    let layers = exr::image::read::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    // On this thread: the crate would make a thread pool of its own for every file.
    let image = layers.all_attributes().non_parallel().from_chunks(chunks).map_err(wrong)?;
    let colour = image.layer_data.iter().find_map(|layer| Some((layer, colour(&layer.channel_data)?)));
    let Some((layer, channels)) = colour else {
        let names = image.layer_data.iter().flat_map(|l| &l.channel_data.list).map(|c| c.name.to_string());
        let names = names.collect::<Vec<_>>().join(", ");
        return Err(broken("exr", "channels", "R, G and B, or Y, without sub-sampling", names));
    };
    // Where the data window lies inside the display window.
    let display = image.attributes.display_window;
    let offset = layer.attributes.layer_position - display.position;
    affordable("exr", display.size.0, display.size.1, 12, bytes.len())?;
    Ok(place(layer, channels, display.size, offset))
}

/// Sizes that the file's own length makes plausible, and nothing that the crate could stumble on.
fn check(header: &Header, length: usize) -> Result<()> {
    if header.deep {
        return Err(broken("exr", "header", "flat pixels", "deep data"));
    }
    // Each chunk has an 8-byte offset in a table and at least 8 bytes of its own.
    if header.chunk_count > length / 16 {
        let most = format!("at most {} chunks in a file of {length} bytes", length / 16);
        return Err(broken("exr", "header", most, header.chunk_count.to_string()));
    }
    let Vec2(width, height) = header.layer_size;
    let sampled = header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample()).sum();
    affordable("exr", width, height, sampled, length)
}

/// R, G, B of a layer: plain, else of the first named group that has all three (`Combined.R`); Y three times where there is
/// none.
fn colour(channels: &AnyChannels<FlatSamples>) -> Option<[&AnyChannel<FlatSamples>; 3]> {
    let find = |prefix: &str, letter: &str| {
        let named = |c: &&AnyChannel<FlatSamples>| c.name.to_string() == format!("{prefix}{letter}");
        channels.list.iter().find(named).filter(|c| c.sampling == Vec2(1, 1))
    };
    let group = |prefix: &str| Some([find(prefix, "R")?, find(prefix, "G")?, find(prefix, "B")?]);
    let named = || {
        let prefixes = channels.list.iter().filter_map(|c| c.name.to_string().strip_suffix('R').map(String::from));
        prefixes.filter(|prefix| prefix.ends_with('.')).find_map(|prefix| group(&prefix))
    };
    group("").or_else(|| find("", "Y").map(|y| [y; 3])).or_else(named)
}

/// The layer's pixels inside the display window; black around them.
fn place(
    layer: &Layer<AnyChannels<FlatSamples>>,
    channels: [&AnyChannel<FlatSamples>; 3],
    Vec2(width, height): Vec2<usize>,
    Vec2(left, top): Vec2<i32>,
) -> Image {
    let mut pixels = vec![[0f32; 3]; width * height];
    for (c, channel) in channels.iter().enumerate() {
        for (i, value) in channel.sample_data.values_as_f32().enumerate() {
            let x = usize::try_from((i % layer.size.0) as i64 + i64::from(left));
            let y = usize::try_from((i / layer.size.0) as i64 + i64::from(top));
            if let (Ok(x), Ok(y)) = (x, y)
                && x < width
                && y < height
            {
                pixels[y * width + x][c] = value;
            }
        }
    }
    Image { width, height, pixels }
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
