//! What the targets share: each hands libFuzzer's bytes to one [`Reader`] and checks what it accepts.

use prt_tests::hostile::{Kind, Parts, Reader, mutate_parts, reseal};
use libfuzzer_sys::fuzzer_mutate;
use rand::RngExt;
use std::panic::{set_hook, take_hook};

pub use libfuzzer_sys;
pub use prt_tests::hostile::reader;

/// Before the first input: one thread, and panics that a reader catches itself do not end the process.
pub fn start() {
    // SAFETY: libFuzzer has started no thread yet.
    unsafe { std::env::set_var("RAYON_NUM_THREADS", "1") };
    let abort = take_hook();
    // The reader of .exr takes panics of the `exr` crate for damage; libfuzzer-sys would abort at them.
    set_hook(Box::new(move |panic| {
        let of_exr = |file: &str| file.contains("/exr-");
        if !panic.location().is_some_and(|place| of_exr(place.file())) {
            abort(panic);
        }
    }));
}

/// Reads, and checks what was read.
pub fn run(reader: &Reader, bytes: &[u8]) {
    match (reader.read)(bytes) {
        Ok(check) => check(),
        Err(message) => assert!((1..=2000).contains(&message.len()), "refuses with {} bytes", message.len()),
    }
}

/// Changes bytes as their kind demands; the number of bytes that they are then.
pub fn mutate(reader: &Reader, data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    match reader.kind {
        Kind::File => fuzzer_mutate(data, size, max_size),
        Kind::Sealed => {
            let length = fuzzer_mutate(data, size, max_size);
            reseal(&mut data[..length]);
            length
        }
        Kind::Parts => match Parts::from_bytes(&data[..size]) {
            Ok(parts) => {
                let bytes = mutated(parts, max_size - size, seed);
                let length = bytes.len().min(max_size);
                data[..length].copy_from_slice(&bytes[..length]);
                length
            }
            Err(_) => fuzzer_mutate(data, size, max_size),
        },
    }
}

/// One section or line changed: half of the times as the mutation test does, half of the times by libFuzzer's own mutations, which know what
/// comparisons failed.
fn mutated(mut parts: Parts, room: usize, seed: u32) -> Vec<u8> {
    let mut rng = prt_tests::random(seed.into());
    if parts.sections.is_empty() || rng.random_range(0..2) == 0 {
        return mutate_parts(&parts, &parts, &mut rng);
    }
    let at = rng.random_range(0..parts.sections.len());
    let bytes = &mut parts.sections[at].bytes;
    let length = bytes.len();
    bytes.resize(length + room.min(64), 0);
    let longest = bytes.len();
    let length = fuzzer_mutate(bytes, length, longest);
    bytes.truncate(length);
    parts.to_bytes()
}

/// A target of the reader of this name.
#[macro_export]
macro_rules! fuzz {
    ($name:literal) => {
        use $crate::libfuzzer_sys;
        libfuzzer_sys::fuzz_target!(init: $crate::start(), |bytes: &[u8]| {
            $crate::run($crate::reader($name), bytes);
        });
        libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
            $crate::mutate($crate::reader($name), data, size, max_size, seed)
        });
    };
}
