//! Lights in scattered lobes beside Haar wavelets and spherical harmonics of as many numbers.

use super::restored::{BASIS, haar, harmonics, relative_error};
use crate::charts::curves::{Curves, Dot, Plane};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::machine::Machine;
use crate::table::aligned;
use crate::{lights, number};
use anyhow::Context;
use prt_srbf::fit::{FitParams, fit};
use std::path::Path;
use std::time::Instant;

pub(super) const FIGURE: Figure = Figure { name: "lights", table: None, draw };

/// Lobes of the built-in lights, and of those in a folder.
const LOBES: [&[usize]; 2] = [&[8, 16, 32, 64], &[8, 16, 32, 64, 128, 162, 256, 512]];

/// Of more lights than a chart has room for there is a table alone, with the paper's number of lobes.
const CHARTED: usize = 4;
const PAPER_LOBES: &[usize] = &[162];

/// Bands of harmonics.
const ORDERS: [usize; 7] = [2, 4, 6, 9, 12, 18, 24];

/// Numbers for a lobe, and for a coefficient.
const NUMBERS: [usize; 2] = [6, 3];

const METHODS: [&str; 3] = ["scattered lobes", "Haar", "spherical harmonics"];

/// A light in so many numbers.
struct Outcome {
    light: String,
    /// Index into [`METHODS`].
    method: usize,
    numbers: usize,
    relative_squared_error: f64,
    seconds: f64,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let names = match stage.folder() {
        Some(folder) => images(folder)?,
        None => lights::LIGHTS.map(String::from).to_vec(),
    };
    let charted = names.len() <= CHARTED;
    let counts = if charted { LOBES[usize::from(stage.folder().is_some())] } else { PAPER_LOBES };
    let mut outcomes = Vec::new();
    for name in &names {
        outcomes.extend(of_light(stage, name, counts)?);
    }
    Ok(Drawing {
        text: table(&outcomes),
        tables: vec![("", csv(&outcomes, &stage.machine)?)],
        chart: charted.then(|| chart(&outcomes)),
        measured: !outcomes.is_empty(),
        ..Drawing::default()
    })
}

/// The .exr files of a folder, by name.
pub(super) fn images(folder: &Path) -> anyhow::Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot read folder {}", folder.display()))?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let exr = paths.filter(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")));
    let mut names: Vec<String> = exr.map(|path| path.display().to_string()).collect();
    names.sort();
    anyhow::ensure!(!names.is_empty(), "there is no .exr in {}", folder.display());
    Ok(names)
}

fn of_light(stage: &Stage, name: &str, counts: &[usize]) -> anyhow::Result<Vec<Outcome>> {
    let light = lights::light(name, &BASIS)?;
    let title = Path::new(name).file_stem().map_or_else(|| name.into(), |stem| stem.to_string_lossy().into_owned());
    let outcome = |method: usize, numbers, relative_squared_error, seconds| {
        let light = title.clone();
        Outcome { light, method, numbers, relative_squared_error, seconds }
    };
    let mut outcomes = Vec::new();
    for &lobes in counts {
        stage.steps.show(&format!("{title}: {lobes} lobes"));
        let began = Instant::now();
        let params = FitParams { lobes, ..FitParams::default() };
        let found = stage.bench.pools.everywhere(|| fit(&params, &BASIS, light.view(), &Unseen))?;
        let seconds = began.elapsed().as_secs_f64();
        outcomes.push(outcome(0, NUMBERS[0] * lobes, found.relative_squared_error, seconds));
    }
    for count in counts.iter().map(|lobes| lobes * NUMBERS[0] / NUMBERS[1]) {
        let began = Instant::now();
        let error = relative_error(&light, &haar(&light, count)?);
        outcomes.push(outcome(1, NUMBERS[1] * count, error, began.elapsed().as_secs_f64()));
    }
    for order in ORDERS {
        let began = Instant::now();
        let error = relative_error(&light, &harmonics(&light, order)?);
        outcomes.push(outcome(2, NUMBERS[1] * order * order, error, began.elapsed().as_secs_f64()));
    }
    Ok(outcomes)
}

fn chart(outcomes: &[Outcome]) -> Curves {
    let plane = |light: &String| {
        let dots = |method: usize| {
            let of = outcomes.iter().filter(move |o| o.light == *light && o.method == method);
            of.map(|o| Dot { x: o.numbers as f64, y: o.relative_squared_error, label: String::new() }).collect()
        };
        Plane {
            upwards: format!("{light}: relative squared error"),
            across: "numbers".into(),
            curves: (0..METHODS.len()).map(dots).collect(),
            references: vec![(972.0, "162 lobes".into())],
        }
    };
    Curves {
        title: "Lights in scattered lobes, Haar wavelets and spherical harmonics (Tsai and Shih 2006, Figure 4)".into(),
        subject: format!("{BASIS}; 6 numbers for a lobe, 3 for a coefficient"),
        remark: None,
        names: METHODS.map(String::from).into(),
        apart: false,
        planes: lights(outcomes).into_iter().map(plane).collect(),
    }
}

/// Names of the lights, in order.
fn lights(outcomes: &[Outcome]) -> Vec<&String> {
    let mut names: Vec<&String> = outcomes.iter().map(|o| &o.light).collect();
    names.dedup();
    names
}

/// Each number of lobes beside as many numbers of Haar coefficients and of harmonics.
fn table(outcomes: &[Outcome]) -> String {
    let find = |method: usize, of: &Outcome| {
        outcomes.iter().find(|o| o.method == method && o.light == of.light && o.numbers == of.numbers)
    };
    let titles = ["light", "lobes", "numbers", "error", "Haar", "harmonics", "Haar / lobes", "s"];
    let rows = outcomes.iter().filter(|o| o.method == 0).map(|o| {
        let [haar, harmonics] = [1, 2].map(|method| find(method, o).map(|other| other.relative_squared_error));
        let short = |value: Option<f64>| value.map_or_else(|| "-".into(), number::short);
        vec![
            o.light.clone(),
            (o.numbers / NUMBERS[0]).to_string(),
            o.numbers.to_string(),
            number::short(o.relative_squared_error),
            short(haar),
            short(harmonics),
            short(haar.map(|haar| haar / o.relative_squared_error)),
            number::short(o.seconds),
        ]
    });
    format!("Lights (Figure 4)\n{}", aligned(&titles, rows))
}

fn csv(outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["light", "method", "numbers", "relative_squared_error", "seconds", "machine"])?;
    for o in outcomes {
        let figures = [o.numbers.to_string(), o.relative_squared_error.to_string(), o.seconds.to_string()];
        let words = [o.light.clone(), METHODS[o.method].into()];
        writer.write_record(words.into_iter().chain(figures).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
