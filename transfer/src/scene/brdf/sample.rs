//! Directions drawn in proportion to a lobe, or nearly so: what a path tracer follows.
//!
//! Microfacet lobes (Cook-Torrance, Ward) are drawn by their half vectors h, whose slopes (x, y) = h_xy/h_z are Gaussian: with
//! p_h = exp(-x²/αx² - y²/αy²) / (π αx αy h_z³) per solid angle of h, the mirrored direction has p = p_h / (4 v·h) (Walter, Marschner, Li
//! and Torrance, "Microfacet Models for Refraction through Rough Surfaces", 2007). A cosine power is drawn about the mirror direction.
//! Directions at the horizon or below are refused, and p integrates to 1 less what they would have had. The quotient lobe · cos θ / p is
//! bounded in every model: by 2 ks for both microfacet lobes, by ks (n+2)/(n+1) for the cosine power.

use super::{Brdf, HORIZON};
use crate::codec::Configure;
use glam::DVec3;
use std::f64::consts::TAU;

impl Brdf {
    /// A light direction for a view, both unit and local, drawn with the density [`Brdf::lobe_pdf`] from `u`, uniform in [0, 1)²; `None`
    /// where the draw falls to the horizon or below, which is a sample of value 0, and where the model has no lobe.
    pub fn sample_lobe(&self, view: DVec3, u: [f64; 2]) -> Option<DVec3> {
        let light = match (self, self.slopes()) {
            (_, Some(widths)) => about_half_vector(view, widths, u),
            (Brdf::Phong(model), _) => about_mirror(view, model.params().exponent, u),
            _ => None,
        };
        light.filter(|light| light.z > HORIZON && view.z > HORIZON)
    }

    /// The density, per steradian, with which [`Brdf::sample_lobe`] draws `light`; 0 where it never does.
    #[inline]
    pub fn lobe_pdf(&self, view: DVec3, light: DVec3) -> f64 {
        if view.z <= HORIZON || light.z <= HORIZON {
            return 0.0;
        }
        match (self, self.slopes()) {
            (_, Some([alpha_x, alpha_y])) => {
                // H = v + s is not normalised: h_z = H_z/|H|, and v·h = |H|/2.
                let half = view + light;
                let slope = ((half.x / alpha_x).powi(2) + (half.y / alpha_y).powi(2)) / (half.z * half.z);
                (-slope).exp() * half.length_squared() / (TAU * alpha_x * alpha_y * half.z.powi(3))
            }
            (Brdf::Phong(model), _) => {
                let n = model.params().exponent;
                let cosine = view.z * light.z - (view.x * light.x + view.y * light.y);
                (n + 1.0) / TAU * cosine.max(0.0).powf(n)
            }
            _ => 0.0,
        }
    }

    /// About the lobe's part of [`Brdf::albedo`], at the cost of a few products; 0 exactly where there is no lobe.
    pub(crate) fn lobe_estimate(&self, view: DVec3) -> f64 {
        match self {
            Brdf::Lambert(_) => 0.0,
            Brdf::Phong(model) => model.params().specular,
            Brdf::CookTorrance(model) => model.params().specular * model.fresnel(view.z.min(1.0)),
            Brdf::Ward(model) => model.params().specular,
        }
    }

    /// αx and αy of a lobe that is drawn by its half vector.
    #[inline]
    fn slopes(&self) -> Option<[f64; 2]> {
        match self {
            Brdf::Lambert(_) | Brdf::Phong(_) => None,
            Brdf::CookTorrance(model) => Some([model.params().roughness; 2]),
            Brdf::Ward(model) => Some([model.params().alpha_x, model.params().alpha_y]),
        }
    }
}

/// `view` mirrored at a half vector of Gaussian slopes: a radius t with density 2t exp(-t²) and any azimuth, stretched by the widths.
fn about_half_vector(view: DVec3, [alpha_x, alpha_y]: [f64; 2], [u, v]: [f64; 2]) -> Option<DVec3> {
    let (t, (sin, cos)) = ((-(-u).ln_1p()).sqrt(), (TAU * v).sin_cos());
    let half = DVec3::new(alpha_x * t * cos, alpha_y * t * sin, 1.0).normalize();
    let cosine = view.dot(half);
    (cosine > 0.0).then(|| (2.0 * cosine * half - view).normalize())
}

/// A direction at an angle α to the mirrored `view`: cos α = u^(1/(n+1)).
fn about_mirror(view: DVec3, n: f64, [u, v]: [f64; 2]) -> Option<DVec3> {
    let mirror = DVec3::new(-view.x, -view.y, view.z);
    // 1 - u is never 0. sin² α = 1 - cos² α without cancellation.
    let log = (-u).ln_1p() / (n + 1.0);
    let (cosine, sine) = (log.exp(), (-(2.0 * log).exp_m1()).max(0.0).sqrt());
    let ((sin, cos), (a, b)) = ((TAU * v).sin_cos(), mirror.any_orthonormal_pair());
    Some(cosine * mirror + sine * (cos * a + sin * b))
}

