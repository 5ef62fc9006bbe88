//! The command line of `prt render`.

use crate::pictures::{AZIMUTH, ELEVATION, FIELD_OF_VIEW};
use crate::precompute::{count, pair};
use crate::scenes::Up;
use crate::worlds;
use clap::Args;
use glam::Vec3;
use prt_slf::Interpolation;
use prt_transfer::image::Tone;
use prt_transfer::mesh::Mesh;
use prt_transfer::params::Value;
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::camera::{Camera, Film};
use prt_transfer::{LightBasis, ResponseBasis};
use std::path::PathBuf;

/// Arguments of `prt render`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt render teapot teapot.prt -o teapot.png\n  prt render bunny.ply bunny.npz --up y --light hall.exr --azimuth 200 --elevation 15 -o bunny.png\n  prt render teapot --reference -o exact.exr\n  prt render teapot teapot.prt --compare exact.exr --error-map error.png -o teapot.png\n  prt render cornell-spheres --slf field -o picture.png\n  prt render cornell-spheres --reference --samples 16 -o paths.exr"
)]
pub struct Render {
    /// A built-in scene or world (`prt scenes` lists them) or a mesh (.ply, .obj): the one that the matrix or the fields were computed of
    #[arg(value_name = "SCENE|MESH")]
    pub scene: String,
    /// Its matrix, of any signal: .prt, .npz, .npy or .mtx
    #[arg(required_unless_present_any = ["reference", "slf"], conflicts_with_all = ["reference", "slf"])]
    pub matrix: Option<PathBuf>,
    /// Instead of a matrix: the folder of surface light fields that `prt slf` made; shapes without one are traced
    #[arg(long, value_name = "DIR", conflicts_with = "reference")]
    pub slf: Option<PathBuf>,
    /// Instead of a matrix: trace direct light at every sample of the picture; paths in a world and with --bounces
    #[arg(long)]
    pub reference: bool,
    /// With --reference: paths of at most N reflections, also of a mesh; 1 is direct light [default: 32 in a world]
    #[arg(long, value_name = "N", requires = "reference", value_parser = count(0, 1000))]
    pub bounces: Option<usize>,
    /// Of paths [default: 0]
    #[arg(long, value_name = "SEED", conflicts_with = "matrix")]
    pub seed: Option<u64>,
    /// Between texels and directions of --slf: bilinear, or paper (inverse distances and e^(d·d')) [default: bilinear]
    #[arg(long, value_name = "RULE", value_parser = interpolation)]
    pub interpolation: Option<Interpolation>,
    /// Where to write the picture: .png (exposed, tone-mapped) or .exr (linear radiance)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Vertices of a built-in scene, as they were asked of `prt precompute` [default: the scene's own]
    #[arg(long, value_name = "N", value_parser = count(1, 100_000_000))]
    pub vertices: Option<usize>,
    /// The axis of a mesh file that points up, as it was given to prt precompute
    #[arg(long, value_name = "AXIS", default_value = "z")]
    pub up: Up,
    /// What the rows of a sample stand for, where the matrix does not say: irradiance, local:8, exit:24 or terms:16:BRDF
    #[arg(long, value_name = "RESPONSES", conflicts_with = "reference")]
    pub responses: Option<ResponseBasis>,
    /// What the columns stand for, where the matrix does not say; with --reference the cubemap on which light is sampled
    /// [default: cubemap:32]
    #[arg(long, value_name = "BASIS")]
    pub basis: Option<LightBasis>,
    /// Visibility of --reference is sampled with 2^m x 2^m rays for each texel [default: 1]
    #[arg(long, value_name = "m", value_parser = clap::value_parser!(u32).range(0..=4))]
    pub supersampling: Option<u32>,
    /// The surface's reflectance, where no matrix holds it already: with --reference and biscale any, with diffuse lambert (see prt scenes)
    /// [default: lambert]
    #[arg(long)]
    pub brdf: Option<Brdf>,
    /// A built-in light (`prt scenes` lists them) or a lat-long image (.exr, .hdr); a built-in world has its own [default: sky]
    #[arg(long, value_name = "LIGHT")]
    pub light: Option<String>,
    /// Where the camera is.
    #[command(flatten)]
    pub place: Place,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "640x480", value_parser = size)]
    pub size: [usize; 2],
    /// Each pixel is the mean of n x n samples, n from 1 to 16, and to 64 of paths [default: 4; 2 with --reference of a mesh, 3 with --slf]
    #[arg(long, value_name = "n")]
    pub samples: Option<usize>,
    /// What is behind the scene: light, or a colour of the screen (linear, before the tone curve): black, white or r,g,b
    #[arg(long, default_value = "light", value_parser = background)]
    pub background: Background,
    /// Stops by which radiance is raised, or auto: 95 percent of the surface stay below 0.6 of white (with --compare, in the
    /// picture compared with) [default: auto]
    #[arg(long, value_name = "EV|auto", allow_hyphen_values = true, value_parser = exposure)]
    pub exposure: Option<Exposure>,
    /// The curve to the screen: clip or filmic [default: clip]
    #[arg(long, value_parser = tone)]
    pub tone: Option<Tone>,
    /// Tell the error against a picture (.exr) of the same camera, over the pixels that the surface fills
    #[arg(long, value_name = "FILE.exr")]
    pub compare: Option<PathBuf>,
    /// Write the error of each pixel: black up to 0.001 of white, then violet, red, orange, pale yellow from 1 on
    #[arg(long, value_name = "FILE.png", requires = "compare")]
    pub error_map: Option<PathBuf>,
    /// Write the picture, the one compared with and the error of each pixel side by side
    #[arg(long, value_name = "FILE.png", requires = "compare")]
    pub beside: Option<PathBuf>,
    /// Print seconds, exposure and errors as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Where the camera is.
