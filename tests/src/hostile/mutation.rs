//! Mutations that know what files are made of: bits, boundary values of numbers of every width and order of bytes, numbers in
//! text, runs of bytes, and parts of other files of the same format.

use super::parts::Parts;
use prt_transfer::{LightBasis, Section};
use rand::{Rng, RngExt};

/// No mutation makes a file longer than this.
const LONGEST: usize = 1 << 17;
/// Numbers in text that no writer means.
const WORDS: &[&str] = &[
    "0",
    "1",
    "-1",
    "1e999",
    "-1e38",
    "1e-45",
    "nan",
    "inf",
    "99999999999",
    "2147483648",
    "4294967295",
    "18446744073709551615",
    "0.5",
    "",
    "x",
    "1048576",
    "3",
    "32",
];
/// Bases with which a header agrees once its number of lights does.
const BASES: &[&str] = &[
    "plain:0",
    "plain:1",
    "plain:96",
    "cubemap:1",
    "cubemap:2",
    "cubemap:8",
    "cubemap:64",
    "cubemap:2048",
    "latlong:12x8",
    "latlong:96x1",
    "latlong:1x96",
    "latlong:1x16384",
    "sh:3",
    "lobes:96",
];
const BYTES: &[u8] = &[0, 1, 0x7f, 0x80, 0xff, b' ', b'\n', b'0'];
const FLOATS: &[f32] = &[0.0, -0.0, 1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e-45, 3e20];

/// Changes a file in one to four places; `other` is a file of the same format.
pub fn mutate(bytes: &mut Vec<u8>, other: &[u8], rng: &mut impl Rng) {
    let times = [1, 1, 2, 4];
    for _ in 0..times[rng.random_range(0..times.len())] {
        once(bytes, other, rng);
        bytes.truncate(LONGEST);
    }
}

fn once(bytes: &mut Vec<u8>, other: &[u8], rng: &mut impl Rng) {
    if bytes.is_empty() {
        return bytes.extend(other);
    }
    match rng.random_range(0..14) {
        0 | 1 => {
            let at = rng.random_range(0..bytes.len());
            bytes[at] ^= 1 << rng.random_range(0..8u32);
        }
        2 => {
            let at = rng.random_range(0..bytes.len());
            bytes[at] = pick(BYTES, rng);
        }
        3 | 4 => integer(bytes, rng),
        5 => float(bytes, rng),
        6 | 7 => word(bytes, rng),
        8 => {
            let run = run(bytes, rng);
            let at = rng.random_range(0..=bytes.len());
            let copy = bytes[run].to_vec();
            bytes.splice(at..at, copy);
        }
        9 => drop(bytes.drain(run(bytes, rng))),
        10 => {
            let moved: Vec<u8> = bytes.drain(run(bytes, rng)).collect();
            let at = rng.random_range(0..=bytes.len());
            bytes.splice(at..at, moved);
        }
        11 => bytes.truncate(rng.random_range(0..bytes.len())),
        12 => splice(bytes, other, rng),
        _ => {
            let count = rng.random_range(1..64);
            bytes.extend(std::iter::repeat_n(pick(BYTES, rng), count));
        }
    }
}

/// One of several.
fn pick<T: Copy>(from: &[T], rng: &mut impl Rng) -> T {
    from[rng.random_range(0..from.len())]
}

/// A short run, seldom a long one.
fn run(bytes: &[u8], rng: &mut impl Rng) -> std::ops::Range<usize> {
    let longest = if rng.random_range(0..4) == 0 { bytes.len() } else { bytes.len().min(32) };
    let length = rng.random_range(1..=longest);
    let start = rng.random_range(0..=bytes.len() - length);
    start..start + length
}

/// Replaces an integer by a boundary value, or by a neighbour of what it is or of the file's length.
fn integer(bytes: &mut [u8], rng: &mut impl Rng) {
    let width = pick(&[1, 2, 4, 8], rng);
    if bytes.len() < width {
        return;
    }
    let at = rng.random_range(0..=bytes.len() - width);
    let at = if rng.random_range(0..2) == 0 { at - at % width } else { at };
    let big = rng.random_range(0..4) == 0;
    let mut there = [0; 8];
    there[..width].copy_from_slice(&bytes[at..at + width]);
    if big {
        there[..width].reverse();
    }
    let there = u64::from_le_bytes(there);
    let length = bytes.len() as u64;
    let value = match rng.random_range(0..14) {
        0 => 0,
        1 => 1,
        2 => u64::MAX,
        3 => u64::MAX >> 1,
        4 => 1 << 31,
        5 => u32::MAX.into(),
        6 => 1 << 63,
        7 => length - 1 + rng.random_range(0..3),
        8 | 9 => there.wrapping_add(1),
        10 | 11 => there.wrapping_sub(1),
        12 => there.wrapping_mul(2),
        _ => 1 << rng.random_range(0..8 * width),
    };
    let mut value = value.to_le_bytes();
    if big {
        value[..width].reverse();
    }
    bytes[at..at + width].copy_from_slice(&value[..width]);
}

