//! What the stored form promises, for every width, even and uneven ranks, with and without a view basis.

use ndarray::{Array2, s};
use prt_tensor::{Cluster, EncodedCta, Model, Storage};
use prt_transfer::random::Random;
use prt_transfer::{Encoded, Flops, Shape};

const STORAGES: [Storage; 4] = [Storage::F32, Storage::F16, Storage::I16, Storage::Coded];

/// A model whose numbers `number` makes: of clusters with such ranks of lights and samples, `memberships` of them for each sample.
fn model(
    shape: [usize; 3],
    views: Option<usize>,
    ranks: &[[usize; 2]],
    memberships: usize,
    mut number: impl FnMut() -> f32,
) -> Model {
    let shape = Shape::new(shape[0], shape[1], shape[2]).unwrap();
    let mut matrix = |size: [usize; 2]| Array2::from_shape_simple_fn(size, &mut number);
    let view = views.map(|views| matrix([shape.responses, views]));
    let of_views = views.unwrap_or(shape.responses);
    let clusters: Vec<Cluster> = ranks
        .iter()
        .map(|&[light, sample]| Cluster {
            light: matrix([light, shape.lights]),
            dual: matrix([sample, if sample > 0 { of_views * light } else { 0 }]),
        })
        .collect();
    // Each sample in clusters that follow each other.
    let members: Vec<u32> = (0..shape.samples * memberships)
        .map(|at| ((at / memberships * 5 + at % memberships) % ranks.len()) as u32)
        .collect();
    let weights = members.iter().flat_map(|&k| 0..ranks[k as usize][1]).map(|_| number()).collect();
    Model { shape, view, clusters, memberships, members, weights }
}

fn models() -> Vec<Model> {
    let (uneven, mut random) = ([[3, 2], [0, 0], [5, 9], [1, 4], [2, 0], [4, 1]], Random(7));
    let mut number = || random.normal() as f32;
    vec![
        // More samples than two tasks have, the last one not full.
        model([1100, 1, 10], None, &[[3, 2]; 4], 1, &mut number),
        model([1100, 3, 6], Some(2), &uneven, 2, &mut number),
        // The view basis meets columns where samples are many, samples where their ranks are.
        model([90, 4, 9], Some(3), &[[2, 2]; 2], 1, &mut number),
        model([90, 8, 9], Some(2), &[[2, 6]; 2], 1, &mut number),
        model([70, 2, 40], None, &uneven, 3, &mut number),
        model([65, 5, 7], Some(5), &uneven, 6, &mut number),
        model([6, 40, 3], Some(33), &[[2, 3], [1, 1]], 1, &mut number),
        // As many columns as samples: to them the view basis costs the same, and the columns are wider then.
        model([6, 40, 3], Some(33), &[[2, 2]; 3], 1, &mut number),
        model([1, 1, 1], None, &[[1, 1]], 1, &mut number),
        model([4, 2, 3], None, &[[0, 0]], 1, &mut number),
        model([3, 2, 0], None, &[[0, 0], [0, 0]], 1, &mut number),
    ]
}

/// Calls `check` with every model in every width.
fn each(check: impl Fn(&Model, Storage, &EncodedCta)) {
    for model in models() {
        STORAGES.into_iter().for_each(|storage| check(&model, storage, &EncodedCta::store(&model, storage, 1e-6)));
    }
}

/// Rows of the model by its definition, and as they would be if no number had a sign.
fn rows(model: &Model) -> [Array2<f64>; 2] {
    let (shape, views) = (model.shape, model.views());
    [false, true].map(|unsigned| {
        let number = |v: f32| if unsigned { f64::from(v).abs() } else { f64::from(v) };
        let view = model.view.as_ref().map_or(Array2::eye(views), |view| view.mapv(number));
        let mut rows = Array2::zeros((shape.rows(), shape.lights));
        let mut weights = model.weights.iter().map(|w| number(*w));
        for (at, &member) in model.members.iter().enumerate() {
            let Cluster { light, dual } = &model.clusters[member as usize];
            let mut core = Array2::<f64>::zeros((views, light.nrows()));
            for (row, weight) in dual.outer_iter().zip(weights.by_ref()) {
                let row = row.mapv(number).into_shape_with_order(core.dim()).unwrap();
                core.scaled_add(weight, &row);
            }
            let first = at / model.memberships * shape.responses;
            let mut own = rows.slice_mut(s![first..first + shape.responses, ..]);
            own += &view.dot(&core).dot(&light.mapv(number));
        }
        rows
    })
}

#[test]
fn decoded_rows_are_those_of_the_definition_however_many_at_a_time() {
    each(|_, storage, encoded| {
        let ([expected, size], shape) = (rows(&encoded.model()), encoded.shape());
        for (first, count) in [(0, shape.rows()), (0, 1), (1, 2), (2, 3), (shape.rows().saturating_sub(5), 5)] {
            if first + count > shape.rows() {
                continue;
            }
            let mut out = Array2::from_elem((count, shape.lights), f32::NAN);
            encoded.rows_into(first, out.view_mut());
            for ((row, light), &y) in out.indexed_iter() {
                let at = [first + row, light];
                let error = (f64::from(y) - expected[at]).abs();
                assert!(error <= 2e-7 * size[at], "{shape:?} {storage:?} {at:?}: {y} for {}", expected[at]);
            }
        }
    });
}

