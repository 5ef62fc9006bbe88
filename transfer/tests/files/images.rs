use super::{folder, names};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, IntegerBounds, Layer, LayerAttributes,
    LineOrder, Vec2, WritableImage,
};
use half::f16;
use prt_transfer::image::{Image, Picture};
use prt_transfer::io::image::{self, Precision, exr_bytes, png_bytes, read_exr, read_hdr};
use std::io::Cursor;

fn gradient(width: usize, height: usize) -> Image {
    let pixel = |i: usize| [i as f32 * 0.25, -(i as f32), 1e4 + i as f32];
    Image { width, height, pixels: (0..width * height).map(pixel).collect() }
}

#[test]
fn a_written_exr_reads_back() {
    let image = gradient(37, 21);
    assert_eq!(read_exr(&exr_bytes(&image, Precision::Single).unwrap()).unwrap(), image);
    let half = read_exr(&exr_bytes(&image, Precision::Half).unwrap()).unwrap();
    let rounded = image.pixels.iter().map(|p| p.map(|v| f16::from_f32(v).to_f32()));
    assert!(rounded.eq(half.pixels));
    let folder = folder();
    let path = folder.path().join("light.exr");
    image::write_exr(&path, &image, Precision::Single).unwrap();
    assert_eq!(image::read(&path).unwrap(), image);
    names(image::read("a.png"), ".exr, .hdr");
}

#[test]
fn a_written_png_is_decoded_to_the_same_pixels_and_is_srgb() {
    // Of few colours there is a palette.
    for (colours, kind) in [(777, png::ColorType::Rgb), (256, png::ColorType::Indexed), (1, png::ColorType::Indexed)] {
        let pixels = (0..37 * 21).map(|i| i % colours).map(|i| [i, i / 3, 255 - i % 256].map(|c| c as u8)).collect();
        let picture = Picture { width: 37, height: 21, pixels };
        let folder = folder();
        let path = folder.path().join("picture.png");
        image::write_png(&path, &picture).unwrap();
        let mut decoder = png::Decoder::new(Cursor::new(std::fs::read(&path).unwrap()));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        assert_eq!((reader.info().color_type, reader.info().srgb), (kind, Some(png::SrgbRenderingIntent::Perceptual)));
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((frame.width, frame.height, frame.color_type), (37, 21, png::ColorType::Rgb));
        assert_eq!(pixels, picture.pixels.as_flattened());
    }
    let picture = Picture { width: 37, height: 21, pixels: vec![[1; 3]; 777] };
    names(png_bytes(&Picture { width: 0, height: 3, pixels: Vec::new() }), "picture");
    names(png_bytes(&Picture { width: 3, ..picture }), "expected 63, found 777");
}

/// Named channels of `width` x `height` samples, the data window at `position` in a display window of `display`.
fn file(
    channels: &[(&str, FlatSamples)],
    (width, height): (usize, usize),
    position: (i32, i32),
    display: (usize, usize),
    (compression, blocks): (Compression, Blocks),
) -> Vec<u8> {
    let list = channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone())).collect();
    let attributes = LayerAttributes { layer_position: Vec2(position.0, position.1), ..LayerAttributes::default() };
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let mut image =
        exr::prelude::Image::from_layer(Layer::new((width, height), attributes, encoding, AnyChannels::sort(list)));
    image.attributes.display_window = IntegerBounds::new((0, 0), display);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

const PLAIN: (Compression, Blocks) = (Compression::Uncompressed, Blocks::ScanLines);

#[test]
fn every_compression_and_both_block_shapes_are_read() {
    use Compression::{B44, B44A, DWAA, DWAB, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
    let (width, height) = (40, 36);
    let value = |i: usize, c: usize| 2.0 + ((i % width) as f32 * 0.2).sin() + (i / width) as f32 * 0.03 + c as f32;
    for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, B44, B44A, DWAA(None), DWAB(None)] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16))] {
            for half in [true, false] {
                let samples = |c: usize| {
                    let values = (0..width * height).map(|i| value(i, c));
                    if half {
                        FlatSamples::F16(values.map(f16::from_f32).collect())
                    } else {
                        FlatSamples::F32(values.collect())
                    }
                };
                let channels = [("R", samples(0)), ("G", samples(1)), ("B", samples(2)), ("A", samples(0))];
                let encoding = (compression, blocks);
                let image = read_exr(&file(&channels, (width, height), (0, 0), (width, height), encoding)).unwrap();
                // Half precision costs 1e-3, the lossy codings somewhat more.
                let lossy = matches!(compression, B44 | B44A | DWAA(_) | DWAB(_));
                let tolerance = if lossy { 0.08 } else { 2e-3 };
                for (i, pixel) in image.pixels.iter().enumerate() {
                    for (c, found) in pixel.iter().enumerate() {
                        let expected = value(i, c);
                        assert!((found - expected).abs() < tolerance, "{compression:?} {blocks:?} {found} {expected}");
                    }
                }
            }
        }
    }
}

