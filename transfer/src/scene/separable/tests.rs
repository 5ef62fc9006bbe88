use super::*;
use crate::params::Value;
use crate::quadrature::gauss_legendre;
use glam::DVec3;
use proptest::prelude::*;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Views and lights on their own grid: unit vectors, and weights of dω.
fn hemisphere(rings: usize, sectors: usize, turn: f64) -> Vec<(DVec3, f64)> {
    let ring = |(x, weight): (f64, f64)| {
        let t = 0.5 * (1.0 + x);
        let (z, share) = (t * t, weight * t * TAU / sectors as f64);
        (0..sectors).map(move |j| (direction(z, turn + TAU * j as f64 / sectors as f64), share))
    };
    gauss_legendre(rings).into_iter().flat_map(ring).collect()
}

fn direction(z: f64, azimuth: f64) -> DVec3 {
    let sine = (1.0 - z * z).sqrt();
    DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), z)
}

fn separate(brdf: &str, terms: &str, views: Views) -> SeparableBrdf {
    SeparableBrdf::new(&brdf.parse().unwrap(), terms.parse().unwrap(), views).unwrap()
}

fn measure(views: Views, z: f64) -> f64 {
    if views == Views::Projected { z } else { 1.0 }
}

fn view_at(separable: &SeparableBrdf, v: DVec3) -> Vec<f64> {
    let mut out = vec![0.0; separable.terms()];
    separable.view(v.as_vec3(), &mut out);
    out
}

fn light_at(separable: &SeparableBrdf, s: DVec3) -> Vec<f64> {
    let mut out = vec![0f32; separable.terms()];
    separable.light(s.as_vec3(), &mut out);
    out.into_iter().map(f64::from).collect()
}

#[test]
fn the_error_is_the_tail_of_the_singular_values() {
    for (label, views) in [
        ("cook-torrance", Views::Projected),
        ("cook-torrance", Views::SolidAngle),
        ("phong:diffuse=0.3:specular=0.7:exponent=10", Views::SolidAngle),
        ("ward:alpha_x=0.1:alpha_y=0.8:diffuse=0.1:specular=0.9", Views::Projected),
    ] {
        let brdf: Brdf = label.parse().unwrap();
        let separable = separate(label, "16", views);
        let lights: Vec<_> =
            hemisphere(50, 480, 0.1).into_iter().map(|(s, w)| (s, w, light_at(&separable, s))).collect();
        let (mut error, mut energy) = (0.0, 0.0);
        for (v, w) in hemisphere(20, 23, 0.3) {
            let phi = view_at(&separable, v);
            for (s, weight, psi) in &lights {
                let exact = brdf.evaluate(v, *s) * s.z;
                let sum: f64 = phi.iter().zip(psi).map(|(a, b)| a * b).sum();
                let weight = w * weight * measure(views, v.z);
                error += weight * (exact - sum).powi(2);
                energy += weight * exact * exact;
            }
        }
        assert!((energy / separable.energy - 1.0).abs() < 5e-3, "{label}: {energy} {}", separable.energy);
        let (measured, tail) = (error / energy, separable.relative_error(16));
        assert!((measured / tail - 1.0).abs() < 5e-3, "{label}: {measured} {tail}");
    }
}

#[test]
fn views_are_orthonormal_and_lights_orthogonal_with_the_singular_values_as_lengths() {
    for (label, views) in [("cook-torrance", Views::SolidAngle), ("ward:alpha_x=0.2:alpha_y=0.4", Views::Projected)] {
        let separable = separate(label, "12", views);
        let (mut phi, mut psi) = ([[0.0; 12]; 12], [[0.0; 12]; 12]);
        for (d, weight) in hemisphere(80, 60, 0.2) {
            let (v, s) = (view_at(&separable, d), light_at(&separable, d));
            for (j, k) in (0..12).flat_map(|j| (0..12).map(move |k| (j, k))) {
                phi[j][k] += weight * measure(views, d.z) * v[j] * v[k];
                psi[j][k] += weight * s[j] * s[k];
            }
        }
        let sigma = separable.singular_values();
        for (j, k) in (0..12).flat_map(|j| (0..12).map(move |k| (j, k))) {
            let one = if j == k { 1.0 } else { 0.0 };
            assert!((phi[j][k] - one).abs() < 1e-2, "{label} φ {j} {k}: {}", phi[j][k]);
            let cosine = psi[j][k] / (sigma[j] * sigma[k]);
            assert!((cosine - one).abs() < 1e-2, "{label} ψ {j} {k}: {cosine}");
        }
    }
}

