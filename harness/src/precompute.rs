//! `prt precompute`: the transfer matrix of a scene.

use crate::compute::{Computation, Precomputed, Streamed};
use crate::progress::Bar;
use crate::scenes::Up;
use crate::signal::{Signal, Spec};
use crate::{files, memory, number, terminal};
use anyhow::bail;
use clap::Args;
use prt_transfer::responses::Coordinates;
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::repair::Repairs;
use prt_transfer::scene::separable::Terms;
use prt_transfer::scene::signal::Traced;
use prt_transfer::{LightBasis, ResponseBasis, Shape, Stage};
use std::path::PathBuf;

/// Arguments of `prt precompute`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt precompute teapot --signal biscale -o teapot.npz\n  prt precompute bunny.ply --up y --signal diffuse --basis sh:5 --bounces 2 --brdf lambert:albedo=0.7 -o bunny.npz\n  prt precompute bunny.ply --up y --signal glossy --brdf cook-torrance:roughness=0.2 -o bunny.npz\n  prt precompute bunny.ply --up y --signal terms --terms 16 -o bunny.npy\n  prt precompute bunny.ply --signal terms --transform srbf -o bunny.npy\n\nA .npz says what its rows and columns stand for. A .npy does not, but a signal without bounces is written into it as it is computed and never held as a whole."
)]
pub struct Precompute {
    /// A built-in scene (`prt scenes` lists them) or a mesh (.ply, .obj)
    #[arg(value_name = "SCENE|MESH")]
    pub scene: String,
    /// What to compute
    #[arg(long)]
    pub signal: Signal,
    /// Light basis: cubemap:EDGE, or sh:ORDER for diffuse and glossy [default: cubemap:32; sh:5 for glossy]
    #[arg(long)]
    pub basis: Option<LightBasis>,
    /// Vertices of a built-in scene, about [default: the scene's own, see prt scenes]; a mesh keeps its own
    #[arg(long, value_name = "N", value_parser = count(1, 100_000_000))]
    pub vertices: Option<usize>,
    /// The axis of a mesh file that points up
    #[arg(long, value_name = "AXIS", default_value = "z")]
    pub up: Up,
    /// Visibility is sampled with 2^m x 2^m rays for each texel
    #[arg(long, value_name = "m", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=4))]
    pub supersampling: u32,
    /// Local directions of biscale: D x D over the hemisphere [default: 8]
    #[arg(long, value_name = "D", value_parser = count(1, 64))]
    pub local_directions: Option<usize>,
    /// Reflectance of the surface, of glossy, terms and bounces: lambert:albedo=0.7, phong, cook-torrance or ward, see prt scenes
    /// [default: cook-torrance; lambert for diffuse]
    #[arg(long)]
    pub brdf: Option<Brdf>,
    /// Harmonics of glossy exit radiance: n², or n² - 1 without l = 1, m = 0; n up to 10 [default: 24]
    #[arg(long, value_name = "N", value_parser = count(1, 100))]
    pub coefficients: Option<usize>,
    /// Glossy exit radiance in functions that are orthonormal on the hemisphere, in which squared error is that of radiance
    #[arg(long)]
    pub orthonormal: bool,
    /// Bands in which arriving light is projected before glossy reflection [default: 6]
    #[arg(long, value_name = "BANDS", value_parser = count(1, 10))]
    pub incident: Option<usize>,
    /// Functions of the BRDF of terms: a number, or the percentage of the sum of singular values that they hold, as 90% [default: 16]
    #[arg(long, value_name = "K|P%")]
    pub terms: Option<Terms>,
    /// Interreflections of diffuse and glossy, gathered with one ray for each texel [default: 0]
    #[arg(long, value_name = "N", value_parser = count(0, 1000))]
    pub bounces: Option<usize>,
    /// Write the coefficients of a light transform, such as srbf, instead of the rows themselves (.npy, signals without bounces): for
    /// prt encode --transformed
    #[arg(long, value_name = "TRANSFORM")]
    pub transform: Option<Stage>,
    /// Where to write the matrix: .npz or .mtx (sparse), .npy (dense)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Print shape, non-zeros, rays, seconds and peak memory as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What is told of a matrix.
struct Told {
    shape: Shape,
    non_zeros: usize,
    basis: LightBasis,
    responses: ResponseBasis,
    repairs: Repairs,
    traced: Traced,
    energies: Vec<f64>,
    /// What a light transform left out, as a part of the square over the sphere.
    lost: Option<f64>,
    seconds: f64,
}

/// A whole number within a range.
pub(crate) fn count(least: usize, most: usize) -> impl Fn(&str) -> Result<usize, String> + Clone {
    move |text| match text.parse() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(format!("expected a whole number from {least} to {most}")),
    }
}

