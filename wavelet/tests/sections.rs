//! What truncation writes, and what it refuses to read.

use proptest::prelude::*;
use prt_transfer::transform::Identity;
use prt_transfer::{Compressed, LightBasis, Quiet, Registry, Section, TransferMatrix};
use prt_wavelet::{Haar, Truncate};

const LABELS: [&str; 4] = [
    "truncate:terms=3",
    "truncate:terms=3:bits=16",
    "truncate:terms=3:order=columns",
    "haar+truncate:max_error=0.05:bits=8:order=columns",
];

fn registry() -> Registry {
    Registry::new().transform::<Identity>().transform::<Haar>().codec::<Truncate>()
}

fn encode(label: &str, matrix: &TransferMatrix) -> Compressed {
    registry().method(&label.parse().unwrap()).unwrap().encode(matrix, &Quiet).unwrap()
}

fn matrix(rows: usize, basis: LightBasis) -> TransferMatrix {
    let values = (0..rows * basis.lights()).map(|i| (i * i % 23) as f32 - 11.0).collect();
    TransferMatrix::from_dense(values, rows, 1, basis).unwrap()
}

fn cubemap(rows: usize) -> TransferMatrix {
    matrix(rows, LightBasis::Cubemap { resolution: 2 })
}

#[test]
fn what_was_read_writes_the_same_sections() {
    for rows in [0, 1, 40, 1030] {
        for label in LABELS {
            let compressed = encode(label, &cubemap(rows));
            let sections = compressed.sections().into_sections();
            let read = registry().restore(&compressed.header(), sections.clone()).unwrap();
            assert_eq!(read.sections().into_sections(), sections, "{label}");
        }
    }
}

#[test]
fn empty_narrow_and_dark_matrices_are_matrices_too() {
    for (rows, lights) in [(0, 5), (1, 5), (5, 1), (1, 1), (3, 0), (0, 0)] {
        for factor in [0.0, 1.0] {
            let values = vec![factor; rows * lights];
            let matrix = TransferMatrix::from_dense(values.clone(), rows, 1, LightBasis::Plain { lights }).unwrap();
            for label in ["truncate", "truncate:max_error=0", "truncate:energy=1:order=columns", "truncate:bits=8"] {
                let compressed = encode(label, &matrix);
                let sections = compressed.sections().into_sections();
                let read = registry().restore(&compressed.header(), sections).unwrap();
                let mut row = vec![f32::NAN; lights];
                for r in 0..rows {
                    read.row_into(r, &mut row);
                    assert_eq!(row, values[..lights], "{label}");
                }
                let (light, mut out) = (ndarray::Array2::ones((lights, 3)), ndarray::Array2::ones((rows, 3)));
                read.apply_into(light.view(), out.view_mut()).unwrap();
                assert!(out.iter().all(|&y| y == factor * lights as f32));
                read.flops(&vec![1.0; lights]).unwrap();
            }
        }
    }
}

#[test]
fn columns_have_the_narrowest_width_that_holds_them() {
    for (lights, width) in [(256, 1), (257, 2), (65536, 2), (65537, 4)] {
        let mut values = vec![0f32; lights];
        values[lights - 1] = 1.0;
        let matrix = TransferMatrix::from_dense(values.clone(), 1, 1, LightBasis::Plain { lights }).unwrap();
        for label in ["truncate", "truncate:order=columns"] {
            let compressed = encode(label, &matrix);
            let sink = compressed.sections();
            assert_eq!(sink.sizes().find(|(name, _)| *name == "index/columns").unwrap().1, width, "{lights}");
            let read = registry().restore(&compressed.header(), sink.into_sections()).unwrap();
            let mut row = vec![f32::NAN; lights];
            read.row_into(0, &mut row);
            assert_eq!(row, values);
        }
    }
}

/// One section replaced by other numbers.
fn with<T: prt_transfer::sections::Pod>(
    sections: &[Section],
    name: &str,
    change: impl Fn(&mut Vec<T>),
) -> Vec<Section> {
    let mut source = prt_transfer::Source::new(sections.iter().filter(|s| s.name == name).cloned().collect()).unwrap();
    let mut numbers: Vec<T> = source.take(name).unwrap();
    change(&mut numbers);
    let mut sink = prt_transfer::Sink::new();
    sink.put(name, &numbers);
    sections.iter().filter(|s| s.name != name).cloned().chain(sink.into_sections()).collect()
}

