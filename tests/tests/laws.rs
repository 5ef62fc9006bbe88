//! Promises that every registered method keeps. A new method is in every one of these loops by being registered.

use ndarray::Array2;
use prt_cpca::EncodedCpca;
use prt_harness::registry::registry;
use prt_slf::{EncodedSlf, Width};
use prt_tensor::EncodedCta;
use prt_tests::*;
use prt_transfer::io::prt;
use prt_transfer::sections::Section;
use prt_transfer::{Compressed, Label, Quiet, Registry, Restore, Source, TransferMatrix};
use rand::RngExt;
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::LazyLock;

static CASES: LazyLock<Vec<Case>> = LazyLock::new(cases);

/// The bytes of a file, and what is in it.
type File = (&'static Case, Vec<u8>);

/// For every label the files of all cases that it is defined on: encoded once for all laws.
static FILES: LazyLock<Vec<(Label, Vec<File>)>> = LazyLock::new(|| {
    let registry = registry();
    let files = |label: Label| {
        let file = |case| {
            let (_, compressed) = encode_where_defined(&registry, &label, case)?;
            Some((case, prt::to_bytes(&compressed, &Quiet).unwrap()))
        };
        let files: Vec<_> = CASES.iter().filter_map(file).collect();
        assert!(files.len() >= 10, "{label} is defined on {} cases only", files.len());
        (label, files)
    };
    labels(&registry).into_par_iter().map(files).collect()
});

/// Runs `law` on every label and every case that the label is defined on, after a round trip through a file's bytes.
fn for_every_method(mut law: impl FnMut(&Registry, &Label, &Case, &Compressed)) {
    let registry = registry();
    for (label, files) in FILES.iter() {
        for (case, bytes) in files {
            let reloaded =
                prt::from_bytes(bytes, &registry).unwrap_or_else(|e| panic!("{label} on {}: {e}", case.name));
            law(&registry, label, case, &reloaded);
        }
    }
}

#[test]
fn relighting_equals_decoded_rows_times_light() {
    for_every_method(|_, label, case, compressed| {
        if label.transform.params.iter().any(|(name, _)| name == "light_terms") {
            return; // the light is cut at run time: `cut_lights_relight_as_the_light_they_keep` holds instead
        }
        let rows = decoded(compressed).mapv(f64::from);
        for channels in [1, 3, 5] {
            let light = light(case.matrix.lights(), channels);
            let mut out = Array2::from_elem((rows.nrows(), channels), f32::NAN);
            compressed.apply_into(light.view(), out.view_mut()).unwrap();
            let expected = rows.dot(&light.mapv(f64::from));
            // Rounding is bounded by the sum of magnitudes, not by the sum itself. The wavelet domain mixes columns, so
            // the bound is taken over whole rows.
            let mut magnitude = rows.mapv(f64::abs).sum_axis(ndarray::Axis(1)) * 2.0;
            // Clusters mix samples: a row of zeros may be a sum of representatives that are none.
            if ["vq", "pca", "cpca", "tucker", "cta", "slf"].contains(&label.codec.name.as_str()) {
                let largest = magnitude.iter().copied().fold(0.0, f64::max);
                magnitude.fill(largest);
            }
            for ((row, channel), y) in out.indexed_iter() {
                let error = (f64::from(*y) - expected[[row, channel]]).abs();
                let bound = 4e-6 * magnitude[row] + 1e-37;
                assert!(error <= bound, "{label} on {}: row {row} channel {channel}: {error:e} > {bound:e}", case.name);
            }
        }
    });
}

#[test]
fn rows_that_are_decoded_at_once_are_those_decoded_one_by_one() {
    for_every_method(|_, label, case, compressed| {
        let (one, shape) = (decoded(compressed), compressed.shape());
        let largest = one.iter().fold(0f32, |most, v| most.max(v.abs()));
        // From the middle of a sample to the middle of another.
        for range in [0..shape.rows(), shape.rows() / 3..shape.rows(), 1.min(shape.rows())..shape.rows() * 2 / 3] {
            let mut rows = Array2::from_elem((range.len(), shape.lights), f32::NAN);
            compressed.rows_into(range.start, rows.view_mut());
            let expected = one.slice(ndarray::s![range.start..range.start + range.len(), ..]);
            let far = rows.iter().zip(expected).find(|(a, b)| (*a - *b).abs() > 1e-6 * largest);
            assert!(far.is_none() && rows.iter().all(|v| v.is_finite()), "{label} on {}: {far:?}", case.name);
        }
    });
}

#[test]
fn saving_what_was_loaded_gives_the_same_bytes() {
    for_every_method(|registry, label, case, reloaded| {
        let bytes = prt::to_bytes(reloaded, &Quiet).unwrap();
        let again = prt::to_bytes(&prt::from_bytes(&bytes, registry).unwrap(), &Quiet).unwrap();
        assert_eq!(bytes, again, "{label} on {}", case.name);
        let first = prt::to_bytes(&encode(registry, label, &case.matrix).unwrap(), &Quiet).unwrap();
        assert_eq!(bytes, first, "{label} on {}", case.name);
    });
}

#[test]
fn storage_is_what_the_writer_wrote() {
    for_every_method(|_, label, case, compressed| {
        let bytes = prt::to_bytes(compressed, &Quiet).unwrap();
        let info = prt::inspect(&bytes).unwrap();
        let stored: u64 = info.sections.iter().map(|s| s.stored).sum();
        assert_eq!(info.sizes.header + stored, bytes.len() as u64, "{label} on {}", case.name);
        assert_eq!(info.sizes.file, bytes.len() as u64);
        let raw: u64 = info.sections.iter().map(|s| s.raw).sum();
        assert_eq!(raw, compressed.sections().resident_bytes() as u64, "{label} on {}", case.name);
        assert_eq!(info.sizes.raw, raw);
        assert_eq!(info.header, compressed.header(), "{label} on {}", case.name);
    });
}

#[test]
fn one_two_and_seven_threads_give_the_same_bytes() {
    let [one, two, seven] = [1, 2, 7].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    for_every_method(|registry, label, case, _| {
        let bytes = || prt::to_bytes(&encode(registry, label, &case.matrix).unwrap(), &Quiet).unwrap();
        let of_one = one.install(bytes);
        assert!(of_one == two.install(bytes) && of_one == seven.install(bytes), "{label} on {}", case.name);
    });
}

#[test]
fn every_parameter_is_covered_and_changes_the_outcome() {
    let registry = registry();
    for about in registry.codecs().into_iter().chain(registry.transforms()) {
        for field in about.fields {
            let settings =
                SETTINGS.iter().filter(|s| s.stage == about.name && s.parameter.split('=').next() == Some(field.name));
            assert!(settings.count() > 0, "no setting in SETTINGS for {}:{}", about.name, field.name);
        }
    }
    for setting in SETTINGS {
        let outcome = |label: &str| {
            let label: Label = label.parse().unwrap();
            let visible: Vec<_> = cases()
                .into_iter()
                .filter(|c| ["smooth", "visibility", "noise", "windows"].contains(&c.name))
                .collect();
            let made = visible.iter().map(|case| {
                let compressed = encode(&registry, &label, &case.matrix).unwrap();
                let light = light(case.matrix.lights(), 1);
                let mut out = Array2::zeros((case.matrix.rows(), 1));
                compressed.apply_into(light.view(), out.view_mut()).unwrap();
                (compressed.sections().into_sections(), out)
            });
            made.collect::<Vec<(Vec<Section>, Array2<f32>)>>()
        };
        assert!(outcome(setting.without) != outcome(&setting.label()), "{} changes nothing", setting.label());
    }
}

#[test]
fn labels_read_back_what_they_print_and_print_only_what_differs() {
    let registry = registry();
    for label in labels(&registry) {
        let canonical = registry.method(&label).unwrap().label().clone();
        let printed: Label = canonical.to_string().parse().unwrap();
        assert_eq!(printed, canonical);
        assert_eq!(registry.method(&printed).unwrap().label(), &canonical);
    }
    for about in registry.codecs() {
        // Every default written out is the same method as none.
        let fields = about.fields.iter().map(|f| (f.name.to_string(), f.default.clone())).collect();
        let mut label: Label = about.name.parse().unwrap();
        label.codec.params = fields;
        assert_eq!(registry.method(&label).unwrap().label().to_string(), about.name);
    }
}

#[test]
fn unknown_names_and_values_are_refused_by_name() {
    let registry = registry();
    let codecs = registry.codecs().into_iter().map(|about| (about, ""));
    let transforms = registry.transforms().into_iter().map(|about| (about, "+csr"));
    for (about, codec) in codecs.chain(transforms) {
        let refused = |label: String| registry.method(&label.parse().unwrap()).err().map(|e| e.to_string());
        assert!(refused(format!("{}:nonsense=1{codec}", about.name)).unwrap().contains("nonsense"));
        for field in about.fields {
            let message = refused(format!("{}:{}=nonsense{codec}", about.name, field.name)).unwrap();
            assert!(message.contains(field.name) && message.contains("nonsense"), "{message}");
        }
    }
}

/// Whether every element must come back as it was.
fn is_exact(label: &Label) -> bool {
    let lossy = label.codec.params.iter().any(|(name, _)| name == "max_error");
    let exact = ["dense", "csr", "compact", "runs", "visibility", "bicluster"].contains(&label.codec.name.as_str());
    exact && !lossy && label.transform.name == "identity"
}

#[test]
fn exact_codecs_give_back_every_element() {
    for_every_method(|_, label, case, compressed| {
        if is_exact(label) {
            assert_eq!(decoded(compressed), elements(&case.matrix), "{label} on {}", case.name);
        }
    });
}

/// Multiplications and additions of `runs`: a product for each element alone and for each value that has runs in a row, two
/// additions for each run, and the prefix sums.
fn flops_of_runs(matrix: &TransferMatrix) -> [u64; 2] {
    let (mut products, mut runs) = (0, 0);
    for row in elements(matrix).outer_iter() {
        let mut values = Vec::new();
        for run in row.to_vec().chunk_by(|a, b| a == b).filter(|run| run[0] != 0.0) {
            products += u64::from(run.len() == 1);
            runs += u64::from(run.len() > 1);
            if run.len() > 1 && !values.contains(&run[0]) {
                values.push(run[0]);
            }
        }
        products += values.len() as u64;
    }
    [products, products + 2 * runs + matrix.lights() as u64]
}

/// Multiplications and additions of clusters: representatives times light, then representatives times weights; a scale for each number of a
/// representative's response where anything is scaled, and a product of two scales for each component where both are.
fn flops_of_clusters(compressed: &Compressed) -> [u64; 2] {
    let (shape, sections) = (compressed.shape(), compressed.sections());
    let scaled = ["basis/scales", "weights/scales"].map(|name| sections.sizes().any(|(section, _)| section == name));
    let mut source = Source::new(sections.into_sections()).unwrap();
    let model = EncodedCpca::read(shape, &mut source).unwrap().model();
    let components = || (0..model.clusters.len()).map(|cluster| model.components(cluster));
    let (vectors, all): (usize, usize) = (components().map(|n| 1 + n).sum(), components().sum());
    let products = vectors * model.dimension() + model.weights.len() * shape.responses;
    let scales = match scaled {
        [false, false] => 0,
        [true, false] => vectors * shape.responses,
        [false, true] => all * shape.responses,
        [true, true] => vectors * shape.responses + all,
    };
    [(products + scales) as u64, products as u64]
}

/// Multiplications and additions of tensors: light bases and dual bases times light, columns times weights, and the view basis after it or, where
/// that is less, before; a scale for each row of a light basis, for each number of a column, and a product of two scales for each column.
fn flops_of_tensors(compressed: &Compressed) -> [u64; 2] {
    let (shape, sections) = (compressed.shape(), compressed.sections());
    let scaled = sections.sizes().any(|(section, _)| section == "weights/scales");
    let mut source = Source::new(sections.into_sections()).unwrap();
    let model = EncodedCta::read(shape, &mut source).unwrap().model();
    let (views, weights) = (model.views(), model.weights.len());
    let ranks = || model.clusters.iter().map(|c| [c.light.nrows(), c.dual.nrows()]);
    let bases: usize = ranks().map(|[light, sample]| light * (shape.lights + sample * views)).sum();
    let columns: usize = ranks().map(|[_, sample]| sample).sum();
    let after = weights * views + shape.samples * shape.responses * views;
    let before = columns * views * shape.responses + weights * shape.responses;
    let products = bases + if model.view.is_some() { after.min(before) } else { weights * views };
    let scales: usize = ranks().map(|[light, sample]| light + sample * (views + 1)).sum();
    [(products + if scaled { scales } else { 0 }) as u64, products as u64]
}

/// Multiplications and additions of surface light fields: the sum of the light, view maps times light, means and weights times what came of
/// both; a scale for each component and channel of a cluster where view or surface maps have scales, a product of two where both have, and a
/// scale for each channel of a cluster where means have.
fn flops_of_light_fields(compressed: &Compressed) -> [u64; 2] {
    let shape = compressed.shape();
    let mut source = Source::new(compressed.sections().into_sections()).unwrap();
    let slf = EncodedSlf::read(shape, &mut source).unwrap();
    let [of_surface, of_views] = slf.widths().map(|width| u64::from(width != Width::F32));
    // View maps of n numbers each; channels of clusters.
    let tiles = slf.tiles() as u64;
    let components = tiles * slf.components() as u64;
    let products = components * shape.lights as u64 + (shape.rows() * (1 + slf.components())) as u64;
    let scales = components * (of_surface + of_views) + tiles * of_surface;
    [products + scales, products + shape.lights as u64]
}

#[test]
fn flops_equal_the_closed_formula() {
    for_every_method(|_, label, case, compressed| {
        if label.transform.name != "identity" {
            return; // the transform's own formula is checked in its crate
        }
        let shape = case.matrix.shape();
        let shared = compressed.held().into_sections();
        if shared.iter().any(|s| s.name == "index/slots") {
            return; // its own law: `shared_sums_cost_what_their_sections_say`
        }
        let flops = compressed.flops(light(shape.lights, 1).column(0).to_vec().as_slice()).unwrap();
        // `compact` and `f16` keep every element where that is smaller, and then have no index.
        let sections = |prefix| compressed.sections().sizes().any(|(name, _)| name.starts_with(prefix));
        let stored = if sections("index/") { case.matrix.non_zeros() } else { shape.rows() * shape.lights };
        let products = match label.codec.name.as_str() {
            "dense" => shape.rows() * shape.lights,
            "csr" | "visibility" => case.matrix.non_zeros(),
            "compact" | "f16" => stored,
            // Left to the layout of `compact`, after what max_error dropped.
            "bicluster" if sections("index/") => decoded(compressed).iter().filter(|v| **v != 0.0).count(),
            "bicluster" => shape.rows() * shape.lights,
            // One product for every element that is kept: what decodes to a non-zero.
            "truncate" => decoded(compressed).iter().filter(|v| **v != 0.0).count(),
            "runs" if !sections("index/run_") => stored,
            "runs" => {
                return assert_eq!(flops_of_runs(&case.matrix), [flops.multiplications, flops.additions], "{label}");
            }
            "vq" | "pca" | "cpca" => {
                return assert_eq!(flops_of_clusters(compressed), [flops.multiplications, flops.additions], "{label}");
            }
            "tucker" | "cta" => {
                return assert_eq!(flops_of_tensors(compressed), [flops.multiplications, flops.additions], "{label}");
            }
            "slf" => {
                return assert_eq!(
                    flops_of_light_fields(compressed),
                    [flops.multiplications, flops.additions],
                    "{label}"
                );
            }
            other => panic!("state the closed formula of {other}"),
        };
        // Values stored as multiples of a row's step take one more multiplication a row.
        let steps = if sections("weights/steps") { shape.rows() } else { 0 };
        assert_eq!(flops.multiplications, (products + steps) as u64, "{label} on {}", case.name);
        assert_eq!(flops.additions, products as u64, "{label} on {}", case.name);
    });
}

#[test]
fn shared_sums_cost_what_their_sections_say() {
    let mut tried = 0;
    for_every_method(|_, label, case, compressed| {
        let sections = compressed.held().into_sections();
        let numbers = |name: &str, width: usize| -> Vec<u32> {
            let bytes = sections.iter().find(|s| s.name == name).map_or(&[][..], |s| &s.bytes);
            let number = |b: &[u8]| b.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b));
            bytes.chunks(width).map(number).collect()
        };
        if !sections.iter().any(|s| s.name == "index/slots") {
            return;
        }
        // A multiplication for each leaf whose factor is not 1, n - 1 additions for a sum or a row of n terms.
        let (factors, ends) = (numbers("weights/factors", 4), numbers("index/runs", 4));
        let (mut run, mut scaled) = (0, 0);
        for block in numbers("index/blocks", 4).chunks(3) {
            let mut leaf = 0;
            for run in run..run + block[0] as usize {
                let leaves = u64::from(ends[run] - std::mem::replace(&mut leaf, ends[run]));
                scaled += if f32::from_bits(factors[run]) == 1.0 { 0 } else { leaves };
            }
            run += block[0] as usize;
        }
        let sums: u64 = numbers("index/blocks", 4).chunks(3).map(|block| u64::from(block[1])).sum();
        let rows: u64 = numbers("index/groups", 4).chunks(2).map(|g| u64::from(g[0] - 1) * u64::from(g[1])).sum();
        let additions = numbers("index/inputs", 2).len() as u64 - sums + rows;
        // What no sum covers: a multiplication and an addition each, and one addition for each distinct row.
        let products: u64 = numbers("header/products", 4).into_iter().map(u64::from).sum();
        let flops = compressed.flops(&vec![1.0; case.matrix.lights()]).unwrap();
        let lights = case.matrix.lights() as u64;
        let width = [1 << 8, 1 << 16].iter().filter(|&&most| lights > most).count() + 1;
        let listed = sections.iter().any(|s| s.name == "index/rest-lengths");
        let rest = if listed { numbers("index/rest-columns", width).len() as u64 } else { products * lights };
        assert_eq!(flops.multiplications, scaled + rest, "{label} on {}", case.name);
        assert_eq!(flops.additions, additions + products + rest, "{label} on {}", case.name);
        tried += 1;
    });
    assert!(tried >= 10, "only {tried} matrices had sums to share");
}