/// Two whole numbers, as `640x480`.
pub(crate) fn pair(text: &str) -> Option<[usize; 2]> {
    let (first, second) = text.split_once('x')?;
    Some([first.parse().ok()?, second.parse().ok()?])
}

impl Precompute {
    /// What is asked for; options of other signals are refused.
    fn spec(&self) -> anyhow::Result<Spec> {
        use Signal::{Biscale, Diffuse, Glossy, Terms};
        let bounces = self.bounces.unwrap_or(0);
        let brdf_of: &[Signal] = if bounces > 0 { &[Diffuse, Glossy, Terms] } else { &[Glossy, Terms] };
        let belongs: [(&str, bool, &[Signal]); 7] = [
            ("--local-directions", self.local_directions.is_some(), &[Biscale]),
            ("--brdf", self.brdf.is_some(), brdf_of),
            ("--coefficients", self.coefficients.is_some(), &[Glossy]),
            ("--orthonormal", self.orthonormal, &[Glossy]),
            ("--incident", self.incident.is_some(), &[Glossy]),
            ("--terms", self.terms.is_some(), &[Terms]),
            ("--bounces", self.bounces.is_some(), &[Diffuse, Glossy]),
        ];
        let foreign = belongs.iter().find(|(_, given, signals)| *given && !signals.contains(&self.signal));
        if let Some((option, _, signals)) = foreign {
            let names: Vec<String> = signals.iter().map(|s| s.to_string()).collect();
            let without = if *option == "--brdf" && self.signal == Diffuse { " or to --bounces" } else { "" };
            bail!("{option} belongs to --signal {}{without}, not to {}", names.join(" or "), self.signal);
        }
        let basis = self.basis.clone().unwrap_or_else(|| self.signal.usual_basis());
        let usual = Spec::new(self.signal, basis);
        Ok(Spec {
            supersampling: self.supersampling,
            local_directions: self.local_directions.unwrap_or(usual.local_directions),
            brdf: self.brdf.clone().unwrap_or(usual.brdf),
            coefficients: self.coefficients.unwrap_or(usual.coefficients),
            coordinates: if self.orthonormal { Coordinates::Orthonormal } else { usual.coordinates },
            incident: self.incident.unwrap_or(usual.incident),
            terms: self.terms.unwrap_or(usual.terms),
            bounces,
            ..usual
        })
    }
}

/// Runs the command.
pub fn run(arguments: &Precompute) -> anyhow::Result<()> {
    let spec = arguments.spec()?;
    let bar = Bar::default();
    let (told, peak) = memory::peak_of(|| computed(arguments, &spec, &bar));
    drop(bar);
    let told = told?;
    if arguments.json { terminal::say_json(&told.json(peak)) } else { told.say(arguments, peak) }
}

