//! What the encoded form promises, for every width, even and uneven clusters, and damaged sections.

use ndarray::Array2;
use proptest::prelude::*;
use prt_cpca::{Cluster, EncodedCpca, Model, Width};
use prt_transfer::sections::Section;
use prt_transfer::{Encoded, Flops, Restore, Result, Shape, Sink, Source};

const WIDTHS: [Width; 3] = [Width::F32, Width::F16, Width::I16];

/// Numbers that look drawn and are the same in every run.
struct Draw(u64);

impl Draw {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }
    fn below(&mut self, end: usize) -> usize {
        self.bits() as usize % end
    }
    fn number(&mut self) -> f32 {
        self.bits() as f32 / (1u64 << 30) as f32 - 1.0
    }
    fn numbers(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| self.number()).collect()
    }
}

/// A model of clusters with so many components each.
fn model(shape: [usize; 3], components: &[usize], seed: u64) -> Model {
    let mut draw = Draw(seed);
    let shape = Shape::new(shape[0], shape[1], shape[2]).unwrap();
    let n = shape.responses * shape.lights;
    let mut cluster = |&k: &usize| Cluster { mean: draw.numbers(n), components: draw.numbers(k * n) };
    let clusters: Vec<Cluster> = components.iter().map(&mut cluster).collect();
    let members: Vec<u32> = (0..shape.samples).map(|_| draw.below(components.len()) as u32).collect();
    let weights = members.iter().flat_map(|&k| draw.numbers(if n == 0 { 0 } else { components[k as usize] })).collect();
    Model { shape, clusters, members, weights }
}

fn models() -> Vec<Model> {
    let mut models = Vec::new();
    for (seed, responses) in [1, 2, 3, 4, 5, 7, 9, 24, 25].into_iter().enumerate() {
        models.push(model([200, responses, 10], &[3; 5], seed as u64));
        models.push(model([131, responses, 17], &[0, 4, 9, 1, 4, 8, 2], 100 + seed as u64));
    }
    models.extend([
        model([1, 1, 1], &[0], 1),
        model([1, 1, 1], &[1], 1),
        model([70, 1, 40], &[17], 2),
        model([64, 2, 3], &[0, 0], 3),
        model([128, 1, 8], &[2, 3], 4),
        model([0, 3, 4], &[], 5),
        model([0, 3, 4], &[2], 6),
        model([5, 2, 0], &[0, 0], 7),
        model([3000, 1, 5], &[2, 0, 1], 8),
    ]);
    models
}

fn each(mut check: impl FnMut(&Model, &EncodedCpca)) {
    for model in models() {
        for weights in WIDTHS {
            for representatives in WIDTHS {
                check(&model, &EncodedCpca::store(&model, weights, representatives));
            }
        }
    }
}

fn sections(encoded: &EncodedCpca) -> Vec<Section> {
    let mut sink = Sink::new();
    encoded.write(&mut sink);
    sink.into_sections()
}

fn read(shape: Shape, sections: Vec<Section>) -> Result<EncodedCpca> {
    let mut source = Source::new(sections)?;
    let encoded = EncodedCpca::read(shape, &mut source)?;
    source.finish()?;
    Ok(encoded)
}

/// The rows of a model, and the sum of the magnitudes of what each element is made of.
fn rows(model: &Model) -> Vec<[f64; 2]> {
    let (n, mut weights) = (model.dimension(), model.weights.iter());
    let row = |&k: &u32| {
        let cluster = &model.clusters[k as usize];
        let mut row: Vec<[f64; 2]> = cluster.mean.iter().map(|&x| [x.into(), x.abs().into()]).collect();
        for component in cluster.components.chunks(n.max(1)) {
            let w = f64::from(*weights.next().unwrap());
            for (sum, &x) in row.iter_mut().zip(component) {
                let term = w * f64::from(x);
                *sum = [sum[0] + term, sum[1] + term.abs()];
            }
        }
        row
    };
    model.members.iter().flat_map(row).collect()
}

#[test]
fn a_row_is_that_of_the_model_that_is_stored() {
    each(|_, encoded| {
        let (decoded, shape) = (encoded.model(), encoded.shape());
        decoded.check().unwrap();
        let mut out = vec![9.0; shape.lights];
        for (row, expected) in rows(&decoded).chunks(shape.lights.max(1)).enumerate() {
            encoded.row_into(row, &mut out);
            for (y, [sum, size]) in out.iter().zip(expected) {
                assert!((f64::from(*y) - sum).abs() <= 1e-7 * size, "{y} for {sum}");
            }
        }
    });
}

