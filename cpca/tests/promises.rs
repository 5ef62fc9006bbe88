//! The promises of clustered principal components: errors that are the tails of spectra, modes that never do worse than the
//! simpler ones, bounds that hold after decoding, exact smaller models of degenerate matrices.

use proptest::prelude::*;
use prt_cpca::{Cpca, Pca, Vq};
use prt_transfer::linalg::singular;
use prt_transfer::transform::Identity;
use prt_transfer::{Compressed, Error, LightBasis, Metric, Quiet, Registry, TransferMatrix};

fn registry() -> Registry {
    Registry::new().transform::<Identity>().codec::<Vq>().codec::<Pca>().codec::<Cpca>()
}

fn encode(label: &str, matrix: &TransferMatrix) -> Result<Compressed, Error> {
    registry().method(&label.parse()?)?.encode(matrix, &Quiet)
}

fn dense(values: Vec<f32>, samples: usize, responses: usize) -> TransferMatrix {
    let lights = values.len() / (samples * responses).max(1);
    TransferMatrix::from_dense(values, samples * responses, responses, LightBasis::Plain { lights }).unwrap()
}

fn decode(compressed: &Compressed) -> Vec<f32> {
    let shape = compressed.shape();
    let mut values = vec![f32::NAN; shape.rows() * shape.lights];
    (0..shape.rows()).for_each(|row| compressed.row_into(row, &mut values[row * shape.lights..][..shape.lights]));
    values
}

fn square(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v).powi(2)).sum()
}

fn difference(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum()
}

/// Σ(T-T̃)²/ΣT² of what is decoded.
fn error(label: &str, matrix: &TransferMatrix) -> f64 {
    let exact = matrix.as_dense().unwrap();
    difference(exact, &decode(&encode(label, matrix).unwrap())) / square(exact)
}

fn resident(label: &str, matrix: &TransferMatrix) -> usize {
    encode(label, matrix).unwrap().resident_bytes()
}

/// Samples on curved sheets of different dimensions, with noise: what radiance transfer looks like from far away.
fn sheets(samples: usize, n: usize, noise: f64) -> TransferMatrix {
    let value = |i: usize| {
        let (p, k) = (i / n, (i % n) as f64);
        let (sheet, u, v) = (p % 3, (p as f64 * 0.754_877).fract(), (p as f64 * 0.569_840).fract());
        let bend = match sheet {
            0 => (3.0 * u + 0.11 * k).sin(),
            1 => (2.0 * u + 0.05 * k).cos() * (1.0 + v),
            _ => (0.3 * k * (u - 0.5)).sin() + v * (0.2 * k + u).cos(),
        };
        let random = ((i as f64 * 12.9898).sin() * 43_758.545_3).fract();
        (bend + noise * random) as f32
    };
    dense((0..samples * n).map(value).collect(), samples, 1)
}

#[test]
fn the_error_of_pca_is_the_tail_of_the_spectrum() {
    let matrix = sheets(120, 30, 0.01);
    let values = matrix.as_dense().unwrap();
    // A second way: singular values of the centred matrix.
    let rows = ndarray::ArrayView2::from_shape((120, 30), values).unwrap().mapv(f64::from);
    let centred = &rows - &rows.mean_axis(ndarray::Axis(0)).unwrap();
    let squares: Vec<f64> = singular(centred.view()).unwrap().values.iter().map(|s| s * s).collect();
    for solver in ["auto", "krylov", "gram", "svd"] {
        for components in [0, 1, 4, 9] {
            let found = error(&format!("pca:components={components}:solver={solver}"), &matrix);
            let tail = squares[components..].iter().sum::<f64>() / square(values);
            assert!((found - tail).abs() <= 1e-6 * tail + 1e-12, "{solver} {components}: {found:e} {tail:e}");
        }
    }
}

#[test]
fn vq_and_pca_are_cpca_with_no_components_and_with_one_cluster() {
    let matrix = sheets(150, 20, 0.05);
    let same =
        |a: &str, b: &str| assert_eq!(decode(&encode(a, &matrix).unwrap()), decode(&encode(b, &matrix).unwrap()));
    same("vq:clusters=12", "cpca:clusters=12:components=0");
    same("pca:components=5", "cpca:clusters=1:components=5");
}

