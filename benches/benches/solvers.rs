//! Eigen-solvers of `prt-cpca`, eight components: on rows of several shapes, and on Gram matrices from a guess that is a little or
//! much off. On one thread.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use prt_benches::mix;
use prt_cpca::Solver;
use prt_cpca::solver::leading_of_gram;
use std::time::Duration;

const COMPONENTS: usize = 8;

/// Mean 0, from -2 to 2, the same on every machine.
fn noise(counter: usize) -> f64 {
    (0..4).map(|part| (mix((4 * counter + part) as u64) >> 11) as f64 / (1u64 << 53) as f64 - 0.5).sum()
}

/// Rows (m x n) whose singular values fall about as i^-decay.
fn rows(m: usize, n: usize, decay: f64) -> Array2<f64> {
    let rank = m.min(n);
    let weights = Array2::from_shape_fn((m, rank), |(i, j)| noise(i * rank + j) * ((j + 1) as f64).powf(-decay));
    let directions = Array2::from_shape_fn((rank, n), |(i, j)| noise(m * rank + i * n + j) / (n as f64).sqrt());
    weights.dot(&directions)
}

fn solvers(c: &mut Criterion) {
    for decay in [0.5, 1.0, 2.0] {
        for (m, n) in [(140, 25), (140, 155), (140, 600), (300, 300), (600, 600), (2000, 600)] {
            let mut group = c.benchmark_group(format!("{m}x{n}, i^-{decay}"));
            group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1)).sample_size(10);
            let f = rows(m, n, decay);
            for solver in [Solver::Power, Solver::Krylov, Solver::Gram, Solver::Svd, Solver::Auto] {
                let by = solver.solver();
                group.bench_function(format!("{solver:?}"), |b| b.iter(|| by.leading(f.view(), COMPONENTS, None)));
            }
            group.finish();
        }
    }
}

/// What iterative clustering does again and again: members have moved, the components of before are known.
fn guesses(c: &mut Criterion) {
    for n in [25, 64, 100, 155] {
        for components in [1, 2, 4, COMPONENTS] {
            let mut group = c.benchmark_group(format!("gram of {n}, {components} components"));
            group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1)).sample_size(10);
            let f = rows(140, n, 1.0);
            let gram = f.t().dot(&f);
            let before = leading_of_gram(gram.view(), components, None).expect("finite").vectors;
            group.bench_function("no guess", |b| b.iter(|| leading_of_gram(gram.view(), components, None)));
            for moved in [1e-3, 1e-2, 1e-1] {
                let f = Array2::from_shape_fn(f.dim(), |(i, j)| f[[i, j]] * (1.0 + moved * noise(i * n + j)));
                let gram = f.t().dot(&f);
                group.bench_function(BenchmarkId::new("moved by", moved), |b| {
                    b.iter(|| leading_of_gram(gram.view(), components, Some(before.view())))
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, solvers, guesses);
criterion_main!(benches);
