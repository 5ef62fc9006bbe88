//! The one place where the program learns of scenes, lights and signals.

use crate::signal::{Signal, Spec};
use ndarray::Array2;
use prt_transfer::basis::Direction;
use prt_transfer::{Error, LightBasis, Progress, Result, TransferMatrix};
use serde::Serialize;
use std::f64::consts::PI;
use std::time::Instant;

/// A built-in scene or light.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// Its name.
    pub name: &'static str,
    /// A sentence.
    pub about: &'static str,
}

/// A matrix and what it took.
pub struct Precomputed {
    /// The transfer matrix.
    pub matrix: TransferMatrix,
    /// Rays cast.
    pub rays: u64,
    /// Wall clock, s.
    pub seconds: f64,
}

/// The lights under which `prt bench` compares relit output, in the order of the columns of results.csv.
pub const LIGHTS: [&str; 2] = ["sky", "room"];

/// Every built-in scene.
pub fn scenes() -> Vec<About> {
    vec![About { name: "sphere", about: "A unit sphere: convex, so that its transfer has a closed form" }]
}

/// Every built-in light.
pub fn lights() -> Vec<About> {
    vec![
        About { name: "sky", about: "A bright gradient with a sun" },
        About { name: "room", about: "Windows and small lamps in a dark room" },
    ]
}

/// Vertices of a built-in scene where nobody asks for another number.
pub const VERTICES: usize = 1000;

/// The transfer matrix of a built-in scene with about `vertices` vertices, or of a mesh file, which has its own.
pub fn precompute(scene: &str, vertices: Option<usize>, spec: &Spec, progress: &dyn Progress) -> Result<Precomputed> {
    if scene != "sphere" {
        return Err(Error::Unknown { what: "scene", name: scene.into(), known: "sphere".into() });
    }
    let began = Instant::now();
    let matrix = sphere(vertices.unwrap_or(VERTICES), spec, progress)?;
    Ok(Precomputed { matrix, rays: 0, seconds: began.elapsed().as_secs_f64() })
}

/// A built-in light or an image file in `basis`: lights x 3 channels.
pub fn light(name: &str, basis: &LightBasis) -> Result<Array2<f32>> {
    let radiance: fn(Direction) -> [f64; 3] = match name {
        "sky" => |d| {
            let sun = if d[0] * 0.6 + d[2] * 0.8 > 0.995 { 2000.0 } else { 0.0 };
            [0.3 + 0.2 * d[2] + sun, 0.5 + 0.3 * d[2] + sun, 0.8 + 0.4 * d[2] + 0.8 * sun]
        },
        "room" => |d| {
            let window = if d[1] > 0.8 { 40.0 } else { 0.1 };
            let lamp = if d[2] > 0.99 { 900.0 } else { 0.0 };
            [window + lamp, window + 0.8 * lamp, 1.2 * window + 0.4 * lamp]
        },
        _ => return Err(Error::Unknown { what: "light", name: name.into(), known: LIGHTS.join(", ") }),
    };
    let directions = basis.directions().ok_or_else(|| Error::Unsupported {
        what: format!("light '{name}'"),
        expected: "a basis of texels".into(),
        found: basis.to_string(),
    })?;
    Ok(Array2::from_shape_fn((basis.lights(), 3), |(k, channel)| radiance(directions[k])[channel] as f32))
}

/// Unoccluded transfer on a Fibonacci lattice of normals.
fn sphere(vertices: usize, spec: &Spec, progress: &dyn Progress) -> Result<TransferMatrix> {
    let directions = spec.basis.directions().unwrap_or_default();
    Error::expect_size(format!("texels of basis {}", spec.basis), spec.basis.lights(), directions.len())?;
    let angles = spec.basis.solid_angles().unwrap_or_default();
    let responses = if spec.signal == Signal::Biscale { spec.local_directions * spec.local_directions } else { 1 };
    progress.start("precompute", vertices as u64);
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for vertex in 0..vertices {
        let z = 1.0 - (2.0 * vertex as f64 + 1.0) / vertices as f64;
        let (r, phi) = ((1.0 - z * z).sqrt(), vertex as f64 * PI * (3.0 - 5f64.sqrt()));
        let normal = [r * phi.cos(), r * phi.sin(), z];
        let cosine = |k: usize| directions[k].iter().zip(normal).map(|(d, n)| d * n).sum::<f64>();
        for response in 0..responses {
            for k in (0..directions.len()).filter(|&k| cosine(k) > 0.0) {
                match spec.signal {
                    Signal::Diffuse => values.push((cosine(k) * angles[k] / PI) as f32),
                    Signal::Biscale if (cosine(k) * responses as f64) as usize == response => values.push(1.0),
                    Signal::Biscale => continue,
                }
                columns.push(k as u32);
            }
            offsets.push(columns.len());
        }
        progress.advance(1)?;
    }
    TransferMatrix::from_csr(offsets, columns, values, responses, spec.basis.clone())
}