#[derive(Args, Debug)]
pub struct Place {
    /// Degrees from +x towards +y at which the camera stands, seen from the middle of the scene [default: 30; a built-in world has a view of its own]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub azimuth: Option<f64>,
    /// Degrees above the horizon at which the camera stands [default: 15]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub elevation: Option<f64>,
    /// Degrees that the shorter side of the picture spans
    #[arg(long, value_name = "DEGREES", default_value_t = FIELD_OF_VIEW)]
    pub fov: f64,
    /// Magnify the part of the picture that the scene fills
    #[arg(long)]
    pub crop: bool,
    /// Where the camera is, instead of angles
    #[arg(long, value_name = "X,Y,Z", requires = "target", conflicts_with_all = ["azimuth", "elevation"], allow_hyphen_values = true, value_parser = vector)]
    pub eye: Option<Vec3>,
    /// What it looks at
    #[arg(long, value_name = "X,Y,Z", requires = "eye", allow_hyphen_values = true, value_parser = vector)]
    pub target: Option<Vec3>,
}

/// What is behind the scene.
#[derive(Clone, Copy, Debug)]
pub enum Background {
    /// The light itself.
    Light,
    /// Linear RGB at the exposure used: 1 is white.
    Screen([f32; 3]),
}

/// How bright a picture is.
#[derive(Clone, Copy, Debug)]
pub enum Exposure {
    /// See [`prt_transfer::image::Image::automatic_exposure`].
    Auto,
    /// Radiance is multiplied by 2 to this power.
    Stops(f64),
}

impl Render {
    /// The camera that is asked for.
    pub fn camera(&self, mesh: &Mesh) -> prt_transfer::Result<Camera> {
        let Place { azimuth, elevation, fov, crop, eye, target } = self.place;
        let [width, height] = self.size;
        let film = Film { width, height, field_of_view: fov };
        let usual = || worlds::view(&self.scene).filter(|_| azimuth.is_none() && elevation.is_none());
        let camera = match eye.zip(target).or_else(|| usual().map(Into::into)) {
            Some((eye, target)) => Camera::looking(eye, target, film)?,
            None => Camera::framing(mesh, azimuth.unwrap_or(AZIMUTH), elevation.unwrap_or(ELEVATION), film)?,
        };
        if crop { camera.cropped(&mesh.positions) } else { Ok(camera) }
    }
}

fn numbers(text: &str) -> Option<[f32; 3]> {
    let parts: Option<Vec<f32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    parts?.try_into().ok().filter(|all: &[f32; 3]| all.iter().all(|x| x.is_finite()))
}

fn vector(text: &str) -> Result<Vec3, String> {
    numbers(text).map(Vec3::from_array).ok_or_else(|| "expected three numbers, x,y,z".into())
}

fn size(text: &str) -> Result<[usize; 2], String> {
    pair(text).ok_or_else(|| "expected WIDTHxHEIGHT in pixels, such as 640x480".into())
}

fn background(text: &str) -> Result<Background, String> {
    match text {
        "light" => Ok(Background::Light),
        "black" => Ok(Background::Screen([0.0; 3])),
        "white" => Ok(Background::Screen([1.0; 3])),
        colour => match numbers(colour) {
            Some(rgb) if rgb.iter().all(|&c| c >= 0.0) => Ok(Background::Screen(rgb)),
            _ => Err("expected light, black, white or three numbers r,g,b from 0".into()),
        },
    }
}

fn exposure(text: &str) -> Result<Exposure, String> {
    match text.parse() {
        _ if text == "auto" => Ok(Exposure::Auto),
        Ok(stops) if (-100.0..=100.0).contains(&stops) => Ok(Exposure::Stops(stops)),
        _ => Err("expected auto or a number of stops from -100 to 100".into()),
    }
}

fn interpolation(text: &str) -> Result<Interpolation, String> {
    match text {
        "bilinear" => Ok(Interpolation::Bilinear),
        "paper" => Ok(Interpolation::Paper),
        _ => Err("expected bilinear or paper".into()),
    }
}

fn tone(text: &str) -> Result<Tone, String> {
    Tone::parse(text).ok_or_else(|| format!("expected {}", Tone::expected()))
}
