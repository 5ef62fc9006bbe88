//! Integrals over an interval and over texels.

use crate::basis::{Direction, LightBasis, cubemap_direction, latlong_direction};
use std::f64::consts::PI;

/// Nodes in (-1, 1) and weights with which polynomials of degree 2n-1 are integrated exactly.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            // Newton's method on P_n, from Tricomi's approximation of its roots.
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut before, mut p) = (0.0, 1.0);
                for k in 0..n {
                    (before, p) = (p, ((2 * k + 1) as f64 * x * p - k as f64 * before) / (k + 1) as f64);
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// The texels of a cubemap or a latitude-longitude grid as domains of integration: each is the image of the square [0, 1]².
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texels(Grid);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grid {
    Cubemap { resolution: usize },
    LatLong { width: usize, height: usize },
}

impl Texels {
    /// Those of a basis; `None` where it has none.
    pub fn of(basis: &LightBasis) -> Option<Texels> {
        match *basis {
            LightBasis::Cubemap { resolution } if resolution > 0 => Some(Texels(Grid::Cubemap { resolution })),
            LightBasis::LatLong { width, height } if width > 0 && height > 0 => {
                Some(Texels(Grid::LatLong { width, height }))
            }
            _ => None,
        }
    }

    /// The angle of a texel's longer edge in rad: at the equator, or on average along the middle of a face.
    pub fn edge(&self) -> f64 {
        match self.0 {
            Grid::Cubemap { resolution } => 0.5 * PI / resolution as f64,
            Grid::LatLong { width, height } => (2.0 * PI / width as f64).max(PI / height as f64),
        }
    }

    /// An angle in rad within which all of a texel lies around its centre.
    pub fn radius(&self) -> f64 {
        match self.0 {
            // Half a diagonal of the face's square, which lies outside the sphere.
            Grid::Cubemap { resolution } => 2f64.sqrt() / resolution as f64,
            // Along the parallel, then along the meridian.
            Grid::LatLong { width, height } => PI / width as f64 + 0.5 * PI / height as f64,
        }
    }

    /// The direction at a place in [0, 1]² of texel `k`, and the solid angle per area of that square in sr.
    pub fn point(&self, k: usize, s: f64, t: f64) -> (Direction, f64) {
        match self.0 {
            Grid::Cubemap { resolution: r } => {
                let edge = 2.0 / r as f64;
                let (u, v) = (edge * ((k % r) as f64 + s) - 1.0, edge * ((k / r % r) as f64 + t) - 1.0);
                (cubemap_direction(k / (r * r), u, v), edge * edge * (1.0 + u * u + v * v).powf(-1.5))
            }
            Grid::LatLong { width, height } => {
                let (s, t) = (((k % width) as f64 + s) / width as f64, ((k / width) as f64 + t) / height as f64);
                let cell = 2.0 * PI * PI / (width * height) as f64;
                (latlong_direction(s, t), cell * (PI * t).sin())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_integrates_polynomials_exactly() {
        for n in 1..40 {
            let nodes = gauss_legendre(n);
            for degree in 0..2 * n {
                let sum: f64 = nodes.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree + 1) as f64 } else { 0.0 };
                assert!((sum - exact).abs() < 1e-13, "{n} nodes, degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn a_texel_is_the_image_of_a_square_with_its_solid_angle_and_lies_within_its_radius() {
        for basis in ["cubemap:1", "cubemap:2", "cubemap:9", "latlong:8x4", "latlong:1x3", "latlong:3x1", "latlong:1x1"]
        {
            let basis: LightBasis = basis.parse().unwrap();
            let texels = Texels::of(&basis).unwrap();
            let (nodes, angles) = (gauss_legendre(24), basis.solid_angles().unwrap());
            for (k, centre) in basis.directions().unwrap().into_iter().enumerate() {
                let mut sum = 0.0;
                for (s, s_weight) in &nodes {
                    for (t, t_weight) in &nodes {
                        let (direction, density) = texels.point(k, 0.5 + 0.5 * s, 0.5 + 0.5 * t);
                        sum += 0.25 * s_weight * t_weight * density;
                        let cosine: f64 = direction.iter().zip(centre).map(|(a, b)| a * b).sum();
                        assert!(cosine.clamp(-1.0, 1.0).acos() <= texels.radius() + 1e-12, "{basis} {k}");
                    }
                }
                assert!((sum / angles[k] - 1.0).abs() < 1e-9, "{basis} {k}: {sum} {}", angles[k]);
            }
            assert!(texels.edge() > 0.0 && texels.edge() <= 2.0 * texels.radius() + 1e-12);
        }
        assert_eq!(Texels::of(&LightBasis::Plain { lights: 6 }), None);
        assert_eq!(Texels::of(&LightBasis::SphericalHarmonics { order: 3 }), None);
    }
}
