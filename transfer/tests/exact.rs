//! What `csr`, `dense`, `compact`, `runs` and `f16` promise, on matrices of every kind of value.

use ndarray::{Array2, ArrayView2, ShapeBuilder};
use proptest::prelude::*;
use prt_transfer::compact::{Compact, EncodedCompact};
use prt_transfer::csr::{Csr, EncodedCsr};
use prt_transfer::dense::{Dense, EncodedDense};
use prt_transfer::f16::{EncodedF16, F16};
use prt_transfer::runs::{EncodedRuns, Runs};
use prt_transfer::{Codec, Encoded, LightBasis, Quiet, Restore, Section, Shape, Sink, Source, TransferMatrix};

/// Encodes, writes, reads back.
fn through<C: Codec>(matrix: &TransferMatrix) -> (Box<dyn Encoded>, Vec<Section>)
where
    C::Params: Default,
{
    let encoded = C::new(Default::default()).unwrap().encode(matrix, &Quiet).unwrap();
    let sections = sections(&encoded);
    (Box::new(read::<C::Encoded>(matrix.shape(), sections.clone()).unwrap()), sections)
}

fn sections(encoded: &dyn Encoded) -> Vec<Section> {
    let mut sink = Sink::new();
    encoded.write(&mut sink);
    sink.into_sections()
}

fn read<E: Restore>(shape: Shape, sections: Vec<Section>) -> prt_transfer::Result<E> {
    let mut source = Source::new(sections)?;
    let encoded = E::read(shape, &mut source)?;
    source.finish()?;
    Ok(encoded)
}

type Through = fn(&TransferMatrix) -> (Box<dyn Encoded>, Vec<Section>);
const EXACT: [(&str, Through); 4] =
    [("csr", through::<Csr>), ("dense", through::<Dense>), ("compact", through::<Compact>), ("runs", through::<Runs>)];
const ALL: [(&str, Through); 5] = [EXACT[0], EXACT[1], EXACT[2], EXACT[3], ("f16", through::<F16>)];

/// Values of one kind: each calls for another form.
fn value() -> impl Strategy<Value = BoxedStrategy<f32>> {
    prop_oneof![
        Just((0u8..=4).prop_map(|k| f32::from(k) / 4.0).boxed()),
        Just((-100i32..100).prop_map(|k| k as f32 * 2f32.powi(-140)).boxed()),
        Just(any::<u16>().prop_map(f32::from).boxed()),
        Just(any::<i16>().prop_map(|k| f32::from(k) * 1024.0).boxed()),
        Just(prop::sample::select(vec![0.1f32, 1e-40, -3.3e38, 1.0, -1.0, -0.0, 7.0]).boxed()),
        Just((0u32..700).prop_map(|k| (k as f32).sin()).boxed()),
        Just(
            any::<u16>()
                .prop_map(|b| half::f16::from_bits(b).to_f32())
                .prop_filter("finite", |v| v.is_finite())
                .boxed()
        ),
        Just(any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |v| v.is_finite()).boxed()),
        Just((-1f32..1.0).boxed()),
    ]
}

fn matrix_of(values: impl Strategy<Value = BoxedStrategy<f32>>) -> impl Strategy<Value = TransferMatrix> {
    let lights = prop_oneof![0usize..3, 3usize..60, Just(256), Just(257), Just(300)];
    (0usize..150, lights, values, 0.0f64..1.0, any::<bool>()).prop_flat_map(|(rows, lights, value, zeros, sparse)| {
        let rows = if lights > 60 { rows / 8 } else { rows };
        let element = prop_oneof![
            (1000.0 * zeros) as u32 => Just(0f32),
            (1000.0 * (1.0 - zeros)) as u32 + 1 => value
        ];
        prop::collection::vec(element, rows * lights).prop_map(move |values| matrix(values, rows, lights, sparse))
    })
}

