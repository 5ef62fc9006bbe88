//! What a compressed light field promises.

mod common;

use common::*;
use ndarray::Array2;
use prt_slf::{Clusters, Colour, EncodedSlf, Maps, Mode, Norm, Slf, SlfParams, Solver, Sphere, Width};
use prt_transfer::io::prt;
use prt_transfer::texels::{Border, Texels};
use prt_transfer::transform::Identity;
use prt_transfer::{
    Codec, Configure, Encoded, Label, LightBasis, Params, Quiet, Registry, Restore, Sink, Source, TransferMatrix,
    linalg,
};

const COLOURS: [Colour; 3] = [Colour::Shared, Colour::Separate, Colour::Joint];

fn with(clusters: usize, components: usize, colour: Colour) -> SlfParams {
    SlfParams { clusters: Clusters::Number(clusters), components, colour, ..Default::default() }
}

fn bytes(encoded: &EncodedSlf, section: &str) -> u64 {
    let mut sink = Sink::new();
    encoded.write(&mut sink);
    sink.sizes().find(|(name, _)| *name == section).map_or(0, |(_, bytes)| bytes as u64)
}

#[test]
fn sections_hold_the_numbers_of_equation_5() {
    let matrix = smooth();
    let [m, zeta, n] = [TEXELS.count() as u64, 3, SPHERE.count() as u64];
    for colour in COLOURS {
        let encoded = encoded(with(5, 3, colour), &matrix);
        let (counts, eta, k) = (encoded.counts(), encoded.clusters() as u64, encoded.components() as u64);
        assert_eq!((eta, k), (5, 3));
        let own = if colour == Colour::Joint { 1 } else { zeta };
        let ids = if colour == Colour::Separate { zeta * m } else { m };
        assert_eq!([counts.surface, counts.mean, counts.ids], [own * m * k, zeta * m, ids]);
        assert_eq!(counts.views, eta * zeta * n * k, "{colour:?}");
        assert_eq!(bytes(&encoded, "weights/surface"), 4 * counts.surface);
        assert_eq!(bytes(&encoded, "basis/views"), 4 * counts.views);
        assert_eq!(bytes(&encoded, "weights/mean"), 4 * counts.mean);
        // Five clusters take three bits.
        assert_eq!(bytes(&encoded, "index/clusters"), (3 * counts.ids).div_ceil(8));
        let ratio = (zeta * m * n) as f64 / (own * m * k + eta * zeta * n * k + zeta * m + ids) as f64;
        assert_eq!(encoded.ratio(), ratio);
    }
}

#[test]
fn with_as_many_components_as_the_rank_or_a_cluster_for_each_texel_nothing_is_lost() {
    let matrix = noise(20, 3, 14);
    for colour in COLOURS {
        for (clusters, components) in [(1, 42), (4, 42), (20, 1)] {
            let encoded = encoded(with(clusters, components, colour), &matrix);
            let (error, whole) = error(&encoded, &matrix, None);
            assert!(error <= 1e-12 * whole, "{clusters} {components} {colour:?}: {error:e} of {whole}");
        }
    }
    // One cluster loses what its rank has no components for.
    let (error, whole) = error(&encoded(with(1, 2, Colour::Shared), &matrix), &matrix, None);
    assert!(error > 1e-2 * whole);
}

/// Rows of texels of one cluster in one channel less their means.
fn residuals(matrix: &TransferMatrix, encoded: &EncodedSlf, cluster: usize, channel: usize) -> Array2<f64> {
    let (values, shape) = (matrix.as_dense().unwrap(), matrix.shape());
    let members = (0..shape.samples).filter(|&t| encoded.cluster_of(t, channel) == cluster);
    let rows: Vec<f64> = members
        .flat_map(|t| {
            let row = &values[(t * shape.responses + channel) * shape.lights..][..shape.lights];
            let mean = row.iter().map(|v| f64::from(*v)).sum::<f64>() / row.len() as f64;
            row.iter().map(move |v| f64::from(*v) - mean).collect::<Vec<_>>()
        })
        .collect();
    Array2::from_shape_vec((rows.len() / shape.lights, shape.lights), rows).unwrap()
}

