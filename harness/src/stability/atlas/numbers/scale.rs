//! The same matrix in other units: squares leave the range of single precision long before the numbers do.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::Array2;
use prt_transfer::random::Random;
use prt_transfer::{LightBasis, Result, TransferMatrix};

pub(super) const LARGE: Case = Case {
    name: "large-units",
    title: "Matrices in large units",
    parameter: "factor on the matrix, rounded to a power of two",
    values: &[1.0, 1e5, 1e10, 1e15, 1e20, 1e25, 1e30],
    bound: |_| 1e-5,
    promise: "1e-5: results scale as the matrix does",
    breaks: Some(1e10),
    ..SMALL
};

pub(super) const DENORMAL: Case = Case {
    name: "denormals",
    title: "Matrices at the end of single precision",
    values: &[1e-34, 1e-36, 1e-37, 1e-38, 1e-39, 1e-40, 1e-41, 1e-42],
    quantity: "Σ(T-T̃)²/ΣT² beyond that of the matrix in its own unit",
    here: Form { name: "the worst of all methods but cta", figure: denormal },
    bound: |factor| 1e-6 + (8.0 * 2f64.powi(-149) / factor).powi(2),
    promise: "1e-6, and the square of eight of the least numbers that there are",
    breaks: Some(1e-34),
    ..SMALL
};

pub(super) const SMALL: Case = Case {
    name: "small-units",
    title: "Matrices in small units",
    source: "what a reader would write: squares and products in f32",
    parameter: "factor on the matrix, rounded to a power of two",
    values: &[1.0, 1e-5, 1e-10, 1e-15, 1e-20, 1e-25, 1e-30, 1e-34],
    quantity: "largest change of an element of T̃ divided by the factor, of the largest element",
    printed: Form { name: "principal component by power iteration in f32", figure: printed },
    here: Form { name: "the worst of all methods but cta", figure: here },
    bound: |_| 1e-5,
    promise: "1e-5: results scale as the matrix does",
    breaks: Some(1e-15),
};

/// Smooth rows with solid values: samples of three responses on a cubemap of 6 x 4 x 4.
fn matrix(factor: f64) -> Result<TransferMatrix> {
    let factor = power(factor);
    let mut random = Random(93);
    let waves: Vec<[f64; 3]> = (0..24).map(|_| std::array::from_fn(|_| random.uniform())).collect();
    let rows = Array2::from_shape_fn((72, 96), |(i, k)| {
        let [a, b, c] = waves[i / 3];
        factor * (1.0 + a * (0.1 * k as f64 + b).sin() + c * (0.05 * (i % 3) as f64 * k as f64).cos())
    });
    ground::on(rows.view(), 3, LightBasis::Cubemap { resolution: 4 })
}

/// So that the matrix is the same but for its unit, to the last bit.
fn power(factor: f64) -> f64 {
    2f64.powf(factor.log2().round())
}

/// One of each registered method, as small as the matrix.
const METHODS: [&str; 16] = [
    "dense",
    "csr",
    "compact",
    "runs",
    "haar+truncate:terms=20:bits=16",
    "haar:scale=sphere+truncate:max_error=1e-3",
    "sh:order=3+csr",
    "srbf:centers=42+csr",
    "bicluster",
    "bicluster:max_error=1e-3",
    "vq:clusters=6",
    "pca:components=3",
    "cpca:clusters=4:components=2:mode=iterative",
    "cpca:clusters=3:components=2:weights=i16:representatives=f16",
    "tucker:view=2:light=6:sample=8:numbers=coded",
    "slf:clusters=3:components=2",
];

fn here(factor: f64) -> Result<f64> {
    let (plain, scaled) = (matrix(1.0)?, matrix(factor)?);
    let mut worst = 0f64;
    for label in METHODS {
        let [plain, scaled] =
            [&plain, &scaled].map(|matrix| ground::encoded(label, matrix).map(|c| ground::decoded(&c)));
        let (plain, scaled) = (plain?.mapv(f64::from), scaled?.mapv(f64::from) / power(factor));
        let largest = plain.iter().fold(0f64, |most, v| most.max(v.abs()));
        worst = plain.iter().zip(&scaled).fold(worst, |worst, (a, b)| worst.max((a - b).abs() / largest));
    }
    Ok(worst)
}

fn printed(factor: f64) -> Result<f64> {
    let first = |factor: f64| -> Result<Array2<f64>> {
        let matrix = matrix(factor)?;
        let x = Array2::from_shape_vec((72, 96), matrix.as_dense().unwrap_or_default().to_vec()).unwrap_or_default();
        let mut v = ndarray::Array1::from_elem(96, 1f32);
        for _ in 0..50 {
            v = x.t().dot(&x.dot(&v));
            let length = v.dot(&v).sqrt();
            v /= length;
        }
        let weights = x.dot(&v);
        Ok(Array2::from_shape_fn((72, 96), |(i, k)| f64::from(weights[i] * v[k]) / power(factor)))
    };
    let (plain, scaled) = (first(1.0)?, first(factor)?);
    let largest = plain.iter().fold(0f64, |most, v| most.max(v.abs()));
    // NaN is the largest of all.
    Ok(plain
        .iter()
        .zip(&scaled)
        .map(|(a, b)| (a - b).abs() / largest)
        .fold(0.0, |most, d| if d <= most { most } else { d }))
}

fn denormal(factor: f64) -> Result<f64> {
    let (plain, scaled) = (matrix(1.0)?, matrix(factor)?);
    let more = |label: &&str| Ok(ground::error(label, &scaled)? - ground::error(label, &plain)?);
    METHODS.iter().map(more).try_fold(0.0, |most, more: Result<f64>| Ok(f64::max(most, more?)))
}