#[test]
fn sections_that_break_the_layout_are_refused_by_name() {
    type Change = fn(&[Section]) -> Vec<Section>;
    let rows: &[(&str, Change)] = &[
        ("header/layout", |s| with(s, "header/layout", |n: &mut Vec<u8>| n[0] = 2)),
        ("header/layout", |s| with(s, "header/layout", |n: &mut Vec<u8>| n[1] = 24)),
        ("header/layout", |s| with(s, "header/layout", |n: &mut Vec<u8>| n.push(0))),
        ("index/offsets", |s| with(s, "index/offsets", |n: &mut Vec<u32>| n[0] = 1)),
        ("index/offsets", |s| with(s, "index/offsets", |n: &mut Vec<u32>| n[2] = u32::MAX)),
        ("index/offsets", |s| with(s, "index/offsets", |n: &mut Vec<u32>| n[5] += 1)),
        ("index/columns", |s| with(s, "index/columns", |n: &mut Vec<u8>| n[2] = 24)),
        ("index/columns", |s| with(s, "index/columns", |n: &mut Vec<u8>| n[1] = n[0])),
        ("index/columns", |s| with(s, "index/columns", |n: &mut Vec<u8>| n.swap(0, 1))),
        ("weights/values", |s| with(s, "weights/values", |n: &mut Vec<f32>| n[3] = f32::NAN)),
        ("weights/values", |s| with(s, "weights/values", |n: &mut Vec<f32>| n.truncate(4))),
    ];
    let columns: &[(&str, Change)] = &[
        ("index/blocks", |s| with(s, "index/blocks", |n: &mut Vec<[u32; 2]>| n[1][0] += 1)),
        ("index/blocks", |s| with(s, "index/blocks", |n: &mut Vec<[u32; 2]>| n[0] = [1, 1])),
        ("index/columns", |s| with(s, "index/columns", |n: &mut Vec<u8>| n[1] = 0)),
        ("index/columns", |s| with(s, "index/columns", |n: &mut Vec<u8>| *n.last_mut().unwrap() = 24)),
        ("index/lengths", |s| with(s, "index/lengths", |n: &mut Vec<u16>| n[0] += 1)),
        ("index/lengths", |s| {
            with(s, "index/lengths", |n: &mut Vec<u16>| {
                n[1] += n[0];
                n[0] = 0;
            })
        }),
        ("index/rows", |s| with(s, "index/rows", |n: &mut Vec<u16>| *n.last_mut().unwrap() = 5)),
        ("index/rows", |s| with(s, "index/rows", |n: &mut Vec<u16>| n[1] = n[0])),
        ("weights/steps", |s| with(s, "weights/steps", |n: &mut Vec<f32>| n[2] = -1.0)),
        ("weights/steps", |s| with(s, "weights/steps", |n: &mut Vec<f32>| n[2] = f32::MAX)),
        // 32,767 steps are finite, 32,768 are not.
        ("weights/steps", |s| with(s, "weights/steps", |n: &mut Vec<f32>| n[2] = f32::MAX / 32_767.5)),
    ];
    // Blocks of rows: the second and last has six, and it alone can begin before the first ends.
    let blocks: &[(&str, Change)] = &[
        ("index/blocks", |s| with(s, "index/blocks", |n: &mut Vec<[u32; 2]>| n[1][0] = n[2][0] + 1)),
        ("index/blocks", |s| with(s, "index/blocks", |n: &mut Vec<[u32; 2]>| n[1][1] = n[2][1] + 1)),
        ("index/rows", |s| with(s, "index/rows", |n: &mut Vec<u16>| *n.last_mut().unwrap() = 6)),
    ];
    for (label, samples, changes) in [
        ("truncate:terms=3", 5, rows),
        ("truncate:terms=9:order=columns:bits=16", 5, columns),
        ("truncate:terms=9:order=columns", 1030, blocks),
    ] {
        let compressed = encode(label, &cubemap(samples));
        let sections = compressed.sections().into_sections();
        for (i, (name, change)) in changes.iter().enumerate() {
            let error = registry().restore(&compressed.header(), change(&sections)).map(|_| ()).unwrap_err();
            assert!(error.to_string().contains(name), "{label} {i}: {error}");
        }
    }
}

proptest! {
    #[test]
    fn damaged_bytes_are_refused_or_harmless(which in 0..LABELS.len(), section in 0usize..9, at in 0usize..4000, bits in 1u8.., cut in prop::option::of(0usize..400)) {
        let compressed = encode(LABELS[which], &cubemap(9));
        let mut sections = compressed.sections().into_sections();
        let count = sections.len();
        let bytes = &mut sections[section % count].bytes;
        match cut {
            Some(cut) => bytes.truncate(cut % (bytes.len() + 1)),
            None => { let at = at % bytes.len(); bytes[at] ^= bits; }
        }
        if let Ok(read) = registry().restore(&compressed.header(), sections) {
            let (mut row, light) = (vec![0f32; 24], ndarray::Array2::ones((24, 3)));
            (0..9).for_each(|r| read.row_into(r, &mut row));
            read.apply_into(light.view(), ndarray::Array2::zeros((9, 3)).view_mut()).unwrap();
            read.flops(&[1.0; 24]).unwrap();
        }
    }
}
