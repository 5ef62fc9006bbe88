//! What the columns of a transfer matrix stand for.
//!
//! A light is `L(ω) = Σ_k x_k b_k(ω)`; a row of the matrix holds the moments `T_k = ∫ f(ω) b_k(ω) dω` of its transfer
//! function `f`, so that `y = Σ_k T_k x_k = ∫ f L dω`. For texels `b_k` is 1 on texel `k`, `x_k` is the radiance there and
//! `T_k` includes the texel's solid angle. The norm of `f` over the sphere is then
//! `Tᵀ G⁻¹ T` with the Gram matrix `G` of the basis; for texels, where `G = diag(dω)`, that is `Σ T_k² / dω_k`. It is the
//! expected square of `y` under light that is white noise over the sphere, and an error in it the expected squared error of relit
//! output. Where the light brings the solid angles along instead, as for `biscale`, the same is `Σ T_k² dω_k`
//! ([`crate::ResponseBasis::light_weights`]).

use crate::error::{Error, Result};
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// A direction on the unit sphere, z up: `[x, y, z]`.
pub type Direction = [f64; 3];

/// The light basis of a transfer matrix's columns. Written as `cubemap:32`, `latlong:64x32`, `sh:5`, `lobes:642`,
/// `lobes:642:orthonormal` or `plain:100`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum LightBasis {
    /// Coefficients without a place on the sphere.
    Plain {
        /// How many.
        lights: usize,
    },
    /// Six faces +x, -x, +y, -y, +z, -z of `resolution`² texels each; see [`cubemap_direction`].
    Cubemap {
        /// Texels along an edge of a face.
        resolution: usize,
    },
    /// Latitude-longitude grid, rows from +z (north) to -z; see [`latlong_direction`].
    LatLong {
        /// Texels around the equator.
        width: usize,
        /// Texels from pole to pole.
        height: usize,
    },
    /// Orthonormal real spherical harmonics of bands 0 to order-1, index `l(l+1)+m`, no Condon-Shortley phase.
    SphericalHarmonics {
        /// Bands; order² coefficients.
        order: usize,
    },
    /// Spherical radial basis functions, of which their own transform knows where they are: what its rows C multiply.
    Lobes {
        /// How many.
        lights: usize,
        /// Whether columns stand for orthonormal functions of the lobes' span and not for the lobes themselves.
        orthonormal: bool,
    },
}

/// Face axes: the direction of texel (u, v) in [-1, 1]² of face f is `forward + u·right + v·up`.
///
/// Faces are +x, -x, +y, -y, +z, -z. Every face is seen from inside with `right × up = -forward`.
pub const FACES: [[Direction; 3]; 6] = [
    // forward, right (columns), down (rows)
    [[1., 0., 0.], [0., 0., -1.], [0., -1., 0.]],
    [[-1., 0., 0.], [0., 0., 1.], [0., -1., 0.]],
    [[0., 1., 0.], [1., 0., 0.], [0., 0., 1.]],
    [[0., -1., 0.], [1., 0., 0.], [0., 0., -1.]],
    [[0., 0., 1.], [1., 0., 0.], [0., -1., 0.]],
    [[0., 0., -1.], [-1., 0., 0.], [0., -1., 0.]],
];

/// The unit direction through face coordinates `u` (columns, rightward) and `v` (rows, downward) in [-1, 1].
pub fn cubemap_direction(face: usize, u: f64, v: f64) -> Direction {
    let [forward, right, down] = FACES[face];
    let d: Direction = std::array::from_fn(|i| forward[i] + u * right[i] + v * down[i]);
    let norm = (1.0 + u * u + v * v).sqrt();
    d.map(|c| c / norm)
}

/// Solid angle in sr of the face rectangle from `(u0, v0)` to `(u1, v1)`.
pub fn cubemap_solid_angle(u0: f64, v0: f64, u1: f64, v1: f64) -> f64 {
    // ∫∫ (1 + u² + v²)^(-3/2) du dv has the antiderivative atan(uv / sqrt(1 + u² + v²)).
    let corner = |u: f64, v: f64| (u * v / (1.0 + u * u + v * v).sqrt()).atan();
    corner(u1, v1) - corner(u0, v1) - corner(u1, v0) + corner(u0, v0)
}