/// Computes and writes: as it goes where the file and the signal allow it.
fn computed(arguments: &Precompute, spec: &Spec, bar: &Bar) -> anyhow::Result<Told> {
    let Precompute { scene, vertices, up, output, .. } = arguments;
    let computation = Computation::new(scene, *vertices, *up, spec)?;
    if let Some(transform) = &arguments.transform {
        files::expect_extension(output, "npy")?;
        let (streamed, lost) = computation.write_transformed(output, transform, bar)?;
        return Ok(Told { lost, ..Told::of(streamed) });
    }
    if files::expect_extension(output, "npy").is_ok()
        && let Some(streamed) = computation.write_npy(output, bar)?
    {
        return Ok(Told::of(streamed));
    }
    computation.check_room(files::expect_extension(output, "npz").is_ok())?;
    let Precomputed { matrix, repairs, traced, energies, seconds } = computation.matrix(bar)?;
    files::write_matrix(output, &matrix)?;
    let (shape, non_zeros) = (matrix.shape(), matrix.non_zeros());
    let (basis, responses) = (matrix.basis().clone(), matrix.responses().clone());
    Ok(Told { shape, non_zeros, basis, responses, repairs, traced, energies, lost: None, seconds })
}

impl Told {
    fn of(streamed: Streamed) -> Told {
        let Streamed { basis, responses, shape, non_zeros, repairs, traced, seconds } = streamed;
        Told { shape, non_zeros, basis, responses, repairs, traced, energies: vec![], lost: None, seconds }
    }

    fn rate(&self) -> u64 {
        (self.traced.rays as f64 / self.traced.seconds.max(1e-9)) as u64
    }

    fn json(&self, peak: Option<u64>) -> serde_json::Value {
        let Told { shape, non_zeros, traced, .. } = self;
        serde_json::json!({
            "samples": shape.samples, "responses": shape.responses, "lights": shape.lights, "basis": self.basis.to_string(),
            "response_basis": self.responses.to_string(), "non_zeros": non_zeros, "rays": traced.rays,
            "rays_per_second_and_core": self.rate(), "repairs": self.repairs.to_string(), "bounce_energies": self.energies,
            "lost_by_transform": self.lost,
            "seconds": self.seconds, "peak_bytes": peak,
        })
    }

    fn say(&self, arguments: &Precompute, peak: Option<u64>) -> anyhow::Result<()> {
        let (rows, lights, non_zeros) = (self.shape.rows(), self.shape.lights, number::count(self.non_zeros as u64));
        let (rays, rate) = (number::count(self.traced.rays), number::count(self.rate()));
        let (seconds, peak) = (number::short(self.seconds), peak.map_or("unknown memory".into(), number::bytes));
        if self.repairs != Repairs::default() {
            terminal::say(format!("mesh: {}", self.repairs))?;
        }
        if let [direct, bounces @ ..] = &self.energies[..]
            && !bounces.is_empty()
        {
            let shares: Vec<String> = bounces.iter().map(|e| number::short(e / direct)).collect();
            terminal::say(format!("squared transfer of each bounce over that of direct light: {}", shares.join(", ")))?;
        }
        terminal::say(format!(
            "{rows} x {lights}, {non_zeros} non-zeros, {rays} rays ({rate} rays/s a core), precomputed in {seconds} s with at most {peak}"
        ))?;
        if let (Some(lost), Some(transform)) = (self.lost, &arguments.transform) {
            terminal::say(format!("{transform} leaves out {} of the square over the sphere", number::short(lost)))?;
        }
        if let Some(transform) = &arguments.transform {
            let (file, responses, basis) = (arguments.output.display(), &self.responses, &arguments.spec()?.basis);
            terminal::say(format!(
                "{file} does not say what it holds: prt encode {transform}+CODEC {file} --transformed --responses {responses} --basis {basis} -o FILE.prt"
            ))?;
        } else if files::expect_extension(&arguments.output, "npz").is_err() {
            let (file, responses, basis) = (arguments.output.display(), &self.responses, &self.basis);
            terminal::say(format!(
                "{file} does not say what it holds: read it with --responses {responses} --basis {basis}"
            ))?;
        }
        Ok(())
    }
}