#[test]
fn a_diffuse_surface_has_exactly_one_term() {
    let lambert = separate("lambert:albedo=0.5", "99%", Views::SolidAngle);
    assert_eq!(lambert.terms(), 1);
    assert!(lambert.relative_error(1) < 1e-12);
    // |ρ cos θ|² = (0.5/π)² · 2π · 2π/3
    let sigma = 0.5 * FRAC_1_PI * TAU / 3f64.sqrt();
    assert!((lambert.singular_values()[0] - sigma).abs() < 1e-12);
    for z in [0.001, 0.02, 0.3, 1.0] {
        let (v, s) = (direction(0.4, 1.0), direction(z, 2.0));
        assert!((view_at(&lambert, v)[0] - TAU.sqrt().recip()).abs() < 1e-6);
        let product = view_at(&lambert, v)[0] * light_at(&lambert, s)[0];
        assert!((product - 0.5 * FRAC_1_PI * z).abs() < 5e-5, "{z}: {product}");
    }
    let projected = separate("lambert:albedo=0.5", "1", Views::Projected);
    assert!((view_at(&projected, DVec3::Z)[0] - PI.sqrt().recip()).abs() < 1e-6);
    let refused =
        |brdf: &str, terms| SeparableBrdf::new(&brdf.parse().unwrap(), terms, Views::SolidAngle).err().unwrap();
    assert!(refused("lambert", Terms::Count(2)).to_string().contains("from 1 to 1"));
    assert!(refused("lambert:albedo=0", Terms::Count(1)).to_string().contains("black"));
    assert!(refused("phong", Terms::Percent(f64::NAN)).to_string().contains("100 %"));
    assert!(refused("phong:exponent=201", Terms::Count(1)).to_string().contains("0.05"));
}

#[test]
fn more_terms_leave_less_error_down_to_what_the_orders_hold() {
    let separable = separate("phong:exponent=8", "90%", Views::SolidAngle);
    let sigma = separable.singular_values();
    let errors: Vec<f64> = (0..=sigma.len()).map(|k| separable.relative_error(k)).collect();
    assert_eq!(errors[0], 1.0);
    assert!(errors.windows(2).all(|e| e[1] <= e[0]) && errors[100] < 1e-4 && errors[sigma.len()] < 1e-6);
    let (k, sum) = (separable.terms(), sigma.iter().sum::<f64>());
    let part = |k: usize| sigma[..k].iter().sum::<f64>() / sum;
    assert!(part(k) >= 0.9 && part(k - 1) < 0.9, "the least number");
}

#[test]
fn errors_are_those_of_the_documentation() {
    for (views, table) in [
        (Views::SolidAngle, [0.914, 0.739, 0.584, 0.405, 0.308, 0.134]),
        (Views::Projected, [0.769, 0.459, 0.268, 0.123, 0.069, 0.013]),
    ] {
        let separable = separate("cook-torrance:roughness=0.3", "1", views);
        for (k, error) in [1, 4, 8, 16, 24, 64].into_iter().zip(table) {
            let found = separable.relative_error(k);
            assert!((found - error).abs() < 6e-4, "{} K = {k}: {found}", views.show());
        }
    }
}

#[test]
fn pairs_of_isotropic_terms_are_cosine_and_sine_of_one_function() {
    let separable = separate("cook-torrance", "16", Views::Projected);
    let sigma = separable.singular_values();
    let pairs: Vec<usize> = (0..15).filter(|&k| sigma[k] == sigma[k + 1]).collect();
    assert_eq!(pairs.len(), 7, "two terms of order 0: {sigma:?}");
    for first in pairs {
        // g(θ) cos mφ and g(θ) sin mφ: one circle, run through m times as fast as the azimuth.
        let at = |azimuth| view_at(&separable, direction(0.6, azimuth))[first..first + 2].to_vec();
        let radius = at(0.0)[0];
        let m = (at(0.1)[1] / radius).atan2(at(0.1)[0] / radius) / 0.1;
        assert!(m > 0.5 && (m - m.round()).abs() < 0.05, "pair {first}: order {m}");
        for step in 0..20 {
            let azimuth = f64::from(step);
            let (sin, cos) = (m.round() * azimuth).sin_cos();
            let pair = at(azimuth);
            // φ is about 0.4 in the mean.
            let off = (pair[0] - radius * cos).hypot(pair[1] - radius * sin);
            assert!(off < 5e-3, "pair {first} at {azimuth}: {off}");
        }
    }
}