/// The unit direction at longitude `s` and colatitude `t`, both as fractions of the image (0 at its left and top edge).
///
/// The top of the image is +z; its centre column looks along +x, and longitude grows clockwise seen from above (as in
/// environment maps photographed from inside).
pub fn latlong_direction(s: f64, t: f64) -> Direction {
    let (phi, theta) = (PI - 2.0 * PI * s, PI * t);
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

impl LightBasis {
    /// Light coefficients: columns of the matrix.
    pub fn lights(&self) -> usize {
        match *self {
            LightBasis::Plain { lights } | LightBasis::Lobes { lights, .. } => lights,
            LightBasis::Cubemap { resolution } => 6 * resolution * resolution,
            LightBasis::LatLong { width, height } => width * height,
            LightBasis::SphericalHarmonics { order } => order * order,
        }
    }

    /// The direction of each column's centre, where columns are texels.
    pub fn directions(&self) -> Option<Vec<Direction>> {
        let centre = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        match *self {
            LightBasis::Cubemap { resolution: r } => {
                let edge = |i| 2.0 * centre(i, r) - 1.0;
                Some((0..6 * r * r).map(|k| cubemap_direction(k / (r * r), edge(k % r), edge(k / r % r))).collect())
            }
            LightBasis::LatLong { width, height } => Some(
                (0..width * height)
                    .map(|k| latlong_direction(centre(k % width, width), centre(k / width, height)))
                    .collect(),
            ),
            _ => None,
        }
    }

    /// The solid angle of each column in sr, where columns are texels; their sum is 4π.
    pub fn solid_angles(&self) -> Option<Vec<f64>> {
        match *self {
            LightBasis::Cubemap { resolution: r } => {
                let edge = |i: usize| 2.0 * i as f64 / r as f64 - 1.0;
                let face: Vec<f64> = (0..r * r)
                    .map(|k| (k % r, k / r))
                    .map(|(i, j)| cubemap_solid_angle(edge(i), edge(j), edge(i + 1), edge(j + 1)))
                    .collect();
                Some(face.repeat(6))
            }
            LightBasis::LatLong { width, height } => {
                let ring = |t: usize| (PI * t as f64 / height as f64).cos();
                Some(
                    (0..width * height)
                        .map(|k| (ring(k / width) - ring(k / width + 1)) * 2.0 * PI / width as f64)
                        .collect(),
                )
            }
            _ => None,
        }
    }

    /// The diagonal of G⁻¹, scaled to a mean of 1: weights that turn Σ ΔT² into an error over the sphere. `None` where the
    /// basis is orthonormal (every weight 1) or has no place on the sphere.
    pub fn sphere_weights(&self) -> Option<Vec<f64>> {
        let angles = self.solid_angles()?;
        let mean = angles.iter().map(|a| 1.0 / a).sum::<f64>() / angles.len() as f64;
        Some(angles.iter().map(|a| 1.0 / (a * mean)).collect())
    }
}

impl fmt::Display for LightBasis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LightBasis::Plain { lights } => write!(f, "plain:{lights}"),
            LightBasis::Cubemap { resolution } => write!(f, "cubemap:{resolution}"),
            LightBasis::LatLong { width, height } => write!(f, "latlong:{width}x{height}"),
            LightBasis::SphericalHarmonics { order } => write!(f, "sh:{order}"),
            LightBasis::Lobes { lights, orthonormal: false } => write!(f, "lobes:{lights}"),
            LightBasis::Lobes { lights, orthonormal: true } => write!(f, "lobes:{lights}:orthonormal"),
        }
    }
}

impl FromStr for LightBasis {
    type Err = Error;

