//! Radiance pictures, as the manual page of Radiance's file formats describes them.

use super::broken;
use super::image::affordable;
use crate::error::{Error, Result};
use crate::image::Image;

struct Header {
    /// Pixels of a scan line and number of scan lines, as stored.
    across: usize,
    lines: usize,
    /// Scan lines are columns.
    transposed: bool,
    /// Where x and y descend along the file.
    x_descends: bool,
    y_descends: bool,
    /// What the header's exposures multiply each colour by.
    scale: [f32; 3],
}

pub(super) fn read(bytes: &[u8]) -> Result<Image> {
    let mut source = Bytes { bytes, at: 0 };
    let header = source.header()?;
    affordable("hdr", header.across, header.lines, 12, bytes.len())?;
    let (width, height) = if header.transposed { (header.lines, header.across) } else { (header.across, header.lines) };
    let mut stored = Vec::new();
    for _ in 0..header.lines {
        source.scan_line(header.across, &mut stored)?;
    }
    let mut pixels = vec![[0f32; 3]; width * height];
    for (i, &[r, g, b, exponent]) in stored.iter().enumerate() {
        let (line, along) = (i / header.across, i % header.across);
        let (x, y) = if header.transposed { (line, along) } else { (along, line) };
        let x = if header.x_descends { width - 1 - x } else { x };
        // The image's rows count from the top, which -Y stores first.
        let y = if header.y_descends { y } else { height - 1 - y };
        let unit = if exponent == 0 { 0.0 } else { 2f32.powi(i32::from(exponent) - 136) };
        let colour = [r, g, b];
        pixels[y * width + x] = std::array::from_fn(|c| f32::from(colour[c]) * unit / header.scale[c]);
    }
    Ok(Image { width, height, pixels })
}

struct Bytes<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Bytes<'_> {
    fn wrong(&self, expected: impl Into<String>, found: impl Into<String>) -> Error {
        broken("hdr", format!("byte {}", self.at), expected, found)
    }
    fn line(&mut self) -> Result<String> {
        let rest = &self.bytes[self.at..];
        let Some(end) = rest.iter().position(|&b| b == b'\n') else {
            return Err(self.wrong("a header line", "the end of the file"));
        };
        self.at += end + 1;
        Ok(String::from_utf8_lossy(rest[..end].trim_ascii_end()).into_owned())
    }

    fn header(&mut self) -> Result<Header> {
        let magic = self.line()?;
        if !magic.starts_with("#?") {
            return Err(self.wrong("a Radiance picture (#?RADIANCE)", shown(&magic)));
        }
        let mut scale = [1f32; 3];
        loop {
            let line = self.line()?;
            if line.is_empty() {
                break;
            }
            let Some((name, value)) = line.split_once('=') else {
                continue;
            };
            match name.trim() {
                "FORMAT" if value.trim() != "32-bit_rle_rgbe" => {
                    return Err(self.wrong("FORMAT=32-bit_rle_rgbe", shown(&line)));
                }
                "EXPOSURE" => {
                    let [exposure] = self.factors(value)?;
                    scale = scale.map(|s| s * exposure);
                }
                "COLORCORR" => {
                    let factors: [f32; 3] = self.factors(value)?;
                    scale.iter_mut().zip(factors).for_each(|(s, f)| *s *= f);
                }
                _ => {}
            }
        }
        if scale.iter().any(|s| !s.is_normal() || *s < 0.0) {
            return Err(self.wrong("exposures whose product is positive", format!("{scale:?}")));
        }
        let size = self.line()?;
        let words: Vec<&str> = size.split_whitespace().collect();
        let refuse = || self.wrong("a size such as '-Y 512 +X 1024'", shown(&size));
        let [first, lines, second, across] = words[..] else {
            return Err(refuse());
        };
        let number = |word: &str| word.parse().map_err(|_| refuse());
        let (lines, across) = (number(lines)?, number(across)?);
        let transposed = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => false,
            ("-X" | "+X", "-Y" | "+Y") => true,
            _ => return Err(refuse()),
        };
        let descends = |axis: &str| [first, second].contains(&axis);
        Ok(Header { across, lines, transposed, x_descends: descends("-X"), y_descends: descends("-Y"), scale })
    }

    fn factors<const N: usize>(&self, text: &str) -> Result<[f32; N]> {
        let numbers: Option<Vec<f32>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
        let numbers = numbers.and_then(|n| n.try_into().ok());
        numbers.ok_or_else(|| self.wrong(format!("{N} numbers"), shown(text)))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let Some(&taken) = self.bytes[self.at..].first_chunk() else {
            return Err(self.wrong("more pixels", "the end of the file"));
        };
        self.at += N;
        Ok(taken)
    }

    fn scan_line(&mut self, width: usize, pixels: &mut Vec<[u8; 4]>) -> Result<()> {
        let start = pixels.len();
        let mark = self.bytes[self.at..].first_chunk::<4>();
        match mark {
            // New run-length encoding: 2, 2, then the width in two bytes.
            Some(&[2, 2, high, low]) if (8..32768).contains(&width) && high < 128 => {
                let claimed = usize::from(high) << 8 | usize::from(low);
                if claimed != width {
                    return Err(self.wrong(format!("a scan line of {width} pixels"), claimed.to_string()));
                }
                self.at += 4;
                pixels.resize(start + width, [0; 4]);
                (0..4).try_for_each(|channel| self.channel(channel, &mut pixels[start..]))
            }
            _ => self.old_line(start + width, pixels),
        }
    }

    /// One channel of a scan line: a count above 128 repeats a byte, any other copies that many.
    fn channel(&mut self, channel: usize, line: &mut [[u8; 4]]) -> Result<()> {
        let mut x = 0;
        while x < line.len() {
            let [code] = self.take()?;
            let (length, repeated) = match code {
                129.. => (usize::from(code) - 128, Some(self.take::<1>()?[0])),
                _ => (usize::from(code), None),
            };
            if length == 0 || length > line.len() - x {
                return Err(self.wrong(format!("a run of 1 to {} pixels", line.len() - x), length.to_string()));
            }
            for pixel in &mut line[x..x + length] {
                pixel[channel] = match repeated {
                    Some(value) => value,
                    None => self.take::<1>()?[0],
                };
            }
            x += length;
        }
        Ok(())
    }

    /// Flat pixels, or the old run-length encoding: (1, 1, 1, n) repeats the pixel before n times; directly following
    /// repeats count 256 times as much.
    fn old_line(&mut self, end: usize, pixels: &mut Vec<[u8; 4]>) -> Result<()> {
        let start = pixels.len();
        let mut shift = 0;
        while pixels.len() < end {
            match self.take()? {
                [1, 1, 1, count] => {
                    let length = if shift < 24 { usize::from(count) << shift } else { usize::MAX };
                    let previous = pixels[start..].last().copied();
                    let Some(previous) = previous.filter(|_| length <= end - pixels.len()) else {
                        let room = end - pixels.len();
                        return Err(self.wrong(format!("a repeat of at most {room} pixels"), length.to_string()));
                    };
                    pixels.resize(pixels.len() + length, previous);
                    shift += 8;
                }
                pixel => {
                    pixels.push(pixel);
                    shift = 0;
                }
            }
        }
        Ok(())
    }
}

fn shown(text: &str) -> String {
    format!("'{}'", text.chars().take(60).collect::<String>())
}
