//! The rows and the pictures of one matrix after the other.

use super::album::{Album, Key};
use super::{Group, matched, title_of};
use crate::cache::{self, Prepared};
use crate::files;
use crate::forecast::Forecast;
use crate::interrupt::{self, Unseen};
use crate::lights::Light;
use crate::measure::{Bench as Measure, Pools, Reference};
use crate::pictures::{Candidate, Gallery, Pictures};
use crate::progress::Steps;
use crate::report::Selection;
use crate::results::Results;
use crate::row::Row;
use crate::suite::Origin;
use anyhow::Context;
use prt_transfer::LightBasis;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// One run of the command.
pub(super) struct Run<'a> {
    pub(super) measure: Measure<'a>,
    pub(super) out: &'a Path,
    pub(super) results: Results,
    pub(super) steps: Steps,
    /// Rows that are in results.csv.
    pub(super) finished: usize,
    pub(super) forecast: Forecast,
    /// Whether methods are the user's.
    pub(super) given: bool,
    /// Whether pictures are taken.
    pub(super) shown: bool,
    /// Of the pictures.
    pub(super) lights: Vec<(String, Light)>,
}

/// A matrix that is read, and compared with, only when something is left to do.
struct Lazily<'a> {
    origin: &'a Origin,
    prepared: Option<Prepared>,
    reference: Option<Reference>,
}

impl Lazily<'_> {
    fn reference(&mut self, pools: &Pools) -> anyhow::Result<&Reference> {
        if let Some(prepared) = self.prepared.take() {
            let read = || Reference::new(prepared.into_matrix()?)?.with_pictures(self.origin);
            self.reference = Some(pools.everywhere(read)?);
        }
        self.reference.as_ref().context("no matrix")
    }
}

