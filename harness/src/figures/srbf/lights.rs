//! Lights in scattered lobes beside Haar wavelets and spherical harmonics of as many numbers.

use crate::charts::curves::{Curves, Dot, Plane};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::machine::Machine;
use crate::table::aligned;
use crate::{number, scenes};
use anyhow::Context;
use ndarray::Array2;
use prt_srbf::fit::{FitParams, fit};
use prt_transfer::sh::{Sh, ShParams};
use prt_transfer::{Configure, LightBasis, LightTransform, Quiet, Result, Transform};
use prt_wavelet::{Haar, HaarParams, Scale};
use std::path::Path;
use std::time::Instant;

pub(super) const FIGURE: Figure = Figure { name: "lights", draw };

const BASIS: LightBasis = LightBasis::Cubemap { resolution: 32 };

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
        None => scenes::LIGHTS.map(String::from).to_vec(),
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
        pictures: Vec::new(),
        measured: !outcomes.is_empty(),
    })
}

/// The .exr files of a folder, by name.
fn images(folder: &Path) -> anyhow::Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot read folder {}", folder.display()))?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let exr = paths.filter(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")));
    let mut names: Vec<String> = exr.map(|path| path.display().to_string()).collect();
    names.sort();
    anyhow::ensure!(!names.is_empty(), "there is no .exr in {}", folder.display());
    Ok(names)
}

fn of_light(stage: &Stage, name: &str, counts: &[usize]) -> anyhow::Result<Vec<Outcome>> {
    let light = scenes::light(name, &BASIS)?;
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
        let found = stage.bench.pools.everywhere(|| fit(&params, &BASIS, light.view(), &Quiet))?;
        let seconds = began.elapsed().as_secs_f64();
        outcomes.push(outcome(0, NUMBERS[0] * lobes, found.relative_squared_error, seconds));
    }
    for count in counts.iter().map(|lobes| lobes * NUMBERS[0] / NUMBERS[1]) {
        let began = Instant::now();
        let error = haar(&light, count)?;
        outcomes.push(outcome(1, NUMBERS[1] * count, error, began.elapsed().as_secs_f64()));
    }
    for order in ORDERS {
        let began = Instant::now();
        let error = harmonics(&light, order)?;
        outcomes.push(outcome(2, NUMBERS[1] * order * order, error, began.elapsed().as_secs_f64()));
    }
    Ok(outcomes)
}

/// What the `count` largest Haar coefficients leave over, kept for all channels at once: of texels, or of texels times √dω, whichever is
/// better. The former hold a constant face in one number, the latter are orthonormal over the sphere.
fn haar(light: &Array2<f32>, count: usize) -> Result<f64> {
    let errors = [Scale::None, Scale::Sphere].map(|scale| {
        let haar = Haar::new(HaarParams { scale, ..HaarParams::default() })?.bind(&BASIS)?;
        let mut coefficients = Array2::zeros((haar.output().lights(), light.ncols()));
        haar.light_into(light.view(), coefficients.view_mut());
        let square = |k: usize| coefficients.row(k).iter().map(|c| f64::from(*c).powi(2)).sum::<f64>();
        let mut order: Vec<(f64, usize)> = (0..coefficients.nrows()).map(|k| (square(k), k)).collect();
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order.iter().skip(count).for_each(|&(_, k)| coefficients.row_mut(k).fill(0.0));
        // A row is restored with 1/√dω less than a light, where texels are scaled.
        let angles = BASIS.solid_angles().unwrap_or_default();
        let mut restored = Array2::zeros(light.raw_dim());
        for (column, mut out) in coefficients.columns().into_iter().zip(restored.columns_mut()) {
            let mut row = vec![0f32; BASIS.lights()];
            haar.restore_row_into(&column.to_vec(), &mut row);
            let scale = |angle: f64| if scale == Scale::Sphere { angle } else { 1.0 };
            out.iter_mut().zip(row).zip(&angles).for_each(|((out, v), a)| *out = (f64::from(v) / scale(*a)) as f32);
        }
        Ok(relative_error(light, &restored))
    });
    let [texels, sphere]: [Result<f64>; 2] = errors;
    Ok(texels?.min(sphere?))
}

/// Σ (a - b)² dω / Σ a² dω, all channels together.
fn relative_error(reference: &Array2<f32>, found: &Array2<f32>) -> f64 {
    let (mut error, mut whole) = (0.0, 0.0);
    let angles = BASIS.solid_angles().unwrap_or_default();
    for ((a, b), angle) in reference.outer_iter().zip(found.outer_iter()).zip(angles) {
        error += angle * a.iter().zip(&b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum::<f64>();
        whole += angle * a.iter().map(|a| f64::from(*a).powi(2)).sum::<f64>();
    }
    if error == 0.0 { 0.0 } else { error / whole }
}

/// What the nearest sum of harmonics leaves over.
fn harmonics(light: &Array2<f32>, order: usize) -> Result<f64> {
    let sh = Sh::new(ShParams { order })?.bind(&BASIS)?;
    let angles = BASIS.solid_angles().unwrap_or_default();
    let mut found = Array2::zeros(light.raw_dim());
    for (channel, mut out) in light.columns().into_iter().zip(found.columns_mut()) {
        // A row of moments: radiance times solid angle.
        let moments: Vec<f32> = channel.iter().zip(&angles).map(|(l, a)| (f64::from(*l) * a) as f32).collect();
        let (mut coefficients, mut restored) = (vec![0f32; order * order], vec![0f32; moments.len()]);
        sh.row_into(&moments, &mut coefficients);
        sh.restore_row_into(&coefficients, &mut restored);
        out.iter_mut().zip(restored).zip(&angles).for_each(|((out, m), a)| *out = (f64::from(m) / a) as f32);
    }
    Ok(relative_error(light, &found))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn haar_and_harmonics_leave_what_their_coefficients_do_not_hold() {
        let light = scenes::light("room", &BASIS).unwrap();
        let left = [0, 10, 100, 1000, BASIS.lights()].map(|count| haar(&light, count).unwrap());
        assert!(left[0] == 1.0 && left[4] < 1e-12 && left.is_sorted_by(|a, b| a > b), "{left:?}");
        let errors: Vec<f64> = [1, 3, 6].map(|order| harmonics(&light, order).unwrap()).into();
        assert!(errors.is_sorted_by(|a, b| a > b) && errors[2] > 0.0, "{errors:?}");
        let even = Array2::ones((BASIS.lights(), 3));
        assert!(harmonics(&even, 1).unwrap() < 1e-10 && haar(&even, 6).unwrap() < 1e-10);
    }
}