#[test]
fn iterative_is_no_worse_than_static_and_adaptive_no_worse_than_iterative_of_the_same_bytes() {
    for (seed, noise) in [(1, 0.0), (2, 0.02), (3, 0.2)] {
        let matrix = sheets(900, 40, noise);
        let label = |mode: &str| format!("cpca:clusters=12:components=3:mode={mode}:seed={seed}");
        let errors = ["static", "iterative", "adaptive"].map(|mode| error(&label(mode), &matrix));
        assert!(errors[1] <= errors[0] * (1.0 + 1e-9), "{errors:?}");
        assert!(errors[2] <= errors[1] * (1.0 + 1e-6), "{errors:?}");
        // Numbers of components take a few bytes, weights and representatives no more.
        let bytes = ["iterative", "adaptive"].map(|mode| resident(&label(mode), &matrix));
        assert!(bytes[1] <= bytes[0] + 256, "{bytes:?}");
    }
}

#[test]
fn allocation_by_bytes_is_no_worse_than_the_papers_at_equal_bytes() {
    let matrix = sheets(900, 40, 0.05);
    let label = |allocation: &str| format!("cpca:clusters=12:components=3:mode=adaptive:allocation={allocation}");
    let (paper, bytes) = (label("paper"), label("bytes"));
    // The paper's budget is of weights alone: it may take more representatives.
    let per_byte = |label: &str| error(label, &matrix) * resident(label, &matrix) as f64;
    assert!(per_byte(&bytes) <= per_byte(&paper) * 1.02, "{} {}", per_byte(&bytes), per_byte(&paper));
}

#[test]
fn more_components_clusters_or_sweeps_do_not_hurt() {
    let matrix = sheets(600, 30, 0.05);
    let errors = |labels: &[&str]| labels.iter().map(|label| error(label, &matrix)).collect::<Vec<_>>();
    for labels in [
        ["cpca:clusters=8:components=1", "cpca:clusters=8:components=2", "cpca:clusters=8:components=5"],
        ["vq:clusters=4", "vq:clusters=16", "vq:clusters=64"],
        ["vq:clusters=16:sweeps=1", "vq:clusters=16:sweeps=4", "vq:clusters=16:sweeps=100"],
    ] {
        let errors = errors(&labels);
        assert!(errors.is_sorted_by(|a, b| a >= b), "{labels:?}: {errors:?}");
    }
}

#[test]
fn every_start_comes_near_the_others() {
    let matrix = sheets(900, 30, 0.05);
    let errors =
        ["random", "plusplus", "splitting"].map(|start| error(&format!("vq:clusters=24:start={start}"), &matrix));
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(errors.iter().all(|e| *e < 1.35 * least), "{errors:?}");
}

#[test]
fn a_bound_is_kept_by_what_is_decoded_in_every_width_and_mode_and_nearly_used_up() {
    let matrix = sheets(500, 40, 0.05);
    for bound in [0.2, 1e-2, 1e-3] {
        for width in ["f32", "f16", "i16"] {
            for method in ["pca", "cpca:clusters=6", "cpca:clusters=6:mode=iterative", "cpca:clusters=6:mode=adaptive"]
            {
                let label = format!("{method}:max_error={bound}:weights={width}:representatives={width}");
                let found = error(&label, &matrix);
                assert!(found <= bound, "{label}: {found:e}");
                assert!(found > 0.2 * bound, "{label}: {found:e} is far below");
            }
        }
    }
}

#[test]
fn a_bound_that_no_stored_form_keeps_is_refused_with_what_can_be_had() {
    let matrix = sheets(200, 20, 0.3);
    let message = encode("cpca:clusters=4:max_error=1e-13:weights=i16", &matrix).err().unwrap().to_string();
    assert!(message.contains("max_error=1e-13") || message.contains("max_error=0.0000000000001"), "{message}");
    assert!(message.contains("at least"), "{message}");
    for bound in ["0", "-1", "1.5", "nan"] {
        assert!(encode(&format!("pca:max_error={bound}"), &matrix).is_err(), "{bound}");
    }
    assert!(encode("cpca:clusters=auto", &matrix).is_err());
}