#[test]
fn the_error_is_the_tail_energy_of_the_spectra_as_equation_4_says() {
    for matrix in [smooth(), noise(60, 3, 14)] {
        for colour in [Colour::Shared, Colour::Separate] {
            for (clusters, components) in [(1, 3), (6, 2), (6, 0)] {
                let encoded = encoded(with(clusters, components, colour), &matrix);
                let mut tails = 0.0;
                for (cluster, channel) in (0..encoded.clusters()).flat_map(|c| (0..3).map(move |r| (c, r))) {
                    let rows = residuals(&matrix, &encoded, cluster, channel);
                    let squares = linalg::singular(rows.view()).unwrap().values.into_iter().map(|s| s * s);
                    tails += squares.skip(components).sum::<f64>();
                }
                let (error, whole) = error(&encoded, &matrix, None);
                assert!((error - tails).abs() <= 1e-5 * tails + 1e-12 * whole, "{clusters}: {error} {tails}");
            }
        }
    }
}

#[test]
fn elements_are_those_of_rows_and_of_unit_lights_in_every_width() {
    let matrix = smooth();
    for colour in COLOURS {
        for (surface, views) in
            [(Width::F32, Width::F32), (Width::I16, Width::F16), (Width::F32, Width::I16), (Width::F16, Width::F32)]
        {
            let encoded = encoded(SlfParams { surface, views, ..with(4, 3, colour) }, &matrix);
            let (decoded, n) = (rows(&encoded), SPHERE.count());
            let mut relit = Array2::zeros((matrix.rows(), n));
            encoded.apply_into(Array2::eye(n).view(), relit.view_mut()).unwrap();
            for (row, direction) in (0..matrix.rows()).flat_map(|row| (0..n).map(move |d| (row, d))) {
                let element = encoded.element(row / 3, row % 3, direction);
                assert_eq!(element, decoded[row * n + direction]);
                assert!((element - relit[[row, direction]]).abs() < 1e-5);
            }
            let (error, whole) = error(&encoded, &matrix, None);
            assert!(error < 1e-2 * whole);
        }
    }
}

#[test]
fn many_texels_are_relit_as_their_rows_are_into_any_output() {
    // More than the texels of two tasks, the last one not full.
    let matrix = noise(1300, 3, 9);
    for colour in COLOURS {
        let encoded = encoded(with(4, 3, colour), &matrix);
        let decoded = Array2::from_shape_vec((matrix.rows(), 9), rows(&encoded)).unwrap();
        let lights = Array2::from_shape_fn((9, 2), |(d, c)| 0.5 + (d * 7 + c * 3) as f32 / 64.0);
        let (mut relit, mut gaps) = (Array2::zeros((matrix.rows(), 2)), Array2::zeros((matrix.rows(), 4)));
        encoded.apply_into(lights.view(), relit.view_mut()).unwrap();
        encoded.apply_into(lights.view(), gaps.slice_mut(ndarray::s![.., ..;2])).unwrap();
        assert_eq!(gaps.slice(ndarray::s![.., ..;2]), relit);
        let expected = decoded.dot(&lights);
        assert!((&relit - &expected).iter().all(|d| d.abs() < 1e-5), "{colour:?}");
    }
}

#[test]
fn equal_channels_make_shared_separate_and_joint_clusters_the_same() {
    let grey = field(TEXELS, SPHERE, |uv, d, _| glossy(uv, d, 1));
    let decoded = COLOURS.map(|colour| rows(&encoded(with(5, 3, colour), &grey)));
    for other in &decoded[1..] {
        assert!(decoded[0].iter().zip(other).all(|(a, b)| (a - b).abs() < 2e-5));
    }
    // One response is one channel, whatever is shared.
    let noise = noise(40, 1, 12);
    let single = COLOURS.map(|colour| rows(&encoded(with(5, 3, colour), &noise)));
    assert!(single[0] == single[1] && single[0] == single[2]);
}

/// Σ w (F - μ - projection)² is least for the singular vectors of the weighted residuals: nothing else of the same size does better.
#[test]
fn error_over_the_sphere_is_least_where_directions_count_as_their_solid_angles() {
    let matrix = smooth();
    let weights = matrix.responses().light_weights(matrix.basis()).unwrap();
    for colour in COLOURS {
        for components in [0, 1, 4] {
            let fitted = |norm| encoded(SlfParams { norm, ..with(1, components, colour) }, &matrix);
            let (plain, weighted) = (fitted(Norm::Coefficients), fitted(Norm::Radiance));
            let over = |encoded: &EncodedSlf, weights| error(encoded, &matrix, weights).0;
            assert!(over(&weighted, Some(&weights)) < over(&plain, Some(&weights)), "{components} {colour:?}");
            assert!(over(&plain, None) < over(&weighted, None), "{components} {colour:?}");
        }
    }
}