/// Replaces four, eight or two bytes by a number that is none, or a very large or small one.
fn float(bytes: &mut [u8], rng: &mut impl Rng) {
    let value = pick(FLOATS, rng);
    let (wide, narrow) = (f64::from(value).to_le_bytes(), value.to_le_bytes());
    // The upper half of a single is close to the half in all that matters here.
    let number: &[u8] = pick(&[&wide[..], &narrow[..], &narrow[..], &narrow[2..]], rng);
    if let Some(last) = bytes.len().checked_sub(number.len()) {
        let at = rng.random_range(0..=last);
        let at = if rng.random_range(0..4) > 0 { at - at % number.len() } else { at };
        bytes[at..at + number.len()].copy_from_slice(number);
    }
}

/// Replaces a number in text: the first one from a random place on.
fn word(bytes: &mut Vec<u8>, rng: &mut impl Rng) {
    let from = rng.random_range(0..bytes.len());
    let Some(start) = bytes[from..].iter().position(u8::is_ascii_digit).map(|at| from + at) else {
        return;
    };
    let of_number = |b: &u8| b.is_ascii_digit() || b".eE+-".contains(b);
    let start = start - bytes[..start].iter().rev().take_while(|b| of_number(b)).count();
    let end = start + bytes[start..].iter().take_while(|b| of_number(b)).count();
    bytes.splice(start..end, pick(WORDS, rng).bytes());
}

/// The beginning of one and the end of the other, or a run of the other in its place.
fn splice(bytes: &mut Vec<u8>, other: &[u8], rng: &mut impl Rng) {
    if other.is_empty() {
        return;
    }
    if rng.random_range(0..2) == 0 {
        let cut = rng.random_range(0..=bytes.len().min(other.len()));
        bytes.truncate(cut);
        bytes.extend(&other[cut..]);
    } else {
        let of_other = run(other, rng);
        let start = of_other.start.min(bytes.len());
        let end = of_other.end.min(bytes.len());
        bytes.splice(start..end, other[of_other].iter().copied());
    }
}

/// Changes a compressed matrix that is taken apart: its sections mostly, else a line of its header.
pub fn mutate_parts(parts: &Parts, other: &Parts, rng: &mut impl Rng) -> Vec<u8> {
    let (mut lines, mut sections) = (parts.lines(), parts.sections.clone());
    if sections.is_empty() || rng.random_range(0..8) == 0 {
        mutate_lines(&mut lines, &other.lines(), rng);
        return Parts::join(&lines, &sections);
    }
    let at = rng.random_range(0..sections.len());
    match rng.random_range(0..24) {
        0 => drop(sections.remove(at)),
        1 => {
            let to = rng.random_range(0..sections.len());
            let bytes = sections[at].bytes.clone();
            sections[to].bytes = bytes;
        }
        2 => sections.extend(other.sections.iter().find(|s| parts.sections.iter().all(|p| p.name != s.name)).cloned()),
        3 => {
            // All of a name at once, so that what depends on it is found out.
            let named = |section: &&Section| section.name == sections[at].name;
            if let Some(section) = other.sections.iter().find(named) {
                sections[at] = section.clone();
            }
        }
        _ => {
            let of_other = other.sections.iter().find(|s| s.name == sections[at].name);
            let of_other = of_other.map_or(&[][..], |s| &s.bytes);
            mutate(&mut sections[at].bytes, of_other, rng);
        }
    }
    Parts::join(&lines, &sections)
}

fn mutate_lines(lines: &mut [String; 8], other: &[String; 8], rng: &mut impl Rng) {
    let at = rng.random_range(0..lines.len());
    match rng.random_range(0..8) {
        0 => lines[at] = other[at].clone(),
        1 => {
            // Both numbers agree, and nothing else knows of it.
            let basis = pick(BASES, rng);
            lines[4] = basis.parse::<LightBasis>().map_or(0, |basis| basis.lights()).to_string();
            lines[5] = basis.into();
        }
        2 => {
            // As many rows as before, of other samples.
            lines.swap(2, 3);
            lines[6] = format!("plain:{}", lines[3]);
        }
        how => {
            let mut line = std::mem::take(&mut lines[at]).into_bytes();
            if how < 6 && !line.is_empty() {
                word(&mut line, rng);
            } else {
                mutate(&mut line, other[at].as_bytes(), rng);
            }
            lines[at] = String::from_utf8_lossy(&line).into_owned();
        }
    }
}

/// Gives the header of a `.prt` file the checksum that it should have, where its length says where that is.
pub fn reseal(bytes: &mut [u8]) {
    let Some(&length) = bytes.get(12..).and_then(<[u8]>::first_chunk) else {
        return;
    };
    let end = (u32::from_le_bytes(length) as usize).saturating_add(16);
    if (20..=bytes.len()).contains(&end) {
        let checksum = crc32fast::hash(&bytes[..end - 4]);
        bytes[end - 4..end].copy_from_slice(&checksum.to_le_bytes());
    }
}
