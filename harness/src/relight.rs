//! `prt relight`: the responses of a compressed matrix to a light.

use crate::lights::{self, Light};
use crate::registry::registry;
use crate::{files, lobe_file};
use anyhow::{Context, bail};
use clap::Args;
use glam::{DMat3, DVec3};
use ndarray::Array2;
use prt_srbf::{ScatteredLight, Srbf, SrbfParams};
use prt_transfer::{Compressed, Configure, Error, LightBasis, Params, ResponseBasis, Result, Source, Transform};
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
    /// A built-in light (`prt scenes` lists them), a lat-long image (.exr, .hdr), lobes of prt fit-light (.json), or coefficients (.npy, lights or
    /// lights x channels)
    #[arg(long, value_name = "LIGHT")]
    pub light: String,
    /// Turn a light of lobes about an axis: x,y,z,degrees
    #[arg(long, value_name = "X,Y,Z,DEGREES", value_parser = four, allow_hyphen_values = true)]
    pub rotate: Option<[f64; 4]>,
    /// Where to write the responses: .npy, rows x channels
    #[arg(short, long, value_name = "FILE.npy")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Relight) -> anyhow::Result<()> {
    files::expect_extension(&arguments.output, "npy")?;
    let compressed = files::read_prt(&arguments.input, &registry())?;
    let turn = arguments.rotate.map(rotation).transpose()?;
    if lights::is_lobes(&arguments.light) {
        let light = lobe_file::read(Path::new(&arguments.light))?;
        let light = turn.map_or(Ok(light.clone()), |turn| light.rotated(turn))?;
        return Ok(files::write_array(&arguments.output, lit_by_lobes(&compressed, &light)?.view())?);
    }
    if turn.is_some() {
        bail!("--rotate belongs to a light of lobes (.json): {} has texels", arguments.light);
    }
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

/// Responses to a light of lobes: by inner products with the lobes of the transfer where it is in lobes of the same kernel and every column
/// stands for radiance, else by the light's texels.
fn lit_by_lobes(compressed: &Compressed, light: &ScatteredLight) -> anyhow::Result<Array2<f32>> {
    let (basis, responses) = (compressed.basis(), compressed.responses());
    let mut out = Array2::zeros((compressed.shape().rows(), light.coefficients().ncols()));
    let stage = &compressed.label().transform;
    if stage.name == SrbfParams::NAME && responses.light_weights(basis) == basis.sphere_weights() {
        let mut source = Source::new(compressed.sections().into_sections())?;
        let transfer = Srbf::new(SrbfParams::from_stage(stage)?)?.restore(basis, &mut source)?;
        if transfer.kernel() == light.kernel() {
            compressed.apply_coefficients_into(transfer.light_of(light)?.view(), out.view_mut())?;
            return Ok(out);
        }
    }
    let texels = responses.light(basis, Light::lobes(light.clone()).on(basis, 0.0)?)?;
    compressed.apply_into(texels.view(), out.view_mut())?;
    Ok(out)
}

/// The rotation about an axis (x, y, z) by an angle in degrees, counter-clockwise seen from the axis' end.
fn rotation([x, y, z, degrees]: [f64; 4]) -> anyhow::Result<[[f64; 3]; 3]> {
    let axis = DVec3::new(x, y, z).try_normalize().context("--rotate: an axis of length 0 or infinity")?;
    let turned = DMat3::from_axis_angle(axis, degrees.to_radians());
    Ok([0, 1, 2].map(|i| turned.row(i).to_array()))
}

/// The numbers of `x,y,z,degrees`.
fn four(text: &str) -> std::result::Result<[f64; 4], String> {
    let numbers: Vec<f64> =
        text.split(',').filter_map(|n| n.trim().parse().ok()).filter(|n: &f64| n.is_finite()).collect();
    numbers.try_into().map_err(|_| "four numbers: x,y,z,degrees".into())
}

/// Light coefficients, lights x channels: as a file has them, or radiance on `basis` as `responses` expect it.
fn light(name: &str, basis: &LightBasis, responses: &ResponseBasis) -> Result<Array2<f32>> {
    let path = Path::new(name);
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("npy") => files::read_lights(path),
        _ => responses.light(basis, lights::light(name, basis)?),
    }
}
