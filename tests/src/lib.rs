//! What the laws in `tests/` are checked on: small matrices of every kind, every registered method in several settings.

pub mod hostile;

use ndarray::Array2;
use prt_transfer::hemisphere::local_directions;
use prt_transfer::{Compressed, Label, LightBasis, Method, Quiet, Registry, Result, TransferMatrix};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

mod variants;

pub use variants::{far, harmless, relative_error, with};

/// A matrix and what it is, for messages.
pub struct Case {
    /// What it is.
    pub name: &'static str,
    /// The matrix.
    pub matrix: TransferMatrix,
}

/// The cubemap that most cases live on, so that every transform is defined: 6 x 4 x 4 texels.
pub const BASIS: LightBasis = LightBasis::Cubemap { resolution: 4 };

/// Random numbers that are the same in every run.
pub fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Matrices as scenes give them, and the degenerate ones.
pub fn cases() -> Vec<Case> {
    let case = |name, rows: usize, responses, basis: LightBasis, element: &mut dyn FnMut(usize, usize) -> f32| {
        let values: Vec<f32> =
            (0..rows * basis.lights()).map(|i| element(i / basis.lights(), i % basis.lights())).collect();
        let matrix = TransferMatrix::from_dense(values, rows, responses, basis).expect("a case is valid");
        Case { name, matrix }
    };
    let mut rng = random(7);
    // Visibility: runs of equal values k/4, coherent from row to row.
    let mut visibility = |row: usize, col: usize| match (col + 2 * row / 3) % 24 {
        0 => 0.25,
        1..=5 => 1.0,
        6 => 0.75,
        _ => 0.0,
    };
    let smooth = |row: usize, col: usize| ((row as f32 * 0.2).sin() + 1.2) * (col as f32 * 0.13).cos().max(0.0);
    let mut noise = |_: usize, _: usize| rng.random_range(-1.0f32..1.0);
    let mut cases = vec![
        case("visibility", 48, 4, BASIS, &mut visibility),
        case("smooth", 30, 1, BASIS, &mut |r, c| smooth(r, c)),
        // Windows of many places and lengths: rows that share parts with few others.
        case("windows", 400, 4, BASIS, &mut |r, c| {
            let (start, length) = (r * 7 % 61, 12 + r * r % 23);
            if (start..start + length).contains(&c) { 1.0 } else { 0.0 }
        }),
        case("noise", 17, 1, BASIS, &mut noise),
        case("one row", 1, 1, BASIS, &mut |r, c| smooth(r, c)),
        case("zeros", 5, 5, BASIS, &mut |_, _| 0.0),
        case("no rows", 0, 1, BASIS, &mut |_, _| 0.0),
        case("huge and tiny", 6, 2, BASIS, &mut |r, c| if c % 2 == 0 { 1e30 } else { 1e-30 } * (1 + r + c) as f32),
        case("one column", 9, 1, LightBasis::Plain { lights: 1 }, &mut |r, _| r as f32 * 0.5),
        case("no columns", 3, 1, LightBasis::Plain { lights: 0 }, &mut |_, _| 0.0),
    ];
    // More rows than any block of the codecs, more lights than a byte counts, rows long enough for vector kernels.
    let wide = LightBasis::Cubemap { resolution: 8 };
    cases.push(case("several blocks", 1100, 4, wide, &mut |r, c| match (c + r / 9) % 48 {
        0..=10 => 1.0,
        11 => 0.25 + (r % 7) as f32,
        _ => 0.0,
    }));
    cases.push(Case { name: "turned hemispheres", matrix: turned_hemispheres(20, 3) });
    cases.extend(cases.iter().map(|c| Case { name: c.name, matrix: sparse(&c.matrix) }).collect::<Vec<_>>());
    cases
}