#[test]
fn relighting_is_decoded_rows_times_light_for_every_width_and_any_channels() {
    each(|_, encoded| {
        let (elements, shape) = (rows(&encoded.model()), encoded.shape());
        for channels in [0, 1, 2, 3, 5] {
            let mut draw = Draw(channels as u64);
            let lights = Array2::from_shape_simple_fn((shape.lights, channels), || draw.number());
            let mut out = Array2::from_elem((shape.rows(), channels), 9.0);
            encoded.apply_into(lights.view(), out.view_mut()).unwrap();
            // An output with gaps takes the same values.
            let mut gaps = Array2::from_elem((shape.rows(), 2 * channels), 9.0);
            let with_gaps = gaps.slice_mut(ndarray::s![.., ..;2]);
            encoded.apply_into(lights.view(), with_gaps).unwrap();
            assert_eq!(gaps.slice(ndarray::s![.., ..;2]), out);
            for ((row, c), &y) in out.indexed_iter() {
                let (mut sum, mut size) = (0.0, 0.0);
                for (k, [x, magnitude]) in elements[row * shape.lights..][..shape.lights].iter().enumerate() {
                    let l = f64::from(lights[[k, c]]);
                    (sum, size) = (sum + x * l, size + magnitude * l.abs());
                }
                assert!((f64::from(y) - sum).abs() <= 2e-6 * size, "{shape:?} row {row}: {y} for {sum}");
            }
        }
    });
}

#[test]
fn operations_are_those_of_the_formula() {
    each(|model, encoded| {
        let (shape, n) = (model.shape, model.dimension() as u64);
        let components: Vec<u64> = (0..model.clusters.len()).map(|k| model.components(k) as u64).collect();
        let (all, vectors) = (components.iter().sum::<u64>(), components.iter().map(|c| 1 + c).sum::<u64>());
        let of_samples: u64 = model.members.iter().map(|&k| components[k as usize]).sum();
        let responses = shape.responses as u64;
        let products = vectors * n + of_samples * responses;
        let [weights, representatives] = encoded.widths().map(|width| width != Width::F32);
        let scalings = match (representatives, weights) {
            (true, both) => vectors * responses + if both { all } else { 0 },
            (false, true) => all * responses,
            (false, false) => 0,
        };
        let Flops { multiplications, additions, .. } = encoded.flops(&vec![0.5; shape.lights]);
        assert_eq!([multiplications, additions], [products + scalings, products], "{shape:?} {:?}", encoded.widths());
    });
    // Factors of 1 and -1 are known to be: a mean of ones, weights of 1 and -1 in f32.
    let mean = Cluster { mean: vec![1.0; 6], components: vec![0.5; 6] };
    let shape = Shape::new(4, 2, 3).unwrap();
    let model = Model { shape, clusters: vec![mean], members: vec![0; 4], weights: vec![1.0, -1.0, 0.5, 1.0] };
    let flops = EncodedCpca::store(&model, Width::F32, Width::F32).flops(&[1.0; 3]);
    assert_eq!([flops.multiplications, flops.by_one], [12 + 8, 6 + 6]);
    // Of halves those are that have the power of two at or below the largest magnitude of their vector; the mean's scale is 1, too.
    let clusters = vec![Cluster { mean: vec![1.5, 1.0, -1.0, 0.5, 0.0, 1.0], components: vec![-0.25; 6] }];
    let halves = Model { clusters, ..model };
    let flops = EncodedCpca::store(&halves, Width::F32, Width::F16).flops(&[1.0; 3]);
    assert_eq!([flops.multiplications, flops.by_one], [12 + 8 + 4, 3 + 6 + 2 + 6]);
    // Of whole numbers those are that half the range is: 2^14 steps of 2^-14.
    let clusters = vec![Cluster { mean: vec![32767.0, 16384.0, -16384.0, 1.0, 2.0, -1.0], components: vec![0.0; 6] }];
    let codes = Model { clusters, ..halves };
    assert_eq!(EncodedCpca::store(&codes, Width::F32, Width::I16).flops(&[1.0; 3]).by_one, 2 + 6);
}

#[test]
fn what_is_read_is_what_was_written_and_writes_the_same_bytes() {
    each(|_, encoded| {
        let bytes = sections(encoded);
        let again = read(encoded.shape(), bytes.clone()).unwrap();
        assert_eq!(&again, encoded);
        assert_eq!(sections(&again), bytes);
        let names: Vec<u32> = (0..encoded.clusters() as u32).map(|k| k / 2).collect();
        let named = again.with_superclusters(names.clone()).unwrap();
        let read = read(named.shape(), sections(&named)).unwrap();
        assert_eq!(read.superclusters(), Some(&names[..]));
        assert!(read.with_superclusters(vec![0; names.len() + 1]).is_err());
    });
}