#[test]
fn a_bound_is_kept_with_no_component_to_spare() {
    let matrix = smooth();
    let weights = matrix.responses().light_weights(matrix.basis()).unwrap();
    for (colour, norm) in COLOURS.into_iter().flat_map(|c| [Norm::Coefficients, Norm::Radiance].map(|n| (c, n))) {
        let weights = (norm == Norm::Radiance).then_some(&weights[..]);
        for (clusters, mode) in
            [(Clusters::Number(5), Mode::Static), (Clusters::Auto, Mode::Static), (Clusters::Auto, Mode::Iterative)]
        {
            for (bound, width) in [(1e-2, Width::I16), (1e-4, Width::F32), (1e-4, Width::I16)] {
                let params = SlfParams {
                    clusters,
                    colour,
                    norm,
                    mode,
                    surface: width,
                    views: width,
                    max_error: Some(bound),
                    ..Default::default()
                };
                let found = encoded(params.clone(), &matrix);
                let (left, whole) = error(&found, &matrix, weights);
                assert!(left <= bound * whole, "{colour:?} {clusters:?} {bound}: {left} of {whole}");
                if mode == Mode::Static && width == Width::F32 {
                    let given = Clusters::Number(found.clusters());
                    let fewer =
                        SlfParams { clusters: given, components: found.components() - 1, max_error: None, ..params };
                    let (left, whole) = error(&encoded(fewer, &matrix), &matrix, weights);
                    assert!(left > bound * whole, "{colour:?} {clusters:?} {bound}: one component less would do");
                }
            }
        }
    }
}

#[test]
fn the_number_of_clusters_that_is_found_takes_fewest_bytes_among_its_neighbours() {
    let matrix = smooth();
    let params = |clusters| SlfParams { clusters, max_error: Some(1e-4), ..Default::default() };
    let size = |encoded: &EncodedSlf| {
        ["weights/surface", "basis/views", "weights/mean", "index/clusters"]
            .map(|s| bytes(encoded, s))
            .iter()
            .sum::<u64>()
    };
    let found = encoded(params(Clusters::Auto), &matrix);
    for clusters in [1, 2, 4, 8] {
        let other = encoded(params(Clusters::Number(clusters)), &matrix);
        assert!(size(&found) <= size(&other), "{} {clusters}", found.clusters());
    }
}

#[test]
fn a_matte_wall_has_its_mean_map_alone() {
    let matte = field(TEXELS, SPHERE, |[u, v], _, channel| 0.2 + u * v + channel as f64);
    let params = SlfParams { clusters: Clusters::Auto, max_error: Some(1e-3), ..Default::default() };
    let found = encoded(params, &matte);
    assert_eq!((found.components(), found.clusters()), (0, 1));
    let counts = found.counts();
    assert_eq!([counts.surface, counts.views, counts.mean], [0, 0, 3 * TEXELS.count() as u64]);
    // Without a bound too: residuals of 0 have no components.
    assert_eq!(encoded(with(8, 4, Colour::Shared), &matte).components(), 0);
}

#[test]
fn a_bound_that_narrow_numbers_cannot_keep_is_refused_with_what_they_can() {
    let params = SlfParams { views: Width::I16, surface: Width::I16, max_error: Some(1e-13), ..Default::default() };
    let told = Slf::new(params).unwrap().encode(&smooth(), &Quiet).unwrap_err().to_string();
    assert!(told.contains("max_error=0.0000000000001 must be at least"), "{told}");
}

#[test]
fn more_rows_than_directions_have_the_vectors_that_a_decomposition_gives() {
    // 1200 texels in 130 directions with spectra that fall slowly: the Gram matrix, iterated, in place of all rows.
    let matrix = noise(1200, 1, 130);
    let both = [Solver::Auto, Solver::Svd].map(|solver| {
        let encoded = encoded(SlfParams { solver, ..with(1, 1, Colour::Shared) }, &matrix);
        error(&encoded, &matrix, None).0
    });
    assert!((both[0] / both[1] - 1.0).abs() < 1e-6, "{both:?}");
}

fn haar(params: SlfParams) -> SlfParams {
    SlfParams { maps: Maps::Haar, ..params }
}

