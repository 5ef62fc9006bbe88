//! What a stranger's bytes can do to the readers: 100,000 structured mutations. Alone in its process, whose allocations it counts.
//!
//! `PRT_HOSTILE_MUTATIONS=1000000` tries as many, `PRT_HOSTILE_READER=npz` one reader only; `--nocapture` shows what came of them.

use prt_harness::memory::{Counting, peak_of};
use prt_tests::hostile::{Check, Kind, Parts, READERS, Reader, mutate, mutate_parts, reseal};
use prt_tests::random;
use rand::RngExt;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const MUTATIONS: usize = 100_000;
/// A sign of a hang and no measure of speed: most readers take microseconds.
const HANG: Duration = Duration::from_secs(10);

/// What is being tried.
static TRYING: Mutex<Option<Attempt>> = Mutex::new(None);

struct Attempt {
    since: Instant,
    reader: &'static Reader,
    /// Of the mutation.
    number: usize,
    bytes: Vec<u8>,
}

/// What came of the mutations of one reader.
#[derive(Default)]
struct Tally {
    accepted: usize,
    refused: usize,
    longest: Duration,
    /// The most bytes beyond those of the file, as a part of what is allowed.
    fullest: f64,
}

/// The message of a panic.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no text")
}

/// Where a file that broke a promise is left, to be looked at and to become a seed.
fn kept(reader: &Reader, number: usize, bytes: &[u8]) -> String {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{number}", reader.name));
    std::fs::write(&path, bytes).unwrap();
    path.display().to_string()
}

fn of_samples(parts: &Parts, samples: usize) -> Vec<u8> {
    let mut lines = parts.lines();
    lines[2] = samples.to_string();
    Parts::join(&lines, &parts.sections)
}

/// Mutation `number` of some seed.
fn mutated(reader: &Reader, seeds: &[Vec<u8>], parts: &[Parts], number: usize) -> Vec<u8> {
    let mut rng = random(number as u64);
    let [one, other] = [0; 2].map(|_| rng.random_range(0..seeds.len()));
    if parts.is_empty() || rng.random_range(0..16) == 0 {
        let mut bytes = seeds[one].clone();
        mutate(&mut bytes, &seeds[other], &mut rng);
        if reader.kind == Kind::Sealed && !number.is_multiple_of(4) {
            reseal(&mut bytes);
        }
        return bytes;
    }
    // Sections of the same label fit together best.
    let alike = |p: &&Parts| p.header.label == parts[one].header.label && **p != parts[one];
    let other = parts.iter().filter(alike).nth(other % 4).unwrap_or(&parts[other]);
    mutate_parts(&parts[one], other, &mut rng)
}

fn attempt(reader: &'static Reader, number: usize, bytes: &[u8], tally: &mut Tally) -> Result<(), String> {
    let begun = Instant::now();
    *TRYING.lock().unwrap() = Some(Attempt { since: begun, reader, number, bytes: bytes.into() });
    let (outcome, peak) = peak_of(|| catch_unwind(|| (reader.read)(bytes)));
    let check: Option<Check> = match outcome {
        Err(panic) => return Err(format!("panicked: {}", said(&*panic))),
        Ok(Err(message)) => {
            if message.is_empty() || message.len() > 2000 {
                return Err(format!("refuses with {} bytes of text: {message:.200}", message.len()));
            }
            None
        }
        Ok(Ok(check)) => Some(check),
    };
    let (peak, limit) = (peak.expect("the allocator counts") as usize, (reader.limit)(bytes));
    if peak > limit {
        return Err(format!("held {peak} bytes of {limit}"));
    }
    tally.fullest = tally.fullest.max(peak as f64 / limit as f64);
    match check {
        None => tally.refused += 1,
        Some(check) => {
            tally.accepted += 1;
            catch_unwind(AssertUnwindSafe(check)).map_err(|panic| format!("accepts: {}", said(&*panic)))?;
        }
    }
    tally.longest = tally.longest.max(begun.elapsed());
    Ok(())
}

/// All mutations of one reader; the first few that broke a promise.
fn torture(reader: &'static Reader, times: usize, tally: &mut Tally) -> Vec<String> {
    let seeds = (reader.seeds)();
    let parts: Vec<Parts> = match reader.kind {
        Kind::Parts => seeds.iter().map(|seed| Parts::from_bytes(seed).expect("a seed")).collect(),
        Kind::File | Kind::Sealed => Vec::new(),
    };
    for seed in &seeds {
        // Whatever is made once per process exists after this.
        (reader.read)(seed).unwrap_or_else(|e| panic!("{}: a seed is refused: {e}", reader.name))();
    }
    let mut broken = Vec::new();
    for number in 0..times {
        let bytes = match parts.get(number) {
            // Samples that may cost no byte must cost no time.
            Some(parts) => of_samples(parts, 1 << 40),
            None => mutated(reader, &seeds, &parts, number),
        };
        if let Err(problem) = attempt(reader, number, &bytes, tally) {
            broken.push(format!("{} {problem}: {}", reader.name, kept(reader, number, &bytes)));
            if broken.len() == 300 {
                break;
            }
        }
    }
    *TRYING.lock().unwrap() = None;
    broken
}

// The table is for whoever asks with --nocapture.
#[allow(clippy::print_stdout)]
#[test]
fn whatever_the_bytes_a_reader_refuses_or_gives_what_it_promises_in_little_memory_and_time() {
    let work = std::thread::spawn(|| {
        let only = std::env::var("PRT_HOSTILE_READER").ok();
        let mutations = std::env::var("PRT_HOSTILE_MUTATIONS").map_or(MUTATIONS, |n| n.parse().unwrap());
        let all: f64 = READERS.iter().map(|reader| reader.share).sum();
        let mut broken = Vec::new();
        println!("reader      accepted  refused  seconds  longest ms  memory of limit");
        for reader in READERS.iter().filter(|r| only.as_ref().is_none_or(|only| only == r.name)) {
            let (begun, mut tally) = (Instant::now(), Tally::default());
            broken.extend(torture(reader, (mutations as f64 * reader.share / all).ceil() as usize, &mut tally));
            let Tally { accepted, refused, longest, fullest } = tally;
            let (seconds, longest) = (begun.elapsed().as_secs_f64(), 1e3 * longest.as_secs_f64());
            println!("{:10} {accepted:9} {refused:8} {seconds:8.2} {longest:11.2} {fullest:16.3}", reader.name);
            assert!(accepted > 0 && refused > 0, "{} always does the same", reader.name);
        }
        assert!(broken.is_empty(), "{}", broken.join("\n"));
    });
    while !work.is_finished() {
        std::thread::sleep(Duration::from_millis(50));
        if let Some(Attempt { since, reader, number, bytes }) = &*TRYING.lock().unwrap() {
            assert!(since.elapsed() < HANG, "{} hangs: {}", reader.name, kept(reader, *number, bytes));
        }
    }
    if let Err(problem) = work.join() {
        std::panic::resume_unwind(problem);
    }
}
