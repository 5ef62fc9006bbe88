use super::*;
use crate::quadrature::gauss_legendre;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn direction(z: f64, azimuth: f64) -> DVec3 {
    let sine = (1.0 - z * z).sqrt();
    DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), z)
}

fn brdf(label: &str) -> Brdf {
    label.parse().unwrap()
}

/// ∫ f dω over the hemisphere, with no knowledge of where f is large. z = t² resolves the horizon.
fn hemisphere(rings: usize, sectors: usize, f: impl Fn(DVec3) -> f64) -> f64 {
    let mut sum = 0.0;
    for (x, weight) in gauss_legendre(rings) {
        let t = 0.5 * (1.0 + x);
        let ring: f64 = (0..sectors).map(|j| f(direction(t * t, TAU * (j as f64 + 0.5) / sectors as f64))).sum();
        sum += weight * t * ring * TAU / sectors as f64;
    }
    sum
}

fn any_brdf() -> impl Strategy<Value = Brdf> {
    let weights = (0f64..=1.0, 0f64..=1.0).prop_map(|(sum, part)| (sum * part, sum * (1.0 - part)));
    (0..4, weights, 0.01f64..1.0, 0.01f64..1.0).prop_map(|(model, (kd, ks), a, b)| {
        brdf(&match model {
            0 => format!("lambert:albedo={a}"),
            1 => format!("phong:diffuse={kd}:specular={ks}:exponent={}", 1e4f64.powf(a)),
            2 => format!("cook-torrance:diffuse={kd}:specular={ks}:roughness={a}:f0={b}"),
            _ => format!("ward:diffuse={kd}:specular={ks}:alpha_x={a}:alpha_y={b}"),
        })
    })
}

fn any_direction() -> impl Strategy<Value = DVec3> {
    // Half of them within a hundredth of the horizon.
    let z = prop_oneof![0f64..=1.0, (-12f64..-2.0).prop_map(|e| 10f64.powf(e))];
    (z, 0f64..TAU).prop_map(|(z, azimuth)| direction(z, azimuth))
}

proptest! {
    #[test]
    fn reflectance_is_finite_reciprocal_and_mirror_symmetric_bit_for_bit(
        brdf in any_brdf(), view in any_direction(), light in any_direction(),
    ) {
        let value = brdf.evaluate(view, light);
        prop_assert!(value.is_finite() && value >= 0.0);
        prop_assert_eq!(value, brdf.evaluate(light, view));
        for mirror in [DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0)] {
            prop_assert_eq!(value, brdf.evaluate(view * mirror, light * mirror));
        }
    }

    #[test]
    fn nothing_is_reflected_at_the_horizon_or_below(
        brdf in any_brdf(), above in any_direction(), phi in 0f64..TAU, z in -1f64..=0.0,
    ) {
        let below = direction(z, phi);
        prop_assert_eq!(brdf.evaluate(above, below), 0.0);
        prop_assert_eq!(brdf.evaluate(below, above), 0.0);
        prop_assert_eq!(brdf.albedo(below), 0.0);
    }

    #[test]
    fn isotropic_models_know_only_the_relative_azimuth(
        brdf in any_brdf(), z in [0.01f64..1.0, 0.01f64..1.0], phi in [0f64..TAU, 0f64..TAU], turn in 0f64..TAU,
    ) {
        let at = |turn| brdf.evaluate(direction(z[0], phi[0] + turn), direction(z[1], phi[1] + turn));
        let largest = brdf.evaluate(direction(z[0], 0.0), direction(z[1], PI));
        if brdf.is_isotropic() {
            prop_assert!((at(turn) - at(0.0)).abs() <= 1e-9 * largest);
        }
    }

    #[test]
    fn no_surface_reflects_more_than_it_receives(brdf in any_brdf(), view in any_direction()) {
        let albedo = brdf.albedo(view);
        prop_assert!((0.0..=1.0 + 2e-3).contains(&albedo), "{brdf}: {albedo}");
    }

    #[test]
    fn labels_read_back_as_the_same_model(brdf in any_brdf()) {
        prop_assert_eq!(brdf.to_string().parse::<Brdf>().unwrap(), brdf);
    }
}

