//! `prt encode`: compresses a matrix by the method that a label describes.

use crate::files::{self, Description};
use crate::info::Info;
use crate::progress::Bar;
use crate::registry::{method, registry};
use crate::{memory, number, room, terminal};
use clap::Args;
use prt_transfer::{LightBasis, ResponseBasis};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `prt encode`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt encode haar+truncate:terms=64 teapot.npz -o teapot.prt\n  prt encode csr bare.npy --responses 64 --basis cubemap:32 -o bare.prt"
)]
pub struct Encode {
    /// The method: transform:name=value+codec:name=value; `prt methods` lists them
    pub label: String,
    /// Transfer matrix: .npz, .npy or .mtx
    #[arg(value_name = "MATRIX")]
    pub input: PathBuf,
    /// Where to write the compressed matrix
    #[arg(short, long, value_name = "FILE.prt")]
    pub output: PathBuf,
    /// What the rows of one sample stand for, where the matrix does not say: their number, or irradiance, local:8,
    /// exit:24, terms:16:BRDF
    #[arg(long, value_name = "RESPONSES")]
    pub responses: Option<ResponseBasis>,
    /// What the columns stand for, where the matrix does not say: cubemap:32, latlong:64x32, sh:5 or plain:100
    #[arg(long, value_name = "BASIS")]
    pub basis: Option<LightBasis>,
    /// The matrix holds what the label's light transform makes of the rows, as prt precompute --transform writes it; --basis is that of the
    /// lights
    #[arg(long, requires = "basis")]
    pub transformed: bool,
    /// Print what was written, as `prt info --json` does, with what encoding took
    #[arg(long)]
    pub json: bool,
}

/// What is printed. The names are a promise to programs that read them.
#[derive(Serialize)]
struct Written {
    /// The figures of the file, not of what was meant to be in it.
    #[serde(flatten)]
    info: Info,
    /// Wall clock of compressing, s.
    encode_s: f64,
    /// The most memory held while compressing, the result included and the matrix not.
    peak_encode_bytes: Option<u64>,
}

/// Runs the command.
pub fn run(arguments: &Encode) -> anyhow::Result<()> {
    files::expect_extension(&arguments.output, "prt")?;
    // First, so that a wrong label is told before a large file is read.
    let (registry, bar) = (registry(), Bar::default());
    let method = method(&registry, &arguments.label)?;
    let of_lights = arguments.basis.clone().filter(|_| arguments.transformed);
    let columns = match &of_lights {
        Some(basis) => Some(method.bind(basis)?.output()),
        None => arguments.basis.clone(),
    };
    let description = Description { responses: arguments.responses.clone(), basis: columns };
    let outline = files::outline(&arguments.input, &description)?;
    if let (Some((extent, basis)), None) = (outline, &of_lights) {
        room::check_method(&method, &extent, &basis, extent.bytes())?;
    }
    let matrix = files::read_matrix(&arguments.input, &description)?;
    let began = Instant::now();
    let (encoded, peak_encode_bytes) = memory::peak_of(|| match &of_lights {
        Some(basis) => method.encode_coefficients(&matrix, basis, &bar),
        None => method.encode(&matrix, &bar),
    });
    let encode_s = began.elapsed().as_secs_f64();
    let encoded = encoded?;
    let file = files::write_prt(&arguments.output, &encoded, &bar)?.file;
    drop(bar);
    if arguments.json {
        let info = Info::read(&arguments.output, &registry)?;
        return terminal::say_json(&Written { info, encode_s, peak_encode_bytes });
    }
    let [memory, file] = [encoded.resident_bytes() as u64, file].map(number::bytes);
    let peak = peak_encode_bytes.map_or("unknown".into(), number::bytes);
    let seconds = number::short(encode_s);
    let note = encoded.note().map_or(String::new(), |note| format!("\n{note}"));
    terminal::say(format!(
        "{memory} in memory, {file} on disk, encoded in {seconds} s with at most {peak} beside the matrix{note}"
    ))
}
