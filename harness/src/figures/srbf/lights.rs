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
    let counts = LOBES[usize::from(stage.folder().is_some())];
    let mut outcomes = Vec::new();
    for name in &names {
        outcomes.extend(of_light(stage, name, counts)?);
    }
    Ok(Drawing {
        text: table(&outcomes),
        tables: vec![("", csv(&outcomes, &stage.machine)?)],
        chart: Some(chart(&outcomes)),
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
    let began = Instant::now();
    let left = haar(&light)?;
    let seconds = began.elapsed().as_secs_f64();
    let coefficients = counts.iter().map(|lobes| lobes * NUMBERS[0] / NUMBERS[1]);
    outcomes.extend(coefficients.map(|n| outcome(1, NUMBERS[1] * n, left[n], seconds)));
    for order in ORDERS {
        let began = Instant::now();
        let error = harmonics(&light, order)?;
        outcomes.push(outcome(2, NUMBERS[1] * order * order, error, began.elapsed().as_secs_f64()));
    }
    Ok(outcomes)
}

/// What the n largest Haar coefficients leave over, for every n: they are orthonormal over the sphere, and are kept for all channels at once.
fn haar(light: &Array2<f32>) -> Result<Vec<f64>> {
    let haar = Haar::new(HaarParams { scale: Scale::Sphere, ..HaarParams::default() })?.bind(&BASIS)?;
    let mut coefficients = Array2::zeros((haar.output().lights(), light.ncols()));
    haar.light_into(light.view(), coefficients.view_mut());
    let mut squares: Vec<f64> =
        coefficients.outer_iter().map(|row| row.iter().map(|c| f64::from(*c).powi(2)).sum()).collect();
    squares.sort_unstable_by(f64::total_cmp);
    let whole: f64 = squares.iter().sum();
    // Sums from the smallest on, so that small remainders keep their digits.
    let mut left = vec![0.0];
    left.extend(squares.iter().scan(0.0, |sum, square| {
        *sum += square;
        Some(*sum / whole)
    }));
    left.reverse();
    Ok(left)
}

/// What the nearest sum of harmonics leaves over.
fn harmonics(light: &Array2<f32>, order: usize) -> Result<f64> {
    let sh = Sh::new(ShParams { order })?.bind(&BASIS)?;
    let angles = BASIS.solid_angles().unwrap_or_default();
    let (mut error, mut whole) = (0.0, 0.0);
    for channel in light.columns() {
        // A row of moments: radiance times solid angle.
        let moments: Vec<f32> = channel.iter().zip(&angles).map(|(l, a)| (f64::from(*l) * a) as f32).collect();
        let (mut coefficients, mut restored) = (vec![0f32; order * order], vec![0f32; moments.len()]);
        sh.row_into(&moments, &mut coefficients);
        sh.restore_row_into(&coefficients, &mut restored);
        for ((a, b), angle) in moments.iter().zip(&restored).zip(&angles) {
            error += (f64::from(*a) - f64::from(*b)).powi(2) / angle;
            whole += f64::from(*a).powi(2) / angle;
        }
    }
    Ok(error / whole)
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
        planes: lights(outcomes).into_iter().map(plane).collect(),
    }
}

/// Names of the lights, in order.
fn lights(outcomes: &[Outcome]) -> Vec<&String> {
    let mut names: Vec<&String> = outcomes.iter().map(|o| &o.light).collect();
    names.dedup();
    names
}

/// Each number of lobes beside as many numbers of Haar coefficients.
fn table(outcomes: &[Outcome]) -> String {
    let find = |method: usize, of: &Outcome| {
        outcomes.iter().find(|o| o.method == method && o.light == of.light && o.numbers == of.numbers)
    };
    let titles = ["light", "lobes", "numbers", "error", "Haar", "Haar / lobes", "s"];
    let rows = outcomes.iter().filter(|o| o.method == 0).map(|o| {
        let haar = find(1, o).map(|haar| haar.relative_squared_error);
        let short = |value: Option<f64>| value.map_or_else(|| "-".into(), number::short);
        vec![
            o.light.clone(),
            (o.numbers / NUMBERS[0]).to_string(),
            o.numbers.to_string(),
            number::short(o.relative_squared_error),
            short(haar),
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
        let left = haar(&light).unwrap();
        assert!((left[0] - 1.0).abs() < 1e-12 && left[BASIS.lights()] == 0.0 && left.is_sorted_by(|a, b| a >= b));
        // A constant light needs six coefficients, a face's mean each, up to what solid angles differ within a face.
        let errors: Vec<f64> = [1, 3, 6].map(|order| harmonics(&light, order).unwrap()).into();
        assert!(errors.is_sorted_by(|a, b| a > b) && errors[2] > 0.0, "{errors:?}");
        let even = Array2::ones((BASIS.lights(), 3));
        assert!(harmonics(&even, 1).unwrap() < 1e-10);
    }
}