/// The direction of the hemisphere with density cos θ / π above a uniform point of the square: Malley's method.
pub(crate) fn cosine_hemisphere([u, v]: [f64; 2]) -> DVec3 {
    let (radius, (sin, cos)) = (u.sqrt(), (TAU * v).sin_cos());
    DVec3::new(radius * cos, radius * sin, (1.0 - u).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use std::f64::consts::FRAC_1_PI;

    const LABELS: [&str; 10] = [
        "phong:exponent=1",
        "phong:diffuse=0.3:specular=0.6:exponent=200",
        "phong:exponent=10000",
        "cook-torrance:roughness=0.01",
        "cook-torrance:roughness=0.02:f0=0.04:diffuse=0.5:specular=0.5",
        "cook-torrance:roughness=0.3",
        "cook-torrance:roughness=1:f0=1",
        "ward:alpha_x=0.01:alpha_y=0.02",
        "ward:alpha_x=0.1:alpha_y=0.6:diffuse=0.2:specular=0.7",
        "ward:alpha_x=1:alpha_y=1",
    ];

    fn direction(z: f64, azimuth: f64) -> DVec3 {
        let sine = (1.0 - z * z).sqrt();
        DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), z)
    }

    /// A model, a view, and a jittered grid of n² draws.
    fn each_case(n: usize, check: impl Fn(&str, &Brdf, DVec3, &[[f64; 2]])) {
        let mut random = Random(7);
        for label in LABELS {
            for (z, azimuth) in [(1.0, 0.0), (0.8, 0.9), (0.4, 2.0), (0.08, -1.0)] {
                let draws: Vec<[f64; 2]> =
                    (0..n * n).map(|k| [k / n, k % n].map(|i| (i as f64 + random.uniform()) / n as f64)).collect();
                check(label, &label.parse().unwrap(), direction(z, azimuth), &draws);
            }
        }
    }

    #[test]
    fn the_mean_of_lobe_over_density_is_the_albedo_of_the_lobe() {
        each_case(200, |label, brdf, view, draws| {
            let quotients = draws.iter().filter_map(|&u| {
                let light = brdf.sample_lobe(view, u)?;
                Some(brdf.lobe(view, light) * light.z / brdf.lobe_pdf(view, light))
            });
            let (mean, expected) = (quotients.sum::<f64>() / draws.len() as f64, brdf.albedo(view) - brdf.diffuse());
            assert!((mean - expected).abs() < 3e-3, "{label} from {view}: {mean}, not {expected}");
        });
    }

    #[test]
    fn directions_fall_where_the_density_says() {
        // Cells of the square from which half vectors or mirrored directions are drawn: each draw of a cell has the same probability,
        // hence the mean of g/p over all draws is ∫ g dω for every g. Take g = a bump of the lobe's own width about any direction that is
        // drawn; its integral is known (2π/k (1 - e^{-2k}) for exp(k (cos - 1)), less what is below the horizon).
        each_case(400, |label, brdf, view, draws| {
            let Some(centre) = brdf.sample_lobe(view, [0.4, 0.3]).filter(|c| c.z > 0.05) else { return };
            // Narrower than the lobe, which shrinks with v·h across the plane of incidence, and above the horizon.
            let across = 0.5 * (view + centre).length();
            let k = (4.0 / (brdf.width() * across)).powi(2).max((5.0 / centre.z).powi(2));
            let bump = |light: DVec3| (-0.5 * k * light.distance_squared(centre)).exp();
            let drawn = draws.iter().filter_map(|&u| brdf.sample_lobe(view, u));
            let found = drawn.map(|light| bump(light) / brdf.lobe_pdf(view, light)).sum::<f64>() / draws.len() as f64;
            let expected = TAU / k * (1.0 - (-2.0 * k).exp());
            assert!((found / expected - 1.0).abs() < 0.05, "{label} from {view}: {found}, not {expected}");
        });
    }

    #[test]
    fn what_is_drawn_is_a_unit_direction_above_the_horizon_of_positive_density_and_bounded_weight() {
        each_case(60, |label, brdf, view, draws| {
            for light in draws.iter().filter_map(|&u| brdf.sample_lobe(view, u)) {
                assert!(light.z > 0.0 && light.is_normalized(), "{label}: {light}");
                let weight = brdf.lobe(view, light) * light.z / brdf.lobe_pdf(view, light);
                assert!((0.0..=2.0 + 1e-9).contains(&weight), "{label} from {view} to {light}: {weight}");
            }
        });
    }

    #[test]
    fn a_surface_without_a_lobe_draws_nothing_and_nothing_is_drawn_from_below() {
        let lambert: Brdf = "lambert".parse().unwrap();
        assert_eq!(lambert.sample_lobe(DVec3::Z, [0.3, 0.4]), None);
        assert_eq!([lambert.lobe_pdf(DVec3::Z, DVec3::Z), lambert.lobe(DVec3::Z, DVec3::Z)], [0.0; 2]);
        for label in LABELS {
            let brdf: Brdf = label.parse().unwrap();
            let below = direction(-0.3, 1.0);
            assert_eq!(brdf.sample_lobe(below, [0.3, 0.4]), None);
            assert_eq!([brdf.lobe_pdf(below, DVec3::Z), brdf.lobe_pdf(DVec3::Z, below)], [0.0; 2]);
        }
    }

    #[test]
    fn the_lobe_and_the_diffuse_part_make_the_whole() {
        for label in LABELS {
            let brdf: Brdf = label.parse().unwrap();
            let (view, light) = (direction(0.6, 0.3), direction(0.5, 3.2));
            let parts = brdf.diffuse() * FRAC_1_PI + brdf.lobe(view, light);
            assert!((brdf.evaluate(view, light) - parts).abs() <= 1e-15 * parts, "{label}");
        }
    }

    #[test]
    fn cosines_of_the_hemisphere_have_their_moments() {
        let n = 300;
        let centre = |i: usize| (i as f64 + 0.5) / n as f64;
        let directions = (0..n * n).map(|k| cosine_hemisphere([centre(k / n), centre(k % n)]));
        let sum: DVec3 = directions.inspect(|d| assert!(d.is_normalized())).sum();
        // ∫ ω cos θ / π dω = 2/3 along the normal.
        assert!((sum / (n * n) as f64 - 2.0 / 3.0 * DVec3::Z).length() < 1e-4);
    }
}