    fn from_str(text: &str) -> Result<LightBasis> {
        let refuse = || Error::Unknown {
            what: "light basis",
            name: text.into(),
            known: "cubemap:EDGE, latlong:WIDTHxHEIGHT, sh:ORDER, lobes:LIGHTS, lobes:LIGHTS:orthonormal, plain:LIGHTS"
                .into(),
        };
        let number = |t: &str| {
            t.parse::<usize>().ok().filter(|n| (1..=crate::matrix::MAX_LIGHTS).contains(n)).ok_or_else(refuse)
        };
        let (kind, size) = text.split_once(':').ok_or_else(refuse)?;
        let basis = match kind {
            "plain" => LightBasis::Plain { lights: size.parse().map_err(|_| refuse())? },
            "cubemap" => LightBasis::Cubemap { resolution: number(size)? },
            "lobes" => match size.split_once(':') {
                None => LightBasis::Lobes { lights: number(size)?, orthonormal: false },
                Some((size, "orthonormal")) => LightBasis::Lobes { lights: number(size)?, orthonormal: true },
                Some(_) => return Err(refuse()),
            },
            "sh" => LightBasis::SphericalHarmonics { order: number(size)? },
            "latlong" => {
                let (width, height) = size.split_once('x').ok_or_else(refuse)?;
                LightBasis::LatLong { width: number(width)?, height: number(height)? }
            }
            _ => return Err(refuse()),
        };
        // The products below cannot overflow: each factor is at most 2^25.
        match basis.lights() {
            lights if lights <= crate::matrix::MAX_LIGHTS => Ok(basis),
            lights => Err(Error::TooLarge {
                what: format!("light coefficients of basis {text}"),
                limit: crate::matrix::MAX_LIGHTS as u64,
                found: lights as u64,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angles_add_up_to_the_sphere_and_match_quadrature() {
        for basis in [LightBasis::Cubemap { resolution: 7 }, LightBasis::LatLong { width: 12, height: 5 }] {
            let sum: f64 = basis.solid_angles().unwrap().iter().sum();
            assert!((sum - 4.0 * PI).abs() < 1e-12, "{basis}: {sum}");
        }
        // Second way: midpoint rule over one texel.
        let (n, mut sum) = (400, 0.0);
        for k in 0..n * n {
            let (u, v) =
                (0.5 + 0.25 * ((k % n) as f64 + 0.5) / n as f64, -1.0 + 0.25 * ((k / n) as f64 + 0.5) / n as f64);
            sum += (1.0 + u * u + v * v).powf(-1.5) * (0.25 / n as f64).powi(2);
        }
        assert!((sum - cubemap_solid_angle(0.5, -1.0, 0.75, -0.75)).abs() < 1e-7);
    }

    #[test]
    fn directions_are_unit_and_the_faces_cover_the_sphere_once() {
        let basis = LightBasis::Cubemap { resolution: 16 };
        let (directions, angles) = (basis.directions().unwrap(), basis.solid_angles().unwrap());
        let mut second_moment = [[0.0; 3]; 3];
        for (d, a) in directions.iter().zip(&angles) {
            assert!((d.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
            for (i, row) in second_moment.iter_mut().enumerate() {
                row.iter_mut().zip(d).for_each(|(m, dj)| *m += d[i] * dj * a);
            }
        }
        // ∫ d dᵀ dω = 4π/3 I
        for (i, row) in second_moment.iter().enumerate() {
            for (j, m) in row.iter().enumerate() {
                let expected = if i == j { 4.0 * PI / 3.0 } else { 0.0 };
                assert!((m - expected).abs() < 0.01, "{i} {j} {m}");
            }
        }
    }

    #[test]
    fn every_basis_reads_back_what_it_prints() {
        for text in ["cubemap:32", "latlong:64x32", "sh:5", "lobes:642", "lobes:12:orthonormal", "plain:100"] {
            assert_eq!(text.parse::<LightBasis>().unwrap().to_string(), text);
        }
        for text in
            ["cubemap", "cubemap:0", "cubemap:-1", "sh:9999999", "latlong:3", "x:1", "plain:", "lobes:0", "lobes:9:x"]
        {
            assert!(text.parse::<LightBasis>().is_err(), "{text}");
        }
    }
}
