//! The command line of `prt slf`.

use crate::precompute::{count, pair};
use crate::scenes::Up;
use clap::Args;
use prt_transfer::Label;
use prt_transfer::params::Value;
use prt_transfer::responses::Directions;
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::light_field::{FieldParams, Horizon};
use prt_transfer::scene::path::PathParams;
use std::path::PathBuf;
use std::str::FromStr;

/// Arguments of `prt slf`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt slf cornell-spheres -o field\n  prt slf cornell-spheres --shape blue-sphere --texels 256x256 --method slf:clusters=auto:max_error=1e-3 -o field\n  prt slf vase.obj --brdf cook-torrance:roughness=0.2 --light hall.exr --directions 64x32 -o vase\n  prt render cornell-spheres --slf field -o picture.png\n\n--texels, --directions and --method count for all shapes, or with NAME= for one; the last that fits a shape holds."
)]
pub struct LightField {
    /// A built-in world (`prt scenes` lists them) or a mesh with texture coordinates (.ply, .obj)
    #[arg(value_name = "WORLD|MESH")]
    pub scene: String,
    /// Folder for a compressed field of each shape, SHAPE.prt, and their figures, shapes.csv
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Only this shape; may be repeated
    #[arg(long = "shape", value_name = "NAME", value_delimiter = ',')]
    pub shapes: Vec<String>,
    /// Texels of a shape's chart, X x Y [default: 128x128; 256x256 with --paper]
    #[arg(long, value_name = "[NAME=]XxY", value_parser = per_shape(size))]
    pub texels: Vec<PerShape<[usize; 2]>>,
    /// Directions of the sphere, Z x W [default: 32x16 of matte shapes, 64x32 of glossy ones]
    #[arg(long, value_name = "[NAME=]ZxW", value_parser = per_shape(size))]
    pub directions: Vec<PerShape<[usize; 2]>>,
    /// How a shape is compressed, by any method [default: slf:clusters=1:components=1 of matte shapes; slf:norm=radiance of glossy ones, without norm=radiance with --paper, and as many clusters as make 256 texels each]
    #[arg(long, value_name = "[NAME=]LABEL", value_parser = label)]
    pub method: Vec<PerShape<String>>,
    /// The sizes of the paper's Table 1: more texels, minutes to hours of tracing
    #[arg(long)]
    pub paper: bool,
    /// Each direction is the mean over s x s finer ones, a path each
    #[arg(long, value_name = "s", default_value_t = FieldParams::default().supersampling, value_parser = count(1, 16))]
    pub supersampling: usize,
    /// Width of the box filter in finer directions, odd or even as s is [default: s, a cell; the paper has 5]
    #[arg(long, value_name = "w", value_parser = count(1, 64))]
    pub filter: Option<usize>,
    /// Paths of a texel for what its surface reflects alike in all directions
    #[arg(long, value_name = "N", default_value_t = FieldParams::default().diffuse, value_parser = count(1, 65536))]
    pub diffuse_paths: usize,
    /// What a field holds below the horizon of a point: continued or dark
    #[arg(long, default_value = "continued", value_parser = horizon)]
    pub horizon: Horizon,
    /// Directions of a field: in the world, as in the paper, or reflected about the point's normal, in which lobes compress further
    /// [default: reflected; world with --paper]
    #[arg(long, value_name = "FRAME", value_parser = frame)]
    pub frame: Option<Directions>,
    /// How paths are traced.
    #[command(flatten)]
    pub paths: Paths,
    /// How a mesh looks.
    #[command(flatten)]
    pub look: LookArguments,
    /// Write each field as it was traced too, SHAPE.npy
    #[arg(long)]
    pub keep: bool,
    /// Print the figures of all shapes as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// How paths are traced.
#[derive(Args, Clone, Debug)]
pub struct Paths {
    /// Most reflections of a path; 1 is direct light
    #[arg(long, value_name = "N", default_value_t = PathParams::default().bounces, value_parser = count(0, 1000))]
    pub bounces: usize,
    /// Largest luminance that one path may add (biased: it takes fireflies away, and light with them) [default: none]
    #[arg(long, value_name = "L", value_parser = positive)]
    pub clamp: Option<f64>,
    /// Of what is drawn
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

/// How a mesh looks; a built-in world has its own lights and materials.
#[derive(Args, Clone, Debug)]
pub struct LookArguments {
    /// The light of a mesh: built in (`prt scenes` lists them) or a lat-long image (.exr, .hdr) [default: sky]
    #[arg(long, value_name = "LIGHT")]
    pub light: Option<String>,
    /// The reflectance of a mesh [default: lambert:albedo=0.7]
    #[arg(long)]
    pub brdf: Option<Brdf>,
    /// The axis of a mesh file that points up
    #[arg(long, value_name = "AXIS", default_value = "z")]
    pub up: Up,
}

/// A value for all shapes or for one.
#[derive(Clone, Debug, PartialEq)]
pub struct PerShape<T> {
    /// Which; all of them without a name.
    pub shape: Option<String>,
    /// What.
    pub value: T,
}

impl Paths {
    /// As the tracer takes them.
    pub fn params(&self) -> PathParams {
        PathParams { bounces: self.bounces, clamp: self.clamp, seed: self.seed, ..PathParams::default() }
    }
}

/// The last value that fits a shape.
pub(super) fn of_shape<'a, T>(values: &'a [PerShape<T>], shape: &str) -> Option<&'a T> {
    let fits = |value: &&PerShape<T>| value.shape.as_deref().is_none_or(|name| name == shape);
    values.iter().rev().find(fits).map(|value| &value.value)
}