#[test]
fn single_precision_stores_the_model_itself() {
    for model in models() {
        assert_eq!(EncodedCpca::store(&model, Width::F32, Width::F32).model(), model);
    }
}

#[test]
fn sections_decode_as_the_documentation_says() {
    // By hand: two clusters with 1 and 0 components of 1 x 2 numbers, three samples.
    let clusters = vec![
        Cluster { mean: vec![1.0, -2.0], components: vec![0.25, 0.5] },
        Cluster { mean: vec![0.0; 2], components: vec![] },
    ];
    let shape = Shape::new(3, 1, 2).unwrap();
    let model = Model { shape, clusters, members: vec![0, 1, 0], weights: vec![3.0, -1.5] };
    let bytes = sections(&EncodedCpca::store(&model, Width::I16, Width::F16));
    let bytes_of = |name: &str| bytes.iter().find(|s| s.name == name).map(|s| &s.bytes[..]).unwrap();
    let words = |numbers: &[u32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    assert_eq!(bytes_of("header/layout"), words(&[2, 1, 2]));
    assert_eq!(bytes_of("index/components"), words(&[1, 0]));
    assert_eq!(bytes_of("index/members"), [0b010]);
    // 1 and -2 are 2^13 and -2^14 times 2^-13; halves of them have the exponents 13 and 14.
    let halves: Vec<u16> =
        bytes_of("basis/representatives").as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b)).collect();
    assert_eq!(halves[..2], [(15 + 13) << 10, 1 << 15 | (15 + 14) << 10]);
    let scale = |bytes: &[u8], i: usize| f32::from_le_bytes(bytes[4 * i..4 * i + 4].try_into().unwrap());
    assert_eq!(scale(bytes_of("basis/scales"), 0), 2f32.powi(-13));
    // 3/32767 with nine bits, rounded up: 384.01 units of 2^-22 become 385.
    assert_eq!(scale(bytes_of("weights/scales"), 0), 385.0 * 2f32.powi(-22));
    assert_eq!(bytes_of("weights/scales").len(), 4);
    let codes: Vec<i16> =
        bytes_of("weights/weights").as_chunks::<2>().0.iter().map(|b| i16::from_le_bytes(*b)).collect();
    let step = 385.0 / 2f64.powi(22);
    assert_eq!(codes, [(3.0 / step).round() as i16, (-1.5 / step).round() as i16]);
}

#[test]
fn sixteen_bits_keep_vectors_of_any_size() {
    // Means near the ends of f32, weights down to denormals, a component of zeros.
    for size in [3.4e38f32, 1e38, 1.0, 1e-38, 1e-42] {
        let clusters = vec![Cluster { mean: vec![size, -size / 3.0], components: vec![0.6, -0.8, 0.0, 0.0] }];
        let weights = vec![size / 2.0, 1.0, -size / 7.0, 0.0];
        let shape = Shape::new(2, 1, 2).unwrap();
        let model = Model { shape, clusters, members: vec![0; 2], weights };
        for width in [Width::F16, Width::I16] {
            let decoded = EncodedCpca::store(&model, width, width).model();
            decoded.check().unwrap();
            let close = |a: &[f32], b: &[f32], largest: f32| {
                // The smallest number of f32 beside.
                a.iter().zip(b).all(|(a, b)| (a - b).abs() <= largest * 5e-4 + f32::from_bits(1))
            };
            assert!(close(&decoded.clusters[0].mean, &model.clusters[0].mean, size), "{width:?} {size:e}");
            assert!(close(&decoded.weights, &model.weights, size.max(1.0)), "{width:?} {size:e}");
            assert_eq!(decoded.clusters[0].components[2..], [0.0; 2]);
        }
    }
}

#[test]
fn a_light_near_the_end_of_f32_does_not_overflow_before_the_product_does() {
    let clusters = vec![Cluster { mean: vec![1e-6, 2e-6], components: vec![3e-6, 1e-6] }];
    let shape = Shape::new(1, 1, 2).unwrap();
    let model = Model { shape, clusters, members: vec![0], weights: vec![0.5] };
    for width in WIDTHS {
        let encoded = EncodedCpca::store(&model, width, width);
        let (light, mut out) = (Array2::from_elem((2, 1), 5e37), Array2::zeros((1, 1)));
        encoded.apply_into(light.view(), out.view_mut()).unwrap();
        assert!((out[[0, 0]] / (5e-6 * 5e37) - 1.0f32).abs() < 1e-3, "{width:?}: {}", out[[0, 0]]);
    }
}

