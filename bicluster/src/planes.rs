//! Whole numbers for the file: their lowest bytes first, then the next, since bytes of one kind pack better side by side.

use prt_transfer::sections::broken;
use prt_transfer::{Result, Sink, Source};

/// Writes numbers in as many bytes as `largest` needs.
pub(crate) fn put(sink: &mut Sink, name: &str, numbers: &[u32], largest: usize) {
    let bytes: Vec<u8> =
        (0..width(largest)).flat_map(|plane| numbers.iter().map(move |n| (n >> (8 * plane)) as u8)).collect();
    sink.put(name, &bytes);
}

/// Reads numbers up to `largest`, however many.
pub(crate) fn take(source: &mut Source, name: &str, largest: usize) -> Result<Vec<u32>> {
    let bytes: Vec<u8> = source.take(name)?;
    let width = width(largest);
    if !bytes.len().is_multiple_of(width) {
        return Err(broken(name, format!("{width} bytes a number"), format!("{} bytes", bytes.len())));
    }
    let count = bytes.len() / width;
    let number = |i: usize| (0..width).fold(0, |n, plane| n | u32::from(bytes[plane * count + i]) << (8 * plane));
    let numbers: Vec<u32> = (0..count).map(number).collect();
    match numbers.iter().find(|&&n| n as usize > largest) {
        Some(n) => Err(broken(name, format!("numbers up to {largest}"), n.to_string())),
        None => Ok(numbers),
    }
}

fn width(largest: usize) -> usize {
    (1..4).find(|bytes| largest >> (8 * bytes) == 0).unwrap_or(4)
}