fn matrix(values: Vec<f32>, rows: usize, lights: usize, sparse: bool) -> TransferMatrix {
    let basis = LightBasis::Plain { lights };
    if !sparse {
        return TransferMatrix::from_dense(values, rows, 1, basis).unwrap();
    }
    let (mut offsets, mut columns, mut kept) = (vec![0], Vec::new(), Vec::new());
    for row in 0..rows {
        for (k, &v) in values[row * lights..(row + 1) * lights].iter().enumerate().filter(|(_, v)| **v != 0.0) {
            columns.push(k as u32);
            kept.push(v);
        }
        offsets.push(kept.len());
    }
    TransferMatrix::from_csr(offsets, columns, kept, 1, basis).unwrap()
}

fn any_light(lights: usize, channels: usize) -> Array2<f32> {
    Array2::from_shape_fn((lights, channels), |(k, c)| ((k * 31 + c * 17) % 97) as f32 / 48.0 - 0.7)
}

/// Decoded rows times light in f64, and the sum of magnitudes that rounding is measured against.
fn reference(encoded: &dyn Encoded, lights: ArrayView2<f32>) -> (Array2<f64>, Array2<f64>) {
    let shape = encoded.shape();
    let size = (shape.rows(), lights.ncols());
    let (mut sums, mut sizes, mut row) = (Array2::zeros(size), Array2::zeros(size), vec![0f32; shape.lights]);
    for r in 0..shape.rows() {
        encoded.row_into(r, &mut row);
        for (k, &v) in row.iter().enumerate() {
            for c in 0..lights.ncols() {
                let term = f64::from(v) * f64::from(lights[[k, c]]);
                sums[[r, c]] += term;
                sizes[[r, c]] += term.abs();
            }
        }
    }
    (sums, sizes)
}

