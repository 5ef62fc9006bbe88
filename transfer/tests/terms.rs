//! Term transfer and shading against a slow computation that shares none of their steps.
#![cfg(feature = "scene")]

use glam::Vec3;
use ndarray::Array2;
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::dense;
use prt_transfer::scene::frames::vertex_frames;
use prt_transfer::scene::separable::Terms;
use prt_transfer::scene::shading::{Shading, towards};
use prt_transfer::scene::shapes;
use prt_transfer::scene::signal::{Sampling, Surface};
use prt_transfer::scene::terms::TermTransfer;
use prt_transfer::{Quiet, ResponseBasis};

const SAMPLING: Sampling = Sampling { resolution: 8, supersampling: 1 };

/// Exit radiance of the vertices that an eye sees well, ray by ray with the BRDF itself, beside what `terms` terms make
/// of it.
fn radiance(brdf: &str, terms: Terms) -> (Vec<f64>, Vec<f64>) {
    let mesh = shapes::find("blob").unwrap().build(120).unwrap();
    let (occluders, frames) = (Occluders::new(&mesh).unwrap(), vertex_frames(&mesh).unwrap());
    let surface = Surface { occluders: &occluders, points: &mesh.positions, frames: &frames };
    let brdf: Brdf = brdf.parse().unwrap();
    let signal = TermTransfer::new(&brdf, terms, &SAMPLING).unwrap();
    let (matrix, _) = dense::matrix(&signal, &surface, &Quiet).unwrap();
    let light = Array2::from_shape_fn((matrix.lights(), 3), |(k, c)| 1.0 + ((k * (c + 3)) % 7) as f32);
    let mut out = Array2::zeros((matrix.rows(), 3));
    matrix.apply_into(light.view(), out.view_mut()).unwrap();
    let (eye, samples) = (Vec3::new(3.0, 2.0, 1.0), SAMPLING.samples().unwrap());
    let shading = Shading::new(matrix.responses(), None).unwrap();
    let found = shading.colours(&mesh.positions, &frames, eye, out.view()).unwrap();
    let (mut shown, mut expected) = (Vec::new(), Vec::new());
    for ((position, frame), colour) in mesh.positions.iter().zip(&frames).zip(found) {
        let (origin, view) = (*position + occluders.offset() * frame.normal, towards(frame, eye - position));
        // Few terms are worst where nobody looks.
        if view.z < 0.2 {
            continue;
        }
        shown.extend(colour.map(f64::from));
        let mut sum = [0f64; 3];
        for sample in samples.lanes().iter().filter(|s| s.solid_angle > 0.0 && s.direction.dot(frame.normal) > 0.0) {
            if occluders.occluded(origin, sample.direction) {
                continue;
            }
            let local = frame.to_local(sample.direction);
            let factor = brdf.evaluate(view.as_dvec3(), local.as_dvec3()) * f64::from(local.z) * sample.solid_angle;
            let row = light.row(sample.texel as usize);
            sum.iter_mut().zip(row).for_each(|(sum, &l)| *sum += factor * f64::from(l));
        }
        expected.extend(sum);
    }
    (shown, expected)
}

fn relative_error((found, expected): (Vec<f64>, Vec<f64>)) -> f64 {
    let squares = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>();
    squares(&mut found.iter().zip(&expected).map(|(a, b)| a - b)) / squares(&mut expected.iter().copied())
}

#[test]
fn a_lambertian_surface_is_one_term_and_exact() {
    let error = relative_error(radiance("lambert:albedo=0.6", Terms::Count(1)));
    assert!(error < 1e-7, "{error}");
}

#[test]
fn more_terms_come_nearer_to_the_brdf_itself() {
    let brdf = "cook-torrance:roughness=0.5:f0=0.6:diffuse=0.3:specular=0.7";
    let errors = [1, 4, 16, 64].map(|terms| relative_error(radiance(brdf, Terms::Count(terms))));
    assert!(errors.windows(2).all(|pair| pair[1] < 0.9 * pair[0]), "{errors:?}");
    assert!(errors[3] < 1e-3, "{errors:?}");
}

#[test]
fn shading_needs_to_know_what_responses_are_and_whose_brdf_it_is() {
    let shading = |responses: &str, brdf: Option<&str>| {
        let brdf = brdf.map(|text| text.parse::<Brdf>().unwrap());
        Shading::new(&responses.parse::<ResponseBasis>().unwrap(), brdf.as_ref()).map(|s| s.responses())
    };
    assert_eq!(shading("irradiance", None).unwrap(), 1);
    assert_eq!(shading("local:4", Some("phong")).unwrap(), 16);
    assert_eq!(shading("exit-orthonormal:15", None).unwrap(), 15);
    for (responses, brdf, part) in [
        ("plain:7", None, "numbers alone"),
        ("irradiance", Some("phong"), "lambert"),
        ("exit:16", Some("lambert"), "no other BRDF"),
        ("terms:3:lambert", Some("lambert"), "no other BRDF"),
        ("terms:3:velvet", None, "velvet"),
        ("terms:3:lambert", None, "terms"),
    ] {
        let message = shading(responses, brdf).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}