#[test]
fn relighting_is_rows_times_light_for_any_channels_and_output() {
    each(|_, storage, encoded| {
        let ([rows, size], shape) = (rows(&encoded.model()), encoded.shape());
        for channels in [1, 3] {
            let lights = Array2::from_shape_fn((shape.lights, channels), |(l, c)| ((l * 7 + c * 3) % 11) as f32 - 4.0);
            let (expected, size) = (rows.dot(&lights.mapv(f64::from)), size.dot(&lights.mapv(|v| f64::from(v.abs()))));
            let mut out = Array2::from_elem((shape.rows(), channels), f32::NAN);
            let mut gaps = Array2::from_elem((shape.rows(), 2 * channels), f32::NAN);
            encoded.apply_into(lights.view(), out.view_mut()).unwrap();
            encoded.apply_into(lights.view(), gaps.slice_mut(s![.., ..;2])).unwrap();
            assert!(gaps.slice(s![.., ..;2]) == out, "{shape:?} {storage:?}");
            for (at, &y) in out.indexed_iter() {
                let error = (f64::from(y) - expected[at]).abs();
                assert!(error <= 2e-6 * size[at], "{shape:?} {storage:?} {at:?}: {y} for {}", expected[at]);
            }
        }
    });
}

/// Multiplications, and as many additions, of the documented formula; of those the ones by a weight and by a number of the view basis.
fn formula(model: &Model) -> (u64, [usize; 2]) {
    let (shape, views, weights) = (model.shape, model.views(), model.weights.len());
    let ranks = || model.clusters.iter().map(|c| [c.light.nrows(), c.dual.nrows()]);
    let bases: usize = ranks().map(|[light, sample]| light * (shape.lights + sample * views)).sum();
    let columns: usize = ranks().map(|[_, sample]| sample).sum();
    let after = [weights * views, shape.samples * shape.responses * views];
    let before = [weights * shape.responses, columns * views * shape.responses];
    let [after, before] = [after, before].map(|terms| (terms.iter().sum::<usize>(), terms));
    let (gathered, terms) = match model.view {
        None => (weights * views, [weights * views, 0]),
        Some(_) => after.min(before),
    };
    ((bases + gathered) as u64, terms)
}

#[test]
fn operations_are_those_of_the_formula() {
    each(|model, storage, encoded| {
        let (products, views) = (formula(model).0, model.views());
        let ranks = model.clusters.iter().map(|c| c.light.nrows() + c.dual.nrows() * (views + 1));
        let scales = if storage == Storage::F32 { 0 } else { ranks.sum::<usize>() as u64 };
        let Flops { multiplications, additions, .. } = encoded.flops(&vec![0.5; model.shape.lights]);
        assert_eq!([multiplications, additions], [products + scales, products], "{:?} {storage:?}", model.shape);
    });
}

#[test]
fn factors_of_one_are_known_to_be() {
    let ones = |numbers: &mut dyn Iterator<Item = &f32>| numbers.filter(|n| n.abs() == 1.0).count() as u64;
    // Each view basis one way and the other.
    for (shape, views, rank) in [([90, 3, 6], None, 2), ([90, 4, 9], Some(3), 2), ([90, 8, 9], Some(2), 6)] {
        for storage in [Storage::F32, Storage::F16] {
            let mut at = 0;
            let mut number = || {
                at += 1;
                [1.0, 0.5, -1.0, 0.0, 1.0, 0.25, 0.5][at % 7]
            };
            let mut model = model(shape, views, &[[2, rank]; 2], 1, &mut number);
            let narrow = storage == Storage::F16;
            if narrow {
                // Weights whose scale is 1: 2^14 times as large, but for those that are 1 as they are stored.
                let large = |(at, w): (usize, &mut f32)| {
                    if at / rank % 4 < 2 {
                        *w = 16384.0
                    }
                };
                model.weights.iter_mut().enumerate().for_each(large);
            }
            let bases = model.clusters.iter().flat_map(|c| c.light.iter().chain(&c.dual));
            let of_bases = ones(&mut bases.into_iter());
            let (of_weights, weights) = (ones(&mut model.weights.iter()), model.weights.len() as u64);
            let (_, [gathered, seen]) = formula(&model);
            let of_view =
                model.view.as_ref().map_or(0, |view| ones(&mut view.iter()) * seen as u64 / view.len() as u64);
            // Rows of bases have 1 as their largest magnitude, and then a scale of 1; so have their products with those of weights.
            let scales = 2 * (2 + rank * (model.views() + 1)) as u64;
            let expected =
                of_bases + of_weights * (gathered as u64 / weights) + of_view + if narrow { scales } else { 0 };
            let found = EncodedCta::store(&model, storage, 0.0).flops(&vec![0.5; model.shape.lights]).by_one;
            assert_eq!(found, expected, "{shape:?} {storage:?}");
            assert!(of_weights > 0 && of_bases > 0);
        }
    }
}