#[test]
fn one_and_two_threads_relight_alike() {
    let model = model([5000, 3, 11], &[4, 0, 2], 21);
    let encoded = EncodedCpca::store(&model, Width::I16, Width::F16);
    let light = Array2::from_elem((11, 3), 0.7);
    let relit = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut out = Array2::zeros((15_000, 3));
        pool.install(|| encoded.apply_into(light.view(), out.view_mut())).unwrap();
        out
    };
    assert_eq!(relit(1), relit(2));
}

/// Uses everything of what was accepted.
fn use_all(encoded: &EncodedCpca) {
    let shape = encoded.shape();
    let mut out = Array2::zeros((shape.rows(), 3));
    encoded.apply_into(Array2::ones((shape.lights, 3)).view(), out.view_mut()).unwrap();
    let mut row = vec![0.0; shape.lights];
    (0..shape.rows()).for_each(|r| {
        encoded.row_into(r, &mut row);
        assert!(row.iter().all(|y| y.is_finite()));
    });
    encoded.flops(&vec![1.0; shape.lights]);
    encoded.model().check().unwrap();
    encoded.hold(&mut Sink::new());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn damaged_sections_are_refused_or_harmless(
        uneven in any::<bool>(), widths in [0usize..3, 0usize..3], section in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(), change in 0..6, byte in any::<u8>(),
        resized in [0usize..70, 1usize..4, 0usize..6],
    ) {
        let components: &[usize] = if uneven { &[2, 0, 3] } else { &[2, 2] };
        let model = model([67, 2, 3], components, 5);
        let stored = EncodedCpca::store(&model, WIDTHS[widths[0]], WIDTHS[widths[1]]);
        let mut damaged = sections(&stored);
        let chosen = section.index(damaged.len());
        let bytes = &mut damaged[chosen].bytes;
        let shape = match change {
            0 => { bytes.truncate(at.index(bytes.len() + 1)); model.shape }
            1 => { bytes.extend([byte; 8]); model.shape }
            2 => { damaged.remove(chosen); model.shape }
            3 => Shape::new(resized[0], resized[1], resized[2]).unwrap(),
            _ => { let at = at.index(bytes.len()); bytes[at] ^= byte; model.shape }
        };
        if let Ok(accepted) = read(shape, damaged) {
            use_all(&accepted);
        }
    }
}

#[test]
fn a_header_cannot_claim_what_its_sections_do_not_hold() {
    let stored = EncodedCpca::store(&model([3, 1, 2], &[1], 9), Width::F32, Width::F32);
    let put = |name: &str, numbers: &[u32], shape: Shape| {
        let mut changed = sections(&stored);
        let bytes = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        changed.retain(|s| s.name != name);
        changed.push(Section { name: name.into(), bytes });
        read(shape, changed).err().map(|e| e.to_string())
    };
    let (shape, huge) = (stored.shape(), Shape::new(1 << 40, 1, 2).unwrap());
    for clusters in [0, 4, u32::MAX] {
        assert!(put("header/layout", &[clusters, 0, 0], shape).unwrap().contains("clusters"));
    }
    assert!(put("header/layout", &[1, 3, 0], shape).unwrap().contains("widths"));
    assert!(put("index/components", &[u32::MAX], shape).unwrap().contains("components"));
    assert!(put("index/components", &[1, 1], shape).unwrap().contains("1 number"));
    assert!(put("header/layout", &[1 << 31, 0, 0], huge).is_some());
    assert!(put("index/components", &[1], huge).unwrap().contains("weights"));
}

#[test]
fn models_that_do_not_fit_are_refused_by_part() {
    let valid = model([5, 1, 3], &[1, 2], 1);
    valid.check().unwrap();
    let broken = |change: &dyn Fn(&mut Model)| {
        let mut model = valid.clone();
        change(&mut model);
        model.check().unwrap_err().to_string()
    };
    assert!(broken(&|m| m.clusters.clear()).contains("clusters"));
    assert!(broken(&|m| m.clusters[1].mean.truncate(2)).contains("mean of cluster 1"));
    assert!(broken(&|m| m.clusters[1].components.truncate(5)).contains("components of cluster 1"));
    assert!(broken(&|m| m.clusters[0].components = vec![0.0; 12]).contains("components of cluster 0"));
    assert!(broken(&|m| m.members[2] = 2).contains("sample 2"));
    assert!(broken(&|m| m.weights.push(0.0)).contains("weights"));
    assert!(broken(&|m| m.weights[0] = f32::NAN).contains("finite"));
}
