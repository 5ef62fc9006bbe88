//! A model that was tried: encoded, sized and held against the matrix.

use super::ledger::Ledger;
use super::projection::Projection;
use crate::fingerprint;
use crate::interrupt::{self, Unseen};
use crate::measure::{Bench, Reference};
use crate::suite::DENSE_LIMIT;
use crate::{files, number, room};
use anyhow::{Context, Result, bail, ensure};
use prt_transfer::method::Transformed;
use prt_transfer::{Compressed, Extent, Label, Registry};
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Figures of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trial {
    /// Its label, the shortest.
    pub label: String,
    /// Σ(T-T̃)²/ΣT².
    pub error: f64,
    /// The same over the sphere.
    pub error_sphere: Option<f64>,
    /// The `.prt` file.
    pub file_bytes: u64,
    /// What relighting holds in memory.
    pub resident_bytes: u64,
    /// Relighting one channel on one thread, median, ms; where it was asked for.
    pub relight_ms: Option<f64>,
    /// Encoding, sizing and comparing, s.
    pub seconds: f64,
}

/// What came of a label.
#[derive(Clone, Debug)]
pub(super) enum Attempt {
    /// Figures.
    Tried(Trial),
    /// There is no such model, and why.
    Failed(String),
}

impl Attempt {
    /// Whether it says what is asked: a time where relighting is timed.
    fn is_enough(&self, timed: bool) -> bool {
        match self {
            Attempt::Tried(trial) => !timed || trial.relight_ms.is_some(),
            Attempt::Failed(_) => true,
        }
    }
}

/// Tries labels on one matrix, each once. What a light transform makes of the matrix is made once for all labels.
pub(super) struct Trials<'a> {
    bench: &'a Bench<'a>,
    reference: &'a Reference,
    /// Whether relighting is timed.
    timed: bool,
    known: HashMap<String, Attempt>,
    ledger: Option<Ledger>,
    /// Why no more can be tried: a trial could not be kept, or the user wants no more.
    stopped: Option<anyhow::Error>,
    transformed: HashMap<String, Arc<Shared>>,
}

/// A transformed matrix, and the matrix as the rows of B see it.
struct Shared {
    transformed: Transformed,
    projection: Option<Projection>,
}

/// Transformed matrices that are held at once.
const HELD: usize = 3;

impl<'a> Trials<'a> {
    /// Nothing has been tried.
    pub(super) fn new(bench: &'a Bench<'a>, reference: &'a Reference, timed: bool) -> Trials<'a> {
        Trials {
            bench,
            reference,
            timed,
            known: HashMap::new(),
            ledger: None,
            stopped: None,
            transformed: HashMap::new(),
        }
    }

    /// Begins with what a file knows of the matrix, and adds to it.
    pub(super) fn keep_in(&mut self, path: &Path) -> Result<()> {
        let (ledger, known) = Ledger::open(path, fingerprint::matrix(self.reference.matrix()))?;
        self.known.extend(known.into_iter().filter(|(_, attempt)| attempt.is_enough(self.timed)));
        self.ledger = Some(ledger);
        Ok(())
    }

    /// Whether nothing more will be tried; [`Trials::kept`] says why.
    pub(super) fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    /// Fails where a trial could not be kept, or where the user has asked to stop.
    pub(super) fn kept(&mut self) -> Result<()> {
        self.stopped.take().map_or(Ok(()), Err)
    }

    /// Whether relighting is timed from now on; what was tried without is forgotten then.
    pub(super) fn set_timed(&mut self, timed: bool) {
        self.known.retain(|_, attempt| attempt.is_enough(timed));
        self.timed = timed;
    }

    /// The matrix and what it is compared by.
    pub(super) fn reference(&self) -> &'a Reference {
        self.reference
    }

