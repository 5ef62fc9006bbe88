//! `prt relight`: the responses of a compressed matrix to a light.

use crate::registry::registry;
use crate::{files, scenes};
use clap::Args;
use ndarray::Array2;
use prt_transfer::{Error, LightBasis, ResponseBasis, Result};
use std::path::{Path, PathBuf};

/// Arguments of `prt relight`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt relight teapot.prt --light sky -o lit.npy\n  prt relight teapot.prt --light studio.exr -o lit.npy"
)]
pub struct Relight {
    /// Compressed matrix
    #[arg(value_name = "FILE.prt")]
    pub input: PathBuf,
    /// A built-in light (`prt scenes` lists them), a lat-long image (.exr, .hdr), or coefficients (.npy, lights or
    /// lights x channels)
    #[arg(long, value_name = "LIGHT")]
    pub light: String,
    /// Where to write the responses: .npy, rows x channels
    #[arg(short, long, value_name = "FILE.npy")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Relight) -> anyhow::Result<()> {
    files::expect_extension(&arguments.output, "npy")?;
    let compressed = files::read_prt(&arguments.input, &registry())?;
    let light = light(&arguments.light, compressed.basis(), compressed.responses())?;
    Error::expect_size(
        format!("light coefficients of '{}'", arguments.light),
        compressed.shape().lights,
        light.nrows(),
    )?;
    let mut out = Array2::zeros((compressed.shape().rows(), light.ncols()));
    compressed.apply_into(light.view(), out.view_mut())?;
    Ok(files::write_array(&arguments.output, out.view())?)
}

/// Light coefficients, lights x channels: as a file has them, or radiance on `basis` as `responses` expect it.
fn light(name: &str, basis: &LightBasis, responses: &ResponseBasis) -> Result<Array2<f32>> {
    let path = Path::new(name);
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("npy") => files::read_lights(path),
        _ => responses.light(basis, scenes::light(name, basis)?),
    }
}