#[test]
fn automatic_clusters_make_about_the_smallest_file_of_all() {
    for matrix in [sheets(800, 40, 0.02), sheets(800, 40, 0.3)] {
        let size = |clusters: &str| resident(&format!("cpca:clusters={clusters}:max_error=1e-3"), &matrix);
        let found = size("auto");
        let best = [1, 2, 4, 8, 16, 32, 64].map(|k: usize| size(&k.to_string())).into_iter().min().unwrap();
        assert!(found as f64 <= 1.1 * best as f64, "{found} {best}");
    }
}

#[test]
fn enough_components_give_every_element_back_to_single_precision() {
    for (samples, n) in [(40, 12), (12, 40), (7, 7)] {
        let matrix = sheets(samples, n, 0.5);
        for label in
            ["pca:components=40", "cpca:clusters=3:components=40", "cpca:clusters=3:components=40:mode=iterative"]
        {
            let found = error(label, &matrix);
            assert!(found < 1e-12, "{label} {samples} x {n}: {found:e}");
        }
        let found = error(&format!("vq:clusters={samples}:sweeps=50"), &matrix);
        assert!(found < 1e-12, "{found:e}");
    }
}

/// Numbers of clusters and components that a model has.
fn model_size(label: &str, matrix: &TransferMatrix) -> (usize, Vec<usize>) {
    let sections = encode(label, matrix).unwrap().sections().into_sections();
    let mut source = prt_transfer::Source::new(sections).unwrap();
    let encoded = <prt_cpca::EncodedCpca as prt_transfer::Restore>::read(matrix.shape(), &mut source).unwrap();
    let model = encoded.model();
    (model.clusters.len(), (0..model.clusters.len()).map(|k| model.components(k)).collect())
}

#[test]
fn degenerate_matrices_have_the_exact_smaller_model() {
    let n = 6;
    let row = |seed: usize| (0..n).map(|k| ((seed * 7 + k * 3) % 11) as f32).collect::<Vec<f32>>();
    let of = |seeds: &[usize]| dense(seeds.iter().flat_map(|&s| row(s)).collect(), seeds.len(), 1);
    for start in ["random", "plusplus", "splitting"] {
        // Fewer samples than clusters; duplicates; all equal; one sample.
        for (seeds, distinct) in [(&[1, 2, 3][..], 3), (&[4, 4, 5, 5, 5, 4], 2), (&[9; 8], 1), (&[3], 1)] {
            let (matrix, label) = (of(seeds), format!("vq:clusters=5:start={start}"));
            assert_eq!(model_size(&label, &matrix).0, distinct, "{label} {seeds:?}");
            assert_eq!(decode(&encode(&label, &matrix).unwrap()), matrix.as_dense().unwrap(), "{label} {seeds:?}");
        }
    }
    // Components above the rank of a cluster: samples on a line have one, equal ones none.
    let line = dense((0..8).flat_map(|p| (0..n).map(move |k| (p * (k + 1)) as f32)).collect(), 8, 1);
    assert_eq!(model_size("pca:components=5", &line), (1, vec![1]));
    assert_eq!(model_size("pca:components=5", &of(&[2; 9])), (1, vec![0]));
    for mode in ["static", "iterative", "adaptive"] {
        let label = format!("cpca:clusters=2:components=4:mode={mode}");
        assert!(error(&label, &line) < 1e-12, "{label}");
        assert!(decode(&encode(&label, &of(&[0; 5])).unwrap()).iter().all(|v| v.is_finite()), "{label}");
    }
}

#[test]
fn constant_columns_cost_no_component() {
    let with = |constant: f32| {
        let value = |i: usize| if i.is_multiple_of(4) { constant } else { ((i * i) % 17) as f32 };
        dense((0..80 * 4).map(value).collect(), 80, 1)
    };
    let error_of = |matrix: &TransferMatrix| {
        difference(matrix.as_dense().unwrap(), &decode(&encode("pca:components=2", matrix).unwrap()))
    };
    let (none, some) = (error_of(&with(0.0)), error_of(&with(1000.0)));
    assert!((none - some).abs() < 1e-4 * none, "{none} {some}");
}