/// What points without neighbours but in frames of their own see of the cubemap: each texel in the row of the local direction nearest
/// to its centre, `edge`² rows a sample, the part of it that lies before a wall in quarters.
fn turned_hemispheres(samples: usize, edge: usize) -> TransferMatrix {
    let (directions, centres) = (local_directions(edge), BASIS.directions().expect("texels have directions"));
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut values = vec![0f32; samples * edge * edge * BASIS.lights()];
    for sample in 0..samples {
        // A turn about z, then one about x.
        let ((s, c), (t, d)) = ((0.7 * sample as f64).sin_cos(), (1.1 * sample as f64).sin_cos());
        let axes = [[c, s, 0.0], [-s * d, c * d, t], [s * t, -c * t, d]];
        for (texel, &centre) in centres.iter().enumerate() {
            let local = axes.map(|axis| dot(axis, centre));
            let cosine = |d: &[f32; 3]| dot(d.map(f64::from), local);
            let nearest = (0..edge * edge).max_by(|&a, &b| cosine(&directions[a]).total_cmp(&cosine(&directions[b])));
            if local[2] > 0.0 && local[0] < 0.5 {
                let row = sample * edge * edge + nearest.expect("there are directions");
                values[row * BASIS.lights() + texel] = if local[0] > 0.3 { 0.25 } else { 1.0 };
            }
        }
    }
    TransferMatrix::from_dense(values, samples * edge * edge, edge * edge, BASIS).expect("a case is valid")
}