/// What a file takes after zstd: the `.prt` bytes.
fn file(params: SlfParams, matrix: &TransferMatrix) -> usize {
    let registry = Registry::new().transform::<Identity>().codec::<Slf>();
    let label = Label { transform: "identity".parse::<Label>().unwrap().codec, codec: params.to_stage() };
    prt::to_bytes(&registry.method(&label).unwrap().encode(matrix, &Quiet).unwrap(), &Quiet).unwrap().len()
}

#[test]
fn rounded_images_add_the_error_that_they_may_and_no_more() {
    let matrix = smooth();
    for colour in COLOURS {
        for noise in [0.02, 0.3] {
            let params = with(3, 2, colour);
            let (plain, whole) = error(&encoded(params.clone(), &matrix), &matrix, None);
            let rounded = error(&encoded(SlfParams { noise, ..haar(params) }, &matrix), &matrix, None).0;
            // Errors of weights and of components meet: a little more or less than allowed for each alone.
            let added = (rounded - plain) / plain;
            assert!(added <= 1.25 * noise && added > 0.5 * noise, "{colour:?} {noise}: {added} of {whole}");
        }
    }
}

#[test]
fn rounded_images_of_smooth_fields_make_smaller_files_at_the_error_asked_for() {
    let texels = Texels { width: 32, height: 24, border: Border::Clamp };
    let matrix = field(texels, Sphere { z: 24, w: 15 }, glossy);
    let params = SlfParams { clusters: Clusters::Auto, max_error: Some(1e-4), ..Default::default() };
    let narrow = SlfParams { surface: Width::I16, views: Width::I16, ..params.clone() };
    let found = encoded(haar(params.clone()), &matrix);
    let (left, whole) = error(&found, &matrix, None);
    assert!(left <= 1e-4 * whole);
    let [plain, narrow, rounded] = [params.clone(), narrow, haar(params)].map(|params| file(params, &matrix));
    assert!(rounded * 4 < plain && rounded * 2 < narrow, "{plain} {narrow} {rounded}");
}

#[test]
fn rounded_images_come_back_from_a_file_to_the_bit() {
    for matrix in [smooth(), noise(20, 3, 14), noise(9, 1, 1), noise(0, 3, 5), noise(4, 3, 0)] {
        for colour in COLOURS {
            let first = encoded(haar(with(3, 2, colour)), &matrix);
            let mut sink = Sink::new();
            first.write(&mut sink);
            let sections = sink.into_sections();
            let again = EncodedSlf::read(first.shape(), &mut Source::new(sections.clone()).unwrap()).unwrap();
            assert_eq!(rows(&again), rows(&first));
            let mut sink = Sink::new();
            again.write(&mut sink);
            assert!(sink.into_sections() == sections);
        }
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let refused = |params: SlfParams| Slf::new(params).err().map(|e| e.to_string()).unwrap_or_default();
    let base = SlfParams::default;
    assert!(refused(SlfParams { components: 5000, ..base() }).contains("components=5000"));
    assert!(refused(SlfParams { clusters: Clusters::Number(0), ..base() }).contains("clusters=0"));
    assert!(refused(SlfParams { clusters: Clusters::Auto, ..base() }).contains("clusters=auto"));
    assert!(refused(SlfParams { sweeps: Some(0), ..base() }).contains("sweeps=0"));
    assert!(refused(SlfParams { max_error: Some(0.0), ..base() }).contains("max_error=0"));
    assert!(refused(SlfParams { noise: 2.0, ..base() }).contains("noise=2"));
    assert!(refused(SlfParams { views: Width::F16, ..haar(base()) }).contains("maps=haar"));
}

#[test]
fn clusters_by_subspace_find_the_lines_that_residuals_lie_on() {
    // Two lines through 0 on which texels lie near and far: means do not tell them apart, distances from lines do.
    let line = |which: usize, d: usize| ((d * (2 + 3 * which)) as f32 * 0.4).sin();
    let element = |t: usize, d: usize| ((t * 37 % 41) as f32 / 20.0 - 1.0 + 0.02) * line(t % 2, d);
    let values = (0..120 * 16).map(|i| element(i / 16, i % 16)).collect();
    let matrix = TransferMatrix::from_dense(values, 120, 1, LightBasis::Plain { lights: 16 }).unwrap();
    let [by_means, by_lines] = [Mode::Static, Mode::Iterative].map(|mode| {
        let encoded = encoded(SlfParams { mode, ..with(2, 1, Colour::Shared) }, &matrix);
        let (error, whole) = error(&encoded, &matrix, None);
        error / whole
    });
    assert!(by_lines < 1e-10 && by_means > 1e-2, "{by_means} {by_lines}");
}