fn assert_relights(name: &str, encoded: &dyn Encoded, channels: usize) {
    let shape = encoded.shape();
    let lights = any_light(shape.lights, channels);
    let (sums, sizes) = reference(encoded, lights.view());
    let size = (shape.rows(), channels);
    for mut out in [Array2::from_elem(size, 7f32), Array2::from_elem(size.f(), 7f32)] {
        encoded.apply_into(lights.view(), out.view_mut()).unwrap();
        for (at, &y) in out.indexed_iter() {
            // Half an ulp for each addition, and denormals where products vanish.
            let bound = 4e-7 * (1.0 + shape.lights as f64 / 8.0) * sizes[at] + 1e-40;
            let (y, sum) = (f64::from(y), sums[at]);
            assert!((y - sum).abs() <= bound, "{name}, {channels} channels, {at:?}: {y} for {sum}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn exact_codecs_reconstruct_every_finite_matrix_bit_for_bit(matrix in matrix_of(value())) {
        let (mut row, mut expected) = (vec![0f32; matrix.lights()], vec![0f32; matrix.lights()]);
        for (name, through) in EXACT {
            let (encoded, bytes) = through(&matrix);
            prop_assert_eq!(&sections(&*encoded), &bytes, "{} reads what it writes", name);
            for r in 0..matrix.rows() {
                encoded.row_into(r, &mut row);
                matrix.gather(r, &mut expected);
                // Equal floats are equal bits, but for the sign of zero.
                prop_assert_eq!(&row, &expected, "{}, row {}", name, r);
            }
        }
    }

    #[test]
    fn relighting_is_decoded_rows_times_light(matrix in matrix_of(Just((-1f32..1.0).boxed())), channels in 0usize..=6) {
        for (name, through) in ALL {
            assert_relights(name, &*through(&matrix).0, channels);
        }
    }

    #[test]
    fn relighting_holds_in_every_form_of_values(matrix in matrix_of(value())) {
        // Large values overflow f32 when they are added: take them as they are only where sums stay finite.
        let largest = (0..matrix.rows()).flat_map(|r| matrix.row(r).non_zeros().map(|e| e.1.abs()).collect::<Vec<_>>());
        prop_assume!(largest.fold(0.0, f32::max) < 1e35);
        for (name, through) in ALL {
            assert_relights(name, &*through(&matrix).0, 1);
            assert_relights(name, &*through(&matrix).0, 3);
        }
    }

    #[test]
    fn flops_are_the_closed_formulas(matrix in matrix_of(value())) {
        let (cells, nnz) = ((matrix.rows() * matrix.lights()) as u64, matrix.non_zeros() as u64);
        let ones: u64 = (0..matrix.rows()).map(|r| matrix.row(r).non_zeros().filter(|e| e.1.abs() == 1.0).count() as u64).sum();
        let light = vec![1.0; matrix.lights()];
        // `runs` has a test of its own.
        for (name, through) in EXACT.into_iter().filter(|e| e.0 != "runs") {
            let (encoded, bytes) = through(&matrix);
            let flops = encoded.flops(&light);
            let full = name == "dense" || (name == "compact" && bytes.iter().all(|s| s.name != "index/columns"));
            let products = if full { cells } else { nnz };
            prop_assert_eq!((flops.multiplications, flops.additions), (products, products), "{}", name);
            prop_assert_eq!(flops.by_one, ones, "{}", name);
        }
        prop_assert_eq!(through::<F16>(&matrix).0.flops(&light).total(), 2 * if matrix.is_sparse() { nnz } else { cells });
    }

    #[test]
    fn compact_is_never_larger_than_dense_nor_much_larger_than_csr(matrix in matrix_of(value())) {
        let bytes = |through: Through| through(&matrix).1.iter().map(|s| s.bytes.len()).sum::<usize>();
        let (compact, csr, dense) = (bytes(through::<Compact>), bytes(through::<Csr>), bytes(through::<Dense>));
        // The header has 16 bytes.
        prop_assert!(compact <= csr + 16 && compact <= dense + 16, "{compact}, csr {csr}, dense {dense}");
    }

    #[test]
    fn halves_keep_eleven_bits_of_all_but_the_smallest_values(matrix in matrix_of(value())) {
        let (encoded, _) = through::<F16>(&matrix);
        let (mut row, mut expected) = (vec![0f32; matrix.lights()], vec![0f32; matrix.lights()]);
        let values = (0..matrix.rows()).flat_map(|r| matrix.row(r).non_zeros().collect::<Vec<_>>());
        let largest = values.fold(0f64, |m, (_, v)| m.max(f64::from(v.abs())));
        for r in 0..matrix.rows() {
            encoded.row_into(r, &mut row);
            matrix.gather(r, &mut expected);
            for (&half, &exact) in row.iter().zip(&expected) {
                let (error, size) = (f64::from(half) - f64::from(exact), f64::from(exact.abs()));
                let bound = (2f64.powi(-11) * size).max(if size < 2f64.powi(-28) * largest { 2f64.powi(-39) * largest } else { 0.0 });
                prop_assert!(error.abs() <= bound, "{half} for {exact}, largest {largest}");
            }
        }
    }

    #[test]
    fn damaged_sections_are_refused_or_can_be_used(
        matrix in matrix_of(value()), codec in 0usize..5, section in any::<prop::sample::Index>(),
        place in any::<prop::sample::Index>(), bit in 0u8..8, cut in any::<bool>(),
    ) {
        let (_, mut sections) = ALL[codec].1(&matrix);
        let bytes = &mut section.get_mut(&mut sections).bytes;
        prop_assume!(!bytes.is_empty());
        match cut {
            true => bytes.truncate(place.index(bytes.len())),
            false => *place.get_mut(bytes) ^= 1 << bit,
        }
        let shape = matrix.shape();
        let accepted: Option<Box<dyn Encoded>> = match codec {
            0 => read::<EncodedCsr>(shape, sections).ok().map(|e| Box::new(e) as _),
            1 => read::<EncodedDense>(shape, sections).ok().map(|e| Box::new(e) as _),
            2 => read::<EncodedCompact>(shape, sections).ok().map(|e| Box::new(e) as _),
            3 => read::<EncodedRuns>(shape, sections).ok().map(|e| Box::new(e) as _),
            _ => read::<EncodedF16>(shape, sections).ok().map(|e| Box::new(e) as _),
        };
        prop_assert!(accepted.is_none() || !cut, "a section cut short was accepted");
        if let Some(encoded) = accepted {
            let (lights, mut out) = (any_light(shape.lights, 3), Array2::zeros((shape.rows(), 3)));
            encoded.apply_into(lights.view(), out.view_mut()).unwrap();
            encoded.flops(&vec![1.0; shape.lights]);
            let mut row = vec![0f32; shape.lights];
            (0..shape.rows()).for_each(|r| encoded.row_into(r, &mut row));
            prop_assert!(row.iter().all(|v| v.is_finite()));
        }
    }
}

/// A column of every value, so that a value's width is what the matrix costs beyond its index.
fn value_bytes(values: Vec<f32>) -> usize {
    let rows = values.len();
    let (_, sections) = through::<Compact>(&matrix(values, rows, 1, false));
    sections.iter().filter(|s| s.name.starts_with("weights/")).map(|s| s.bytes.len()).sum()
}

#[test]
fn compact_takes_the_narrowest_exact_form() {
    let of = |f: fn(usize) -> f32| value_bytes((0..1000).map(f).collect());
    assert_eq!(of(|i| (1 + i % 4) as f32 / 4.0), 1000, "multiples of 1/4");
    assert_eq!(of(|i| (i % 400) as f32 - 200.5), 2000, "400 odd multiples of 1/2");
    assert_eq!(of(|i| (i % 100) as f32 * -1e6 * 0.5), 1000 + 400, "a hundred values far apart");
    assert_eq!(of(|i| (1 + i) as f32 * 2f32.powi(-149)), 2000, "denormals on a grid");
    assert_eq!(of(|i| ((1 + i % 7) as f32).sqrt()), 1000 + 28, "seven values in a table");
    assert_eq!(of(|i| (1024 + i) as f32 * if i % 2 == 0 { 1024.0 } else { 1.0 / 1024.0 }), 2000, "halves");
    assert_eq!(of(|i| ((1 + i) as f32).sqrt()), 4000, "as they are");
    let many = value_bytes((0..20_000).map(|i| ((1 + i % 300) as f32).sqrt()).collect());
    assert_eq!(many, 40_000 + 1200, "300 values in a table");
}

#[test]
fn columns_take_four_bytes_only_beyond_65536_lights() {
    for (lights, width) in [(256, 1), (257, 2), (65_536, 2), (65_537, 4)] {
        let columns = vec![0, lights as u32 - 1];
        let matrix =
            TransferMatrix::from_csr(vec![0, 2], columns, vec![1.0; 2], 1, LightBasis::Plain { lights }).unwrap();
        for (through, name) in [(through::<Compact> as Through, "compact"), (through::<F16>, "f16")] {
            let (encoded, sections) = through(&matrix);
            let index = sections.iter().find(|s| s.name == "index/columns").unwrap();
            assert_eq!(index.bytes.len(), 2 * width, "{name}, {lights} lights");
            assert_relights(name, &*encoded, 1);
        }
    }
}

#[test]
fn threads_do_not_change_the_result() {
    let values = (0..900 * 70).map(|i| if i % 3 == 0 { 0.0 } else { ((i * 7919) % 1000) as f32 / 999.0 }).collect();
    let matrix = matrix(values, 900, 70, true);
    let lights = any_light(70, 3);
    for (name, through) in ALL {
        let (encoded, _) = through(&matrix);
        let results = [1, 2].map(|threads| {
            let mut out = Array2::zeros((900, 3));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| encoded.apply_into(lights.view(), out.view_mut())).unwrap();
            out
        });
        assert_eq!(results[0], results[1], "{name}");
    }
}