#[test]
fn the_blocks_of_an_anisotropic_brdf_agree_with_those_of_an_isotropic_one() {
    let ward = |y: f64| separate(&format!("ward:alpha_x=0.3:alpha_y={y}"), "1", Views::Projected);
    let (round, oval) = (ward(0.3), ward(0.3 + 1e-9));
    assert!((round.energy / oval.energy - 1.0).abs() < 1e-5);
    for (a, b) in round.singular_values().iter().zip(oval.singular_values()).take(40) {
        assert!((a - b).abs() < 1e-5 * round.singular_values()[0], "{a} {b}");
    }
}

#[test]
fn tables_stay_near_the_extension() {
    for (label, views, bound) in [
        ("cook-torrance", Views::Projected, 6e-3),
        ("cook-torrance", Views::SolidAngle, 1.2e-2),
        ("ward", Views::Projected, 8e-3),
    ] {
        let brdf: Brdf = label.parse().unwrap();
        let resolution = Resolution::of(&brdf).unwrap();
        let (factors, _) = factor(&Kernel::new(&brdf, views, resolution), resolution).unwrap();
        let extension = Extension::new(&brdf, views, resolution, &factors[..16]);
        let (view, light) = Table::tabulate(&extension);
        let mut scratch = extension.scratch();
        let [mut exact, mut read] = [[[0.0; 16]; 2]; 2];
        let mut sums = [[0.0; 4]; 16];
        for i in 0..1000 {
            // Equal areas down to 1/2000 above the horizon.
            let d = direction((i as f64 + 0.5) / 1000.0, 2.4 * i as f64);
            let azimuth = d.truncate().normalize();
            let [phi, psi] = &mut exact;
            extension.at(d.z, (azimuth.x, azimuth.y), &mut scratch, phi, psi);
            view.read(d.as_vec3(), &mut read[0]);
            light.read(d.as_vec3(), &mut read[1]);
            for (k, sum) in sums.iter_mut().enumerate() {
                for side in 0..2 {
                    sum[side] += exact[side][k].powi(2);
                    sum[2 + side] += (read[side][k] - exact[side][k]).powi(2);
                }
            }
        }
        for (k, sum) in sums.iter().enumerate() {
            let errors = [sum[2] / sum[0], sum[3] / sum[1]].map(f64::sqrt);
            assert!(errors.iter().all(|e| *e < bound), "{label} term {k}: {errors:?}");
        }
    }
}

#[test]
fn threads_change_nothing_and_the_horizon_is_dark() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| separate("phong:exponent=30", "5", Views::SolidAngle))
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.singular_values(), three.singular_values());
    for azimuth in 0..20 {
        let d = direction(0.04 * f64::from(azimuth) + 0.01, f64::from(azimuth));
        assert_eq!((view_at(&one, d), light_at(&one, d)), (view_at(&three, d), light_at(&three, d)));
        assert_eq!(view_at(&one, direction(0.0, 1.0)), [0.0; 5]);
        assert_eq!(light_at(&one, -d), [0.0; 5]);
    }
}

proptest! {
    #[test]
    fn numbers_of_terms_read_back(count in 0usize..1_000_000, percent in 0f64..100.0) {
        for terms in [Terms::Count(count), Terms::Percent(percent)] {
            prop_assert_eq!(terms.to_string().parse::<Terms>().unwrap(), terms);
        }
        prop_assert!(["", "%", "0.9", "-1", "inf%"].iter().all(|text| text.parse::<Terms>().is_err()));
    }
}

#[test]
fn measures_of_views_read_back() {
    for views in [Views::SolidAngle, Views::Projected] {
        assert_eq!(Views::parse(&views.show()), Some(views));
    }
}