    /// Every method.
    pub(super) fn registry(&self) -> &'a Registry {
        self.bench.registry
    }

    /// Tries a label, and says with which file where it was not tried before.
    pub(super) fn attempt(&mut self, label: &Label) -> (Attempt, Option<Vec<u8>>) {
        // The shortest form, so that two spellings are one trial; a label that is none fails below.
        let name = self.bench.registry.method(label).map_or_else(|_| label.to_string(), |m| m.label().to_string());
        if let Some(known) = self.known.get(&name) {
            return (known.clone(), None);
        }
        let tried = catch_unwind(AssertUnwindSafe(|| self.attempted(label)));
        let (attempt, file) = match tried {
            Ok(Ok((trial, file))) => (Attempt::Tried(trial), Some(file)),
            Ok(Err(error)) if interrupt::is_cause_of(&error) => {
                // Nothing was learnt of the label, and nothing is kept of it.
                self.stopped = Some(error);
                return (Attempt::Failed("interrupted".into()), None);
            }
            Ok(Err(error)) => (Attempt::Failed(format!("{error:#}")), None),
            Err(_) => (Attempt::Failed("the method panicked: a mistake in the program".into()), None),
        };
        if let Some(ledger) = &mut self.ledger
            && self.stopped.is_none()
        {
            self.stopped = ledger.add(&name, &attempt).err();
        }
        self.known.insert(name, attempt.clone());
        (attempt, file)
    }

    /// The file of a label that was tried before.
    pub(super) fn file(&mut self, label: &str) -> Result<Vec<u8>> {
        Ok(self.attempted(&label.parse()?)?.1)
    }

    /// The figures of what a file holds, read as any file.
    pub(super) fn read_back(&self, file: &[u8]) -> Result<Trial> {
        let compressed = files::prt_from_bytes(file, self.bench.registry)?;
        let (error, error_sphere) = self.bench.pools.everywhere(|| self.reference.error_of(&compressed));
        let trial = Trial { error, error_sphere, relight_ms: Some(self.relight_ms(&compressed)?), ..Trial::default() };
        Ok(self.sized(trial, &compressed, file))
    }

    fn attempted(&mut self, label: &Label) -> Result<(Trial, Vec<u8>)> {
        let (matrix, began) = (self.reference.matrix(), Instant::now());
        let cells = 4 * matrix.rows() as u64 * matrix.lights() as u64;
        if label.to_string() == "dense" && cells > DENSE_LIMIT {
            bail!("would need {}, above the limit of {}", number::bytes(cells), number::bytes(DENSE_LIMIT));
        }
        let method = self.bench.registry.method(label)?;
        self.bench.pools.everywhere(|| room::check_method(&method, &Extent::of(matrix), matrix.basis(), 0))?;
        let shared = self.shared(method.label())?;
        let (compressed, file, (error, error_sphere)) = self.bench.pools.everywhere(|| -> Result<_> {
            let compressed = method.encode_transformed(matrix, &shared.transformed, &Unseen)?;
            let file = files::prt_bytes(&compressed, &Unseen)?;
            let error = match &shared.projection {
                Some(projection) => projection.error_of(&compressed, self.reference),
                None => self.reference.error_of(&compressed),
            };
            Ok((compressed, file, error))
        })?;
        ensure!(error.is_finite(), "the decoded matrix is not finite");
        let relight_ms = if self.timed { Some(self.relight_ms(&compressed)?) } else { None };
        let trial = Trial { error, error_sphere, relight_ms, ..Trial::default() };
        let trial = Trial { seconds: began.elapsed().as_secs_f64(), ..self.sized(trial, &compressed, &file) };
        Ok((trial, file))
    }

    fn sized(&self, trial: Trial, compressed: &Compressed, file: &[u8]) -> Trial {
        let [file_bytes, resident_bytes] = [file.len() as u64, compressed.resident_bytes() as u64];
        Trial { label: compressed.label().to_string(), file_bytes, resident_bytes, ..trial }
    }

    fn relight_ms(&self, compressed: &Compressed) -> Result<f64> {
        let timings = self.bench.race(std::slice::from_ref(compressed), self.reference)?;
        Ok(timings.first().context("one timing of one runner")?.median_ms)
    }

    fn shared(&mut self, label: &Label) -> Result<Arc<Shared>> {
        let stage = label.transform.to_string();
        if let Some(shared) = self.transformed.get(&stage) {
            return Ok(shared.clone());
        }
        if self.transformed.len() >= HELD {
            self.transformed.clear();
        }
        let matrix = self.reference.matrix();
        let shared = self.bench.pools.everywhere(|| -> Result<Shared> {
            let transformed = self.bench.registry.method(label)?.transformed(matrix, &Unseen)?;
            let projection = Projection::worthwhile(&transformed, self.reference);
            Ok(Shared { transformed, projection })
        })?;
        let shared = Arc::new(shared);
        self.transformed.insert(stage, shared.clone());
        Ok(shared)
    }
}
