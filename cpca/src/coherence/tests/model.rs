use super::super::{Overdraw, optimise, overdraw, recluster, squared_error, supercluster_of_samples};
use super::grid;
use crate::model::{Cluster, Model};
use proptest::prelude::*;
use prt_transfer::{LightBasis, TransferMatrix};

const RESPONSES: usize = 2;
const LIGHTS: usize = 5;
const N: usize = RESPONSES * LIGHTS;

/// Numbers from -1 to 1 that look random.
fn noise(seed: u64, i: usize) -> f32 {
    let mixed = (seed << 32 | i as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 40) as f32 / (1u32 << 23) as f32 - 1.0
}

/// Samples that follow three smooth functions of their place, a third of their values 0.
fn values(samples: usize, seed: u64) -> Vec<f32> {
    let value = |i: usize| {
        let (sample, k) = (i / N, i % N);
        let smooth = (sample as f32 * 0.37 + k as f32).sin() + noise(seed, k) * (sample as f32 * 0.11).cos();
        if (sample + k).is_multiple_of(3) { 0.0 } else { smooth + 0.1 * noise(seed, i) }
    };
    (0..samples * N).map(value).collect()
}

fn dense(values: &[f32]) -> TransferMatrix {
    let basis = LightBasis::Plain { lights: LIGHTS };
    TransferMatrix::from_dense(values.to_vec(), values.len() / LIGHTS, RESPONSES, basis).unwrap()
}

