//! Matrices of more than one block, and of more lights than two bytes count.

mod common;

use common::{encode, registry, reloaded};
use ndarray::Array2;
use prt_bicluster::{BiclusterParams, Levels};
use prt_transfer::{Compressed, Flops, LightBasis, Section, TransferMatrix};

/// Rows of windows whose places and lengths all differ, their ends half seen, every seventh of other signs: `between` apart.
fn windows(rows: usize, lights: usize, between: usize) -> TransferMatrix {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    let places = (lights - 40) / between;
    for row in 0..rows {
        let (start, length) = (row % places * between, 4 + row / places);
        for i in 0..length {
            columns.push((start + i) as u32);
            values.push(if i == 0 {
                0.25
            } else if start % 7 == 6 {
                -1.0
            } else {
                1.0
            });
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, 1, LightBasis::Plain { lights }).unwrap()
}

/// As a file gives it back.
fn through_file(levels: Levels, matrix: &TransferMatrix) -> Compressed {
    let compressed = encode(BiclusterParams { levels, ..Default::default() }, matrix);
    let reloaded = reloaded(&compressed);
    assert!(reloaded.held().into_sections() == compressed.held().into_sections(), "{levels:?}");
    reloaded
}

/// The numbers of a section, of so many bytes each.
fn numbers(sections: &[Section], name: &str, width: usize) -> Vec<u32> {
    let bytes = sections.iter().find(|s| s.name == name).map_or(&[][..], |s| &s.bytes);
    bytes.chunks(width).map(|b| b.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b))).collect()
}

fn assert_exact(compressed: &Compressed, matrix: &TransferMatrix, what: &str) {
    let lights = matrix.lights();
    let (mut row, mut expected) = (vec![0f32; lights], vec![0f32; lights]);
    for r in (0..matrix.rows()).step_by(1 + lights / 10_000) {
        compressed.row_into(r, &mut row);
        matrix.gather(r, &mut expected);
        assert!(row == expected, "{what}: row {r}");
    }
    for channels in [1, 3] {
        // Multiples of 2^-8 below 2^6: sums of a row are exact.
        let coefficient = |(k, c): (usize, usize)| ((k * 37 + k / 65_536 * 5 + c * 1001) % 16_384) as f32 / 256.0;
        let light = Array2::from_shape_fn((lights, channels), coefficient);
        let (mut y, mut expected) =
            (Array2::zeros((matrix.rows(), channels)), Array2::zeros((matrix.rows(), channels)));
        compressed.apply_into(light.view(), y.view_mut()).unwrap();
        matrix.apply_into(light.view(), expected.view_mut()).unwrap();
        assert!(y == expected, "{what}: {channels} channels");
    }
}

#[test]
fn several_blocks_are_exact_and_cost_what_their_sections_say() {
    let matrix = windows(9000, 400, 1);
    for levels in [Levels::One, Levels::Two, Levels::All] {
        let compressed = through_file(levels, &matrix);
        let sections = compressed.held().into_sections();
        let blocks = numbers(&sections, "index/blocks", 4);
        assert!(blocks.len() > 3, "{levels:?}: one block");
        assert_exact(&compressed, &matrix, &format!("{levels:?}"));
        // A multiplication for each leaf whose factor is not 1.
        let (factors, ends) = (numbers(&sections, "weights/factors", 4), numbers(&sections, "index/runs", 4));
        let (mut first, mut all, mut scaled, mut negative) = (0, 0, 0, 0);
        for block in blocks.chunks(3) {
            let mut leaf = 0;
            for run in first..first + block[0] as usize {
                let leaves = u64::from(ends[run] - std::mem::replace(&mut leaf, ends[run]));
                let factor = f32::from_bits(factors[run]);
                all += leaves;
                scaled += if factor == 1.0 { 0 } else { leaves };
                negative += if factor == -1.0 { leaves } else { 0 };
            }
            first += block[0] as usize;
        }
        let columns = sections.iter().find(|s| s.name == "index/columns").unwrap();
        assert_eq!(columns.bytes.len() as u64, 2 * all, "{levels:?}: two bytes a leaf");
        // One addition less than terms for each sum and each row.
        let sums: u32 = blocks.chunks(3).map(|block| block[1]).sum();
        let rows: u32 = numbers(&sections, "index/groups", 4).chunks(2).map(|g| (g[0] - 1) * g[1]).sum();
        let additions = numbers(&sections, "index/inputs", 2).len() as u32 - sums + rows;
        let expected = Flops { multiplications: scaled, additions: additions.into(), by_one: negative };
        assert!(numbers(&sections, "header/products", 4).is_empty(), "{levels:?}: elements are left");
        assert_eq!(compressed.flops(&vec![1.0; 400]).unwrap(), expected, "{levels:?}");
        assert!(scaled > negative && negative > 0, "{levels:?}: {scaled} {negative}");
    }
}

#[test]
fn more_lights_than_two_bytes_count_are_exact() {
    let matrix = windows(1400, 70_000, 1000);
    for levels in [Levels::One, Levels::All] {
        let compressed = through_file(levels, &matrix);
        let sections = compressed.held().into_sections();
        assert!(numbers(&sections, "index/columns", 4).iter().any(|&c| c > u32::from(u16::MAX)), "{levels:?}");
        assert_exact(&compressed, &matrix, &format!("{levels:?}"));
    }
}

#[test]
fn a_section_of_one_number_too_many_or_too_few_is_refused() {
    let matrix = windows(3000, 400, 1);
    let registry = registry();
    for levels in [Levels::One, Levels::Two] {
        let compressed = through_file(levels, &matrix);
        let sections = compressed.sections().into_sections();
        let restored = |sections| registry.restore(&compressed.header(), sections);
        assert!(restored(sections.clone()).is_ok(), "{levels:?}");
        let widths = [
            ("index/slots", 4),
            ("index/blocks", 4),
            ("weights/factors", 4),
            ("index/runs", 4),
            ("index/columns", 2),
            ("index/arities", 2),
            ("index/inputs", 2),
            ("index/groups", 4),
            ("index/terms", 2),
        ];
        for (name, width) in widths {
            let at = sections.iter().position(|s| s.name == name);
            let at = at.unwrap_or_else(|| panic!("{levels:?}: no {name}"));
            let [mut more, mut fewer] = [sections.clone(), sections.clone()];
            more[at].bytes.extend(vec![0; width]);
            let length = fewer[at].bytes.len() - width;
            fewer[at].bytes.truncate(length);
            assert!(restored(more).is_err() && restored(fewer).is_err(), "{levels:?} {name}");
        }
    }
}