#[test]
fn albedo_agrees_with_quadrature_that_knows_no_lobes() {
    let labels = [
        "lambert:albedo=0.7",
        "phong:exponent=1",
        "phong:diffuse=0.3:specular=0.6:exponent=20",
        "cook-torrance:f0=1:roughness=0.2",
        "cook-torrance:f0=0.04:roughness=0.6:diffuse=0.4:specular=0.6",
        "ward:alpha_x=0.2:alpha_y=0.5",
        "ward:alpha_x=1:alpha_y=1",
    ];
    for brdf in labels.map(brdf) {
        for z in [0.05, 0.3, 0.7, 1.0] {
            let view = direction(z, 0.7);
            let plain = hemisphere(120, 360, |light| brdf.evaluate(view, light) * light.z);
            assert!((plain - brdf.albedo(view)).abs() < 1e-3, "{brdf} at {z}: {plain} {}", brdf.albedo(view));
        }
    }
}

#[test]
fn albedos_of_normal_incidence_are_those_of_closed_form() {
    let at_normal = |label: &str| brdf(label).albedo(DVec3::Z);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
    near(at_normal("lambert:albedo=0.25"), 0.25);
    for n in [1, 2, 7, 50, 5000] {
        near(at_normal(&format!("phong:diffuse=0.25:specular=0.5:exponent={n}")), 0.75);
    }
    // Facets that shadow nothing reflect everything, or Schlick's f0 of what meets them nearly head-on.
    for roughness in [0.01, 0.03, 0.1] {
        near(at_normal(&format!("cook-torrance:f0=1:roughness={roughness}")), 1.0);
    }
    near(at_normal("cook-torrance:f0=0.04:roughness=0.01"), 0.04);
    // ∫ D (2 cos θ_h - 1/cos θ_h) dω_h = 1 - (αx² + αy²)/2
    near(at_normal("ward:alpha_x=0.1:alpha_y=0.15"), 1.0 - (0.1f64.powi(2) + 0.15f64.powi(2)) / 2.0);
}

#[test]
fn slope_distributions_project_to_the_unit_area() {
    // With v = s = h, Cook-Torrance is D G / (4 cos²θ) and G = min(1, 2 cos²θ); Ward is D / 4. ∫ D cos θ dω = 1.
    for label in
        ["cook-torrance:f0=1:roughness=0.3", "cook-torrance:f0=1:roughness=0.8", "ward:alpha_x=0.3:alpha_y=0.6"]
    {
        let brdf = brdf(label);
        let area = hemisphere(150, 200, |h| {
            let lobe = 4.0 * brdf.evaluate(h, h);
            h.z * if let Brdf::Ward(_) = brdf { lobe } else { lobe * h.z * h.z / (2.0 * h.z * h.z).min(1.0) }
        });
        assert!((area - 1.0).abs() < 1e-6, "{label}: {area}");
    }
}

#[test]
fn ward_with_equal_widths_is_isotropic() {
    let ward = brdf("ward:alpha_x=0.4:alpha_y=0.4");
    assert!(ward.is_isotropic() && !brdf("ward:alpha_x=0.4:alpha_y=0.3").is_isotropic());
    let at = |turn| ward.evaluate(direction(0.6, 0.2 + turn), direction(0.3, 2.0 + turn));
    assert!((at(1.234) / at(0.0) - 1.0).abs() < 1e-12);
    let askew = brdf("ward:alpha_x=0.1:alpha_y=0.5");
    let along = |azimuth| askew.evaluate(direction(0.8, azimuth), DVec3::Z);
    assert!(along(FRAC_PI_2) > 2.0 * along(0.0), "broad along y");
}

#[test]
fn parameters_out_of_range_and_unknown_names_are_refused_by_name() {
    for (label, said) in [
        ("lambert:albedo=1.1", "albedo=1.1"),
        ("phong:exponent=0.5", "from 1 to 10000"),
        ("cook-torrance:roughness=0", "from 0.01 to 1"),
        ("cook-torrance:f0=-0.1", "f0=-0.1"),
        ("ward:alpha_y=2", "alpha_y=2"),
        ("ward:diffuse=0.5", "at most 0.5"),
        ("phong:shine=3", "diffuse, specular, exponent"),
        ("ward:alpha_x=NaN", "finite"),
        ("blinn", "lambert, phong, cook-torrance, ward"),
        ("cook-:f0=1", "not a name"),
    ] {
        let error = label.parse::<Brdf>().unwrap_err().to_string();
        assert!(error.contains(said), "{label}: {error}");
    }
    for about in Brdf::all() {
        assert_eq!(brdf(about.name).to_string(), about.name, "defaults are not written");
    }
    assert_eq!(brdf("ward:alpha_x=0.50:diffuse=0").to_string(), "ward:alpha_x=0.5");
}
