//! `prt fit-light`: a light as a sum of scattered lobes.

use crate::lobe_file::{LobeFile, Provenance, StageEntry};
use crate::precompute::count;
use crate::progress::Bar;
use crate::{files, lights, lobe_file, number, terminal};
use clap::Args;
use ndarray::Array2;
use prt_srbf::fit::{Fit, FitParams, Solver, Starts, fit};
use prt_srbf::{Kernel, ScatteredLight};
use prt_transfer::image::{Image, Picture, Tone};
use prt_transfer::params::{Params, Value};
use prt_transfer::{LightBasis, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Pixels of a reconstruction.
const SIZE: [usize; 2] = [512, 256];

/// Arguments of `prt fit-light`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt fit-light hall.exr --lobes 162 -o hall.json --compare hall.png\n  prt fit-light hall.exr --lobes 32 --cubemap 64 --json\n  prt relight teapot.prt --light hall.json -o lit.npy"
)]
pub struct FitLight {
    /// A lat-long image (.exr, .hdr) or a built-in light (`prt scenes` lists them)
    #[arg(value_name = "LIGHT")]
    pub light: String,
    /// Lobes: two numbers for a centre, a bandwidth and three of colour each
    #[arg(long, value_name = "N", value_parser = count(1, 4096), default_value = "162")]
    pub lobes: usize,
    /// The texels that are fitted: a cubemap of R x R texels a face
    #[arg(long, value_name = "R", value_parser = count(1, 512), default_value = "32")]
    pub cubemap: usize,
    /// The function of the angle to a centre: gaussian or abel-poisson
    #[arg(long, value_parser = value::<Kernel>, default_value = "gaussian", hide_possible_values = true)]
    pub kernel: Kernel,
    /// Where lobes begin: greedy (where the residual is largest, in stages), coverage (the paper's heuristic) or random
    #[arg(long, value_parser = value::<Starts>, default_value = "greedy")]
    pub starts: Starts,
    /// How lobes move: gauss-newton or l-bfgs (both with the coefficients eliminated), or alternate (the paper's)
    #[arg(long, value_parser = value::<Solver>, default_value = "gauss-newton")]
    pub solver: Solver,
    /// Steps of the solver on all lobes; rounds, for alternate
    #[arg(long, value_name = "N", value_parser = count(0, 100_000), default_value = "60")]
    pub steps: usize,
    /// Rounds in which the lobes that matter least are tried elsewhere
    #[arg(long, value_name = "N", value_parser = count(0, 100_000), default_value = "16")]
    pub exchanges: usize,
    /// After alternate, move all at once by l-bfgs (the paper's step 4)
    #[arg(long)]
    pub joint: bool,
    /// The narrowest lobe's bandwidth [default: that of a spread of half a texel]
    #[arg(long, value_name = "LAMBDA")]
    pub max_bandwidth: Option<f64>,
    /// The widest lobe's bandwidth [default: that of a spread of 1.2 rad]
    #[arg(long, value_name = "LAMBDA")]
    pub min_bandwidth: Option<f64>,
    /// Fit a large cubemap at once, and not at half its resolution first
    #[arg(long)]
    pub no_coarse: bool,
    /// Seed of random starts, and of which lobes are tried elsewhere
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Where to write the lobes
    #[arg(short, long, value_name = "FILE.json")]
    pub output: Option<PathBuf>,
    /// Where to write the sum of lobes as a lat-long image of 512 x 256 pixels
    #[arg(long, value_name = "FILE.exr")]
    pub reconstruction: Option<PathBuf>,
    /// Where to write a picture: the light's texels, the lobes at their centres, the error (lat-long)
    #[arg(long, value_name = "FILE.png")]
    pub compare: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What is printed. The names are a promise to programs that read them.
#[derive(Serialize)]
struct Told {
    lobes: usize,
    /// Numbers that the lobes are: six for each.
    parameters: usize,
    texels: usize,
    /// Over the texels' centres, weighted by solid angle, R, G and B together.
    relative_squared_error: f64,
    /// Of R, G and B.
    flux_error: Vec<f64>,
    /// Wall clock of the fit, s.
    seconds: f64,
    label: String,
    history: Vec<StageEntry>,
}

/// A parameter as labels write it.
fn value<T: Value>(text: &str) -> std::result::Result<T, String> {
    T::parse(text).ok_or_else(|| T::expected())
}

/// Runs the command.
pub fn run(arguments: &FitLight) -> anyhow::Result<()> {
    let FitLight { output, reconstruction, compare, .. } = arguments;
    for (path, extension) in [(output, "json"), (reconstruction, "exr"), (compare, "png")] {
        path.as_ref().map_or(Ok(()), |path| files::expect_extension(path, extension))?;
    }
    let params = arguments.params();
    let basis = LightBasis::Cubemap { resolution: arguments.cubemap };
    let light = lights::light(&arguments.light, &basis)?;
    let (bar, began) = (Bar::default(), Instant::now());
    let found = fit(&params, &basis, light.view(), &bar)?;
    drop(bar);
    let seconds = began.elapsed().as_secs_f64();
    let history: Vec<StageEntry> = found.history.iter().map(StageEntry::from).collect();
    let label = params.to_stage().to_string();
    if let Some(path) = output {
        let provenance = Provenance {
            label: label.clone(),
            source: source(&arguments.light),
            basis: basis.to_string(),
            relative_squared_error: found.relative_squared_error,
            flux_error: found.flux_error.clone(),
            history: history.clone(),
        };
        lobe_file::write(path, &LobeFile::new(&found.light, provenance))?;
    }
    if let Some(path) = reconstruction {
        files::write_radiance(path, &image(&found.light)?)?;
    }
    if let Some(path) = compare {
        files::write_picture(path, &comparison(&found.light, &basis, &light)?)?;
    }
    let lobes = found.light.lobes().len();
    let Fit { relative_squared_error, flux_error, .. } = found;
    let told = Told {
        lobes,
        parameters: 6 * lobes,
        texels: basis.lights(),
        relative_squared_error,
        flux_error,
        seconds,
        label,
        history,
    };
    if arguments.json { terminal::say_json(&told) } else { terminal::say(told.text()) }
}

impl FitLight {
    fn params(&self) -> FitParams {
        let &FitLight { lobes, kernel, starts, solver, steps, exchanges, joint, max_bandwidth, min_bandwidth, .. } =
            self;
        let (coarse, seed) = (!self.no_coarse, self.seed);
        let moves = FitParams { lobes, kernel, starts, solver, steps, exchanges, joint, ..FitParams::default() };
        FitParams { max_bandwidth, min_bandwidth, coarse, seed, ..moves }
    }
}

impl Told {
    fn text(&self) -> String {
        let worst = self.flux_error.iter().fold(0f64, |worst, e| worst.max(e.abs()));
        format!(
            "{} lobes ({} numbers) for {} texels: relative squared error {}, flux off by {} % at most, in {} s",
            self.lobes,
            self.parameters,
            self.texels,
            number::short(self.relative_squared_error),
            number::short(100.0 * worst),
            number::short(self.seconds),
        )
    }
}

/// The light's name without the folders of this machine.
fn source(light: &str) -> String {
    Path::new(light).file_name().map_or_else(|| light.into(), |name| name.to_string_lossy().into_owned())
}

/// The lobes as a lat-long image.
fn image(light: &ScatteredLight) -> Result<Image> {
    let [width, height] = SIZE;
    let texels = light.texels(&LightBasis::LatLong { width, height })?;
    Ok(Image { width, height, pixels: texels.outer_iter().map(|row| [row[0], row[1], row[2]]).collect() })
}

/// Texels, lobes at the texels' centres, and their difference, each as a lat-long picture of the cubemap.
fn comparison(light: &ScatteredLight, basis: &LightBasis, texels: &Array2<f32>) -> Result<Picture> {
    let [reference, found] =
        [lights::unwrapped(basis, texels, SIZE), lights::unwrapped(basis, &light.texels(basis)?, SIZE)];
    let everywhere = vec![1.0; reference.pixels.len()];
    let exposure = reference.automatic_exposure(&everywhere)?;
    let map = found.error_map(&reference, &everywhere, exposure)?;
    Ok(Picture::beside(&[reference.develop(exposure, Tone::Filmic), found.develop(exposure, Tone::Filmic), map]))
}