#[test]
fn a_matrix_scaled_by_a_power_of_two_has_the_same_model_scaled() {
    let matrix = sheets(200, 24, 0.1);
    let values = matrix.as_dense().unwrap();
    for label in
        ["vq:clusters=9", "pca", "cpca:clusters=5:components=3:mode=iterative", "cpca:clusters=5:max_error=1e-3"]
    {
        let plain = decode(&encode(label, &matrix).unwrap());
        for exponent in [-100i32, -60, 20, 100] {
            let scale = f64::from(exponent).exp2() as f32;
            let scaled = dense(values.iter().map(|v| v * scale).collect(), 200, 1);
            let found: Vec<f32> = decode(&encode(label, &scaled).unwrap()).iter().map(|v| v / scale).collect();
            let apart = difference(&found, &plain) / square(&plain);
            assert!(apart < 1e-13, "{label} at 2^{exponent}: {apart:e}");
        }
    }
}

#[test]
fn responses_of_a_sample_are_compressed_together() {
    // Two responses, the second a multiple of the first: one component holds both.
    let value =
        |p: usize, r: usize, k: usize| (p as f32 * 0.1).sin() * (k as f32 + 1.0) * if r == 0 { 1.0 } else { -2.0 };
    let values = (0..50 * 2 * 5).map(|i| value(i / 10, i / 5 % 2, i % 5)).collect();
    assert!(error("pca:components=1", &dense(values, 50, 2)) < 1e-12);
}

#[test]
fn the_norm_that_is_asked_for_is_the_one_that_is_small() {
    // Harmonics on the hemisphere are far from orthonormal.
    let matrix = sheets(300, 9 * 4, 0.3);
    let matrix = TransferMatrix::from_dense(
        matrix.as_dense().unwrap().to_vec(),
        300 * 9,
        9,
        LightBasis::SphericalHarmonics { order: 2 },
    )
    .unwrap()
    .with_responses("exit:9".parse().unwrap())
    .unwrap();
    let errors = |norm: &str| {
        let decoded = decode(&encode(&format!("cpca:clusters=4:components=3:norm={norm}"), &matrix).unwrap());
        let exact = matrix.as_dense().unwrap();
        let metric = Metric::of(&matrix).unwrap();
        let mut radiance = 0.0;
        for (d, e) in decoded.chunks(36).zip(exact.chunks(36)) {
            let mut apart: Vec<f64> = d.iter().zip(e).map(|(d, e)| f64::from(*d) - f64::from(*e)).collect();
            radiance += metric.square_of(&mut apart, 4);
        }
        (difference(exact, &decoded), radiance)
    };
    let ((plain, plain_radiance), (other, radiance)) = (errors("coefficients"), errors("radiance"));
    assert!(radiance < 0.8 * plain_radiance && plain < other, "{plain} {plain_radiance} {other} {radiance}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn whatever_comes_is_decoded_to_finite_numbers_no_worse_than_the_mean(
        values in prop::collection::vec(prop_oneof![4 => -1.0f32..1.0, 1 => Just(0.0), 1 => -1e30f32..1e30], 1..120),
        responses in 1usize..4,
        clusters in 1usize..6,
        components in 0usize..5,
        mode in prop_oneof![Just("static"), Just("iterative"), Just("adaptive")],
        norm in prop_oneof![Just("coefficients"), Just("radiance")],
    ) {
        let lights = 2;
        let samples = values.len() / (responses * lights);
        let values = values[..samples * responses * lights].to_vec();
        let basis = LightBasis::Plain { lights };
        let matrix = TransferMatrix::from_dense(values, samples * responses, responses, basis).unwrap();
        let exact = matrix.as_dense().unwrap();
        let decoded = decode(&encode(&format!("cpca:clusters={clusters}:components={components}:mode={mode}:norm={norm}"), &matrix).unwrap());
        prop_assert!(decoded.iter().all(|v| v.is_finite()));
        let (n, count) = (responses * lights, samples.max(1) as f64);
        let mean = |k: usize| exact.chunks(n).map(|x| f64::from(x[k])).sum::<f64>() / count;
        let variance: f64 = exact.chunks(n).map(|x| (0..n).map(|k| (f64::from(x[k]) - mean(k)).powi(2)).sum::<f64>()).sum();
        prop_assert!(difference(exact, &decoded) <= variance * (1.0 + 1e-5) + 1e-10 * square(exact));
    }
}