/// Uses everything of a compressed matrix that was accepted from damaged bytes.
fn use_all(compressed: &Compressed) {
    let shape = compressed.shape();
    if shape.rows() * shape.lights > 1 << 19 {
        return; // damage that made a matrix larger is legal where the sections agree with it; using it all takes too long
    }
    decoded(compressed);
    prt::to_bytes(compressed, &Quiet).unwrap();
    let light = light(shape.lights, 3);
    compressed.apply_into(light.view(), Array2::zeros((shape.rows(), 3)).view_mut()).unwrap();
    compressed.flops(&light.column(0).to_vec()).unwrap();
}

#[test]
fn truncated_and_damaged_files_never_panic() {
    let mut rng = random(3);
    for_every_method(|registry, label, case, compressed| {
        let bytes = prt::to_bytes(compressed, &Quiet).unwrap();
        // Large files take as long for one damage as small ones for many.
        let times = if bytes.len() > 1 << 14 { 6 } else { 64 };
        for length in (0..bytes.len()).step_by(1 + bytes.len() / times) {
            assert!(prt::from_bytes(&bytes[..length], registry).is_err(), "{label} on {}: cut at {length}", case.name);
        }
        for _ in 0..times {
            let mut damaged = bytes.clone();
            flip_bit(&mut damaged, &mut rng);
            let outcome = catch_unwind(AssertUnwindSafe(|| prt::from_bytes(&damaged, registry)));
            // A bit that the decompressor ignores may flip; the content is behind a checksum.
            if let Ok(accepted) = outcome.unwrap_or_else(|_| panic!("{label} on {}: panicked", case.name)) {
                assert_eq!(accepted.header(), compressed.header(), "{label} on {}", case.name);
                let sections = accepted.sections().into_sections();
                assert!(sections == compressed.sections().into_sections(), "{label} on {}: damage passed", case.name);
            }
        }
    });
}

#[test]
fn damaged_sections_behind_a_valid_checksum_never_panic() {
    let mut rng = random(5);
    for_every_method(|registry, label, case, compressed| {
        let sections = compressed.sections().into_sections();
        for _ in 0..if case.matrix.rows() > 1000 { 6 } else { 48 } {
            let mut damaged = sections.clone();
            if damaged.is_empty() {
                break;
            }
            let at = rng.random_range(0..damaged.len());
            match rng.random_range(0..4) {
                0 => damaged[at].bytes.truncate(rng.random_range(0..=sections[at].bytes.len())),
                1 => damaged[at].bytes.extend_from_slice(&[0xff; 8]),
                2 => drop(damaged.remove(at)),
                _ => (0..rng.random_range(1..8)).for_each(|_| flip_bit(&mut damaged[at].bytes, &mut rng)),
            }
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                if let Ok(accepted) = registry.restore(&compressed.header(), damaged) {
                    use_all(&accepted);
                }
            }));
            assert!(outcome.is_ok(), "{label} on {}: panicked on damaged sections", case.name);
        }
    });
}