/// `VALUE` or `NAME=VALUE`.
fn per_shape<T>(
    parse: fn(&str) -> Result<T, String>,
) -> impl Fn(&str) -> Result<PerShape<T>, String> + Clone + Send + Sync + 'static
where
    T: 'static,
{
    move |text| {
        let (shape, value) = match text.split_once('=') {
            Some((name, value)) => (Some(name.to_string()), value),
            None => (None, text),
        };
        Ok(PerShape { shape, value: parse(value)? })
    }
}

/// `LABEL` or `NAME=LABEL`: a name has no colon, and a label no equals sign before its first colon.
fn label(text: &str) -> Result<PerShape<String>, String> {
    let (shape, label) = match text.split_once('=') {
        Some((name, label)) if !name.contains([':', '+']) => (Some(name.to_string()), label),
        _ => (None, text),
    };
    let label = Label::from_str(label).map_err(|e| e.to_string())?;
    Ok(PerShape { shape, value: label.to_string() })
}

fn size(text: &str) -> Result<[usize; 2], String> {
    pair(text).ok_or_else(|| "expected two numbers such as 128x128".into())
}

fn horizon(text: &str) -> Result<Horizon, String> {
    Horizon::parse(text).ok_or_else(|| format!("expected {}", Horizon::expected()))
}

fn frame(text: &str) -> Result<Directions, String> {
    Directions::parse(text).ok_or_else(|| format!("expected {}", Directions::expected()))
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|l: &f64| *l > 0.0 && l.is_finite()).ok_or_else(|| "expected a number above 0".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_value_that_fits_a_shape_holds() {
        let values: Vec<PerShape<[usize; 2]>> =
            ["64x32", "torus=8x4", "sphere=16x8", "torus=4x2"].map(|t| per_shape(size)(t).unwrap()).into();
        assert_eq!(of_shape(&values, "torus"), Some(&[4, 2]));
        assert_eq!(of_shape(&values, "sphere"), Some(&[16, 8]));
        assert_eq!(of_shape(&values, "wall"), Some(&[64, 32]));
        assert_eq!(of_shape::<[usize; 2]>(&[], "wall"), None);
    }

    #[test]
    fn labels_are_told_from_names() {
        let of = |text: &str| label(text).map(|l| (l.shape, l.value)).unwrap();
        assert_eq!(of("slf:clusters=4"), (None, "slf:clusters=4".into()));
        assert_eq!(of("torus=slf:clusters=4"), (Some("torus".into()), "slf:clusters=4".into()));
        assert_eq!(of("haar:scale=sphere+truncate"), (None, "haar:scale=sphere+truncate".into()));
        assert!(label("torus=").is_err() && label("").is_err());
    }
}