/// The same elements in compressed rows.
pub fn sparse(matrix: &TransferMatrix) -> TransferMatrix {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..matrix.rows() {
        for (col, value) in matrix.row(row).non_zeros() {
            columns.push(col as u32);
            values.push(value);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, matrix.shape().responses, matrix.basis().clone())
        .expect("the elements of a valid matrix")
}

/// A light with positive and negative coefficients, lights x channels.
pub fn light(lights: usize, channels: usize) -> Array2<f32> {
    let mut rng = random(11);
    Array2::from_shape_simple_fn((lights, channels), || rng.random_range(-1.0f32..2.0))
}

/// Every row of what a method made, rows x lights.
pub fn decoded(compressed: &Compressed) -> Array2<f32> {
    let shape = compressed.shape();
    let mut rows = Array2::zeros((shape.rows(), shape.lights));
    for (row, mut out) in rows.outer_iter_mut().enumerate() {
        compressed.row_into(row, out.as_slice_mut().expect("rows of a fresh array are contiguous"));
    }
    rows
}

/// Every element of a matrix, rows x lights.
pub fn elements(matrix: &TransferMatrix) -> Array2<f32> {
    let mut rows = Array2::zeros((matrix.rows(), matrix.lights()));
    for (row, mut out) in rows.outer_iter_mut().enumerate() {
        matrix.gather(row, out.as_slice_mut().expect("rows of a fresh array are contiguous"));
    }
    rows
}

/// A parameter of a method set to something other than its default, in company that lets it act.
pub struct Setting {
    /// The label without the parameter.
    pub without: &'static str,
    /// The parameter, `name=value`.
    pub parameter: &'static str,
    /// Which stage of the label it belongs to.
    pub stage: &'static str,
}

/// One setting for every parameter of every registered method: a new parameter must be added here.
pub const SETTINGS: &[Setting] = &[
    Setting { without: "haar+csr", parameter: "scale=sphere", stage: "haar" },
    Setting { without: "haar+csr", parameter: "light_terms=9", stage: "haar" },
    Setting { without: "haar:light_terms=9+csr", parameter: "light_select=area", stage: "haar" },
    Setting { without: "sh+csr", parameter: "order=2", stage: "sh" },
    Setting { without: "srbf+csr", parameter: "centers=42", stage: "srbf" },
    Setting { without: "srbf:centers=12+csr", parameter: "bandwidth=9", stage: "srbf" },
    Setting { without: "srbf:centers=12+csr", parameter: "kernel=abel-poisson", stage: "srbf" },
    Setting { without: "srbf:centers=12+csr", parameter: "ridge=0.1", stage: "srbf" },
    Setting { without: "srbf:centers=42+csr", parameter: "coordinates=lobes", stage: "srbf" },
    Setting { without: "truncate", parameter: "terms=3", stage: "truncate" },
    Setting { without: "truncate", parameter: "energy=0.75", stage: "truncate" },
    Setting { without: "truncate", parameter: "max_error=0.1", stage: "truncate" },
    Setting { without: "truncate", parameter: "bits=8", stage: "truncate" },
    Setting { without: "truncate", parameter: "bits=16", stage: "truncate" },
    Setting { without: "truncate:order=columns", parameter: "bits=8", stage: "truncate" },
    Setting { without: "haar+truncate", parameter: "order=columns", stage: "truncate" },
    Setting { without: "bicluster", parameter: "objective=flops", stage: "bicluster" },
    Setting { without: "bicluster", parameter: "levels=1", stage: "bicluster" },
    Setting { without: "bicluster", parameter: "levels=2", stage: "bicluster" },
    Setting { without: "bicluster:levels=1", parameter: "seeds=random", stage: "bicluster" },
    Setting { without: "bicluster:levels=1:seeds=random", parameter: "seed=9", stage: "bicluster" },
    Setting { without: "bicluster", parameter: "max_error=0.1", stage: "bicluster" },
    Setting { without: "vq", parameter: "clusters=3", stage: "vq" },
    Setting { without: "vq:clusters=6", parameter: "sweeps=1", stage: "vq" },
    Setting { without: "vq:clusters=6", parameter: "start=splitting", stage: "vq" },
    Setting { without: "vq:clusters=6", parameter: "start=random", stage: "vq" },
    Setting { without: "vq:clusters=6", parameter: "seed=9", stage: "vq" },
    Setting { without: "vq:clusters=6", parameter: "norm=radiance", stage: "vq" },
    Setting { without: "vq:clusters=6", parameter: "representatives=i16", stage: "vq" },
    Setting { without: "pca", parameter: "components=2", stage: "pca" },
    Setting { without: "pca", parameter: "solver=power", stage: "pca" },
    Setting { without: "pca", parameter: "norm=radiance", stage: "pca" },
    Setting { without: "pca", parameter: "weights=f16", stage: "pca" },
    Setting { without: "pca", parameter: "representatives=f16", stage: "pca" },
    Setting { without: "pca", parameter: "max_error=0.1", stage: "pca" },
    Setting { without: "cpca", parameter: "clusters=5", stage: "cpca" },
    Setting { without: "cpca:max_error=0.1", parameter: "clusters=auto", stage: "cpca" },
    Setting { without: "cpca:clusters=5", parameter: "components=2", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "mode=iterative", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "mode=adaptive", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2:mode=iterative", parameter: "sweeps=1", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "start=splitting", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "seed=9", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2:mode=adaptive", parameter: "allocation=paper", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "solver=power", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "norm=radiance", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "weights=i16", stage: "cpca" },
    Setting { without: "cpca:clusters=5:components=2", parameter: "representatives=i16", stage: "cpca" },
    Setting { without: "cpca:clusters=5", parameter: "max_error=0.1", stage: "cpca" },
    Setting { without: "tucker", parameter: "view=2", stage: "tucker" },
    Setting { without: "tucker", parameter: "light=3", stage: "tucker" },
    Setting { without: "tucker", parameter: "sample=2", stage: "tucker" },
    Setting { without: "tucker:sample=3:light=4", parameter: "mode=hosvd", stage: "tucker" },
    Setting { without: "tucker:sample=3:light=4", parameter: "mode=hooi", stage: "tucker" },
    Setting { without: "tucker:sample=3:light=4:mode=hooi", parameter: "sweeps=1", stage: "tucker" },
    Setting { without: "tucker:sample=3:light=4:mode=randomised", parameter: "seed=9", stage: "tucker" },
    Setting { without: "tucker:sample=3:light=4", parameter: "norm=radiance", stage: "tucker" },
    Setting { without: "tucker", parameter: "numbers=f32", stage: "tucker" },
    Setting { without: "tucker", parameter: "numbers=f16", stage: "tucker" },
    Setting { without: "tucker:sample=3", parameter: "numbers=coded", stage: "tucker" },
    Setting { without: "tucker:sample=3:numbers=coded", parameter: "noise=0.5", stage: "tucker" },
    Setting { without: "tucker", parameter: "max_error=0.1", stage: "tucker" },
    Setting { without: "cta", parameter: "clusters=3", stage: "cta" },
    Setting { without: "cta:clusters=3", parameter: "view=2", stage: "cta" },
    Setting { without: "cta:clusters=3", parameter: "light=3", stage: "cta" },
    Setting { without: "cta:clusters=3", parameter: "sample=2", stage: "cta" },
    Setting { without: "cta:clusters=3:sample=2", parameter: "members=2", stage: "cta" },
    Setting { without: "cta:clusters=4:sample=2:light=4", parameter: "sweeps=0", stage: "cta" },
    Setting { without: "cta:clusters=4:sample=2:light=4", parameter: "refine=1", stage: "cta" },
    Setting { without: "cta:clusters=4:sample=2:light=4", parameter: "start=elbg", stage: "cta" },
    Setting { without: "cta:clusters=4:sample=2:light=4", parameter: "seed=9", stage: "cta" },
    Setting { without: "cta:clusters=3:sample=2:light=4", parameter: "norm=radiance", stage: "cta" },
    Setting { without: "cta:clusters=3:sample=2", parameter: "numbers=f32", stage: "cta" },
    Setting { without: "cta:clusters=3:sample=2", parameter: "numbers=f16", stage: "cta" },
    Setting { without: "cta:clusters=3:sample=2", parameter: "numbers=coded", stage: "cta" },
    Setting { without: "cta:clusters=3:sample=2:numbers=coded", parameter: "noise=0.5", stage: "cta" },
    Setting { without: "slf", parameter: "clusters=5", stage: "slf" },
    Setting { without: "slf:max_error=0.1", parameter: "clusters=auto", stage: "slf" },
    Setting { without: "slf:clusters=5", parameter: "components=2", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "colour=separate", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "colour=joint", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "mode=iterative", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "sweeps=1", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "start=splitting", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "start=random", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "seed=9", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "solver=power", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "norm=radiance", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "surface=i16", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2", parameter: "views=f16", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2:surface=f16", parameter: "views=i16", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2:colour=joint:surface=i16", parameter: "views=i16", stage: "slf" },
    Setting {
        without: "slf:clusters=5:components=2:colour=separate:surface=i16",
        parameter: "views=i16",
        stage: "slf",
    },
    Setting { without: "slf:clusters=5:components=2", parameter: "maps=haar", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2:maps=haar", parameter: "noise=0.5", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2:colour=joint", parameter: "maps=haar", stage: "slf" },
    Setting { without: "slf:clusters=5:components=2:colour=separate", parameter: "maps=haar", stage: "slf" },
    Setting { without: "slf:clusters=5", parameter: "max_error=0.1", stage: "slf" },
    Setting { without: "slf:clusters=auto:max_error=0.1", parameter: "maps=haar", stage: "slf" },
];

/// Every label that the laws are checked on: each method at its defaults and each of its settings.
pub fn labels(registry: &Registry) -> Vec<Label> {
    let defaults = registry.codecs().into_iter().map(|c| c.name.to_string());
    let transforms = registry.transforms().into_iter().map(|t| format!("{}+csr", t.name));
    let settings = SETTINGS.iter().map(Setting::label);
    let mut labels: Vec<Label> =
        defaults.chain(transforms).chain(settings).map(|l| l.parse().expect("a label of the laws")).collect();
    labels.dedup();
    labels
}

impl Setting {
    /// The label with the parameter in its stage.
    pub fn label(&self) -> String {
        let stages = self.without.split('+').map(|stage| {
            if stage.split(':').next() == Some(self.stage) {
                format!("{stage}:{}", self.parameter)
            } else {
                stage.into()
            }
        });
        stages.collect::<Vec<String>>().join("+")
    }
}

/// A label's method, applied.
pub fn encode(registry: &Registry, label: &Label, matrix: &TransferMatrix) -> Result<Compressed> {
    registry.method(label)?.encode(matrix, &Quiet)
}

/// As [`encode`]; `None` where the method refuses the basis of the case, or `visibility` one of another structure: no other
/// refusals are accepted by the laws.
pub fn encode_where_defined(registry: &Registry, label: &Label, case: &Case) -> Option<(Method, Compressed)> {
    let method = registry.method(label).unwrap_or_else(|e| panic!("{label}: {e}"));
    match method.encode(&case.matrix, &Quiet) {
        Ok(compressed) => Some((method, compressed)),
        Err(prt_transfer::Error::Unsupported { what, .. })
            if what.starts_with("light basis") || what.starts_with("visibility: ") =>
        {
            None
        }
        Err(e) => panic!("{label} on {}: {e}", case.name),
    }
}

/// Flips one random bit.
pub fn flip_bit(bytes: &mut [u8], rng: &mut impl Rng) {
    if !bytes.is_empty() {
        let at = rng.random_range(0..bytes.len());
        bytes[at] ^= 1 << rng.random_range(0..8u32);
    }
}

/// The example codec of CONTRIBUTING.md compiles and works.
#[cfg(doctest)]
#[doc = include_str!("../../CONTRIBUTING.md")]
pub struct Contributing;

/// The example of README.md compiles and works.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