fn sparse(values: &[f32]) -> TransferMatrix {
    let (mut offsets, mut columns, mut kept) = (vec![0], Vec::new(), Vec::new());
    for row in values.chunks_exact(LIGHTS) {
        for (column, &value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            columns.push(column as u32);
            kept.push(value);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, kept, RESPONSES, LightBasis::Plain { lights: LIGHTS }).unwrap()
}

/// Clusters at random places, as many components as `components` says; they are orthonormal or as they come.
fn model(matrix: &TransferMatrix, components: &[usize], orthonormal: bool, seed: u64) -> Model {
    let values = matrix.as_dense().unwrap();
    let cluster = |(i, &count): (usize, &usize)| {
        let mean = values[(i * 7 % matrix.shape().samples) * N..][..N].to_vec();
        let mut vectors: Vec<Vec<f32>> = Vec::new();
        for j in 0..count {
            let mut vector: Vec<f32> = (0..N).map(|k| noise(seed + 1, (i * 8 + j) * N + k)).collect();
            if orthonormal {
                for before in &vectors {
                    let along: f32 = vector.iter().zip(before).map(|(a, b)| a * b).sum();
                    vector.iter_mut().zip(before).for_each(|(v, b)| *v -= along * b);
                }
                let norm = vector.iter().map(|v| v * v).sum::<f32>().sqrt();
                vector.iter_mut().for_each(|v| *v /= norm);
            }
            vectors.push(vector);
        }
        Cluster { mean, components: vectors.concat() }
    };
    let clusters: Vec<Cluster> = components.iter().enumerate().map(cluster).collect();
    let samples = matrix.shape().samples;
    let members: Vec<u32> =
        (0..samples).map(|s| ((s / 3) as u32 + u32::from(noise(seed, s) > 0.6)) % clusters.len() as u32).collect();
    let count = members.iter().map(|&m| components[m as usize]).sum();
    let weights = (0..count).map(|i| 0.3 * noise(seed + 2, i)).collect();
    Model { shape: matrix.shape(), clusters, members, weights }
}

/// What a model makes of a sample: its weights, and what is left of it beside `values`.
fn residuals(model: &Model, values: &[f32]) -> Vec<(Vec<f32>, Vec<f64>)> {
    let mut weights = model.weights.iter();
    let sample = |(&member, x): (&u32, &[f32])| {
        let cluster = &model.clusters[member as usize];
        let own: Vec<f32> = weights.by_ref().take(cluster.components.len() / N).copied().collect();
        let decoded = |k: usize| {
            let vectors = cluster.components.chunks_exact(N).zip(&own);
            f64::from(cluster.mean[k]) + vectors.map(|(c, &w)| f64::from(w) * f64::from(c[k])).sum::<f64>()
        };
        (own.clone(), (0..N).map(|k| f64::from(x[k]) - decoded(k)).collect())
    };
    model.members.iter().zip(values.chunks_exact(N)).map(sample).collect()
}

fn decoded_error(model: &Model, values: &[f32]) -> f64 {
    residuals(model, values).iter().flat_map(|(_, residual)| residual).map(|r| r * r).sum()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
}

proptest! {
    #[test]
    fn a_report_says_what_decoding_says_and_the_budget_is_kept(
        seed in 0..1000u64,
        components in prop::collection::vec(0..4usize, 1..7),
        orthonormal: bool,
        budget in prop_oneof![Just(0.0), 0.0..0.5f64],
    ) {
        let (values, triangles) = (values(30, seed), grid(6, 5, |cell| cell % 2 == 0));
        let matrix = dense(&values);
        let before = model(&matrix, &components, orthonormal, seed);
        let (after, report) = recluster(&before, &matrix, &triangles, budget).unwrap();
        prop_assert!(close(report.initial_error, decoded_error(&before, &values)));
        prop_assert!(close(report.final_error, decoded_error(&after, &values)));
        prop_assert_eq!(squared_error(&after, &matrix).unwrap(), report.final_error);
        let bound = (1.0 + budget) * decoded_error(&before, &values);
        prop_assert!(decoded_error(&after, &values) <= bound * (1.0 + 1e-12));
        prop_assert_eq!(report.original, overdraw(&triangles, &before.members).unwrap());
        prop_assert_eq!(report.reclassified, overdraw(&triangles, &after.members).unwrap());
        prop_assert!(report.reclassified.total <= report.original.total);
    }

    #[test]
    fn samples_that_move_get_the_best_weights_and_the_others_keep_theirs(seed in 0..1000u64, orthonormal: bool) {
        let (values, triangles) = (values(30, seed), grid(6, 5, |cell| cell % 2 == 0));
        let matrix = dense(&values);
        let before = model(&matrix, &[2, 0, 3, 1], orthonormal, seed);
        let (after, report) = recluster(&before, &matrix, &triangles, 0.3).unwrap();
        let mut moved = 0;
        let pairs = residuals(&before, &values).into_iter().zip(residuals(&after, &values));
        for (sample, ((weights_before, _), (weights, residual))) in pairs.enumerate() {
            let [from, to] = [&before, &after].map(|m| &m.clusters[m.members[sample] as usize]);
            if from == to {
                prop_assert_eq!(weights_before, weights);
                continue;
            }
            moved += 1;
            // Least squares leaves nothing along any component, but for the rounding of weights.
            for component in to.components.chunks_exact(N) {
                let along: f64 = component.iter().zip(&residual).map(|(&c, r)| f64::from(c) * r).sum();
                let scale: f64 = weights.iter().map(|w| f64::from(w.abs())).sum();
                prop_assert!(along.abs() <= 1e-6 * scale, "{along:e} of {scale:e}");
            }
        }
        prop_assert_eq!(moved, report.moved);
        prop_assert!(moved > 0);
    }

    #[test]
    fn a_sparse_matrix_gives_what_a_dense_one_gives(seed in 0..1000u64) {
        let (values, triangles) = (values(30, seed), grid(6, 5, |_| true));
        let matrix = dense(&values);
        let before = model(&matrix, &[1, 2, 3], true, seed);
        let found = optimise(&before, &matrix, &triangles, 0.1, 2).unwrap();
        prop_assert_eq!(optimise(&before, &sparse(&values), &triangles, 0.1, 2).unwrap(), found);
    }

    #[test]
    fn the_entries_of_the_table_are_those_of_its_parts(seed in 0..1000u64, members in 1..4usize) {
        let (values, triangles) = (values(30, seed), grid(6, 5, |_| true));
        let matrix = dense(&values);
        let before = model(&matrix, &[1; 6], true, seed);
        let found = optimise(&before, &matrix, &triangles, 0.2, members).unwrap();
        let (model, report) = recluster(&before, &matrix, &triangles, 0.2).unwrap();
        prop_assert_eq!((&found.model, found.report), (&model, report));
        prop_assert_eq!(found.superclusters.len(), model.clusters.len());
        let of_samples = supercluster_of_samples(&model.members, &found.superclusters).unwrap();
        prop_assert_eq!(found.both, overdraw(&triangles, &of_samples).unwrap());
        let smaller = |a: Overdraw, b: Overdraw| a.total <= b.total;
        prop_assert!(smaller(found.both, report.reclassified) && smaller(found.superclustered, report.original));
        if members == 1 {
            prop_assert_eq!((found.both, found.superclustered), (report.reclassified, report.original));
        }
    }
}

/// All samples alike, but for sample 4 with a cluster of its own.
fn alike() -> (Model, TransferMatrix, Vec<[u32; 3]>) {
    let matrix = dense(&[0.5; 9 * N]);
    let cluster = |mean: f32| Cluster { mean: vec![mean; N], components: Vec::new() };
    let clusters = vec![cluster(9.0), cluster(0.5), cluster(0.25)];
    let members = vec![2, 2, 2, 2, 1, 2, 2, 2, 2];
    (Model { shape: matrix.shape(), clusters, members, weights: Vec::new() }, matrix, grid(3, 3, |_| true))
}

#[test]
fn clusters_without_a_member_are_dropped_and_the_others_renumbered() {
    let (before, matrix, triangles) = alike();
    // A free move for sample 4's neighbours: its cluster is exact, and takes all.
    let (after, report) = recluster(&before, &matrix, &triangles, 0.0).unwrap();
    assert_eq!((after.members.as_slice(), &after.clusters[..]), (&[0; 9][..], &before.clusters[1..2]));
    assert_eq!((report.moved, report.dropped, report.final_error, report.increase()), (8, 2, 0.0, -1.0));
    assert_eq!(report.reclassified.factor(), 1.0);
    // And a model without error has no budget, but keeps what it has.
    let (again, report) = recluster(&after, &matrix, &triangles, 0.5).unwrap();
    assert_eq!((again, report.increase(), report.dropped), (after, 0.0, 0));
}

#[test]
fn components_that_depend_on_others_do_no_harm() {
    let (mut before, matrix, triangles) = alike();
    let along: Vec<f32> = (0..N).map(|k| 0.5 + k as f32).collect();
    before.clusters[1].components = [along.clone(), vec![0.0; N], along.clone(), along].concat();
    before.clusters[1].mean = vec![0.375; N];
    before.weights = vec![0.0; 4];
    let (after, report) = recluster(&before, &matrix, &triangles, 0.0).unwrap();
    assert!(report.final_error < report.initial_error && report.moved > 0);
    assert!(after.weights.iter().all(|w| w.is_finite()));
}

#[test]
fn no_samples_are_no_failure() {
    let matrix = dense(&[]);
    let before = Model { shape: matrix.shape(), clusters: Vec::new(), members: Vec::new(), weights: Vec::new() };
    let found = optimise(&before, &matrix, &[], 0.05, 4).unwrap();
    assert_eq!((found.model, found.both.factor(), found.report.increase()), (before, 1.0, 0.0));
}

#[test]
fn a_model_of_another_matrix_is_refused_with_both_numbers() {
    let refused = |change: fn(&mut Model), budget: f64, words: &[&str]| {
        let (mut model, matrix, triangles) = alike();
        change(&mut model);
        let error = recluster(&model, &matrix, &triangles, budget).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    refused(|m| m.shape.samples = 8, 0.1, &["samples", "9", "8"]);
    refused(|m| m.shape.responses = 1, 0.1, &["responses", "2", "1"]);
    refused(|m| m.shape.lights = 6, 0.1, &["lights", "5", "6"]);
    refused(|m| m.members[3] = 3, 0.1, &["cluster of sample 3", "below 3", "found 3"]);
    refused(|m| m.members.truncate(7), 0.1, &["cluster numbers", "9", "7"]);
    refused(|m| m.clusters[2].mean.truncate(4), 0.1, &["mean of cluster 2", "10", "4"]);
    refused(|m| m.clusters[2].components.push(1.0), 0.1, &["components of cluster 2", "0", "1"]);
    refused(|m| m.weights.push(1.0), 0.1, &["weights", "0", "1"]);
    refused(|m| m.clusters[2].mean[0] = f32::NAN, 0.1, &["squared error of the model", "NaN"]);
    refused(|_| (), -0.1, &["error budget", "-0.1"]);
    refused(|_| (), f64::NAN, &["error budget", "NaN"]);
    let (model, matrix, _) = alike();
    assert!(recluster(&model, &matrix, &[[0, 1, 9]], 0.1).unwrap_err().to_string().contains("triangle 0"));
    assert!(optimise(&model, &matrix, &[[0, 1, 8]], 0.1, 0).is_err());
}
