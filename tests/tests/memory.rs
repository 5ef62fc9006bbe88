//! Resident storage is what memory holds: counted by the allocator, not by a formula. Alone in its process, so that no other
//! test allocates meanwhile.

use prt_harness::memory::{Counting, held, peak_of};
use prt_harness::registry::families::{Kind, families};
use prt_harness::registry::registry;
use prt_harness::signal::{Signal, Spec};
use prt_harness::{compute, family};
use prt_tests::*;
use prt_transfer::io::prt;
use prt_transfer::{Extent, Footprint, LightBasis, Quiet, TransferMatrix, linalg};
use rand::RngExt;
use std::collections::HashSet;
use std::hint::black_box;
use std::sync::Mutex;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// One test at a time: what others allocate would be counted too.
static ALONE: Mutex<()> = Mutex::new(());

/// Waits for what threads have still to give back after the test before.
fn settle() {
    let mut before = usize::MAX;
    while before != held() {
        before = held();
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
}

#[test]
fn the_peak_counts_what_is_held_at_once_by_all_threads_and_not_what_is_held_before_or_in_turn() {
    let _alone = ALONE.lock();
    settle();
    const SIZE: usize = 1 << 20;
    let block = || black_box(vec![1u8; SIZE]);
    let before = block();
    let near = |peak: Option<u64>, blocks: usize| {
        let peak = peak.expect("the allocator counts") as usize;
        assert!((blocks * SIZE..blocks * SIZE + SIZE / 4).contains(&peak), "{peak}, expected {blocks} blocks");
    };
    near(peak_of(|| (0..5).for_each(|_| drop(block()))).1, 1);
    near(peak_of(|| [block(), block(), block()].len()).1, 3);
    near(peak_of(|| rayon::join(block, block)).1, 2);
    near(peak_of(|| drop(before)).1, 0);
    // A block that grows is itself, not itself and its copy.
    let grown = |mut bytes: Vec<u8>| {
        bytes.reserve_exact(2 * SIZE);
        black_box(bytes.capacity())
    };
    near(peak_of(|| grown(block())).1, 3);
    near(peak_of(|| black_box(vec![0u64; SIZE / 8]).len()).1, 1);
}

#[test]
fn memory_held_after_loading_is_the_resident_size() {
    let _alone = ALONE.lock();
    settle();
    let registry = registry();
    let basis = LightBasis::Cubemap { resolution: 16 };
    let mut rng = random(1);
    let element = |i: usize| if (i / 64).is_multiple_of(5) { rng.random_range(1..5) as f32 / 4.0 } else { 0.0 };
    let values: Vec<f32> = (0..400 * basis.lights()).map(element).collect();
    let dense = TransferMatrix::from_dense(values, 400, 1, basis).unwrap();
    for matrix in [sparse(&dense), dense] {
        for label in labels(&registry) {
            let bytes = prt::to_bytes(&encode(&registry, &label, &matrix).unwrap(), &Quiet).unwrap();
            drop(prt::from_bytes(&bytes, &registry).unwrap()); // whatever is made once per process exists now
            let before = held();
            let reloaded = prt::from_bytes(&bytes, &registry).unwrap();
            let held = (held() - before) as f64;
            let resident = reloaded.resident_bytes() as f64;
            // Labels, names and boxes come on top.
            assert!(held <= 1.02 * resident + 4096.0, "{label}: {held} bytes held, {resident} written");
            assert!(held >= 0.98 * resident - 4096.0, "{label}: {held} bytes held, {resident} written");
        }
    }
}

/// What a method says it takes is no less than what it takes, and seldom more than twice that.
#[test]
fn what_compressing_takes_is_known_before_within_a_factor_of_two() {
    let _alone = ALONE.lock();
    rayon::broadcast(|_| linalg::warm_up());
    linalg::warm_up();
    settle();
    let registry = registry();
    let scene = |signal, resolution, vertices| {
        let spec = Spec::new(signal, LightBasis::Cubemap { resolution });
        compute::precompute("teapot", Some(vertices), &spec, &Quiet).unwrap().matrix
    };
    let (diffuse, biscale) = (scene(Signal::Diffuse, 16, 1500), scene(Signal::Biscale, 32, 600));
    let (mut wrong, mut checked) = (Vec::new(), HashSet::new());
    let of_codecs = registry.codecs().into_iter().map(|codec| codec.name.to_string());
    let labels: Vec<String> = of_codecs.chain(FURTHER.map(String::from)).collect();
    for (signal, matrix) in [("diffuse", &diffuse), ("biscale", &biscale)] {
        let families = families(&registry, Kind::of_matrix(matrix));
        let of_family = |label: &str| families.iter().any(|f| family::of(label) == family::of(f.base));
        // To a codec of light fields any dense matrix is one.
        let fits = |label: &&String| of_family(label) || (label.as_str() == "slf" && !matrix.is_sparse());
        for label in labels.iter().filter(fits) {
            let method = registry.method(&label.parse().unwrap()).unwrap();
            let told = method.footprint(&Extent::of(matrix), matrix.basis()).unwrap();
            let Footprint { peak: told, result } = told.unwrap_or_else(|| panic!("{label} says nothing"));
            settle();
            let (encoded, peak) = peak_of(|| method.encode(matrix, &Quiet).unwrap());
            let (peak, resident) = (peak.unwrap(), encoded.resident_bytes() as u64);
            checked.insert(label.split('+').next_back().and_then(|codec| codec.split(':').next()).unwrap().to_string());
            // Threads keep what they worked with.
            if peak > told + SLACK || told > 2 * peak + 2 * SLACK || resident > result + SLACK {
                wrong.push(format!("{label} on {signal}: {peak} held, {told} told; result {resident}, {result} told"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(registry.codecs().iter().all(|codec| checked.contains(codec.name)), "{checked:?}");
}

/// Methods whose parameters decide what they take.
const FURTHER: [&str; 14] = [
    "haar+truncate",
    "truncate:max_error=0.01",
    "truncate:terms=0",
    "bicluster:max_error=0.01",
    "sh+dense",
    "srbf+f16",
    "pca:components=32",
    "pca:max_error=1e-2",
    "cpca:clusters=16",
    "cpca:clusters=16:mode=iterative",
    "tucker:max_error=0.01",
    "tucker:mode=randomised",
    "cta:clusters=16",
    "srbf+cta:clusters=16",
];
/// Bytes that say nothing of a method.
const SLACK: u64 = 6_000_000;