impl Run<'_> {
    /// Every method on one matrix, and pictures. Where there is no matrix, every row says why.
    pub(super) fn group(&mut self, origin: &Origin, methods: &[String]) -> anyhow::Result<(Group, Option<Selection>)> {
        let (subject, file_name) = (cache::subject(origin), cache::file_name(origin));
        self.steps.show(&format!("{} {}", subject.scene, subject.signal));
        self.steps.expect(self.forecast.left());
        let began = Instant::now();
        let (rows, (pictures, selection)) = match cache::prepare(&cache::folder(self.out)?, origin, &Unseen) {
            Ok(prepared) => {
                let subject = prepared.about().describe(subject);
                let mut lazily = Lazily { origin, prepared: Some(prepared), reference: None };
                let rows = self.rows(&mut lazily, &subject, methods, &file_name, began)?;
                let Album { pictures, selection, .. } = match self.shown {
                    true => self.album(&mut lazily, &rows, (&title_of(&rows), &file_name))?,
                    false => Album::default(),
                };
                (rows, (pictures, selection))
            }
            Err(error) if interrupt::is_cause_of(&error) => return Err(error),
            Err(error) => {
                let failed = |m: &String| self.measure.planned(&subject, m).failed(format!("{error:#}"));
                let rows: Vec<Row> = methods.iter().map(failed).collect();
                rows.iter().try_for_each(|row| self.results.put(row.clone()))?;
                self.finished += rows.len();
                self.steps.done(rows.len());
                self.forecast.skip(rows.len() + usize::from(self.shown));
                (rows, (Vec::new(), None))
            }
        };
        Ok((Group { title: title_of(&rows), file_name, rows, pictures }, selection))
    }

    /// A row for each method; what the matrix took since `began` counts for the first of them.
    fn rows(
        &mut self,
        lazily: &mut Lazily,
        subject: &Row,
        methods: &[String],
        name: &str,
        mut began: Instant,
    ) -> anyhow::Result<Vec<Row>> {
        let mut rows = Vec::new();
        for method in methods {
            interrupt::check()?;
            let planned = self.measure.planned(subject, method);
            let path = self.encoded(name, method)?;
            // Pictures and verification read the file of a row.
            let is_there = |row: &&Row| path.metadata().ok().map(|file| file.len()) == row.file_bytes;
            let row = match self.results.finished(&planned).filter(is_there) {
                Some(row) => {
                    self.forecast.skip(1);
                    row.clone()
                }
                None => {
                    self.steps.show(&format!("{} {} {method}", planned.scene, planned.signal));
                    let row = self.measure.attempt(planned, lazily.reference(self.measure.pools)?, &path, &Unseen)?;
                    self.results.put(row.clone())?;
                    self.forecast.took(began.elapsed());
                    row
                }
            };
            began = Instant::now();
            self.finished += 1;
            self.steps.done(1);
            self.steps.expect(self.forecast.left());
            rows.push(row);
        }
        Ok(rows)
    }

    /// Where a method's file lies.
    fn encoded(&self, name: &str, method: &str) -> anyhow::Result<PathBuf> {
        cache::make(self.out.join("encoded"))?;
        Ok(cache::encoded(self.out, name, method))
    }

    /// The pictures of an earlier run where they are of the same; else they are taken, and kept.
    fn album(&mut self, lazily: &mut Lazily, rows: &[Row], (title, name): (&str, &str)) -> anyhow::Result<Album> {
        self.steps.show(&format!("pictures of {name}"));
        let basis = rows.first().and_then(|row| row.basis.parse::<LightBasis>().ok());
        let sum = |light: &Light| basis.as_ref().map_or(0, |basis| light.checksum(basis));
        let key = Key::new(rows, self.lights.iter().map(|(name, light)| (name.clone(), sum(light))).collect());
        let path = cache::make(self.out.join("pictures"))?.join(format!("{name}.json"));
        if let Some(album) = Album::read(&path, &key) {
            self.forecast.skip(1);
            return Ok(album);
        }
        let began = Instant::now();
        let (pictures, selection) = self.pictures(lazily, rows, (title, name))?;
        let album = Album::new(key, pictures, selection);
        album.write(&path)?;
        self.forecast.took(began.elapsed());
        Ok(album)
    }

    /// The scene under every light by the best model of each family within about the same bytes, or by the measured ones nearest to them, or by the
    /// user's methods as they are; written as it is returned. And the models that were searched for.
    fn pictures(
        &mut self,
        lazily: &mut Lazily,
        rows: &[Row],
        (title, name): (&str, &str),
    ) -> anyhow::Result<(Vec<Pictures>, Option<Selection>)> {
        let (origin, pools) = (lazily.origin, self.measure.pools);
        let (budget, candidates, selection) = if self.given {
            let all: Vec<&Row> = rows.iter().filter(|row| row.error.is_some_and(|error| error > 0.0)).collect();
            (all.iter().filter_map(|row| row.resident_bytes).max().unwrap_or(0), self.candidates(&all, name)?, None)
        } else {
            let Some(budget) = matched::budget(rows) else { return Ok((Vec::new(), None)) };
            if matched::is_searched(origin.kind()) {
                let (found, selection) = matched::matched(&self.measure, lazily.reference(pools)?, title, budget)?;
                (budget, found, Some(selection).filter(|s| !s.rows.is_empty()))
            } else {
                (budget, self.candidates(&matched::nearest(rows, budget), name)?, None)
            }
        };
        if candidates.is_empty() {
            return Ok((Vec::new(), None));
        }
        let reference = lazily.reference(pools)?;
        let folder = cache::make(self.out.join("pictures"))?;
        let pictures = pools.everywhere(|| {
            let Some(gallery) = Gallery::new(origin, reference.matrix(), &Unseen)? else { return Ok(Vec::new()) };
            let under = |(light, read): &(String, Light)| -> anyhow::Result<Pictures> {
                let pictures = gallery.under(light, read, budget, &candidates)?;
                pictures.write(&folder, name)?;
                Ok(pictures)
            };
            // What has a light of its own looks the same under all others.
            let lights = if gallery.is_lit() { &self.lights[..] } else { &self.lights[..1] };
            lights.iter().map(under).collect::<anyhow::Result<_>>()
        })?;
        Ok((pictures, selection))
    }

    /// Measured methods as pictures take them.
    fn candidates(&self, rows: &[&Row], name: &str) -> anyhow::Result<Vec<Candidate>> {
        let candidate = |row: &&Row| -> anyhow::Result<Candidate> {
            let compressed = files::read_prt(&self.encoded(name, &row.method)?, self.measure.registry)?;
            Ok(Candidate { family: row.family.clone(), file_bytes: row.file_bytes.unwrap_or_default(), compressed })
        };
        rows.iter().map(candidate).collect()
    }
}
