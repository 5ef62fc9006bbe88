//! Relighting by the exact codecs and `f16`, beside the memory traffic of as many bytes. How to read it: the crate's page.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use ndarray::Array2;
use prt_benches::{LIGHTS, ROWS, synthetic};
use prt_bicluster::Bicluster;
use prt_transfer::compact::Compact;
use prt_transfer::csr::Csr;
use prt_transfer::dense::Dense;
use prt_transfer::f16::F16;
use prt_transfer::runs::Runs;
use prt_transfer::{Codec, Encoded, LightBasis, Quiet, Sink, TransferMatrix};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use std::time::Duration;

/// Rows of the dense matrices: 151 MB, far beyond the caches.
const DENSE_ROWS: usize = 6144;

type Group<'a> = BenchmarkGroup<'a, WallTime>;

fn encode<C: Codec>(matrix: &TransferMatrix) -> Box<dyn Encoded> {
    let codec = C::new(C::Params::default()).expect("defaults are valid");
    Box::new(codec.encode(matrix, &Quiet).expect("a valid matrix"))
}

fn bytes(encoded: &dyn Encoded) -> usize {
    let mut sink = Sink::new();
    encoded.hold(&mut sink);
    sink.resident_bytes()
}

/// A name, what a relighting works on, and how many of its elements are stored.
type Candidate = (&'static str, Box<dyn Encoded>, usize);

fn sparse() -> Vec<Candidate> {
    let whole = synthetic(ROWS, LIGHTS).expect("lights are enough");
    let near = synthetic(ROWS, 512).expect("lights are enough");
    let short = synthetic(8000, LIGHTS).expect("lights are enough");
    vec![
        ("csr", encode::<Csr>(&whole), whole.non_zeros()),
        ("compact", encode::<Compact>(&whole), whole.non_zeros()),
        ("runs", encode::<Runs>(&whole), whole.non_zeros()),
        ("bicluster", encode::<Bicluster>(&whole), whole.non_zeros()),
        ("f16", encode::<F16>(&whole), whole.non_zeros()),
        ("csr, light in 2 KiB", encode::<Csr>(&near), near.non_zeros()),
        ("csr, in cache", encode::<Csr>(&short), short.non_zeros()),
    ]
}

fn full() -> Vec<Candidate> {
    let cells = DENSE_ROWS * LIGHTS;
    let values = (0..cells).map(|i| (i as f32).sin()).collect();
    let matrix =
        TransferMatrix::from_dense(values, DENSE_ROWS, 1, LightBasis::Plain { lights: LIGHTS }).expect("finite");
    vec![("dense", encode::<Dense>(&matrix), cells), ("dense f16", encode::<F16>(&matrix), cells)]
}

/// Copies and reads as many bytes as the first candidate's relighting, which is the one to compare with.
fn traffic(group: &mut Group, (name, encoded, _): &Candidate, channels: usize, threads: usize, pool: &ThreadPool) {
    let moved = bytes(&**encoded) + encoded.shape().rows() * channels * size_of::<f32>();
    let source = vec![1u64; moved / 8];
    let mut target = vec![0u64; source.len() / 2];
    let half = &source[..target.len()];
    let part = target.len().div_ceil(threads);
    group.throughput(Throughput::Bytes(moved as u64));
    // The loop runs within the pool: waking a thread takes longer than some of the work.
    group.bench_function(format!("copy/{name} bytes/{threads}"), |b| {
        pool.install(|| {
            b.iter(|| {
                let work = target.par_chunks_mut(part).zip(half.par_chunks(part));
                work.for_each(|(to, from)| to.copy_from_slice(from));
                black_box(&mut target);
            })
        });
    });
    group.bench_function(format!("read/{name} bytes/{threads}"), |b| {
        // Integers, since the order of a floating-point sum forbids vectors.
        let read = || source.par_chunks(2 * part).map(|c| c.iter().fold(0, |s, v| s ^ v)).sum::<u64>();
        pool.install(|| b.iter(read));
    });
}

fn relight(
    group: &mut Group,
    (name, encoded, elements): &Candidate,
    channels: usize,
    threads: usize,
    pool: &ThreadPool,
) {
    let shape = encoded.shape();
    let lights = Array2::from_shape_fn((shape.lights, channels), |(k, c)| ((k + c) % 97) as f32 / 97.0);
    let mut out = Array2::zeros((shape.rows(), channels));
    let held = (bytes(&**encoded) + out.len() * size_of::<f32>()) as u64;
    group.throughput(Throughput::ElementsAndBytes { elements: *elements as u64, bytes: held });
    group.bench_function(format!("{name}/{threads}"), |b| {
        pool.install(|| b.iter(|| encoded.apply_into(lights.view(), out.view_mut()).expect("sizes fit")));
    });
}

fn benchmarks(c: &mut Criterion) {
    let pools = [1, 2].map(|n| (n, ThreadPoolBuilder::new().num_threads(n).build().expect("threads")));
    for candidates in [sparse(), full()] {
        for (channels, name) in [(1, "one_channel"), (3, "three_channels")] {
            let mut group = c.benchmark_group(name);
            group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1)).sample_size(30);
            for (threads, pool) in &pools {
                traffic(&mut group, &candidates[0], channels, *threads, pool);
                candidates.iter().for_each(|candidate| relight(&mut group, candidate, channels, *threads, pool));
            }
            group.finish();
        }
    }
}

criterion_group!(benches, benchmarks);
criterion_main!(benches);
