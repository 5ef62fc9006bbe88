//! Figure 4: a light in 972 numbers. The paper shows pictures; what is lost of them can be measured.

use super::lights::images;
use super::restored::{BASIS, area_weighted, haar, harmonics, relative_error};
use crate::figures::stage::{Stage, title};
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::lights;
use crate::tables::beside::{Beside, Cell, Column, Line};
use ndarray::Array2;
use prt_srbf::fit::{FitParams, fit};
use std::time::Instant;

pub(in crate::figures) const FIGURE: Figure =
    Figure { name: "figure4", table: Some("Figure 4: a light in 972 numbers"), draw };

/// 972 numbers are so many lobes of six, and so many coefficients of three channels: bands of harmonics 0 to 17.
const LOBES: usize = 162;
const COEFFICIENTS: usize = 324;
const ORDER: usize = 18;

/// How a light is restored; [`Approximation::of`] on all threads.
struct Approximation {
    name: &'static str,
    of: fn(&Array2<f32>) -> anyhow::Result<Array2<f32>>,
}

/// What the paper says of each method's picture, and ours of its kind.
struct Printed {
    method: &'static str,
    says: &'static str,
    ours: &'static [Approximation],
}

static METHODS: [Printed; 3] = [
    Printed {
        method: "spherical harmonics",
        says: "rings",
        ours: &[Approximation { name: "harmonics, order 18", of: |light| Ok(harmonics(light, ORDER)?) }],
    },
    Printed {
        method: "area-weighted wavelets",
        says: "loses lamps",
        ours: &[
            Approximation { name: "324 Haar, by area", of: |light| Ok(area_weighted(light, COEFFICIENTS)?) },
            Approximation { name: "324 Haar, the largest", of: |light| Ok(haar(light, COEFFICIENTS)?) },
        ],
    },
    Printed {
        method: "scattered lobes",
        says: "most features",
        ours: &[Approximation { name: "162 lobes", of: lobes }],
    },
];

fn lobes(light: &Array2<f32>) -> anyhow::Result<Array2<f32>> {
    let params = FitParams { lobes: LOBES, ..FitParams::default() };
    Ok(fit(&params, &BASIS, light.view(), &Unseen)?.light.texels(&BASIS)?)
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    // A folder of meshes has no lights.
    let images = stage.folder().and_then(|folder| images(folder).ok());
    let names = images.unwrap_or_else(|| lights::LIGHTS.map(String::from).to_vec());
    let lights = names.iter().map(|name| Ok((title(name), lights::light(name, &BASIS)?)));
    let lights = lights.collect::<anyhow::Result<Vec<(String, Array2<f32>)>>>()?;
    stage.steps.more(lights.len() * METHODS.iter().map(|printed| printed.ours.len()).sum::<usize>());
    let lines = METHODS.iter().flat_map(|printed| {
        let ours = printed.ours.iter().flat_map(|of| lights.iter().map(move |light| ours(stage, of, light)));
        let [error, brightest, negative, seconds] = [const { Cell::Nothing }; 4];
        let cells = vec![error, brightest, negative, seconds, printed.says.into()];
        std::iter::once(Line::printed(printed.method, cells)).chain(ours).collect::<Vec<_>>()
    });
    Ok(Drawing { beside: vec![beside(lines.collect())], ..Drawing::default() })
}

fn ours(stage: &Stage, of: &Approximation, (name, light): &(String, Array2<f32>)) -> Line {
    stage.steps.show(&format!("{name}, {}", of.name));
    let began = Instant::now();
    let restored = stage.bench.pools.everywhere(|| (of.of)(light));
    let seconds = began.elapsed().as_secs_f64();
    stage.steps.done(1);
    let cells = |found: Array2<f32>| {
        [relative_error(light, &found), brightest(light, &found), negative(light, &found), seconds]
            .map(Cell::from)
            .into()
    };
    let cells = restored.map(cells).map_err(|error| format!("{error:#}"));
    Line::ours(format!("{}, {name}", of.name), (name, of.name), cells)
}

/// What is left of the brightest texel.
fn brightest(light: &Array2<f32>, found: &Array2<f32>) -> f64 {
    let sum = |at: usize, of: &Array2<f32>| of.row(at).iter().map(|v| f64::from(*v)).sum::<f64>();
    let at = (0..light.nrows()).max_by(|a, b| sum(*a, light).total_cmp(&sum(*b, light))).unwrap_or_default();
    sum(at, found) / sum(at, light)
}

/// Light below 0, as a part of all light.
fn negative(light: &Array2<f32>, found: &Array2<f32>) -> f64 {
    let angles = BASIS.solid_angles().unwrap_or_default();
    let flux = |of: &Array2<f32>, part: fn(f64) -> f64| -> f64 {
        let texels = of.outer_iter().zip(&angles);
        texels.map(|(texel, angle)| angle * texel.iter().map(|v| part(f64::from(*v))).sum::<f64>()).sum()
    };
    flux(found, |v| (-v).max(0.0)) / flux(light, |v| v)
}

fn beside(lines: Vec<Line>) -> Beside {
    Beside {
        addition: "",
        title: "Figure 4: a light in 972 numbers (Tsai and Shih 2006)".into(),
        subjects: vec![format!("{BASIS}; 162 lobes of 6 numbers, 324 coefficients of 3 channels")],
        head: "method",
        columns: vec![
            Column::new("relative_squared_error", "error"),
            Column::new("brightest", "brightest texel"),
            Column::new("negative", "below 0"),
            Column::new("seconds", "seconds"),
            Column::new("picture", "picture"),
        ],
        lines,
        why: "The paper shows pictures of St. Peter's Basilica, which is not to be had as a package, and prints no \
              error. Brightest texel: how much is left of it; below 0: that much of the light. It fitted lobes in up to \
              nine minutes; it moved centres and widths in turn, ours move together.",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_of_a_lamp_and_what_rings_is_measured() {
        let light = lights::light("room", &BASIS).unwrap();
        assert_eq!((brightest(&light, &light), negative(&light, &light)), (1.0, 0.0));
        let half = &light * 0.5;
        assert!((brightest(&light, &half) - 0.5).abs() < 1e-9);
        assert!((negative(&light, &-&half) - 0.5).abs() < 1e-9);
        let ringing = harmonics(&light, ORDER).unwrap();
        assert!(negative(&light, &ringing) > 0.01 && brightest(&light, &ringing) < 1.0);
    }
}