#[test]
fn grey_layered_and_integer_channels_are_understood() {
    let floats = |v: f32| FlatSamples::F32(vec![v, v + 1.0]);
    let read = |channels: &[(&str, FlatSamples)]| read_exr(&file(channels, (2, 1), (0, 0), (2, 1), PLAIN));
    assert_eq!(read(&[("Y", floats(3.0))]).unwrap().pixels, [[3.0; 3], [4.0; 3]]);
    let layered = [("Sky.R", floats(1.0)), ("Sky.G", floats(2.0)), ("Sky.B", floats(3.0)), ("Z", floats(9.0))];
    assert_eq!(read(&layered).unwrap().pixels[0], [1.0, 2.0, 3.0]);
    let integer = [("R", FlatSamples::U32(vec![7, 8])), ("G", floats(0.0)), ("B", floats(0.0))];
    assert_eq!(read(&integer).unwrap().pixels[1], [8.0, 1.0, 1.0]);
    names(read(&[("Z", floats(0.0))]), "channels");
}

#[test]
fn the_data_window_lies_inside_the_display_window() {
    let grey = FlatSamples::F32((1..=6).map(|v| v as f32).collect());
    let image = read_exr(&file(&[("Y", grey)], (3, 2), (2, -1), (4, 2), PLAIN)).unwrap();
    assert_eq!((image.width, image.height), (4, 2));
    let grey: Vec<f32> = image.pixels.iter().map(|p| p[0]).collect();
    assert_eq!(grey, [0.0, 0.0, 4.0, 5.0, 0.0, 0.0, 0.0, 0.0]);
}

fn picture(header: &str, size: &str, body: &[u8]) -> Vec<u8> {
    [format!("#?RADIANCE\n{header}FORMAT=32-bit_rle_rgbe\n\n{size}\n").as_bytes(), body].concat()
}

#[test]
fn flat_old_and_new_run_lengths_are_one_picture() {
    // Eight pixels: seven alike, one other; 128 with exponent 129 is 1.
    let flat = [[128, 64, 32, 129]; 7].concat();
    let flat = [&flat[..], &[1, 0, 0, 136]].concat();
    let old = [128, 64, 32, 129, 1, 1, 1, 6, 1, 0, 0, 136];
    let new = [2, 2, 0, 8, 135, 128, 1, 1, 135, 64, 129, 0, 7, 32, 32, 32, 32, 32, 32, 32, 1, 0, 135, 129, 1, 136];
    let expected = [vec![[1.0, 0.5, 0.25]; 7], vec![[1.0, 0.0, 0.0]]].concat();
    for body in [&flat[..], &old, &new] {
        assert_eq!(read_hdr(&picture("", "-Y 1 +X 8", body)).unwrap().pixels, expected);
    }
}

#[test]
fn successive_old_repeats_count_in_base_256() {
    let body = [9, 9, 9, 136, 1, 1, 1, 2, 1, 1, 1, 1];
    let image = read_hdr(&picture("", "-Y 1 +X 259", &body)).unwrap();
    assert_eq!(image.pixels, vec![[9.0; 3]; 259]);
}

#[test]
fn the_eight_orientations_put_the_first_pixel_in_its_corner() {
    // Six pixels numbered 0 to 5 along the file; the image is 3 wide and 2 high, or 2 and 3.
    let body: Vec<u8> = (0..6).flat_map(|i| [i, 0, 0, 136]).collect();
    for (size, width, expected) in [
        ("-Y 2 +X 3", 3, [0, 1, 2, 3, 4, 5]),
        ("-Y 2 -X 3", 3, [2, 1, 0, 5, 4, 3]),
        ("+Y 2 +X 3", 3, [3, 4, 5, 0, 1, 2]),
        ("+Y 2 -X 3", 3, [5, 4, 3, 2, 1, 0]),
        ("+X 2 -Y 3", 2, [0, 3, 1, 4, 2, 5]),
        ("-X 2 -Y 3", 2, [3, 0, 4, 1, 5, 2]),
        ("+X 2 +Y 3", 2, [2, 5, 1, 4, 0, 3]),
        ("-X 2 +Y 3", 2, [5, 2, 4, 1, 3, 0]),
    ] {
        let image = read_hdr(&picture("", size, &body)).unwrap();
        let red: Vec<i32> = image.pixels.iter().map(|p| p[0] as i32).collect();
        assert_eq!((image.width, red), (width, expected.to_vec()), "{size}");
    }
}

#[test]
fn exposures_are_divided_out() {
    let image = read_hdr(&picture("EXPOSURE=2\nEXPOSURE=4.0\nCOLORCORR=1 2 4\n", "-Y 1 +X 1", &[128, 128, 128, 136]));
    assert_eq!(image.unwrap().pixels, [[16.0, 8.0, 4.0]]);
}

#[test]
fn a_broken_picture_names_the_byte() {
    names(read_hdr(b"P6\n"), "byte 3");
    names(read_hdr(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n"), "32-bit_rle_rgbe");
    names(read_hdr(&picture("EXPOSURE=0\n", "-Y 1 +X 1", &[0; 4])), "exposures");
    names(read_hdr(&picture("", "-Y 1 +Z 1", &[0; 4])), "size");
    names(read_hdr(&picture("", "-Y 0 +X 1", &[])), "0");
    names(read_hdr(&picture("", "-Y 1 +X 2", &[0; 4])), "byte");
    names(read_hdr(&picture("", "-Y 1 +X 8", &[2, 2, 0, 9])), "8 pixels");
    names(read_hdr(&picture("", "-Y 1 +X 8", &[2, 2, 0, 8, 137, 1])), "run of 1 to 8");
    names(read_hdr(&picture("", "-Y 1 +X 2", &[1, 1, 1, 1])), "repeat");
}
