use super::{folder, names};
use half::f16;
use ndarray::{Array2, array};
use proptest::prelude::*;
use prt_transfer::io::matrix::{self, Description};
use prt_transfer::io::{mtx, npy, npz};
use prt_transfer::matrix::Layout;
use prt_transfer::{LightBasis, ResponseBasis, Shape, TransferMatrix};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;

fn plain(responses: usize) -> ResponseBasis {
    ResponseBasis::Plain { responses }
}

const BARE: Description = Description { responses: None, basis: None };

/// An array file of format version 1, put together by hand.
fn array_file(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let text = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

fn archive(entries: &[(&str, Vec<u8>)], method: zip::CompressionMethod) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        archive.start_file(*name, SimpleFileOptions::default().compression_method(method)).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn i64s(numbers: &[i64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// A compressed matrix of 64-bit integers, as scipy would archive it.
fn compressed(format: &str, shape: [i64; 2], indptr: &[i64], indices: &[i64], data: &[i64]) -> Vec<u8> {
    let vector = |numbers: &[i64]| array_file("<i8", false, &format!("({},)", numbers.len()), &i64s(numbers));
    let entries = [
        ("format.npy", array_file("|S3", false, "()", format.as_bytes())),
        ("shape.npy", vector(&shape)),
        ("indptr.npy", vector(indptr)),
        ("indices.npy", vector(indices)),
        ("data.npy", vector(data)),
    ];
    archive(&entries, zip::CompressionMethod::Stored)
}

fn read_npz(bytes: &[u8]) -> prt_transfer::Result<TransferMatrix> {
    Ok(npz::read_from(Cursor::new(bytes), &BARE)?.matrix)
}

fn read_npy(bytes: &[u8]) -> prt_transfer::Result<TransferMatrix> {
    npy::read_from(Cursor::new(bytes), &BARE)
}

fn dense(matrix: &TransferMatrix) -> Vec<Vec<f32>> {
    let row = |r| {
        let mut out = vec![0.0; matrix.lights()];
        matrix.gather(r, &mut out);
        out
    };
    (0..matrix.rows()).map(row).collect()
}

/// Any matrix, sparse or dense, with responses and a basis.
fn matrices() -> impl Strategy<Value = TransferMatrix> {
    let value = prop_oneof![3 => Just(0f32), 1 => proptest::num::f32::NORMAL | proptest::num::f32::SUBNORMAL];
    (0usize..5, 1usize..4, 1usize..3, any::<bool>(), any::<bool>()).prop_flat_map(
        move |(samples, responses, edge, sparse, by_samples)| {
            let (rows, lights) = (samples * responses, 6 * edge * edge);
            proptest::collection::vec(value.clone(), rows * lights).prop_map(move |values| {
                let basis = LightBasis::Cubemap { resolution: edge };
                if !sparse {
                    let matrix = TransferMatrix::from_dense(values, rows, responses, basis).unwrap();
                    return if by_samples { matrix.by_samples() } else { matrix };
                }
                let (mut offsets, mut columns, mut kept) = (vec![0], Vec::new(), Vec::new());
                for row in values.chunks(lights) {
                    for (column, value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                        columns.push(column as u32);
                        kept.push(*value);
                    }
                    offsets.push(kept.len());
                }
                TransferMatrix::from_csr(offsets, columns, kept, responses, basis).unwrap()
            })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_format_reads_back_the_exact_elements(matrix in matrices()) {
        let folder = folder();
        for extension in ["npz", "npy", "mtx"] {
            let path = folder.path().join(format!("T.{extension}"));
            matrix::write(&path, &matrix).unwrap();
            let shape = matrix.shape();
            let given = Description { responses: Some(plain(shape.responses)), basis: Some(matrix.basis().clone()) };
            // Three-dimensional arrays carry responses themselves; a disagreement would be an error.
            let read = matrix::read(&path, &given).unwrap();
            prop_assert_eq!(read.shape(), shape);
            prop_assert_eq!(read.basis(), matrix.basis());
            prop_assert_eq!(dense(&read), dense(&matrix));
        }
        let npz = matrix::read(folder.path().join("T.npz"), &BARE).unwrap();
        prop_assert_eq!((npz.shape(), npz.basis()), (matrix.shape(), matrix.basis()));
        let npy = matrix::read(folder.path().join("T.npy"), &Description { responses: Some(plain(matrix.shape().responses)), basis: None }).unwrap();
        prop_assert_eq!(npy.layout() == Layout::Samples, matrix.layout() == Layout::Samples);
        if matrix.is_sparse() {
            prop_assert_eq!(npz, matrix);
        }
    }
}

#[test]
fn an_archive_carries_responses_basis_and_signal_and_refuses_to_be_contradicted() {
    let basis = LightBasis::Cubemap { resolution: 1 };
    let matrix = TransferMatrix::from_csr(vec![0, 1, 1], vec![5], vec![0.25], 2, basis).unwrap();
    let bytes = npz::to_bytes(&matrix, "biscale of a \"teapot\"").unwrap();
    let read = npz::read_from(Cursor::new(&bytes), &BARE).unwrap();
    assert_eq!(read.signal, "biscale of a \"teapot\"");
    assert_eq!(read.matrix.shape(), Shape { samples: 1, responses: 2, lights: 6 });
    let with = |responses: Option<usize>, basis: Option<&str>| {
        let basis = basis.map(|b| b.parse().unwrap());
        npz::read_from(Cursor::new(&bytes), &Description { responses: responses.map(plain), basis })
    };
    assert!(with(Some(2), Some("cubemap:1")).is_ok());
    names(with(Some(1), None), "responses of a sample");
    names(with(None, Some("plain:6")), "light basis");
    names(
        npy::read_from(
            Cursor::new(array_file("|u1", false, "(1, 2, 3)", &[0; 6])),
            &Description { responses: Some(plain(1)), basis: None },
        ),
        "responses of a sample",
    );
}

#[test]
fn an_archive_carries_what_responses_stand_for_and_a_bare_number_agrees_with_it() {
    let terms = "terms:2:phong:exponent=9".parse::<ResponseBasis>().unwrap();
    let basis = LightBasis::Plain { lights: 6 };
    let matrix = TransferMatrix::from_csr(vec![0, 1, 1], vec![5], vec![0.25], 2, basis).unwrap();
    let known = matrix.with_responses(terms.clone()).unwrap();
    let bytes = npz::to_bytes(&known, "").unwrap();
    let with = |responses| npz::read_from(Cursor::new(&bytes), &Description { responses, basis: None });
    for given in [None, Some(plain(2)), Some(terms)] {
        assert_eq!(with(given).unwrap().matrix, known);
    }
    names(with(Some(plain(1))), "responses of a sample");
    names(with(Some("terms:2:lambert".parse().unwrap())), "responses of a sample");
    assert!(known.with_responses(ResponseBasis::Irradiance { brdf: None }).is_err());
}

#[test]
fn the_archive_is_the_same_on_any_number_of_threads() {
    let (n, basis) = (3000, LightBasis::Plain { lights: 64 });
    let values: Vec<f32> = (0..n).map(|i| (i % 7) as f32 + 0.5).collect();
    let columns = (0..n as u32).map(|i| i % 64).collect();
    let matrix = TransferMatrix::from_csr((0..=n).collect(), columns, values, 1, basis).unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| npz::to_bytes(&matrix, "").unwrap())
    };
    assert_eq!(on(1), on(2));
}

/// The nearest `f32` of each number's decimal, by the standard library's own parser, is the second computation.
#[test]
fn every_element_type_is_taken_at_its_value_in_either_byte_order() {
    macro_rules! check {
        ($($type:ty, $code:literal, [$($value:expr),*];)*) => {$(
            let numbers: Vec<$type> = vec![$($value),*];
            let expected: Vec<f32> = numbers.iter().map(|n| n.to_string().parse().unwrap()).collect();
            for (order, bytes) in [
                ('<', numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>()),
                ('>', numbers.iter().flat_map(|n| n.to_be_bytes()).collect()),
            ] {
                let descr = if size_of::<$type>() == 1 { concat!("|", $code).into() } else { format!("{order}{}", $code) };
                let matrix = read_npy(&array_file(&descr, false, &format!("(1, {})", numbers.len()), &bytes)).unwrap();
                assert_eq!(dense(&matrix)[0], expected, "{descr}");
            }
        )*};
    }
    check! {
        i8, "i1", [-128, 0, 127];
        u8, "u1", [0, 255];
        i16, "i2", [-32768, 1];
        u16, "u2", [65535, 1];
        i32, "i4", [-2147483648, 7];
        u32, "u4", [4294967295, 7];
        i64, "i8", [i64::MIN, 3];
        u64, "u8", [u64::MAX, 3];
        f16, "f2", [f16::from_f32(0.333), f16::from_f32(-65504.0)];
        f32, "f4", [0.1, -3.4e38, 1e-45];
        f64, "f8", [0.1, 1e-300, 3.4028235e38];
    }
    assert_eq!(dense(&read_npy(&array_file("|b1", false, "(1, 3)", &[0, 1, 1])).unwrap()), [[0.0, 1.0, 1.0]]);
}

#[test]
fn fortran_order_is_the_transpose_of_c_order_in_two_and_three_dimensions() {
    let (a, b, c) = (2, 3, 4);
    let at = |i: usize, j: usize, k: usize| (100 * i + 10 * j + k) as u8;
    let mut fortran = Vec::new();
    for k in 0..c {
        for j in 0..b {
            (0..a).for_each(|i| fortran.push(at(i, j, k)));
        }
    }
    let matrix = read_npy(&array_file("|u1", true, "(2, 3, 4)", &fortran)).unwrap();
    assert_eq!((matrix.shape(), matrix.layout()), (Shape { samples: a, responses: b, lights: c }, Layout::Samples));
    for (row, values) in dense(&matrix).iter().enumerate() {
        let expected: Vec<f32> = (0..c).map(|k| at(row / b, row % b, k).into()).collect();
        assert_eq!(*values, expected);
    }
    let flat = read_npy(&array_file("|u1", true, "(6, 4)", &(0..24).collect::<Vec<u8>>())).unwrap();
    assert_eq!(dense(&flat)[1], [1.0, 7.0, 13.0, 19.0]);
}

#[test]
fn what_single_precision_cannot_hold_is_refused_with_row_and_column() {
    let doubles: Vec<u8> = [1.0, 2.0, 3.0, 4.0, 1e300, 6.0].iter().flat_map(|v: &f64| v.to_le_bytes()).collect();
    names(read_npy(&array_file("<f8", false, "(2, 3)", &doubles)), "row 1, column 1");
    names(read_npy(&array_file("<f8", true, "(2, 3)", &doubles)), "row 0, column 2");
    names(read_npy(&array_file("<f8", true, "(1, 2, 3)", &doubles)), "row 0, column 2");
    let nan: Vec<u8> = [0.0, f32::NAN].iter().flat_map(|v| v.to_le_bytes()).collect();
    names(read_npy(&array_file("<f4", false, "(2, 1)", &nan)), "row 1, column 0: NaN");
    names(
        mtx::read_from(&b"%%MatrixMarket matrix coordinate real general\n3 3 1\n2 3 1e39\n"[..], &BARE),
        "row 1, column 2",
    );
}

#[test]
fn unsorted_columns_are_sorted_and_duplicates_summed() {
    let matrix = read_npz(&compressed("csr", [3, 5], &[0, 3, 3, 5], &[3, 1, 3, 0, 0], &[1, 2, 3, 4, -4])).unwrap();
    assert_eq!(dense(&matrix), [[0.0, 2.0, 0.0, 4.0, 0.0], [0.0; 5], [0.0; 5]]);
    assert_eq!(matrix.non_zeros(), 2);
}

#[test]
fn columns_and_coordinates_make_the_same_matrix_as_rows() {
    // | 0 7 0 |
    // | 8 0 9 |
    let rows = read_npz(&compressed("csr", [2, 3], &[0, 1, 3], &[1, 0, 2], &[7, 8, 9])).unwrap();
    let columns = read_npz(&compressed("csc", [2, 3], &[0, 1, 2, 3], &[1, 0, 1], &[8, 7, 9])).unwrap();
    assert_eq!(rows, columns);
    let vector = |numbers: &[i64]| array_file("<i8", false, &format!("({},)", numbers.len()), &i64s(numbers));
    let mut entries = vec![
        // NumPy's unicode form of the same name.
        ("format.npy", array_file("<U3", false, "()", b"c\0\0\0o\0\0\0o\0\0\0")),
        ("shape.npy", vector(&[2, 3])),
        ("data.npy", vector(&[9, 7, 8])),
    ];
    let separate = [entries.clone(), vec![("row.npy", vector(&[1, 0, 1])), ("col.npy", vector(&[2, 1, 0]))]].concat();
    entries.push(("coords.npy", array_file("<i8", false, "(2, 3)", &i64s(&[1, 0, 1, 2, 1, 0]))));
    for entries in [entries, separate] {
        assert_eq!(read_npz(&archive(&entries, zip::CompressionMethod::Deflated)).unwrap(), rows);
    }
}

#[test]
fn a_broken_archive_names_the_entry() {
    names(read_npz(b"no archive"), "archive");
    names(read_npz(&compressed("bsr", [1, 1], &[0, 0], &[], &[])), "format.npy");
    names(read_npz(&compressed("csr", [2, 1], &[0, 0], &[], &[])), "indptr.npy");
    names(read_npz(&compressed("csr", [1, 1], &[0, 2], &[0], &[1])), "indptr.npy");
    names(read_npz(&compressed("csr", [1, 1], &[0, 1], &[-1], &[1])), "indices.npy");
    names(read_npz(&compressed("csr", [1, 1], &[0, 1], &[0], &[1, 2])), "data.npy");
    names(read_npz(&compressed("csr", [1, 1], &[0, 1], &[4], &[1])), "column 4");
    names(read_npz(&archive(&[("arr_0.npy", vec![])], zip::CompressionMethod::Stored)), "arr_0.npy");
}

#[test]
fn lights_are_vectors_or_channels() {
    let bytes: Vec<u8> = [1f32, 2.0, 3.0, 4.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let read = |shape: &str| npy::read_lights_from(Cursor::new(array_file("<f4", false, shape, &bytes)));
    assert_eq!(read("(4,)").unwrap(), array![[1.0], [2.0], [3.0], [4.0]]);
    assert_eq!(read("(2, 2)").unwrap(), array![[1.0, 2.0], [3.0, 4.0]]);
    names(read("(1, 2, 2)"), "3 axes");
    let folder = folder();
    let path = folder.path().join("y.npy");
    let output = Array2::from_shape_fn((3, 2), |(i, j)| (10 * i + j) as f32);
    // A transposed view is not contiguous row by row.
    for view in [output.view(), output.t()] {
        npy::write_array(&path, view).unwrap();
        assert_eq!(npy::read_lights(&path).unwrap(), view);
    }
}

#[test]
fn rows_written_one_by_one_must_all_come() {
    let (folder, shape) = (folder(), Shape { samples: 2, responses: 1, lights: 2 });
    let path = folder.path().join("T.npy");
    let mut writer = npy::RowWriter::create(&path, shape, Layout::Rows).unwrap();
    assert!(writer.push(&[1.0]).is_err());
    writer.push(&[1.0, 2.0]).unwrap();
    assert!(writer.finish().is_err());
    assert!(!path.exists());
}

#[test]
fn matrix_market_variants_expand_to_what_they_mean() {
    let read = |text: &str| mtx::read_from(text.as_bytes(), &BARE).map(|m| (dense(&m), m.is_sparse()));
    let sparse = |rows: &[[f32; 2]]| (rows.iter().map(|r| r.to_vec()).collect::<Vec<_>>(), true);
    let full = |rows: &[[f32; 2]]| (sparse(rows).0, false);
    let coordinate = |kind: &str, rest: &str| format!("%%MatrixMarket matrix coordinate {kind}\n% a comment\n\n{rest}");
    let cases = [
        (coordinate("real general", "2 2 3\n1 1 1.5\n2 1 -2e0\n1 1 0.5\n"), sparse(&[[2.0, 0.0], [-2.0, 0.0]])),
        (coordinate("integer symmetric", "2 2 2\n1 1 3\n2 1 4\n"), sparse(&[[3.0, 4.0], [4.0, 0.0]])),
        (coordinate("pattern general", "2 2 1\n2 2\n"), sparse(&[[0.0, 0.0], [0.0, 1.0]])),
        (coordinate("real skew-symmetric", "2 2 1\n2 1 5\n"), sparse(&[[0.0, -5.0], [5.0, 0.0]])),
        ("%%matrixmarket MATRIX array real general\n2 2\n1\n2\n3\n4\n".into(), full(&[[1.0, 3.0], [2.0, 4.0]])),
        ("%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n3\n".into(), full(&[[1.0, 2.0], [2.0, 3.0]])),
        ("%%MatrixMarket matrix array real skew-symmetric\n2 2\n7\n".into(), full(&[[0.0, -7.0], [7.0, 0.0]])),
    ];
    for (text, expected) in cases {
        assert_eq!(read(&text).unwrap(), expected, "{text}");
    }
}

#[test]
fn a_broken_matrix_market_file_names_the_line() {
    let read = |text: &str| mtx::read_from(text.as_bytes(), &BARE);
    names(read(""), "line 1");
    names(read("%%MatrixMarket matrix coordinate complex general\n"), "line 1");
    let head = "%%MatrixMarket matrix coordinate real general\n";
    for (rest, line) in [
        ("2 2\n", "line 2"),
        ("2 2 1\n3 1 1\n", "line 3"),
        ("2 2 1\n0 1 1\n", "line 3"),
        ("2 2 1\n1 1 x\n", "line 3"),
        ("2 2 1\n1 1\n", "line 3"),
        ("2 2 1\n1 1 1 1\n", "line 3"),
        ("2 2 2\n1 1 1\n", "line 4"),
        ("2 2 1\n1 1 1\n2 2 1\n", "line 4"),
        ("2 2 1\n1 1 nan\n", "row 0, column 0"),
    ] {
        names(read(&format!("{head}{rest}")), line);
    }
}

#[test]
fn an_unknown_extension_lists_the_known_ones() {
    names(matrix::read("T.csv", &BARE), ".npz (scipy.sparse), .npy (NumPy), .mtx (MatrixMarket)");
    names(matrix::read("/nonexistent/T.npz", &BARE), "/nonexistent/T.npz");
}
